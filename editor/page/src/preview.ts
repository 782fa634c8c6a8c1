// The tape recorder: plays the move in true time.
import { attributes, button, html } from "./dom";
import { perSecond } from "./move";
import type { Store } from "./store";

type Mode = "once" | "loop" | "ping-pong";

export class Preview {
  private direction = 0; // of the tape: 0 stands
  private mode: Mode = "once";
  private last = 0;
  private readonly counter = html("output", { class: "counter", "aria-label": "Frame counter" });
  private readonly clock = html("output", { class: "clock", "aria-label": "Time" });
  private readonly playButton: HTMLButtonElement;
  private readonly backButton: HTMLButtonElement;

  constructor(
    private readonly store: Store,
    place: HTMLElement,
  ) {
    this.playButton = button("▶", "Play (Space)", () => this.play(1), "play");
    this.backButton = button("◀", "Play backward (R)", () => this.play(-1), "reverse");
    const mode = html(
      "select",
      { id: "mode", "aria-label": "At the end" },
      html("option", { value: "once" }, "Once"),
      html("option", { value: "loop" }, "Loop"),
      html("option", { value: "ping-pong" }, "Ping-pong"),
    );
    mode.addEventListener("change", () => (this.mode = mode.value as Mode));
    const scrub = html("input", { type: "range", id: "scrub", step: "1", "aria-label": "Scrub" });
    scrub.addEventListener("input", () => {
      const frame = Number(scrub.value); // stopping shows the old one
      this.stop();
      store.setFrame(frame);
    });
    place.append(
      button("|◀", "To the first frame", () => this.go(store.solution.firstFrame), "to-start"),
      button("‹", "One frame back (,)", () => this.step(-1), "step-back"),
      this.backButton,
      this.playButton,
      button("›", "One frame on (.)", () => this.step(1), "step"),
      button("▶|", "To the last frame", () => this.go(store.solution.lastFrame), "to-end"),
      mode,
      scrub,
      this.counter,
      this.clock,
    );
    const show = (): void => {
      attributes(scrub, { min: store.solution.firstFrame, max: store.solution.lastFrame });
      scrub.value = String(Math.round(store.frame));
      const frame = Math.floor(store.frame + 1e-6);
      this.counter.textContent = `${frame} / ${store.move.frames}`;
      this.clock.textContent = `${(store.frame / perSecond(store.move.fps)).toFixed(2)} s`;
    };
    store.onChange(show);
    store.onFrame(show);
  }

  play(direction: number): void {
    if (this.direction === direction) return this.stop();
    const { firstFrame, lastFrame } = this.store.solution;
    if (direction > 0 && this.store.frame >= lastFrame) this.store.setFrame(firstFrame);
    if (direction < 0 && this.store.frame <= firstFrame) this.store.setFrame(lastFrame);
    const stood = this.direction === 0;
    this.direction = direction;
    this.show();
    if (!stood) return;
    this.last = performance.now();
    requestAnimationFrame((now) => this.tick(now));
  }
  stop(): void {
    this.direction = 0;
    this.store.setFrame(Math.round(this.store.frame));
    this.show();
  }
  step(by: number): void {
    this.stop();
    this.go(Math.round(this.store.frame) + by);
  }

  private go(frame: number): void {
    const { firstFrame, lastFrame } = this.store.solution;
    this.store.setFrame(Math.min(Math.max(frame, firstFrame), lastFrame));
  }
  private show(): void {
    this.playButton.textContent = this.direction > 0 ? "❚❚" : "▶";
    this.backButton.textContent = this.direction < 0 ? "❚❚" : "◀";
    this.playButton.setAttribute("aria-pressed", String(this.direction > 0));
    this.backButton.setAttribute("aria-pressed", String(this.direction < 0));
  }

  /** By the clock and not by pictures: a slow screen leaves pictures out and keeps the time. */
  private tick(now: number): void {
    if (this.direction === 0) return;
    const { firstFrame, lastFrame } = this.store.solution;
    const span = lastFrame - firstFrame;
    let frame =
      this.store.frame + (this.direction * Math.max(now - this.last, 0) * perSecond(this.store.move.fps)) / 1000;
    this.last = now;
    if (frame > lastFrame || frame < firstFrame) {
      if (this.mode === "once") {
        this.store.setFrame(frame > lastFrame ? lastFrame : firstFrame);
        return this.stop();
      }
      const beyond = frame > lastFrame ? frame - lastFrame : firstFrame - frame;
      if (this.mode === "loop") {
        frame = frame > lastFrame ? firstFrame + (beyond % span) : lastFrame - (beyond % span);
      } else {
        frame = frame > lastFrame ? lastFrame - (beyond % span) : firstFrame + (beyond % span);
        this.direction = -this.direction;
        this.show();
      }
    }
    this.store.setFrame(frame);
    requestAnimationFrame((next) => this.tick(next));
  }
}
