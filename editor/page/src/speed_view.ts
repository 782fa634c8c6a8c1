// The speed curve with its control values, their polygon, the units, and the ceiling that the limits make.
import { attributes, follow, say, svg, ticks } from "./dom";
import { insertValue, removeValues, setValues } from "./edits";
import { fixedSpeed, max_control_value } from "./move";
import { movedOf, quantities } from "./solver";
import type { Store } from "./store";
import { type Size, Strokes, watchSize } from "./strokes";

const margin = { left: 46, right: 62, top: 12, bottom: 22 };
const samples = 400;

export class SpeedView {
  private readonly root = svg("svg", { class: "plot", role: "group" });
  private readonly strokes = new Strokes();
  private readonly red = svg("path", { class: "over", "aria-hidden": "true" });
  private readonly polygon = svg("polyline", { class: "polygon", "aria-hidden": "true" });
  private readonly cursor = svg("line", { class: "cursor", "aria-hidden": "true" });
  private readonly handles = svg("g", { role: "group", "aria-label": "Control values" });
  private readonly band = svg("rect", { class: "band", hidden: true });
  private readonly knobs: SVGGElement[] = [];
  private readonly size: Readonly<Size>;
  private top = max_control_value; // of the scale, in control values
  private held = false;
  private isPressing = false;

  /** `overText` says what is too high: beside the curve, where it is written over nothing. */
  constructor(
    private readonly store: Store,
    place: HTMLElement,
    private readonly overText: HTMLElement,
  ) {
    this.root.append(this.red, this.polygon, this.cursor, this.band, this.handles);
    place.append(this.strokes.element, this.root);
    this.size = watchSize(place, () => this.draw());
    store.onChange(() => this.draw());
    store.onFrame(() => this.drawCursor());
    this.root.addEventListener("pointerdown", (event) => this.pressBackground(event));
    this.root.addEventListener("dblclick", (event) => this.insertAt(event));
  }

  private x(share: number): number {
    return margin.left + share * (this.size.width - margin.left - margin.right);
  }
  private y(value: number): number {
    return this.size.height - margin.bottom - (value / this.top) * (this.size.height - margin.top - margin.bottom);
  }
  private share(clientX: number): number {
    const { left } = this.root.getBoundingClientRect();
    return (clientX - left - margin.left) / (this.size.width - margin.left - margin.right);
  }
  private get track() {
    return this.store.move.tracks[this.store.selection.track];
  }

  draw(): void {
    const { width, height } = this.size;
    if (width === 0) return;
    attributes(this.root, { width, height, viewBox: `0 0 ${width} ${height}` });
    const { store } = this;
    const index = store.selection.track;
    const solved = store.solution.tracks[index];
    const speed = this.track.speed;
    const drawn = speed ?? [];
    if (!this.held) {
      const most = Math.max(...drawn, ...solved.played, 1);
      this.top = speed ? Math.min(1.3 * most, 1.06 * max_control_value) : 1;
    }
    // The curve that is played, in control values; of a track that is timed by frames the speed itself.
    const values = this.sampleCurve(index);
    this.strokes.clear(this.size);
    this.drawGrid(solved.unitPerValue);
    const { pen } = this.strokes;
    for (let i = 0; i < samples; ++i) pen.lineTo(this.x(i / (samples - 1)), this.y(values[i]));
    this.strokes.stroke("speed", 2.2);
    this.drawCeiling(values);
    const f = Math.max(drawn.length - 1, 1);
    attributes(this.polygon, {
      points: drawn.map((value, i) => `${this.x(i / f).toFixed(1)},${this.y(value).toFixed(1)}`).join(" "),
    });
    this.drawKnobs(drawn, f);
    this.drawCursor();
  }

  private sampleCurve(index: number): Float64Array {
    const { store } = this;
    if (store.solution.tracks[index].played.length > 0) return store.solver.speed(index, samples, false);
    const values = store.solver.speed(index, samples, true);
    if (!this.held) this.top = 1.2 * Math.max(...values, 1e-9);
    return values;
  }

