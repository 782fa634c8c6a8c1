// A canvas under the handles of a view, for what has too many strokes to be elements: as an SVG path a thousand ticks
// cost more than solving the move.
import { html } from "./dom";

export interface Size {
  width: number;
  height: number;
}

const draws: (() => void)[] = [];

/** The size of `place`, which asks for no layout, and `draw` when it changes. */
export function watchSize(place: Element, draw: () => void): Readonly<Size> {
  const size = { width: 0, height: 0 };
  new ResizeObserver(([{ contentRect }]) => {
    size.width = Math.floor(contentRect.width);
    size.height = Math.floor(contentRect.height);
    draw();
  }).observe(place);
  draws.push(draw);
  return size;
}

/** Counts the times that they have changed. */
export let colorChanges = 0;
const colors = new Map<string, string>();
for (const query of ["(prefers-contrast: more)", "(forced-colors: active)"]) {
  matchMedia(query).addEventListener("change", () => {
    colors.clear();
    ++colorChanges;
    for (const draw of draws) draw();
  });
}
/** A colour of style.css. */
export function color(name: string): string {
  let value = colors.get(name);
  if (value === undefined)
    colors.set(name, (value = getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim()));
  return value;
}

export class Strokes {
  readonly element = html("canvas", { class: "strokes", "aria-hidden": "true" });
  readonly pen = this.element.getContext("2d")!;

  /** Empty, and as large as the view. */
  clear({ width, height }: Readonly<Size>): void {
    const scale = devicePixelRatio;
    const [w, h] = [Math.round(width * scale), Math.round(height * scale)];
    if (this.element.width !== w || this.element.height !== h) [this.element.width, this.element.height] = [w, h];
    this.pen.setTransform(scale, 0, 0, scale, 0, 0);
    this.pen.clearRect(0, 0, width, height);
    this.pen.beginPath();
  }
  text(words: string, x: number, y: number, align: CanvasTextAlign, name = "dim"): void {
    this.pen.font = "11px system-ui, 'Segoe UI', 'DejaVu Sans', sans-serif";
    this.pen.fillStyle = color(name);
    this.pen.textAlign = align;
    this.pen.fillText(words, x, y);
  }
  line(x0: number, y0: number, x1: number, y1: number): void {
    this.pen.moveTo(x0, y0);
    this.pen.lineTo(x1, y1);
  }
  /** What was put down since the last stroke. */
  stroke(name: string, width = 1, dash: number[] = []): void {
    this.pen.strokeStyle = color(name);
    this.pen.lineWidth = width;
    this.pen.setLineDash(dash);
    this.pen.stroke();
    this.pen.beginPath();
  }
}
