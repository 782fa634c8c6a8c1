// What is edited, kept in this browser at every step: a page that is loaded again, a tab that crashes and a program that
// has ended lose nothing. Each tab has a draft of its own, with the whole history; a step is kept as what it changes. Steps
// are in localStorage, which has them when a call returns; the texts that they start from may be too large for that, and
// are in the Cache.
import { type Key, type Move, parseFps, type Track } from "./move";

/** What takes `old` to its successor: from `at` on, `out` items go and `put` come. */
interface Splice<T> {
  readonly at: number;
  readonly out: number;
  readonly put: readonly T[];
}

interface TrackStep {
  readonly keys: Splice<Key> | null; // null: as before
  readonly speed: Splice<number> | null;
  readonly spline: Track["spline"];
  readonly closed: boolean;
  readonly moved: boolean;
  readonly touched: boolean;
}

/** A state of the move, told from the one before where that has the same base, and from the base otherwise. */
interface Step {
  readonly base: string; // its revision
  readonly frames: number;
  readonly fps: string;
  readonly tracks: readonly TrackStep[];
}

interface Head {
  readonly count: number; // of steps
  readonly at: number; // the step that is shown; those behind it can be done again
  readonly saved: number; // the step that the file has as far as this tab knows, or -1
  readonly known: string; // the revision of the file as far as this tab knows
  readonly time: number; // ms, when it was last changed
  readonly bases: readonly string[];
}

export interface History {
  readonly states: readonly Move[];
  readonly at: number;
  readonly saved: Move | null;
  readonly known: string;
}
export interface KeptHistory extends History {
  readonly base: Move; // of the state that is shown
}

function splice<T>(old: readonly T[], now: readonly T[]): Splice<T> | null {
  if (old === now) return null;
  const shorter = Math.min(old.length, now.length);
  let at = 0;
  while (at < shorter && Object.is(old[at], now[at])) ++at;
  let end = 0;
  while (end < shorter - at && Object.is(old[old.length - 1 - end], now[now.length - 1 - end])) ++end;
  return { at, out: old.length - at - end, put: now.slice(at, now.length - end) };
}
const spliced = <T>(old: readonly T[], by: Splice<T> | null): readonly T[] =>
  by === null ? old : [...old.slice(0, by.at), ...by.put, ...old.slice(by.at + by.out)];

// A curve that nobody has edited is the program's, which may compute it.
const drawnSpeed = (track: Track): readonly number[] => (track.touched ? (track.speed ?? []) : []);

function stepOf(before: Move | undefined, move: Move): Step {
  const tracks = move.tracks.map((track, t): TrackStep => {
    const old = before?.revision === move.revision ? before.tracks[t] : null;
    return {
      keys: track.moved ? splice(old?.keys ?? [], track.keys) : null,
      speed: track.touched ? splice(old ? drawnSpeed(old) : [], drawnSpeed(track)) : null,
      spline: track.spline,
      closed: track.closed,
      moved: track.moved ?? false,
      touched: track.touched ?? false,
    };
  });
  return { base: move.revision, frames: move.frames, fps: move.fps.text, tracks };
}

function stateOf(step: Step, before: Move | undefined, base: Move): Move {
  const old = before?.revision === base.revision ? before : null;
  const tracks = base.tracks.map((track, t): Track => {
    const { keys, speed, spline, closed, moved, touched } = step.tracks[t];
    return {
      ...track,
      spline,
      closed,
      moved,
      touched,
      keys: moved ? spliced(old?.tracks[t].keys ?? [], keys) : track.keys,
      speed: touched ? spliced(old ? drawnSpeed(old.tracks[t]) : [], speed) : track.speed,
    };
  });
  const fps = parseFps(step.fps);
  if (!fps) throw new Error(`the draft has no frame rate: ${step.fps}`);
  return { ...base, frames: step.frames, fps, tracks };
}

const storage = "inbetween-drafts";

export class Draft {
  private written: readonly Move[] = [];
  private readonly missing = new Set<string>(); // revisions of texts for which there was no room

  private constructor(
    private readonly file: string,
    readonly tab: string,
    readonly head: Head | null,
    readonly others: number,
  ) {}