  private drawCeiling(values: Float64Array): void {
    const { certificate } = this.store.solution;
    const index = this.store.selection.track;
    const cells = certificate?.ceilings[index];
    const { pen } = this.strokes;
    let over = "";
    let worst = { rate: 1, share: 0, axis: -1, quantity: 0 };
    if (cells && certificate) {
      const frames = this.store.move.frames;
      const span = Math.max(certificate.lastFrame - certificate.firstFrame, 1);
      // A cell is one number: the line goes through the middles of the cells.
      let isDown = false;
      for (const [i, cell] of cells.entries()) {
        const share = (certificate.firstFrame + ((i + 0.5) / cells.length) * span) / frames;
        const value = values[Math.round(share * (samples - 1))] ?? 0;
        const visible = share >= 0 && share <= 1 && Number.isFinite(cell.rate) && value > 1e-6 * this.top;
        const [x, y] = [this.x(share), this.y(Math.min(value * cell.rate, 1.02 * this.top))];
        if (visible && isDown) pen.lineTo(x, y);
        else if (visible) pen.moveTo(x, y);
        isDown = visible;
      }
      let red = false;
      for (let i = 0; i < samples; ++i) {
        const share = i / (samples - 1);
        const at = Math.floor(((share * frames - certificate.firstFrame) / span) * cells.length);
        const cell = cells[Math.min(Math.max(at, 0), cells.length - 1)];
        if (cell.rate < 1) over += `${red ? "L" : "M"}${this.x(share).toFixed(1)} ${this.y(values[i]).toFixed(1)}`;
        if (cell.rate < worst.rate) worst = { ...cell, share };
        red = cell.rate < 1;
      }
    }
    this.strokes.stroke("ceiling", 1.3, [7, 3]);
    attributes(this.red, { d: over });
    const words =
      worst.axis < 0
        ? ""
        : `${movedOf(this.store.move)[worst.axis].name}: ${quantities[worst.quantity]} ${overInWords(
            worst,
          )} near frame ${Math.round(worst.share * this.store.move.frames)}`;
    if (this.overText.textContent !== words) this.overText.textContent = words;
    attributes(this.overText, { title: words });
  }

  private drawGrid(unit: number): void {
    const isDrawn = this.track.speed !== null;
    const per = isDrawn ? unit : 1;
    const name = this.track.unit ? `${this.track.unit}/s` : "units/s";
    const { frames } = this.store.move;
    const { strokes } = this;
    const [right, bottom] = [this.size.width - margin.right, this.size.height - margin.bottom];
    for (const value of ticks(0, this.top, 4)) {
      const y = this.y(value);
      strokes.line(margin.left, y, right, y);
      if (isDrawn) strokes.text(String(value), margin.left - 6, y + 4, "right");
    }
    for (const frame of ticks(0, frames, 12)) {
      if (!Number.isInteger(frame)) continue;
      const x = this.x(frame / frames);
      strokes.line(x, margin.top, x, bottom);
      strokes.text(String(frame), x, this.size.height - 7, "center");
    }
    strokes.stroke("grid");
    // The real speed at this frame count, on its own scale at the right.
    if (!(per > 0)) return;
    for (const real of ticks(0, this.top * per, 4)) {
      const y = this.y(real / per);
      if (y < margin.top + 12) continue; // the unit stands there
      strokes.line(right, y, right + 4, y);
      strokes.text(String(real), right + 8, y + 4, "left");
    }
    strokes.stroke("dim");
    strokes.text(name, this.size.width - 6, margin.top + 2, "right", "text");
  }

  private drawKnobs(values: readonly number[], f: number): void {
    const { store } = this;
    while (this.knobs.length > values.length) this.knobs.pop()!.remove();
    while (this.knobs.length < values.length) {
      const i = this.knobs.length;
      const knob = svg(
        "g",
        {
          class: "value",
          role: "slider",
          "aria-orientation": "vertical",
          "aria-valuemin": 0,
          "aria-valuemax": max_control_value,
        },
        svg("circle", { r: 14, class: "grip" }),
        svg("rect", { x: -5, y: -5, width: 10, height: 10, rx: 2, class: "knob" }),
      );
      knob.addEventListener("pointerdown", (event) => this.press(event, i));
      knob.addEventListener("keydown", (event) => this.type(event, i));
      knob.addEventListener("focus", () => {
        if (!this.isPressing && !store.selection.values.has(i)) store.selectValue(i);
      });
      this.knobs.push(knob);
      this.handles.append(knob);
    }
    const selected = store.selection.values;
    const focusable = selected.size > 0 ? Math.min(...selected) : 0;
    const fixed = fixedSpeed(this.track) !== null;
    for (const [i, value] of values.entries()) {
      const frame = Math.round((i / f) * store.move.frames);
      attributes(this.knobs[i], {
        transform: `translate(${this.x(i / f).toFixed(1)} ${this.y(value).toFixed(1)})`,
        "aria-label": `Control value ${i} of ${f}, at frame ${frame}`,
        "aria-valuenow": value,
        tabindex: i === focusable ? 0 : -1,
        class: `value${selected.has(i) ? " selected" : ""}${fixed ? " fixed" : ""}`,
      });
    }
  }

  private drawCursor(): void {
    const x = this.x(Math.min(Math.max(this.store.frame / this.store.move.frames, 0), 1));
    attributes(this.cursor, { x1: x, x2: x, y1: margin.top, y2: this.size.height - margin.bottom });
  }

