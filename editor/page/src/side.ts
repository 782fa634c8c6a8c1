// Beside the path: the keys as numbers, and every axis over time.
import { attributes, button, html, say, svg } from "./dom";
import { changeKeys, copyKeys, insertOnPath, removeKeys } from "./edits";
import { firstAxis, type Key, type Spline, withKeys, withTrack } from "./move";
import type { Store } from "./store";

export class KeyTable {
  readonly element = html("div", { class: "fill column" });
  private readonly table = html("table", { class: "keys" });
  private readonly detail = html("div", { class: "detail" });
  private shape = "";

  constructor(private readonly store: Store) {
    const tools = html("div", { class: "tools", role: "toolbar", "aria-label": "Keys" },
      button("Add", "Add a key behind the last", () => insertOnPath(store, Infinity), "add-key"),
      button("Insert", "Insert a key on the path behind the selected one (I)", () => {
        insertOnPath(store, Math.min(...store.selection.keys, store.move.tracks[store.selection.track].keys.length - 1) + 0.5);
      }, "insert-key"),
      button("Copy", "Copy the selected keys (Ctrl+D)", () => copyKeys(store), "copy-key"),
      button("Delete", "Delete the selected keys (Delete)", () => removeKeys(store), "delete-key"));
    const scroll = html("div", { class: "scroll" });
    scroll.append(this.table);
    this.element.append(tools, scroll, this.detail);
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
    for (const [k, row] of [...this.table.tBodies[0].rows].entries()) {
      const key = track.keys[k];
      row.classList.toggle("selected", store.selection.keys.has(k));
      const inputs = row.querySelectorAll("input");
      inputs.forEach((input, i) => {
        if (input === document.activeElement && input.dataset.typing) return;
        input.value = i < key.at.length ? String(key.at[i]) : key.frame === null ? "" : String(key.frame);
        if (i === key.at.length) input.placeholder = (met[k] ?? 0).toFixed(1);
      });
    }
    this.drawDetail();
  }

  private build(): void {
    const { store } = this;
    const index = store.selection.track;
    const track = store.move.tracks[index];
    const first = firstAxis(store.move, index);
    const head = html("tr", {}, html("th", { scope: "col" }, "key"),
      ...track.coordinates.map((name, a) => html("th", { scope: "col" }, name,
        html("small", {}, track.coordinates.length === track.axes.length ? ` ${store.move.axes[first + a].unit}` : ""))),
      html("th", { scope: "col" }, "frame"));
    const rows = track.keys.map((_, k) => {
      const number = html("th", { scope: "row" }, String(k));
      const cells = track.coordinates.map((name, a) =>
        html("td", {}, this.input(`${name} of key ${k}`, track.fixed_keys !== null, (text) => {
          const value = Number(text);
          if (text.trim() === "" || !Number.isFinite(value)) return say("That is no number.", true);
          changeKeys(store, new Set([k]), (key) => ({ ...key, at: key.at.map((x, i) => (i === a ? value : x)) }));
        })));
      const frame = html("td", {}, this.input(`Frame of key ${k}; empty: as drawn`, track.fixed_keys !== null, (text) => {
        const value = text.trim() === "" ? null : Number(text);
        if (value !== null && !(Number.isInteger(value) && value >= 0 && value <= store.move.frames))
          return say(`A frame is a whole number from 0 to ${store.move.frames}.`, true);
        changeKeys(store, new Set([k]), (key) => ({ ...key, frame: value, break: value === null ? false : key.break }));
      }));
      const row = html("tr", {}, number, ...cells, frame);
      row.addEventListener("pointerdown", (event) => store.selectKey(k, event.ctrlKey || event.metaKey));
      row.addEventListener("focusin", () => {
        if (!store.selection.keys.has(k)) store.selectKey(k);
      });
      return row;
    });
    this.table.replaceChildren(html("thead", {}, head), html("tbody", {}, ...rows));
  }

  private input(label: string, fixed: boolean, change: (text: string) => void): HTMLInputElement {
    const input = html("input", { inputmode: "decimal", "aria-label": label, readonly: fixed });
    input.addEventListener("input", () => (input.dataset.typing = "yes"));
    input.addEventListener("change", () => {
      delete input.dataset.typing;
      change(input.value);
      this.draw();
    });
    input.addEventListener("blur", () => delete input.dataset.typing);
    return input;
  }

