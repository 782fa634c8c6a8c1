// The bar of frame stripes, spaced by the distance between frames, with the keys on it.
import { attributes, button, follow, html, svg } from "./dom";
import { shiftKeys } from "./edits";
import { rateAt } from "./plan_view";
import type { Store } from "./store";
import { type Size, Strokes, watchSize } from "./strokes";

export class TimeBar {
  private readonly root = svg("svg", { class: "plot", role: "slider", tabindex: 0, "aria-label": "Frame" });
  private readonly strokes = new Strokes();
  private readonly keys = svg("g", { class: "bar-keys" });
  private readonly cursor = svg("line", { class: "cursor" });
  private readonly place = html("div", { class: "fill" });
  private readonly marks: SVGPathElement[] = [];
  private readonly size: Readonly<Size>;

  constructor(
    private readonly store: Store,
    section: HTMLElement,
  ) {
    this.root.append(this.keys, this.cursor);
    this.place.append(this.strokes.element, this.root);
    section.append(
      button("◀", "Meet the selected keys one frame earlier ([)", () => shiftKeys(store, -1), "earlier"),
      this.place,
      button("▶", "Meet the selected keys one frame later (])", () => shiftKeys(store, 1), "later"),
    );
    this.size = watchSize(this.place, () => this.draw());
    store.onChange(() => this.draw());
    store.onFrame(() => this.drawCursor());
    this.root.addEventListener("pointerdown", (event) => {
      this.scrub(event);
      follow(
        event,
        (e) => this.scrub(e),
        () => {},
      );
    });
    this.root.addEventListener("keydown", (event) => this.type(event));
  }

  /** The place of a frame: the share of the distance that is travelled by then. */
  private x(frame: number): number {
    const solved = this.store.solution.tracks[this.store.selection.track];
    const frames = solved.table.length / solved.stride - 1;
    const at = Math.min(Math.max(frame, 0), frames);
    const low = Math.floor(at);
    const distance = (f: number): number => solved.table[Math.min(f, frames) * solved.stride + 1];
    const here = distance(low) + (at - low) * (distance(low + 1) - distance(low));
    return 6 + (solved.length > 0 ? here / solved.length : at / frames) * (this.size.width - 12);
  }

  private scrub(event: PointerEvent): void {
    const x = event.clientX - this.root.getBoundingClientRect().left;
    const { frames } = this.store.move;
    let [low, high] = [0, frames];
    while (low < high) {
      const middle = Math.floor((low + high) / 2);
      if (this.x(middle) < x) low = middle + 1;
      else high = middle;
    }
    if (low > 0 && x - this.x(low - 1) < this.x(low) - x) --low;
    this.store.setFrame(low);
  }

  private type(event: KeyboardEvent): void {
    const { store } = this;
    const by = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageUp: 10, PageDown: -10 }[event.key];
    if (by !== undefined) store.setFrame(Math.min(Math.max(Math.round(store.frame) + by, 0), store.move.frames));
    else if (event.key === "Home") store.setFrame(0);
    else if (event.key === "End") store.setFrame(store.move.frames);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  draw(): void {
    const { width, height } = this.size;
    if (width === 0) return;
    const { store } = this;
    attributes(this.root, { width, height, viewBox: `0 0 ${width} ${height}` });
    const { certificate } = store.solution;
    const index = store.selection.track;
    const cells = certificate?.ceilings[index];
    const solved = store.solution.tracks[index];
    const frames = solved.table.length / solved.stride - 1;
    this.strokes.clear(this.size);
    const { pen } = this.strokes;
    const isOver = (f: number): boolean =>
      cells !== undefined && rateAt(cells, f, certificate!.firstFrame, certificate!.lastFrame) < 1;
    for (const [over, color, thick] of [
      [false, "stripes", 1],
      [true, "over", 2],
    ] as const) {
      for (let f = 0; f <= frames; ++f) {
        if (isOver(f) !== over) continue;
        const x = this.x(f);
        pen.moveTo(x, f % 10 === 0 ? 4 : 10);
        pen.lineTo(x, height - 12);
      }
      this.strokes.stroke(color, thick);
    }
    const { keys } = store.move.tracks[index];
    while (this.marks.length > keys.length) this.marks.pop()!.remove();
    while (this.marks.length < keys.length) this.marks.push(this.mark(this.marks.length));
    for (const [k, key] of keys.entries()) {
      const x = this.x(solved.keyFrames[k] ?? 0);
      attributes(this.marks[k], {
        transform: `translate(${x.toFixed(1)} ${height - 11})`,
        class: `${store.selection.keys.has(k) ? "selected " : ""}${key.frame !== null ? "locked" : ""}`,
      });
    }
    attributes(this.root, { "aria-valuemin": 0, "aria-valuemax": store.move.frames });
    this.drawCursor();
  }

  private mark(k: number): SVGPathElement {
    const mark = svg("path", { d: "M0 0l5 9h-10z" });
    mark.addEventListener("pointerdown", (event) => {
      event.stopPropagation();
      this.store.selectKey(k, event.shiftKey || event.ctrlKey);
    });
    this.keys.append(mark);
    return mark;
  }

  private drawCursor(): void {
    const x = this.x(this.store.frame);
    attributes(this.cursor, { x1: x, x2: x, y1: 0, y2: this.size.height });
    attributes(this.root, { "aria-valuenow": Math.round(this.store.frame) });
  }
}
