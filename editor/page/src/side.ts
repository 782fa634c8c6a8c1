// Beside the path: the keys as numbers, and every axis over time.
import { attributes, button, html, say, svg, whenTyped } from "./dom";
import { changeKeys, copyKeys, insertOnPath, removeKeys } from "./edits";
import { KeyDetail } from "./key_detail";
import { firstAxis } from "./move";
import type { Store } from "./store";

export class KeyTable {
  readonly element = html("div", { class: "fill column" });
  private readonly table = html("table", { class: "keys" });
  private readonly detail: KeyDetail;
  private shape = "";
  private rows: HTMLTableRowElement[] = [];
  private inputs: HTMLInputElement[][] = [];
  private readonly inView = new Set<Element>();
  private readonly watch = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) this.inView[isIntersecting ? "add" : "delete"](target);
    this.draw();
  });

  constructor(private readonly store: Store) {
    const tools = html(
      "div",
      { class: "tools", role: "toolbar", "aria-label": "Keys" },
      button("Add", "Add a key behind the last", () => insertOnPath(store, Infinity), "add-key"),
      button(
        "Insert",
        "Insert a key on the path behind the selected one (I)",
        () => {
          insertOnPath(
            store,
            Math.min(...store.selection.keys, store.move.tracks[store.selection.track].keys.length - 1) + 0.5,
          );
        },
        "insert-key",
      ),
      button("Copy", "Copy the selected keys (Ctrl+D)", () => copyKeys(store), "copy-key"),
      button("Delete", "Delete the selected keys (Delete)", () => removeKeys(store), "delete-key"),
    );
    const scroll = html("div", { class: "scroll" });
    scroll.append(this.table);
    this.detail = new KeyDetail(store);
    this.element.append(tools, scroll, this.detail.element);
    store.onChange(() => this.draw());
  }

  draw(): void {
    if (this.element.hidden) return;
    const { store } = this;
    const index = store.selection.track;
    const track = store.move.tracks[index];
    const shape = `${index} ${track.keys.length} ${track.axes.join()} ${track.fixed_keys}`;
    if (shape !== this.shape) this.build();
    this.shape = shape;
    const met = store.solution.tracks[index].keyFrames;
    for (const [k, row] of this.rows.entries()) {
      if (store.isDragging && !this.inView.has(row)) continue; // drawn when the drag has ended
      const key = track.keys[k];
      row.classList.toggle("selected", store.selection.keys.has(k));
      this.inputs[k].forEach((input, i) => {
        if (input === document.activeElement && input.dataset.typing) return;
        const text = i < key.at.length ? String(key.at[i]) : key.frame === null ? "" : String(key.frame);
        if (input.value !== text) input.value = text;
        if (i === key.at.length) attributes(input, { placeholder: (met[k] ?? 0).toFixed(1) });
      });
    }
    this.detail.draw();
  }

  private build(): void {
    const { store } = this;
    const index = store.selection.track;
    const track = store.move.tracks[index];
    const first = firstAxis(store.move, index);
    const head = html(
      "tr",
      {},
      html("th", { scope: "col" }, "key"),
      ...track.coordinates.map((name, a) =>
        html(
          "th",
          { scope: "col" },
          name,
          html(
            "small",
            {},
            track.coordinates.length === track.axes.length ? ` ${store.move.axes[first + a].unit}` : "",
          ),
        ),
      ),
      html("th", { scope: "col" }, "frame"),
    );
    const rows = track.keys.map((_, k) => {
      const number = html("th", { scope: "row" }, String(k));
      const cells = track.coordinates.map((name, a) =>
        html(
          "td",
          {},
          this.input(`${name} of key ${k}`, track.fixed_keys !== null, (text) => {
            const value = Number(text);
            if (text.trim() === "" || !Number.isFinite(value)) return say("That is no number.", true);
            changeKeys(store, new Set([k]), (key) => ({ ...key, at: key.at.map((x, i) => (i === a ? value : x)) }));
          }),
        ),
      );
      const frame = html(
        "td",
        {},
        this.input(`Frame of key ${k}; empty: as drawn`, track.fixed_keys !== null, (text) => {
          const value = text.trim() === "" ? null : Number(text);
          if (value !== null && !(Number.isInteger(value) && value >= 0 && value <= store.move.frames))
            return say(`A frame is a whole number from 0 to ${store.move.frames}.`, true);
          changeKeys(store, new Set([k]), (key) => ({
            ...key,
            frame: value,
            break: value === null ? false : key.break,
          }));
        }),
      );
      const row = html("tr", {}, number, ...cells, frame);
      // A press says itself what is selected, before its field gets the keyboard.
      let isPressed = false;
      row.addEventListener("pointerdown", (event) => {
        isPressed = true;
        store.selectKey(k, event.shiftKey || event.ctrlKey || event.metaKey);
      });
      for (const end of ["click", "pointerleave", "pointercancel"])
        row.addEventListener(end, () => (isPressed = false));
      row.addEventListener("focusin", () => {
        if (!isPressed && !store.selection.keys.has(k)) store.selectKey(k);
      });
      return row;
    });
    this.table.replaceChildren(html("thead", {}, head), html("tbody", {}, ...rows));
    this.rows = rows;
    this.inputs = rows.map((row) => [...row.querySelectorAll("input")]);
    this.inView.clear();
    this.watch.disconnect();
    for (const row of rows) this.watch.observe(row);
  }

  private input(label: string, fixed: boolean, change: (text: string) => void): HTMLInputElement {
    const input = html("input", { inputmode: "decimal", "aria-label": label, readonly: fixed });
    whenTyped(
      input,
      () => {
        change(input.value);
        this.draw();
      },
      () => this.draw(),
    );
    return input;
  }
}

