// Small words for making elements.
const svgNamespace = "http://www.w3.org/2000/svg";

type Attributes = Record<string, string | number | boolean | undefined>;

function set(element: Element, attributes: Attributes): void {
  for (const [name, value] of Object.entries(attributes)) {
    const text = value === true ? "" : String(value);
    if (value === undefined || value === false) element.removeAttribute(name);
    else if (element.getAttribute(name) !== text) element.setAttribute(name, text); // the same again costs a layout
  }
}

export function html<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Attributes = {},
  ...children: (Node | string)[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  set(element, attributes);
  element.append(...children);
  return element;
}

export function svg<K extends keyof SVGElementTagNameMap>(
  tag: K,
  attributes: Attributes = {},
  ...children: (Node | string)[]
): SVGElementTagNameMap[K] {
  const element = document.createElementNS(svgNamespace, tag);
  set(element, attributes);
  element.append(...children);
  return element;
}

export const attributes = set;

export function button(label: string, title: string, act: () => void, id?: string): HTMLButtonElement {
  const element = html("button", { type: "button", title, "aria-label": title, id }, label);
  element.addEventListener("click", act);
  return element;
}

export const byId = (id: string): HTMLElement => {
  const element = document.getElementById(id);
  if (!element) throw new Error(`there is no element ${id}`);
  return element;
};

/** Tells it to whoever hears the page, and shows it for a while. */
let sayTimer = 0;
export function say(text: string, isError = false): void {
  const place = byId("said");
  place.textContent = text;
  place.title = text; // where the line is too short for it
  place.classList.toggle("error", isError);
  place.classList.add("shown");
  clearTimeout(sayTimer);
  sayTimer = window.setTimeout(() => place.classList.remove("shown"), isError ? 8000 : 3000);
}

/** A line at the top that stays until it is true no more; null takes it away. */
export function notice(id: string, text: string | null, ...buttons: HTMLButtonElement[]): void {
  const old = document.getElementById(`notice-${id}`);
  if (text === null) return old?.remove();
  if (old?.firstElementChild?.textContent === text) return;
  const line = html("div", { id: `notice-${id}`, class: "notice" }, html("span", {}, text), ...buttons);
  if (old) old.replaceWith(line);
  else byId("notices").append(line);
}

/** A field that is being typed in keeps its words. They count when it is left, or at Enter; Escape takes them back, and
 * `draw` writes what it had. */
export function whenTyped(input: HTMLInputElement, change: () => void, draw: () => void): void {
  input.addEventListener("input", () => (input.dataset.typing = "yes"));
  input.addEventListener("blur", () => delete input.dataset.typing);
  input.addEventListener("change", () => {
    delete input.dataset.typing;
    change();
  });
  input.addEventListener("keydown", (event) => {
    if (event.key !== "Escape" || !input.dataset.typing) return;
    delete input.dataset.typing;
    draw();
    input.select();
    event.preventDefault();
    event.stopPropagation();
  });
}

/** Follows a pointer from its press until it is let go. */
export function follow(
  event: PointerEvent,
  move: (event: PointerEvent) => void,
  end: (cancelled: boolean) => void,
): void {
  const target = event.currentTarget as Element;
  target.setPointerCapture(event.pointerId);
  const moved = (e: Event): void => move(e as PointerEvent);
  const stop = (e: Event): void => {
    target.removeEventListener("pointermove", moved);
    target.removeEventListener("pointerup", stop);
    target.removeEventListener("pointercancel", stop);
    end(e.type === "pointercancel");
  };
  target.addEventListener("pointermove", moved);
  target.addEventListener("pointerup", stop);
  target.addEventListener("pointercancel", stop);
}

/** Numbers that divide a range into steps of 1, 2 or 5. */
export function ticks(low: number, high: number, about: number): number[] {
  const span = high - low;
  if (!(span > 0)) return [];
  const raw = span / about;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = power * ([1, 2, 5].find((f) => f * power >= raw) ?? 10);
  const result: number[] = [];
  for (let i = Math.ceil(low / step); i * step <= high + 1e-9 * span; ++i)
    result.push(Number((i * step).toPrecision(12)));
  return result;
}
