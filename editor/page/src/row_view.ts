// A row of axes that goes together, as a fin does: axis by frame, each place as bright as the axis is far from where it
// rests, with the curves that are drawn in their rows.
import { attributes, byId, follow, html, say, svg } from "./dom";
import type { Hand, Sample } from "./hand";
import { type DrawnCurve, type Network, perSecond, roundTo, stepFor, withTrack } from "./move";
import type { Store } from "./store";
import { color, type Size, Strokes, watchSize } from "./strokes";

const margin = { left: 84, right: 16, top: 22, bottom: 26 };

export class RowView {
  private readonly root = svg("svg", { class: "plot", role: "img" });
  private readonly heat = new Strokes();
  private readonly cursor = svg("line", { class: "cursor", "aria-hidden": "true" });
  private readonly size: Readonly<Size>;

  private far = 1; // the most that an axis is away from where it rests

  constructor(
    private readonly store: Store,
    private readonly panel: HTMLElement,
    private readonly hand: Hand,
  ) {
    this.root.append(this.cursor);
    this.root.addEventListener("pointerdown", (event) => {
      if (hand.isOn) this.drawCurve(event);
    });
    panel.append(this.heat.element, this.root);
    this.size = watchSize(panel, () => this.draw());
    store.onChange(() => this.draw());
    store.onFrame(() => this.drawFrame());
  }

  private get network(): Network | null {
    return this.store.move.tracks[this.store.selection.track].network;
  }
  private get high(): number {
    return this.size.height - margin.top - margin.bottom;
  }
  private x(frame: number): number {
    return margin.left + (frame / this.store.move.frames) * (this.size.width - margin.left - margin.right);
  }
  private top(row: number, rows: number): number {
    return margin.top + (row / rows) * this.high;
  }

  draw(): void {
    const { width, height } = this.size;
    const { network } = this;
    if (this.panel.hidden || width === 0 || !network) return;
    const { store } = this;
    const index = store.selection.track;
    const { axes, keys, unit } = store.move.tracks[index];
    const { table, stride } = store.solution.tracks[index];
    attributes(this.root, {
      width,
      height,
      viewBox: `0 0 ${width} ${height}`,
      "aria-label": `${axes.length} axes over ${store.move.frames} frames, ${network.drawn.length} of them drawn`,
    });
    const frames = table.length / stride;
    let [low, high] = [Infinity, -Infinity];
    for (let frame = 0; frame < frames; ++frame) {
      for (let a = 0; a < axes.length; ++a) {
        const at = table[frame * stride + 4 + a];
        [low, high] = [Math.min(low, at), Math.max(high, at)];
      }
    }
    const rest = low <= 0 && high >= 0 ? 0 : (low + high) / 2;
    const far = Math.max(high - rest, rest - low) || 1;
    this.far = far;
    this.heat.clear(this.size);
    const { pen } = this.heat;
    const rowHigh = this.high / axes.length;
    const columns = Math.min(frames, Math.floor(width - margin.left - margin.right));
    const edge = (column: number): number =>
      margin.left + Math.round((column * (width - margin.left - margin.right)) / columns);
    for (let column = 0; column < columns; ++column) {
      const frame = Math.floor((column * frames) / columns);
      for (let a = 0; a < axes.length; ++a) {
        const away = (table[frame * stride + 4 + a] - rest) / far;
        pen.globalAlpha = Math.min(Math.abs(away), 1) * 0.85;
        pen.fillStyle = color(away >= 0 ? "ceiling" : "path");
        pen.fillRect(edge(column), this.top(a, axes.length), edge(column + 1) - edge(column), rowHigh);
      }
    }
    pen.globalAlpha = 1;
    for (let a = 0; a <= axes.length; ++a)
      this.heat.line(margin.left, this.top(a, axes.length), width - margin.right, this.top(a, axes.length));
    this.heat.stroke("grid");
    for (const key of keys)
      this.heat.line(this.x(key.frame ?? 0), margin.top, this.x(key.frame ?? 0), margin.top + this.high);
    this.heat.stroke("select", 1, [3, 3]);
    for (const { axis } of network.drawn) {
      for (let frame = 0; frame < frames; ++frame) {
        const away = (table[frame * stride + 4 + axis] - rest) / far;
        const y = this.top(axis, axes.length) + (0.5 - 0.45 * away) * rowHigh;
        if (frame === 0) pen.moveTo(this.x(frame), y);
        else pen.lineTo(this.x(frame), y);
      }
    }
    this.heat.stroke("text", 2);
    const isDrawn = (a: number): boolean => network.drawn.some(({ axis }) => axis === a);
    for (const [a, name] of axes.entries()) {
      const y = this.top(a, axes.length) + rowHigh / 2 + 4;
      this.heat.text(isDrawn(a) ? `✎ ${name}` : name, margin.left - 8, y, "right", isDrawn(a) ? "text" : "dim");
    }
    const words = (at: number): string => `${Number(at.toPrecision(3))} ${unit}`;
    this.heat.text(
      `orange: up to ${words(high)}; blue: down to ${words(low)}; lines: drawn; dashed: keys`,
      margin.left,
      14,
      "left",
    );
    for (const key of keys) this.heat.text(String(key.frame ?? 0), this.x(key.frame ?? 0), height - 10, "center");
    this.drawFrame();
  }

