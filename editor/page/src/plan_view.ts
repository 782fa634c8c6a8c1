// The path in plan or elevation: two axes of a track against each other, keys as handles, frames as ticks.
import { attributes, byId, follow, html, say, svg, ticks } from "./dom";
import type { Hand } from "./hand";
import { insertOnPath, moveKeys, removeKeys } from "./edits";
import { firstAxis, isRounded, stepFor } from "./move";
import { parameterOf } from "./solver";
import type { Store } from "./store";
import { colorChanges, type Size, Strokes, watchSize } from "./strokes";

const margin = { left: 46, right: 16, top: 16, bottom: 26 };

interface Box {
  x0: number;
  x1: number;
  y0: number;
  y1: number;
}

export class PlanView {
  private readonly root = svg("svg", { class: "plot", role: "group" });
  private readonly hit = svg("path", { class: "path-hit", "aria-hidden": "true" });
  private readonly ground = new Strokes(); // the grid and the path
  private readonly strokes = new Strokes(); // the frames
  private readonly rig = svg("circle", { class: "playhead-dot", r: 6, "aria-hidden": "true" });
  private readonly trace = svg("polyline", { class: "trace", "aria-hidden": "true" }); // of a hand
  private readonly handles = svg("g", { role: "listbox", "aria-label": "Keys", "aria-multiselectable": "true" });
  private readonly keys: SVGGElement[] = [];
  private box: Box = { x0: 0, x1: 1, y0: 0, y1: 1 };
  private readonly size: Readonly<Size>;
  private held: Box | null = null; // while a key is dragged the view stands still
  private drawnFrom: unknown[] = [];
  private isPressing = false;
  horizontal = 0;
  vertical = 1;

  constructor(
    private readonly store: Store,
    place: HTMLElement,
    private readonly hand: Hand,
  ) {
    this.root.append(this.hit, this.handles, this.rig, this.trace);
    place.append(this.ground.element, this.strokes.element, this.root);
    this.size = watchSize(place, () => this.draw());
    store.onChange(() => this.draw());
    store.onFrame(() => this.drawFrame());
    this.hit.addEventListener("dblclick", (event) => this.insertAt(event));
    this.root.addEventListener(
      "pointerdown",
      (event) => {
        if (hand.isOn) this.drawMotion(event);
      },
      true,
    );
    this.root.addEventListener("pointerdown", (event) => {
      if (event.target === this.root && !hand.isOn) store.select({ keys: new Set() });
    });
    const marked = hand.onSwitch;
    hand.onSwitch = () => {
      marked();
      this.root.classList.toggle("drawing", hand.isOn);
    };
  }

  get shown(): boolean {
    return !byId("plan").hidden;
  }

  private get one(): { index: number; axes: number } {
    const index = this.store.selection.track;
    return { index, axes: this.store.move.tracks[index].axes.length };
  }

  /** Positions by frame or by place of the path, in the two axes that are shown. A track of one axis is shown over s. */
  private place(values: ArrayLike<number>, offset: number, along: number): [number, number] {
    const { axes } = this.one;
    if (axes === 1) return [along, values[offset]];
    return [values[offset + Math.min(this.horizontal, axes - 1)], values[offset + Math.min(this.vertical, axes - 1)]];
  }

  private x(value: number): number {
    const { x0, x1 } = this.box;
    return margin.left + ((value - x0) / (x1 - x0)) * (this.size.width - margin.left - margin.right);
  }
  private y(value: number): number {
    const { y0, y1 } = this.box;
    return (
      this.size.height - margin.bottom - ((value - y0) / (y1 - y0)) * (this.size.height - margin.top - margin.bottom)
    );
  }
  private perPixel(): [number, number] {
    const { x0, x1, y0, y1 } = this.box;
    return [
      (x1 - x0) / (this.size.width - margin.left - margin.right),
      (y1 - y0) / (this.size.height - margin.top - margin.bottom),
    ];
  }