/** Position, velocity and acceleration of every axis over time, with its limits and the cursor. */
export class AxisGraphs {
  readonly element = html("div", { class: "fill scroll", tabindex: 0, "aria-label": "Axes over time" });
  private readonly cursors: SVGLineElement[] = [];
  private built = "";
  private readonly graphs: {
    axis: number;
    quantity: number;
    root: SVGSVGElement;
    line: SVGPathElement;
    limit: SVGPathElement;
    value: SVGTextElement;
  }[] = [];

  constructor(private readonly store: Store) {
    store.onChange(() => this.draw());
    store.onFrame(() => this.drawCursor());
    new ResizeObserver(() => this.draw()).observe(this.element);
  }

  draw(): void {
    if (this.element.hidden || this.element.clientWidth === 0) return;
    const { store } = this;
    const shape = store.move.axes.map((axis) => axis.name).join();
    if (shape !== this.built) this.build();
    this.built = shape;
    const { firstFrame, lastFrame } = store.solution;
    const samples = 220;
    const axes = store.move.axes.length;
    const motion = store.solver.motion(firstFrame, (lastFrame - firstFrame) / (samples - 1), samples, axes);
    const width = this.element.clientWidth - 16;
    for (const graph of this.graphs) {
      const height = 62;
      attributes(graph.root, { width, height, viewBox: `0 0 ${width} ${height}` });
      const values = Array.from({ length: samples }, (_, i) => motion[(i * axes + graph.axis) * 4 + graph.quantity]);
      const limits = store.move.axes[graph.axis].limits;
      const bound = limits
        ? [null, limits.max_velocity, limits.max_acceleration, limits.max_jerk][graph.quantity]
        : null;
      let low = Math.min(...values);
      let high = Math.max(...values);
      if (graph.quantity > 0) {
        high = Math.max(Math.abs(low), Math.abs(high), 1e-9);
        if (bound !== null && bound < 1.6 * high) high = Math.max(high, bound);
        low = -high;
      }
      const span = high - low || 1;
      const y = (value: number): number => height - 5 - ((value - low) / span) * (height - 20);
      const over = bound !== null && values.some((value) => Math.abs(value) > bound);
      graph.line.setAttribute(
        "d",
        values
          .map((value, i) => `${i ? "L" : "M"}${((i / (samples - 1)) * width).toFixed(1)} ${y(value).toFixed(1)}`)
          .join(""),
      );
      graph.line.classList.toggle("over-line", over);
      graph.limit.setAttribute(
        "d",
        bound !== null && bound <= high ? `M0 ${y(bound)}H${width}M0 ${y(-bound)}H${width}` : "",
      );
    }
    this.drawCursor();
  }

  private build(): void {
    const { store } = this;
    this.graphs.length = 0;
    this.cursors.length = 0;
    const parts = store.move.axes.flatMap((axis, a) => {
      const unit = axis.unit || "units";
      return [
        ["", unit],
        ["velocity", `${unit}/s`],
        ["acceleration", `${unit}/s²`],
      ].map(([name, per], quantity) => {
        const line = svg("path", { class: "graph-line" });
        const limit = svg("path", { class: "limit-line" });
        const cursor = svg("line", { class: "cursor" });
        const value = svg("text", { y: 11, "text-anchor": "end", class: "graph-value" });
        const label = `${axis.name} ${name}`.trim();
        const root = svg(
          "svg",
          { class: `graph quantity-${quantity}`, role: "img", "aria-label": `${label} over time` },
          svg("text", { x: 2, y: 11, class: "axis-name" }, `${label} (${per})`),
          limit,
          line,
          cursor,
          value,
        );
        this.cursors.push(cursor);
        this.graphs.push({ axis: a, quantity, root, line, limit, value });
        return root;
      });
    });
    this.element.replaceChildren(...parts);
  }

  private drawCursor(): void {
    if (this.element.hidden || this.graphs.length === 0) return;
    const { store } = this;
    const { firstFrame, lastFrame } = store.solution;
    const width = this.element.clientWidth - 16;
    const x = ((store.frame - firstFrame) / Math.max(lastFrame - firstFrame, 1)) * width;
    for (const cursor of this.cursors) attributes(cursor, { x1: x, x2: x, y1: 14, y2: 58 });
    const motion = store.solver.motion(store.frame, 1, 1, store.move.axes.length);
    for (const graph of this.graphs) {
      attributes(graph.value, { x: width - 2 });
      graph.value.textContent = motion[graph.axis * 4 + graph.quantity].toFixed(2);
    }
  }
}
