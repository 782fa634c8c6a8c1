// Edits of keys and control values that several parts of the page offer.
import { say } from "./dom";
import {
  type Key,
  max_control_value,
  type Move,
  plainKey,
  roundTo,
  stepFor,
  withKeys,
  withSpeed,
  fixedSpeed,
} from "./move";
import type { Store } from "./store";

export function moveKeys(
  move: Move,
  track: number,
  keys: readonly number[],
  by: readonly number[],
  steps: readonly number[],
): Move {
  const chosen = new Set(keys);
  return withKeys(
    move,
    track,
    move.tracks[track].keys.map((key, k) =>
      chosen.has(k) ? { ...key, at: key.at.map((x, a) => (by[a] === 0 ? x : roundTo(x + by[a], steps[a]))) } : key,
    ),
  );
}

export function changeKeys(store: Store, keys: ReadonlySet<number>, change: (key: Key, k: number) => Key): void {
  const { track } = store.selection;
  const why = store.move.tracks[track].fixed_keys;
  if (why) return say(`Keys of this track: ${why}.`);
  store.edit(
    withKeys(
      store.move,
      track,
      store.move.tracks[track].keys.map((key, k) => (keys.has(k) ? change(key, k) : key)),
    ),
  );
}

export function removeKeys(store: Store): void {
  const { track, keys } = store.selection;
  const one = store.move.tracks[track];
  if (one.fixed_keys) return say(`Keys of this track: ${one.fixed_keys}.`);
  if (keys.size === 0) return;
  if (keys.size >= one.keys.length) return say("A path needs a key.");
  const first = Math.min(...keys);
  store.edit(
    withKeys(
      store.move,
      track,
      one.keys.filter((_, k) => !keys.has(k)),
    ),
  );
  store.selectKey(Math.max(0, first - 1));
  say(keys.size === 1 ? `Key ${first} deleted` : `${keys.size} keys deleted`);
}

/** A new key where the path is at s, which is i at key i; at the ends the path grows by half a chord. */
export function insertOnPath(store: Store, s: number): void {
  const { track } = store.selection;
  const one = store.move.tracks[track];
  if (one.fixed_keys) return say(`Keys of this track: ${one.fixed_keys}.`);
  const last = one.keys.length - 1;
  const round = (at: number[]): number[] =>
    at.map((x, a) => {
      const values = one.keys.map((key) => key.at[a]);
      return roundTo(x, stepFor(Math.max(...values) - Math.min(...values) || Math.abs(x) || 1) / 10);
    });
  const segments = one.closed ? last + 1 : last;
  let at: number[];
  let before: number;
  if (s > segments || last === 0) {
    const end = one.keys[last].at;
    const previous = one.keys[Math.max(last - 1, 0)].at;
    at = end.map((x, a) => x + (x - previous[a]) / 2 + (last === 0 && a === 0 ? 10 : 0));
    before = last;
  } else {
    at = store.solver.at(track, s, one.axes.length);
    before = Math.min(Math.floor(s), last);
  }
  const keys = [...one.keys];
  const frames = one.timing === "frames";
  const key = plainKey(round(at));
  const frame = frames ? frameBetween(one.keys, before, store.move.frames) : null;
  if (frames && frame === null) return say("There is no free frame between these keys.");
  keys.splice(before + 1, 0, { ...key, frame });
  store.edit(withKeys(store.move, track, keys));
  store.selectKey(before + 1);
  say(`Key ${before + 1} inserted`);
}

function frameBetween(keys: readonly Key[], before: number, frames: number): number | null {
  const from = keys[before].frame ?? 0;
  const to = keys[before + 1]?.frame ?? frames;
  const middle = Math.round((from + to) / 2);
  return middle > from && middle < to ? middle : null;
}