  /** From the press on; up is more, and the height of the view is twice what any axis of the row is away from rest. */
  private drawCurve(event: PointerEvent): void {
    const { store, hand } = this;
    const { axes } = store.move.tracks[store.selection.track];
    const y = event.clientY - this.root.getBoundingClientRect().top;
    const axis = Math.min(Math.max(Math.floor(((y - margin.top) / this.high) * axes.length), 0), axes.length - 1);
    event.preventDefault();
    hand.press(event);
    follow(
      event,
      (moved) => void hand.move(moved),
      (cancelled) => {
        const samples = hand.taken();
        if (!cancelled && samples) this.takeCurve(axis, samples);
      },
    );
  }

  /** The pace of the hand fills the move. At keys that have a position for the axis the curve is bent to meet it. */
  private takeCurve(axis: number, samples: readonly Sample[]): void {
    const { store } = this;
    const { move, selection } = store;
    const track = move.tracks[selection.track];
    const network = track.network!;
    const old = network.drawn.find((curve) => curve.axis === axis);
    const keys = old ? old.keys : track.keys.map((_, k) => k);
    const fixed = new Map(keys.map((k) => [track.keys[k].frame ?? 0, track.keys[k].at[axis]]));
    const between = Math.max(1, Math.round(perSecond(move.fps) / 8));
    const frames = Array.from({ length: Math.floor(move.frames / between) + 1 }, (_, i) => i * between).filter(
      (frame) => ![...fixed.keys(), move.frames].some((key) => key !== frame && Math.abs(key - frame) < between),
    );
    const all = [...new Set([0, ...frames, ...fixed.keys(), move.frames])].sort((a, b) => a - b);
    const drawn = all.map((frame) => this.heightAt(samples, frame / move.frames, between / move.frames));
    const met = all.map((frame, i) => (fixed.has(frame) ? fixed.get(frame)! - drawn[i] : null));
    const step = stepFor(2 * this.far) / 10;
    const at = all.map((frame, i) => fixed.get(frame) ?? roundTo(drawn[i] + bend(all, met, i), step));
    const curve: DrawnCurve = { axis, frames: all, at, keys, redrawn: true };
    const others = network.drawn.filter((one) => one.axis !== axis);
    store.edit(
      withTrack(move, selection.track, {
        network: { ...network, drawn: [...others, curve].sort((a, b) => a.axis - b.axis) },
      }),
    );
    say(`${track.axes[axis]} drawn: ${all.length} points, ${fixed.size} of them on keys.`);
    this.hand.toggle();
  }

  /** How far up the hand was at a share of its time, in the middle of a window of time. */
  private heightAt(samples: readonly Sample[], share: number, window: number): number {
    const [first, last] = [samples[0], samples[samples.length - 1]];
    const middle = first.time + share * (last.time - first.time);
    const half = (window * (last.time - first.time)) / 2;
    const near = samples.filter(({ time }) => Math.abs(time - middle) <= half);
    const behind = samples.findIndex(({ time }) => time >= middle);
    const ys = near.length > 0 ? near.map(({ y }) => y) : [samples[Math.max(behind, 0)].y];
    const mean = ys.reduce((sum, y) => sum + y, 0) / ys.length;
    return ((first.y - mean) * 2 * this.far) / this.high;
  }

  private drawFrame(): void {
    if (this.panel.hidden || !this.network) return;
    const x = this.x(Math.min(Math.max(this.store.frame, 0), this.store.move.frames));
    attributes(this.cursor, { x1: x, x2: x, y1: margin.top, y2: margin.top + this.high });
  }
}

/** Between two frames that are met in proportion, and beyond the last of them as there. */
function bend(frames: readonly number[], met: readonly (number | null)[], i: number): number {
  let before = i;
  let behind = i;
  while (before >= 0 && met[before] === null) --before;
  while (behind < met.length && met[behind] === null) ++behind;
  if (before < 0 && behind >= met.length) return 0;
  if (before < 0) return met[behind]!;
  if (behind >= met.length || before === behind) return met[before]!;
  const share = (frames[i] - frames[before]) / (frames[behind] - frames[before]);
  return met[before]! + share * (met[behind]! - met[before]!);
}

/** The tab is there where a network is; such a track is first seen in it. */
export function showRowTab(store: Store): void {
  const tab = byId("tab-row");
  const has = store.move.tracks[store.selection.track].network !== null;
  if (tab.hidden === !has) return;
  tab.hidden = !has;
  byId(has ? "tab-row" : "tab-plan").click();
}

export const rowPanel = (): HTMLElement => html("div", { id: "row", class: "fill" });
