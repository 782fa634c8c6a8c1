// Under the key table: the kind of path, and what belongs to the selected keys. Its elements are made once, so that a
// press or a word being typed survives every picture.
import { html, whenTyped } from "./dom";
import { changeKeys } from "./edits";
import { cornerField, type Key, type Spline, withKeys, withTrack } from "./move";
import type { Store } from "./store";

const shapes = ["tension", "continuity", "bias"] as const;

export class KeyDetail {
  readonly element = html("div", { class: "detail" });
  private readonly spline = html(
    "select",
    { "aria-label": "Path", id: "spline" },
    ...["smooth", "catmull-rom", "tcb", "linear"].map((word) => html("option", { value: word }, word)),
  );
  private readonly closed = html("input", { type: "checkbox", id: "closed" });
  private readonly ease = this.flag("ease");
  private readonly break = this.flag("break");
  private readonly hold = html("input", {
    type: "number",
    min: 0,
    "aria-label": "Frames of rest at the key",
    class: "short",
    id: "key-hold",
  });
  private readonly corner = html("input", {
    type: "number",
    min: 0,
    step: "any",
    "aria-label": "How much the corner is rounded",
    class: "short",
    id: "key-corner",
  });
  private readonly cornerName = html("span");
  private readonly cornerUnit = html("span");
  private readonly rounding = html("label", {}, this.cornerName, " ", this.corner, " ", this.cornerUnit);
  private readonly ofKey: HTMLElement[];
  private readonly holding = html("label", {}, "Hold ", this.hold, " frames");
  private readonly sliders = shapes.map((name) => this.slider(name));

  constructor(private readonly store: Store) {
    this.ofKey = [
      html("label", { title: "The speed touches 0 at the key" }, this.ease, " Ease"),
      html("label", { title: "The speed may jump at the key, which needs a frame" }, this.break, " Break"),
    ];
    this.element.append(
      html("label", {}, "Path ", this.spline),
      html("label", {}, this.closed, " Closed"),
      ...this.ofKey,
      this.holding,
      this.rounding,
      ...this.sliders.map(({ row }) => row),
    );
    this.spline.addEventListener("change", () => this.changeSpline(this.spline.value as Spline));
    this.closed.addEventListener("change", () =>
      store.edit(withTrack(store.move, store.selection.track, { closed: this.closed.checked })),
    );
    const draw = (): void => this.draw();
    whenTyped(
      this.hold,
      () => {
        const value = Math.round(Number(this.hold.value));
        changeKeys(store, store.selection.keys, (one) => ({
          ...one,
          hold: value > 0 ? value : null,
          ease: value > 0 ? false : one.ease,
        }));
      },
      draw,
    );
    whenTyped(this.corner, () => this.changeCorner(), draw);
  }

  draw(): void {
    const { store } = this;
    const track = store.move.tracks[store.selection.track];
    const key = store.selection.keys.size > 0 ? track.keys[Math.min(...store.selection.keys)] : null;
    const bySpeed = track.timing === "speed";
    if (this.spline.value !== track.spline) this.spline.value = track.spline;
    this.closed.checked = track.closed;
    this.closed.disabled = track.periodic || track.path !== null;
    // What the whole track says of its corners is for straight paths alone.
    this.spline.disabled = track.overlap !== null || track.round !== null || track.table !== null;
    const why = track.table ? "The path is that of its rows" : "The track rounds its corners; edit it as text";
    this.spline.title = this.spline.disabled ? why : "";
    for (const row of this.ofKey) row.hidden = key === null;
    this.holding.hidden = key === null || !bySpeed;
    const field = cornerField(track);
    this.rounding.hidden = key === null || field === null;
    for (const { row } of this.sliders) row.hidden = key === null || track.spline !== "tcb";
    if (key === null) return;
    this.ease.checked = key.ease;
    this.ease.disabled = !bySpeed || key.hold !== null;
    this.break.checked = key.break;
    this.break.disabled = !bySpeed || key.frame === null || key.ease;
    this.hold.max = String(store.move.frames);
    if (!this.hold.dataset.typing) this.hold.value = key.hold === null ? "" : String(key.hold);
    if (field !== null) {
      const isOverlap = field === "overlap";
      this.cornerName.textContent = isOverlap ? "Overlap" : "Round";
      this.cornerUnit.textContent = isOverlap ? "frames" : track.unit;
      this.rounding.title = isOverlap
        ? "The actions before and behind the key overlap for so many frames"
        : "The path passes the key no further away than this";
      this.corner.placeholder = String(track[field] ?? 0);
      if (!this.corner.dataset.typing) this.corner.value = key[field] === null ? "" : String(key[field]);
    }
    for (const { name, slider, shown } of this.sliders) {
      slider.value = String(key[name]);
      shown.textContent = key[name].toFixed(2);
    }
  }

  /** An empty field: as the track says. */
  private changeCorner(): void {
    const { store } = this;
    const field = cornerField(store.move.tracks[store.selection.track]);
    const value = this.corner.value.trim() === "" ? null : Number(this.corner.value);
    if (field === null || (value !== null && !(value >= 0))) return;
    const written = value !== null && field === "overlap" ? Math.round(value) : value;
    changeKeys(store, store.selection.keys, (one) => ({ ...one, [field]: written }));
  }

  /** The shape of keys is that of a tcb path, and only straight paths have corners to round. */
  private changeSpline(spline: Spline): void {
    const { store } = this;
    const index = store.selection.track;
    const track = store.move.tracks[index];
    const changed = withTrack(store.move, index, { spline });
    const isShaped = spline !== "tcb" && track.keys.some((key) => shapes.some((name) => key[name] !== 0));
    const isRounded = spline !== "linear" && track.keys.some((key) => key.overlap !== null || key.round !== null);
    if (!isShaped && !isRounded) return store.edit(changed);
    const noShape = isShaped ? { tension: 0, continuity: 0, bias: 0 } : {};
    const noCorner = isRounded ? { overlap: null, round: null } : {};
    store.edit(
      withKeys(
        changed,
        index,
        track.keys.map((key) => ({ ...key, ...noShape, ...noCorner })),
      ),
    );
  }

  private flag(name: "ease" | "break"): HTMLInputElement {
    const box = html("input", { type: "checkbox", id: `key-${name}` });
    box.addEventListener("change", () =>
      changeKeys(this.store, this.store.selection.keys, (one: Key) => ({ ...one, [name]: box.checked })),
    );
    return box;
  }

  private slider(name: (typeof shapes)[number]) {
    const slider = html("input", { type: "range", min: -1, max: 1, step: 0.05, "aria-label": name, id: `key-${name}` });
    const shown = html("output");
    slider.addEventListener("pointerdown", () => this.store.begin());
    slider.addEventListener("input", () =>
      changeKeys(this.store, this.store.selection.keys, (one) => ({ ...one, [name]: Number(slider.value) })),
    );
    // A press that changes nothing has no "change", and would leave the step of undo open.
    for (const end of ["change", "pointerup", "pointercancel"]) slider.addEventListener(end, () => this.store.end());
    return {
      name,
      slider,
      shown,
      row: html("label", { class: "wide" }, html("span", {}, name[0].toUpperCase() + name.slice(1)), slider, shown),
    };
  }
}