  private drawDetail(): void {
    const { store } = this;
    if (this.detail.contains(document.activeElement) && document.activeElement instanceof HTMLInputElement &&
        document.activeElement.type === "range") return this.fillDetail();
    const index = store.selection.track;
    const track = store.move.tracks[index];
    const parts: Node[] = [];
    const spline = html("select", { "aria-label": "Path", id: "spline" },
      ...["smooth", "catmull-rom", "tcb", "linear"].map((word) => html("option", { value: word, selected: track.spline === word }, word)));
    spline.addEventListener("change", () => {
      const to = spline.value as Spline;
      const keys = to === "tcb" ? track.keys : track.keys.map((key) => ({ ...key, tension: 0, continuity: 0, bias: 0 }));
      const changed = withTrack(store.move, index, { spline: to });
      store.edit(track.spline === "tcb" ? withKeys(changed, index, keys) : changed);
    });
    const closed = html("input", { type: "checkbox", id: "closed" });
    closed.checked = track.closed;
    closed.disabled = track.periodic || track.path !== null;
    closed.addEventListener("change", () => store.edit(withTrack(store.move, index, { closed: closed.checked })));
    parts.push(html("label", {}, "Path ", spline), html("label", {}, closed, " Closed"));
    const keys = [...store.selection.keys];
    if (keys.length > 0) {
      const key = track.keys[keys[0]];
      const flag = (name: "ease" | "break", label: string, title: string, can: boolean): HTMLElement => {
        const box = html("input", { type: "checkbox", id: `key-${name}` });
        box.checked = key[name];
        box.disabled = !can;
        box.addEventListener("change", () => changeKeys(store, store.selection.keys, (one) => ({ ...one, [name]: box.checked })));
        return html("label", { title }, box, ` ${label}`);
      };
      const hold = html("input", { type: "number", min: 0, max: store.move.frames, "aria-label": "Frames of rest at the key", class: "short", id: "key-hold" });
      hold.value = key.hold === null ? "" : String(key.hold);
      hold.addEventListener("change", () => {
        const value = Math.round(Number(hold.value));
        changeKeys(store, store.selection.keys, (one) => ({ ...one, hold: value > 0 ? value : null, ease: value > 0 ? false : one.ease }));
      });
      const bySpeed = track.timing === "speed";
      parts.push(
        flag("ease", "Ease", "The speed touches 0 at the key", bySpeed && key.hold === null),
        flag("break", "Break", "The speed may jump at the key, which needs a frame", bySpeed && key.frame !== null && !key.ease));
      if (bySpeed) parts.push(html("label", {}, "Hold ", hold, " frames"));
      if (track.spline === "tcb") {
        for (const name of ["tension", "continuity", "bias"] as const) parts.push(this.slider(name, key));
      }
    }
    this.detail.replaceChildren(...parts);
  }

  private slider(name: "tension" | "continuity" | "bias", key: Key): HTMLElement {
    const { store } = this;
    const slider = html("input", { type: "range", min: -1, max: 1, step: 0.05, "aria-label": name, id: `key-${name}`, "data-name": name });
    slider.value = String(key[name]);
    const shown = html("output", {}, key[name].toFixed(2));
    slider.addEventListener("pointerdown", () => store.begin());
    slider.addEventListener("input", () =>
      changeKeys(store, store.selection.keys, (one) => ({ ...one, [name]: Number(slider.value) })));
    slider.addEventListener("change", () => store.end());
    return html("label", { class: "wide" }, html("span", {}, name[0].toUpperCase() + name.slice(1)), slider, shown);
  }

  private fillDetail(): void {
    const { store } = this;
    const key = store.move.tracks[store.selection.track].keys[Math.min(...store.selection.keys)];
    for (const slider of this.detail.querySelectorAll<HTMLInputElement>("input[type=range]")) {
      const value = key[slider.dataset.name as "tension"];
      slider.value = String(value);
      slider.nextElementSibling!.textContent = value.toFixed(2);
    }
  }
}

/** Position, velocity and acceleration of every axis over time, with its limits and the cursor. */
export class AxisGraphs {
  readonly element = html("div", { class: "fill scroll", tabindex: 0, "aria-label": "Axes over time" });
  private readonly cursors: SVGLineElement[] = [];
  private built = "";
  private readonly graphs: { axis: number; quantity: number; root: SVGSVGElement; line: SVGPathElement; limit: SVGPathElement; value: SVGTextElement }[] = [];

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
      const bound = limits ? [null, limits.max_velocity, limits.max_acceleration, limits.max_jerk][graph.quantity] : null;
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
      graph.line.setAttribute("d", values.map((value, i) => `${i ? "L" : "M"}${((i / (samples - 1)) * width).toFixed(1)} ${y(value).toFixed(1)}`).join(""));
      graph.line.classList.toggle("over-line", over);
      graph.limit.setAttribute("d", bound !== null && bound <= high ? `M0 ${y(bound)}H${width}M0 ${y(-bound)}H${width}` : "");
    }
    this.drawCursor();
  }

  private build(): void {
    const { store } = this;
    this.graphs.length = 0;
    this.cursors.length = 0;
    const parts = store.move.axes.flatMap((axis, a) => {
      const unit = axis.unit || "units";
      return [["", unit], ["velocity", `${unit}/s`], ["acceleration", `${unit}/s²`]].map(([name, per], quantity) => {
        const line = svg("path", { class: "graph-line" });
        const limit = svg("path", { class: "limit-line" });
        const cursor = svg("line", { class: "cursor" });
        const value = svg("text", { y: 11, "text-anchor": "end", class: "graph-value" });
        const label = `${axis.name} ${name}`.trim();
        const root = svg("svg", { class: `graph quantity-${quantity}`, role: "img", "aria-label": `${label} over time` },
          svg("text", { x: 2, y: 11, class: "axis-name" }, `${label} (${per})`), limit, line, cursor, value);
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
