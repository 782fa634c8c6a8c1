// Draw a motion (Baecker's P-curves): the path of the pointer becomes keys, its pace the speed curve.
import { button, html, say } from "./dom";
import { plainKey, perSecond, roundTo, stepFor, withKeys, withSpeed, withTrack } from "./move";
import type { Server } from "./server";
import type { Store } from "./store";

export interface Sample {
  readonly time: number; // ms
  readonly x: number;
  readonly y: number;
}

/** The button, the tolerance and what a drawing becomes. The view that is drawn in asks whether it is on. */
export class Hand {
  readonly tools: HTMLElement;
  private readonly button: HTMLButtonElement;
  private readonly tolerance = html("input", {
    id: "tolerance",
    type: "number",
    min: 0.5,
    max: 50,
    step: 0.5,
    value: 2,
    class: "short",
    "aria-label": "Pixels by which the path may be off",
  });
  private samples: Sample[] = [];
  isOn = false;
  onSwitch: () => void = () => {};

  constructor(
    private readonly store: Store,
    private readonly server: Server | null,
  ) {
    this.button = button(
      "Draw",
      "Draw a motion with the pointer: press, draw, release (D)",
      () => this.toggle(),
      "draw",
    );
    this.button.setAttribute("aria-pressed", "false");
    this.button.disabled = server === null;
    if (!server) this.button.title = "Drawing needs the program: start inbetween edit";
    const within = html(
      "label",
      { title: "How far the path may be from where you drew" },
      "within ",
      this.tolerance,
      " px",
    );
    within.hidden = true;
    this.tools = html("span", { class: "hand" }, this.button, within);
    this.onSwitch = () => (within.hidden = !this.isOn);
  }

  toggle(): void {
    if (!this.server) return say("Drawing needs the program: start inbetween edit.");
    const { track } = this.store.selection;
    const one = this.store.move.tracks[track];
    const why = one.network
      ? null
      : (one.fixed_keys ??
        (one.closed ? "the path is closed; open it first" : one.timing === "frames" ? "the keys have frames" : null));
    if (!this.isOn && why) return say(`A motion cannot be drawn here: ${why}.`);
    this.isOn = !this.isOn;
    this.button.setAttribute("aria-pressed", String(this.isOn));
    this.onSwitch();
    if (this.isOn) {
      say(
        one.network
          ? "Press in the row of an axis, draw up and down at the pace it shall have, and release."
          : "Press in the path, draw the motion at the pace it shall have, and release.",
      );
    }
  }

  press(event: PointerEvent): void {
    this.samples = [];
    this.add(event);
  }
  /** Every position that the pointer had since the last picture. */
  move(event: PointerEvent): readonly Sample[] {
    const events = event.getCoalescedEvents?.() ?? [];
    for (const one of events.length > 0 ? events : [event]) this.add(one);
    return this.samples;
  }
  private add(event: PointerEvent): void {
    const last = this.samples.at(-1);
    if (last && event.timeStamp <= last.time) return;
    // Until the hand moves it has not begun.
    if (this.samples.length === 1 && last!.x === event.clientX && last!.y === event.clientY) this.samples = [];
    this.samples.push({ time: event.timeStamp, x: event.clientX, y: event.clientY });
  }

  /** The positions from the press on, of a motion long enough to be one. */
  taken(): readonly Sample[] | null {
    const { samples } = this;
    this.samples = [];
    if (samples.length >= 8) return samples;
    say("That was too short to be a motion; draw longer.", true);
    return null;
  }

  /** `toAxes` gives the two axes that a view shows at a place of the page, `perPixel` their units. */
  async release(
    shown: readonly [number, number],
    toAxes: (x: number, y: number) => readonly [number, number],
    perPixel: readonly [number, number],
  ): Promise<void> {
    const { store } = this;
    const samples = this.taken();
    if (!this.server || !samples) return;
    const index = store.selection.track;
    const asked = store.move;
    const track = asked.tracks[index];
    const pixels = Number(this.tolerance.value);
    if (!(pixels >= 0.5 && pixels <= 50)) return say("The path may be off by 0.5 to 50 pixels.", true);
    const tolerances = track.axes.map((_, a) =>
      a === shown[0] ? perPixel[0] * pixels : a === shown[1] ? perPixel[1] * pixels : null,
    );
    const others = this.others(index, samples);
    const positions = samples.flatMap(({ x, y }, i) => {
      const [across, up] = toAxes(x, y);
      return track.axes.map((_, a) => (a === shown[1] ? up : a === shown[0] ? across : others[i][a]));
    });
    this.button.setAttribute("aria-busy", "true");
    try {
      const fit = await this.server.draw({
        times: samples.map(({ time }) => (time - samples[0].time) / 1000),
        positions,
        tolerances,
        weights: track.weights.length > 0 ? track.weights : track.axes.map(() => 1),
        frames_per_second: perSecond(asked.fps),
      });
      if (store.move !== asked) return say("The move has been changed meanwhile; draw again.");
      const keys = fit.keys.map((at) =>
        plainKey(at.map((x, a) => roundTo(x, stepFor((tolerances[a] ?? Math.abs(x) / 50) * 50) / 10))),
      );
      const alone = asked.tracks.length === 1;
      const drawn = withTrack(withSpeed(withKeys(asked, index, keys), index, fit.speed), index, { spline: "smooth" });
      store.edit(alone ? { ...drawn, frames: fit.frames } : drawn);
      store.select({ keys: new Set(), values: new Set() });
      const time = alone
        ? `${fit.frames} frames`
        : `its ${fit.frames} frames spread over the ${asked.frames} of the move`;
      say(
        `Drawn: ${keys.length} keys within ${(fit.deviation * pixels).toFixed(1)} of ${pixels} px, ${fit.speed.length} control values, ${time}.`,
      );
      this.toggle();
    } catch (error) {
      say((error as Error).message, true);
    } finally {
      this.button.removeAttribute("aria-busy");
    }
  }

  /** The axes that are not shown go along the path that they had, at the same share of its length. */
  private others(index: number, samples: readonly Sample[]): number[][] {
    const axes = this.store.move.tracks[index].axes.length;
    const { table, stride, length } = this.store.solution.tracks[index];
    const distances = [0];
    for (let i = 1; i < samples.length; ++i) {
      distances.push(distances[i - 1] + Math.hypot(samples[i].x - samples[i - 1].x, samples[i].y - samples[i - 1].y));
    }
    const total = distances[distances.length - 1] || 1;
    let row = 0;
    return distances.map((distance) => {
      while (row + 1 < table.length / stride && table[(row + 1) * stride + 1] <= (distance / total) * length) ++row;
      const next = Math.min(row + 1, table.length / stride - 1);
      const span = table[next * stride + 1] - table[row * stride + 1];
      const share = span > 0 ? ((distance / total) * length - table[row * stride + 1]) / span : 0;
      return Array.from({ length: axes }, (_, a) => {
        const here = table[row * stride + 4 + a];
        return here + share * (table[next * stride + 4 + a] - here);
      });
    });
  }
}
