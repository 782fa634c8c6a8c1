// The bar of frame stripes, spaced by the distance between frames, with the keys on it.
import { attributes, button, follow, html, svg } from "./dom";
import { shiftKeys } from "./edits";
import { rateAt } from "./plan_view";
import type { Store } from "./store";

export class TimeBar {
  private readonly root = svg("svg", { class: "plot", role: "slider", tabindex: 0, "aria-label": "Frame" });
  private readonly stripes = svg("path", { class: "stripes" });
  private readonly red = svg("path", { class: "over" });
  private readonly keys = svg("g", { class: "bar-keys" });
  private readonly cursor = svg("line", { class: "cursor" });
  private readonly place = html("div", { class: "fill" });
  private width = 100;

  constructor(private readonly store: Store, section: HTMLElement) {
    this.root.append(this.stripes, this.red, this.keys, this.cursor);
    this.place.append(this.root);
    section.append(
      button("◀", "Meet the selected keys one frame earlier ([)", () => shiftKeys(store, -1), "earlier"),
      this.place,
      button("▶", "Meet the selected keys one frame later (])", () => shiftKeys(store, 1), "later"));
    new ResizeObserver(() => this.draw()).observe(this.place);
    store.onChange(() => this.draw());
    store.onFrame(() => this.drawCursor());
    this.root.addEventListener("pointerdown", (event) => {
      this.scrub(event);
      follow(event, (e) => this.scrub(e), () => {});
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
    return 6 + (solved.length > 0 ? here / solved.length : at / frames) * (this.width - 12);
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
    this.width = this.place.clientWidth;
    const height = this.place.clientHeight;
    if (this.width === 0) return;
    const { store } = this;
    attributes(this.root, { width: this.width, height, viewBox: `0 0 ${this.width} ${height}` });
    const { certificate } = store.solution;
    const index = store.selection.track;
    const cells = certificate?.ceilings[index];
    const solved = store.solution.tracks[index];
    const frames = solved.table.length / solved.stride - 1;
    let d = "";
    let over = "";
    for (let f = 0; f <= frames; ++f) {
      const stripe = `M${this.x(f).toFixed(1)} ${f % 10 === 0 ? 4 : 10}V${height - 12}`;
      d += stripe;
      if (cells && certificate && rateAt(cells, f, certificate.firstFrame, certificate.lastFrame) < 1) over += stripe;
    }
    this.stripes.setAttribute("d", d);
    this.red.setAttribute("d", over);
    const track = store.move.tracks[index];
    this.keys.replaceChildren(...track.keys.map((key, k) => {
      const x = this.x(solved.keyFrames[k] ?? 0);
      const classes = `${store.selection.keys.has(k) ? "selected " : ""}${key.frame !== null ? "locked" : ""}`;
      const mark = svg("path", { d: `M${x} ${height - 11}l5 9h-10z`, class: classes });
      mark.addEventListener("pointerdown", (event) => {
        event.stopPropagation();
        store.selectKey(k, event.shiftKey || event.ctrlKey);
      });
      return mark;
    }));
    attributes(this.root, { "aria-valuemin": 0, "aria-valuemax": store.move.frames });
    this.drawCursor();
  }

  private drawCursor(): void {
    const x = this.x(this.store.frame);
    attributes(this.cursor, { x1: x, x2: x, y1: 0, y2: this.place.clientHeight });
    attributes(this.root, { "aria-valuenow": Math.round(this.store.frame) });
  }
}