  private fit(points: [number, number][]): Box {
    let [x0, x1, y0, y1] = [Infinity, -Infinity, Infinity, -Infinity];
    for (const [x, y] of points) {
      x0 = Math.min(x0, x);
      x1 = Math.max(x1, x);
      y0 = Math.min(y0, y);
      y1 = Math.max(y1, y);
    }
    const pad = (low: number, high: number): [number, number] => {
      const span = Math.max(high - low, 1e-6 * Math.max(Math.abs(low), Math.abs(high), 1));
      return [low - 0.1 * span, high + 0.1 * span];
    };
    [x0, x1] = pad(x0, x1);
    [y0, y1] = pad(y0, y1);
    // One scale for both where both have one unit: a plan is no graph.
    const move = this.store.move;
    const first = firstAxis(move, this.one.index);
    const unit = (axis: number): string => move.axes[first + Math.min(axis, this.one.axes - 1)].unit;
    if (this.one.axes > 1 && unit(this.horizontal) === unit(this.vertical)) {
      const wide = this.size.width - margin.left - margin.right;
      const high = this.size.height - margin.top - margin.bottom;
      const scale = Math.max((x1 - x0) / wide, (y1 - y0) / high);
      const cx = (x0 + x1) / 2;
      const cy = (y0 + y1) / 2;
      [x0, x1, y0, y1] = [
        cx - (scale * wide) / 2,
        cx + (scale * wide) / 2,
        cy - (scale * high) / 2,
        cy + (scale * high) / 2,
      ];
    }
    return { x0, x1, y0, y1 };
  }

  draw(): void {
    const { width, height } = this.size;
    if (!this.shown || width === 0) return;
    attributes(this.root, { width, height, viewBox: `0 0 ${width} ${height}` });
    const { store } = this;
    const { index, axes } = this.one;
    const track = store.move.tracks[index];
    const solved = store.solution.tracks[index];
    // What the keys alone decide is drawn anew when they change, and not with every picture of a dragged speed curve.
    const from = [
      track.keys,
      track.spline,
      track.closed,
      track.path,
      store.selection.keys,
      width,
      height,
      this.horizontal,
      this.vertical,
      this.held,
      colorChanges,
    ];
    if (from.some((one, i) => one !== this.drawnFrom[i])) {
      this.drawnFrom = from;
      const count = solved.path.length / axes;
      const points: [number, number][] = [];
      for (let i = 0; i < count; ++i) points.push(this.place(solved.path, i * axes, parameterOf(solved, i)));
      this.box = this.held ?? this.fit(points);
      this.ground.clear(this.size);
      this.drawGrid();
      for (const [x, y] of points) this.ground.pen.lineTo(this.x(x), this.y(y));
      this.ground.stroke("path", 2);
      if (!store.isDragging) {
        attributes(this.hit, {
          d: points.map(([x, y], i) => `${i ? "L" : "M"}${this.x(x).toFixed(1)} ${this.y(y).toFixed(1)}`).join(""),
        });
      }
      this.drawKeys(track.fixed_keys !== null);
    }
    this.strokes.clear(this.size);
    this.drawTicks();
    this.drawFrame();
  }

  private tablePoint(frame: number): [number, number] {
    const solved = this.store.solution.tracks[this.one.index];
    return this.place(solved.table, frame * solved.stride + 4, solved.table[frame * solved.stride]);
  }