  private press(event: PointerEvent, i: number): void {
    event.preventDefault();
    event.stopPropagation();
    const { store } = this;
    const more = event.shiftKey || event.ctrlKey || event.metaKey;
    this.isPressing = true; // a press says itself what is selected, and adds to it with Shift or Ctrl
    this.knobs[i].focus({ preventScroll: true });
    this.isPressing = false;
    if (more || !store.selection.values.has(i)) store.selectValue(i, more);
    const why = fixedSpeed(this.track);
    if (why) return say(why);
    const start = store.move;
    const index = store.selection.track;
    const chosen = new Set(store.selection.values).add(i);
    const from = event.clientY;
    const perPixel = this.top / (this.size.height - margin.top - margin.bottom);
    this.held = true;
    store.begin();
    follow(
      event,
      (e) => {
        const by = (from - e.clientY) * perPixel;
        const coarse = e.altKey ? 0.01 : 0.1;
        store.edit(
          setValues(start, index, (value, k) => (chosen.has(k) ? Math.round((value + by) / coarse) * coarse : value)),
        );
      },
      (cancelled) => {
        this.held = false;
        if (cancelled) store.cancel();
        else store.end();
        const value = this.track.speed![i];
        say(`Control value ${i}: ${value}`);
        this.draw();
      },
    );
  }

  private pressBackground(event: PointerEvent): void {
    if (event.button !== 0) return;
    const { store } = this;
    const { left, top } = this.root.getBoundingClientRect();
    const x0 = event.clientX - left;
    const y0 = event.clientY - top;
    let drawn = false;
    follow(
      event,
      (e) => {
        const x1 = e.clientX - left;
        const y1 = e.clientY - top;
        drawn = drawn || Math.hypot(x1 - x0, y1 - y0) > 4;
        if (!drawn) return;
        this.band.removeAttribute("hidden");
        attributes(this.band, {
          x: Math.min(x0, x1),
          y: Math.min(y0, y1),
          width: Math.abs(x1 - x0),
          height: Math.abs(y1 - y0),
        });
        const speed = this.track.speed ?? [];
        const f = Math.max(speed.length - 1, 1);
        const inside = speed.flatMap((value, i) => {
          const [x, y] = [this.x(i / f), this.y(value)];
          return x >= Math.min(x0, x1) && x <= Math.max(x0, x1) && y >= Math.min(y0, y1) && y <= Math.max(y0, y1)
            ? [i]
            : [];
        });
        store.select({ values: new Set(inside), keys: new Set() });
      },
      () => {
        this.band.setAttribute("hidden", "");
        if (!drawn) {
          store.select({ values: new Set() });
          const share = Math.min(Math.max(this.share(event.clientX), 0), 1);
          store.setFrame(Math.round(share * store.move.frames));
        }
      },
    );
  }

  private insertAt(event: MouseEvent): void {
    const speed = this.track.speed;
    if (!speed) return;
    const { top } = this.root.getBoundingClientRect();
    const value =
      (this.size.height - margin.bottom - (event.clientY - top)) *
      (this.top / (this.size.height - margin.top - margin.bottom));
    const index = Math.min(Math.max(Math.ceil(this.share(event.clientX) * (speed.length - 1)), 1), speed.length - 1);
    insertValue(this.store, index, value);
  }

  private type(event: KeyboardEvent, i: number): void {
    const { store } = this;
    const speed = this.track.speed!;
    const go = (to: number): void => {
      const next = Math.min(Math.max(to, 0), speed.length - 1);
      store.selectValue(next);
      this.knobs[next]?.focus();
    };
    const change = (by: number): void => {
      const why = fixedSpeed(this.track);
      if (why) return say(why);
      // What is selected, and not where the keyboard was before something was inserted.
      const chosen = store.selection.values.size > 0 ? store.selection.values : new Set([i]);
      store.edit(setValues(store.move, store.selection.track, (value, k) => (chosen.has(k) ? value + by : value)));
    };
    const step = event.shiftKey ? 5 : event.altKey ? 0.05 : 0.5;
    switch (event.key) {
      case "ArrowLeft":
        go(i - 1);
        break;
      case "ArrowRight":
        go(i + 1);
        break;
      case "ArrowUp":
        change(step);
        break;
      case "ArrowDown":
        change(-step);
        break;
      case "PageUp":
        change(10);
        break;
      case "PageDown":
        change(-10);
        break;
      case "Home":
        go(0);
        break;
      case "End":
        go(speed.length - 1);
        break;
      case "Insert":
      case "i":
        insertValue(store, i + 1);
        break;
      case "Delete":
      case "Backspace":
        removeValues(store);
        break;
      case " ":
        store.selectValue(i, true);
        break;
      case "a":
        if (!(event.ctrlKey || event.metaKey)) return;
        store.select({ values: new Set(speed.keys()), keys: new Set() });
        break;
      default:
        return;
    }
    event.preventDefault();
    event.stopPropagation();
  }
}

/** By how much the quantity itself is too high: velocity goes with the rate, acceleration with its square ... */
function overInWords(worst: { rate: number; quantity: number }): string {
  const times = worst.rate ** -(worst.quantity + 1);
  const percent = (times - 1) * 100;
  if (percent >= 1000) return `is ${Number(times.toPrecision(2))} times what is allowed`;
  return `${percent.toFixed(percent < 10 ? 1 : 0)} % too high`;
}