  /** The draft of this tab, or the latest that no open tab has, or a new one. No other tab gets it while this one is open. */
  static async take(file: string): Promise<Draft> {
    const own = sessionStorage.getItem("inbetween-tab");
    const there = Draft.heads(file);
    // A tab that has been duplicated has the name of the other; one that is loaded again waits until it has ended.
    const ownHead = own === null ? undefined : there.get(own);
    if (own !== null && ownHead && (await held(file, own, 2000))) return Draft.taken(file, own, ownHead, there);
    const latest = [...there].sort(([, a], [, b]) => b.time - a.time);
    for (const [tab, head] of latest) if (await held(file, tab, 0)) return Draft.taken(file, tab, head, there);
    return Draft.fresh(file);
  }
  /** A new one; the others stay. */
  static async fresh(file: string): Promise<Draft> {
    const tab = crypto.randomUUID();
    await held(file, tab, 0);
    return Draft.taken(file, tab, null, new Map());
  }
  private static async taken(file: string, tab: string, head: Head | null, there: Map<string, Head>): Promise<Draft> {
    sessionStorage.setItem("inbetween-tab", tab);
    const locks = (await navigator.locks.query()).held ?? [];
    const others = [...there].filter(
      ([other, { saved, at }]) =>
        other !== tab && saved !== at && !locks.some((lock) => lock.name === lockOf(file, other)),
    );
    return new Draft(file, tab, head, others.length);
  }
  private static heads(file: string): Map<string, Head> {
    const heads = new Map<string, Head>();
    for (const name of Object.keys(localStorage)) {
      const match = /^inbetween-draft (\S+) (\S+) head$/.exec(name);
      if (match?.[1] === file) heads.set(match[2], JSON.parse(localStorage.getItem(name)!) as Head);
    }
    return heads;
  }

  /** Whether there is anything in it that the file did not have. */
  get isChanged(): boolean {
    return this.head !== null && this.head.at !== this.head.saved;
  }

  /** The history that was kept. `document` solves a text. Throws an Error, one line, where it cannot be had. */
  async history(document: (text: string, revision: string) => Promise<Move>): Promise<KeptHistory> {
    const head = this.head!;
    const bases = new Map<string, Move>();
    for (const base of head.bases) {
      const text = await (await caches.open(storage)).match(this.baseName(base));
      if (!text) throw new Error("the browser has forgotten the text that it starts from");
      bases.set(base, await document(await text.text(), base));
    }
    const states: Move[] = [];
    for (let i = 0; i < head.count; ++i) {
      const step = JSON.parse(localStorage.getItem(this.name(String(i)))!) as Step;
      states.push(stateOf(step, states.at(-1), bases.get(step.base)!));
    }
    this.written = states;
    return {
      base: bases.get(states[head.at].revision)!,
      states,
      at: head.at,
      saved: states[head.saved] ?? null,
      known: head.known,
    };
  }

  /** Keeps the text that states of the move start from; `name` then writes the first of them, so that a draft names it.
   * Lets go of texts that no draft names. */
  async keepBase(move: Move, name: () => void): Promise<void> {
    await navigator.locks.request("inbetween-bases", async () => {
      const cache = await caches.open(storage);
      const named = new Set([move.revision]);
      for (const { bases } of Draft.heads(this.file).values()) for (const base of bases) named.add(base);
      for (const request of await cache.keys()) {
        const [, , file, base] = new URL(request.url).pathname.split("/");
        if (file === this.file && !named.has(base)) await cache.delete(request);
      }
      await cache
        .put(this.baseName(move.revision), new Response(move.text))
        .catch(() => this.missing.add(move.revision));
      name();
    });
  }

  /** Keeps a history. False where the browser has no room for it. */
  write({ states, at, saved, known }: History): boolean {
    try {
      let same = 0;
      while (same < Math.min(this.written.length, states.length) && this.written[same] === states[same]) ++same;
      const old = this.written;
      this.written = states.slice(0, same);
      if (same < old.length) this.put("head", this.headOf(this.written, same - 1, -1, known));
      for (let i = same; i < states.length; ++i) this.put(String(i), stepOf(states[i - 1], states[i]));
      for (let i = states.length; i < old.length; ++i) localStorage.removeItem(this.name(String(i)));
      this.put("head", this.headOf(states, at, saved ? states.indexOf(saved) : -1, known));
      this.written = [...states];
      return !states.some(({ revision }) => this.missing.has(revision));
    } catch {
      return false;
    }
  }

  private headOf(states: readonly Move[], at: number, saved: number, known: string): Head {
    return {
      count: states.length,
      at,
      saved,
      known,
      time: Date.now(),
      bases: [...new Set(states.map((state) => state.revision))],
    };
  }
  private put(part: string, value: object): void {
    localStorage.setItem(this.name(part), JSON.stringify(value));
  }
  private name(part: string): string {
    return `inbetween-draft ${this.file} ${this.tab} ${part}`;
  }
  private baseName(revision: string): string {
    return `/draft/${this.file}/${revision}`;
  }
}

const lockOf = (file: string, tab: string): string => `inbetween ${file} ${tab}`;

/** Whether this page holds the lock from now on, for as long as it is open; it waits so long for it. */
function held(file: string, tab: string, patienceMs: number): Promise<boolean> {
  return new Promise((resolve) => {
    const options = patienceMs > 0 ? { signal: AbortSignal.timeout(patienceMs) } : { ifAvailable: true };
    navigator.locks
      .request(lockOf(file, tab), options, (lock) => {
        resolve(lock !== null);
        return lock === null ? undefined : new Promise<void>(() => {});
      })
      .catch(() => resolve(false));
  });
}