  private drawTicks(): void {
    const solved = this.store.solution.tracks[this.one.index];
    const frames = solved.table.length / solved.stride;
    const certificate = this.store.solution.certificate;
    const ceilings = certificate?.ceilings[this.one.index];
    const at: [number, number][] = [];
    for (let f = 0; f < frames; ++f) {
      const [x, y] = this.tablePoint(f);
      at.push([this.x(x), this.y(y)]);
    }
    const { pen } = this.strokes;
    const isOver = (f: number): boolean =>
      ceilings !== undefined && rateAt(ceilings, f, certificate!.firstFrame, certificate!.lastFrame) < 1;
    const put = (f: number): void => {
      const [bx, by] = at[Math.max(f - 1, 0)];
      const [ax, ay] = at[Math.min(f + 1, frames - 1)];
      const length = Math.hypot(ax - bx, ay - by);
      // Where the rig stands there is no direction; a short upright tick will do.
      const [nx, ny] = length > 1e-3 ? [-(ay - by) / length, (ax - bx) / length] : [0, 1];
      const size = f % 10 === 0 ? 8 : 4.5;
      const [px, py] = at[f];
      pen.moveTo(px - nx * size, py - ny * size);
      pen.lineTo(px + nx * size, py + ny * size);
    };
    for (let f = 0; f < frames; ++f) if (!isOver(f)) put(f);
    this.strokes.stroke("ticks");
    for (let f = 0; f < frames; ++f) if (isOver(f)) put(f);
    this.strokes.stroke("over", 2);
  }

  private drawGrid(): void {
    const { store, box } = this;
    const track = store.move.tracks[this.one.index];
    const first = firstAxis(store.move, this.one.index);
    const label = (axis: number): string => {
      const a = Math.min(axis, track.axes.length - 1);
      const unit = store.move.axes[first + a].unit;
      return unit ? `${track.axes[a]} (${unit})` : track.axes[a];
    };
    const [xLabel, yLabel] = this.one.axes === 1 ? ["key", label(0)] : [label(this.horizontal), label(this.vertical)];
    const strokes = this.ground;
    const [right, bottom] = [this.size.width - margin.right, this.size.height - margin.bottom];
    for (const value of ticks(box.x0, box.x1, 8)) {
      strokes.line(this.x(value), margin.top, this.x(value), bottom);
      strokes.text(String(value), this.x(value), bottom + 15, "center");
    }
    for (const value of ticks(box.y0, box.y1, 6)) {
      strokes.line(margin.left, this.y(value), right, this.y(value));
      strokes.text(String(value), margin.left - 6, this.y(value) + 4, "right");
    }
    strokes.stroke("grid");
    strokes.text(xLabel, right, bottom - 6, "right", "text");
    strokes.text(yLabel, margin.left + 6, margin.top + 6, "left", "text");
  }

  private drawKeys(fixed: boolean): void {
    const { store } = this;
    const track = store.move.tracks[this.one.index];
    const solved = store.solution.tracks[this.one.index];
    const shown = solved.keyFrames.length - 1 === track.keys.length ? track.keys : [];
    while (this.keys.length > shown.length) this.keys.pop()!.remove();
    while (this.keys.length < shown.length) {
      const k = this.keys.length;
      const group = svg(
        "g",
        { class: "key", role: "option" },
        svg("line", { class: "miss" }),
        svg("circle", { r: 16, class: "grip" }),
        svg("circle", { r: 6.5, class: "knob" }),
        svg("text", { dy: -11, "text-anchor": "middle" }),
      );
      group.addEventListener("pointerdown", (event) => this.press(event, k));
      group.addEventListener("keydown", (event) => this.type(event, k));
      group.addEventListener("focus", () => {
        if (!this.isPressing && !store.selection.keys.has(k)) store.selectKey(k);
      });
      this.keys.push(group);
      this.handles.append(group);
    }
    const selected = store.selection.keys;
    const focusable = selected.size > 0 ? Math.min(...selected) : 0;
    let labelled: [number, number] = [-1e9, -1e9]; // numbers that would lie on each other are left out
    for (const [k, key] of shown.entries()) {
      const [x, y] = this.place(track.path ? solved.keyPlaces[k] : key.at, 0, k);
      const group = this.keys[k];
      const words = track.axes.map((axis, a) => `${axis} ${key.at[a]}`).join(", ");
      const lock = key.frame !== null ? `, locked on frame ${key.frame}` : "";
      attributes(group, {
        transform: `translate(${this.x(x).toFixed(1)} ${this.y(y).toFixed(1)})`,
        "aria-selected": String(selected.has(k)),
        "aria-label": `Key ${k}: ${words}${lock}`,
        tabindex: k === focusable ? 0 : -1,
        class: `key${selected.has(k) ? " selected" : ""}${key.frame !== null || key.hold !== null ? " locked" : ""}${fixed ? " fixed" : ""}`,
      });
      const here: [number, number] = [this.x(x), this.y(y)];
      const isFree = Math.hypot(here[0] - labelled[0], here[1] - labelled[1]) > 24;
      if (isFree) labelled = here;
      const label = isFree || selected.has(k) ? String(k) : "";
      this.drawMiss(group.firstElementChild!, isRounded(track) ? this.place(solved.keyPlaces[k], 0, k) : null, here);
      const text = group.lastElementChild!;
      if (text.textContent !== label) text.textContent = label;
    }
  }