/** A copy of each selected key right behind it, a little beside, so that it can be seen. */
export function copyKeys(store: Store): void {
  const { track, keys } = store.selection;
  const one = store.move.tracks[track];
  if (one.fixed_keys) return say(`Keys of this track: ${one.fixed_keys}.`);
  if (keys.size === 0) return say("Select a key first.");
  const spans = one.axes.map((_, a) => {
    const values = one.keys.map((key) => key.at[a]);
    return Math.max(...values) - Math.min(...values) || 10;
  });
  const copies: Key[] = [];
  const chosen = new Set<number>();
  const byFrames = one.timing === "frames";
  for (const [k, key] of one.keys.entries()) {
    copies.push(key);
    if (!keys.has(k)) continue;
    // Behind the last frame there is none: that key is copied to before it.
    const isLast = byFrames && k > 0 && k === one.keys.length - 1 && !one.closed;
    const frame = byFrames ? frameBetween(one.keys, isLast ? k - 1 : k, store.move.frames) : null;
    if (byFrames && frame === null) return say(`There is no free frame beside key ${k}.`);
    const at = key.at.map((x, a) => roundTo(x + 0.05 * spans[a], stepFor(spans[a])));
    const index = isLast ? copies.length - 1 : copies.length;
    chosen.add(index);
    copies.splice(index, 0, { ...key, from: null, at, frame, hold: null, break: false });
  }
  store.edit(withKeys(store.move, track, copies));
  store.select({ keys: chosen, values: new Set() });
  say("Copied");
}

/** Locks the selected keys one frame earlier or later than where they are met. */
export function shiftKeys(store: Store, by: number): void {
  const { track, keys } = store.selection;
  if (keys.size === 0) return say("Select a key first.");
  const met = store.solution.tracks[track].keyFrames;
  const { frames } = store.move;
  const last = store.move.tracks[track].keys.length - 1;
  const isEnd = [...keys].some((k) => !store.move.tracks[track].closed && (k === 0 || k === last));
  if (isEnd) return say("The first and the last key are at the ends of the move.");
  changeKeys(store, keys, (key, k) => {
    const now = key.frame ?? Math.round(met[k]);
    return { ...key, frame: Math.min(Math.max(now + by, 1), frames - 1) };
  });
  const k = Math.min(...keys);
  say(`Key ${k} locked on frame ${store.move.tracks[track].keys[k].frame}`);
}

// ---- the speed curve

const bounded = (value: number): number => Math.min(Math.max(value, 0), max_control_value);

export function setValues(move: Move, track: number, change: (value: number, index: number) => number): Move {
  const speed = move.tracks[track].speed!;
  const changed = speed.map((value, i) => roundTo(bounded(change(value, i)), 0.01));
  // A loop goes on where it began.
  if (move.tracks[track].periodic) {
    const last = speed.length - 1;
    if (changed[0] !== speed[0]) changed[last] = changed[0];
    else changed[0] = changed[last];
  }
  return withSpeed(move, track, changed);
}

export function insertValue(store: Store, index: number, value?: number): void {
  const { track } = store.selection;
  const one = store.move.tracks[track];
  const why = fixedSpeed(one);
  if (why) return say(why);
  const speed = [...one.speed!];
  if (speed.length >= 2048) return say("A file holds 2048 control values.");
  const between = value ?? (speed[index - 1] + (speed[index] ?? speed[index - 1])) / 2;
  speed.splice(index, 0, roundTo(bounded(between), 0.01));
  store.edit(withSpeed(store.move, track, speed));
  store.selectValue(index);
  say(`Control value ${index} inserted, ${speed[index]}`);
}

export function removeValues(store: Store): void {
  const { track, values } = store.selection;
  const one = store.move.tracks[track];
  const why = fixedSpeed(one);
  if (why) return say(why);
  if (values.size === 0) return;
  const left = one.speed!.filter((_, i) => !values.has(i));
  if (left.length < 2) return say("A speed curve needs two control values here.");
  if (left.every((value) => value === 0)) return say("With zeros alone the move would go nowhere.");
  store.edit(withSpeed(store.move, track, left));
  const first = Math.min(...values);
  store.selectValue(Math.min(first, left.length - 1));
  say(values.size === 1 ? `Control value ${first} deleted` : `${values.size} control values deleted`);
}