  /** From the key to where the path is when it passes. */
  private drawMiss(line: Element, passed: [number, number] | null, [x, y]: [number, number]): void {
    const at = passed === null ? [0, 0] : [this.x(passed[0]) - x, this.y(passed[1]) - y];
    attributes(line, { x2: at[0].toFixed(1), y2: at[1].toFixed(1) });
  }

  private drawFrame(): void {
    if (!this.shown) return;
    const { store } = this;
    const { index, axes } = this.one;
    const first = firstAxis(store.move, index);
    const all = store.move.axes.length;
    const motion = store.solver.motion(store.frame, 1, 1, all);
    const here = Array.from({ length: axes }, (_, a) => motion[(first + a) * 4]);
    const solved = store.solution.tracks[index];
    const frame = Math.min(Math.max(Math.round(store.frame), 0), solved.table.length / solved.stride - 1);
    const [x, y] = this.place(here, 0, solved.table[frame * solved.stride]);
    attributes(this.rig, { cx: this.x(x), cy: this.y(y) });
  }

  /** From the press on; the trace is drawn as it comes. */
  private drawMotion(event: PointerEvent): void {
    event.preventDefault();
    event.stopPropagation();
    const { hand } = this;
    const { axes } = this.one;
    const { left, top } = this.root.getBoundingClientRect();
    const { x0, y0 } = this.box;
    const [px, py] = this.perPixel();
    const bottom = this.size.height - margin.bottom;
    const toAxes = (x: number, y: number): [number, number] => [
      x0 + (x - left - margin.left) * px,
      y0 + (bottom - (y - top)) * py,
    ];
    hand.press(event);
    follow(
      event,
      (e) => {
        const samples = hand.move(e);
        attributes(this.trace, {
          points: samples.map(({ x, y }) => `${(x - left).toFixed(1)},${(y - top).toFixed(1)}`).join(" "),
        });
      },
      (cancelled) => {
        this.trace.removeAttribute("points");
        const shown: [number, number] =
          axes === 1 ? [-1, 0] : [Math.min(this.horizontal, axes - 1), Math.min(this.vertical, axes - 1)];
        if (!cancelled) void hand.release(shown, toAxes, [px, py]);
      },
    );
  }

  private press(event: PointerEvent, k: number): void {
    event.preventDefault();
    event.stopPropagation();
    const { store } = this;
    const more = event.shiftKey || event.ctrlKey || event.metaKey;
    this.isPressing = true; // a press says itself what is selected, and adds to it with Shift or Ctrl
    this.keys[k].focus({ preventScroll: true });
    this.isPressing = false;
    if (more || !store.selection.keys.has(k)) store.selectKey(k, more);
    const track = store.move.tracks[this.one.index];
    if (track.fixed_keys) return say(`Keys of this track: ${track.fixed_keys}.`);
    const start = store.move;
    const [px, py] = this.perPixel();
    const from = { x: event.clientX, y: event.clientY };
    const keys = store.selection.keys.has(k) ? [...store.selection.keys] : [k];
    let moving = false;
    this.held = this.box;
    store.begin();
    follow(
      event,
      (e) => {
        const dx = e.clientX - from.x;
        const dy = e.clientY - from.y;
        if (!moving && Math.hypot(dx, dy) < 3) return;
        moving = true;
        const by = new Array<number>(this.one.axes).fill(0);
        if (this.one.axes > 1) by[Math.min(this.horizontal, this.one.axes - 1)] += dx * px;
        by[this.one.axes > 1 ? Math.min(this.vertical, this.one.axes - 1) : 0] -= dy * py;
        const steps = by.map((_, a) =>
          stepFor(a === this.horizontal ? this.box.x1 - this.box.x0 : this.box.y1 - this.box.y0),
        );
        store.edit(moveKeys(start, this.one.index, keys, by, steps));
      },
      (cancelled) => {
        this.held = null;
        if (cancelled) store.cancel();
        else store.end();
        this.draw();
      },
    );
  }

  private type(event: KeyboardEvent, k: number): void {
    const { store } = this;
    const track = store.move.tracks[this.one.index];
    const selected = store.selection.keys.size > 0 ? [...store.selection.keys] : [k];
    const go = (to: number): void => {
      const next = Math.min(Math.max(to, 0), track.keys.length - 1);
      store.selectKey(next);
      this.keys[next]?.focus();
    };
    const arrow = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (arrow && !event.altKey) {
      go(k + (arrow[0] + arrow[1] > 0 ? 1 : -1));
    } else if (arrow) {
      if (track.fixed_keys) return say(`Keys of this track: ${track.fixed_keys}.`);
      const steps = track.axes.map((_, a) =>
        stepFor(a === this.horizontal && this.one.axes > 1 ? this.box.x1 - this.box.x0 : this.box.y1 - this.box.y0),
      );
      const by = track.axes.map((_, a) => {
        const size = event.shiftKey ? 10 : 1;
        if (this.one.axes === 1) return (arrow[0] + arrow[1]) * size * steps[a];
        return size * steps[a] * (a === this.horizontal ? arrow[0] : a === this.vertical ? arrow[1] : 0);
      });
      store.edit(moveKeys(store.move, this.one.index, selected, by, steps));
      const moved = store.move.tracks[this.one.index].keys[k].at;
      say(`Key ${k}: ${track.axes.map((axis, a) => `${axis} ${moved[a]}`).join(", ")}`);
    } else if (event.key === "Delete" || event.key === "Backspace") {
      removeKeys(store);
    } else if (event.key === "Insert" || event.key === "i") {
      insertOnPath(store, k + 0.5);
    } else if (event.key === "Home") {
      go(0);
    } else if (event.key === "End") {
      go(track.keys.length - 1);
    } else if (event.key === " ") {
      store.selectKey(k, true);
    } else {
      return;
    }
    event.preventDefault();
    event.stopPropagation();
  }

  private insertAt(event: MouseEvent): void {
    const { left, top } = this.root.getBoundingClientRect();
    const { index, axes } = this.one;
    const solved = this.store.solution.tracks[index];
    let best = 0;
    let nearest = Infinity;
    for (let i = 0; i * axes < solved.path.length; ++i) {
      const [x, y] = this.place(solved.path, i * axes, parameterOf(solved, i));
      const far = Math.hypot(this.x(x) - (event.clientX - left), this.y(y) - (event.clientY - top));
      if (far < nearest) [nearest, best] = [far, i];
    }
    insertOnPath(this.store, parameterOf(solved, best));
  }
}

/** Of the cells beside a frame the least: so many times faster every limit of the track still holds there. */
export function rateAt(ceilings: readonly { rate: number }[], frame: number, first: number, last: number): number {
  const cell = Math.floor(((frame - first) / Math.max(last - first, 1)) * ceilings.length);
  return ceilings[Math.min(Math.max(cell, 0), ceilings.length - 1)]?.rate ?? Infinity;
}

export function planPanel(): HTMLElement {
  return html("div", { id: "plan", class: "fill" });
}
