// The bar at the top: name, frames, rate, what the limits say, and what is asked of the program.
import { attributes, button, byId, html, say } from "./dom";
import { max_frames, type Move, parseFps, withTrack } from "./move";
import { Refusal, type Server } from "./server";
import type { Store } from "./store";

export class Bar {
  private readonly frames = html("input", { id: "frames", type: "number", min: 1, max: max_frames, "aria-label": "Frames" });
  private readonly fps = html("input", { id: "fps", "aria-label": "Frames per second", class: "short" });
  private readonly track = html("select", { id: "track", "aria-label": "Track" });
  private readonly verdict = html("output", { id: "verdict" });
  private readonly saved = html("output", { id: "saved" });
  private readonly undo: HTMLButtonElement;
  private readonly redo: HTMLButtonElement;
  private readonly auto = html("input", { type: "checkbox", id: "autosave" });
  private timer = 0;
  private busy = false;
  private conflict = false;
  private savedMove: Move;
  private known: string; // the revision of the file
  private saving = false;

  constructor(private readonly store: Store, private readonly server: Server | null) {
    this.savedMove = store.move;
    this.known = store.move.revision;
    this.undo = button("↶", "Undo (Ctrl+Z)", () => store.undo(), "undo");
    this.redo = button("↷", "Redo (Ctrl+Shift+Z)", () => store.redo(), "redo");
    const name = html("h1", {}, store.move.name);
    const tools: Node[] = [name, this.track, html("label", {}, "Frames ", this.frames), html("label", {}, "fps ", this.fps),
      this.undo, this.redo];
    if (store.move.rig) {
      tools.push(button("Fit", "Change the speed curve as little as can be, so that it keeps the limits", () => void this.ask("fit"), "fit"),
        button("Fewest frames", "The fewest frames in which this curve keeps the limits", () => void this.ask("fewest"), "fewest"));
    }
    tools.push(this.verdict);
    if (server) {
      this.auto.checked = localStorage.getItem("inbetween-autosave") !== "no";
      this.auto.addEventListener("change", () => {
        localStorage.setItem("inbetween-autosave", this.auto.checked ? "yes" : "no");
        this.later();
      });
      tools.push(html("label", { title: "Save a second after every change" }, this.auto, " Autosave"), this.saved,
        button("Save", "Save (Ctrl+S)", () => void this.save(), "save"));
    } else {
      tools.push(button("Download", "Download the move as a file (Ctrl+S)", () => void this.save(), "save"));
      for (const tool of tools) {
        if (!(tool instanceof HTMLButtonElement) || !["fit", "fewest"].includes(tool.id)) continue;
        attributes(tool, { disabled: true, title: `${tool.textContent} needs the program: start inbetween edit` });
      }
    }
    byId("bar").append(...tools);
    this.frames.addEventListener("change", () => {
      const frames = Number(this.frames.value);
      if (!Number.isInteger(frames) || frames < 1 || frames > max_frames) {
        say(`Frames: a whole number from 1 to ${max_frames}.`, true);
      } else {
        store.edit({ ...store.move, frames });
      }
      this.draw();
    });
    this.fps.addEventListener("change", () => {
      const fps = parseFps(this.fps.value);
      if (!fps) say("Frames per second: a whole number, or a fraction such as 24000/1001.", true);
      else store.edit({ ...store.move, fps });
      this.draw();
    });
    this.track.addEventListener("change", () => store.select({ track: Number(this.track.value), keys: new Set(), values: new Set() }));
    store.onChange(() => this.draw());
    store.onCommit = () => {
      void this.resolve();
      this.later();
    };
    if (server) window.setInterval(() => void this.watch(), 2000);
    window.addEventListener("beforeunload", (event) => {
      if (server && this.isChanged) event.preventDefault();
    });
    this.draw();
  }

  private get isChanged(): boolean {
    return this.store.move !== this.savedMove;
  }

  draw(): void {
    const { store } = this;
    const { move } = store;
    const show = (input: HTMLInputElement, text: string): void => {
      if (document.activeElement !== input && input.value !== text) input.value = text;
    };
    show(this.frames, String(move.frames));
    show(this.fps, move.fps.text);
    this.undo.disabled = !store.canUndo;
    this.redo.disabled = !store.canRedo;
    if (this.track.options.length !== move.tracks.length) {
      this.track.replaceChildren(...move.tracks.map((track, t) => html("option", { value: t }, track.axes.join(" · "))));
    }
    if (this.track.value !== String(store.selection.track)) this.track.value = String(store.selection.track);
    this.track.hidden = move.tracks.length < 2;
    const { certificate } = store.solution;
    let words = `${(move.frames * move.fps.denominator / move.fps.numerator).toFixed(2)} s`;
    let state = "";
    if (store.error) {
      const place = store.error.key >= 0 ? `key ${store.error.key}: ` : "";
      words = `${place}${store.error.what}; ${store.error.remedy}`;
      state = "bad";
    } else if (certificate) {
      const stop = certificate.longestStop !== null ? `, stops in ${certificate.longestStop.toFixed(2)} s` : "";
      words = certificate.fits ? `✓ within the limits, up to ${(certificate.highestRate * 100).toFixed(0)} %${stop}` : `✗ ${certificate.reason}`;
      state = certificate.fits ? "good" : "bad";
    }
    if (this.verdict.textContent !== words) this.verdict.textContent = words;
    attributes(this.verdict, { title: words, class: state });
    this.verdict.dataset.hash = store.solution.tracks.map((track) => track.hash).join(" ");
    const saved = this.conflict ? "changed outside" : this.isChanged ? "not saved" : "saved";
    if (this.server && this.saved.textContent !== saved) this.saved.textContent = saved;
    this.saved.className = this.conflict ? "bad" : this.isChanged ? "" : "good";
  }

  private later(): void {
    clearTimeout(this.timer);
    if (!this.server || !this.auto.checked) return;
    this.timer = window.setTimeout(() => {
      if (this.isChanged && !this.store.error && !this.conflict) void this.save();
    }, 1000);
  }

  /** What the page cannot solve by itself is asked of the program after every edit. */
  private async resolve(): Promise<void> {
    const asked = this.store.move;
    if (!this.server || asked.tracks.every((track) => track.live)) return;
    try {
      const answer = await this.server.resolve(asked);
      if (this.store.move !== asked) return;
      this.store.amend((move) => (move === asked ? this.taken(move, answer) : move));
    } catch (error) {
      say((error as Error).message, true);
    }
  }
  /** Of the program's answer what the page does not work out itself. */
  private taken(move: Move, answer: Move): Move {
    return move.tracks.reduce((result, track, t) => {
      if (track.live) return result;
      const { path, speed } = answer.tracks[t];
      return withTrack(result, t, { path, speed: track.touched ? track.speed : speed });
    }, move);
  }

  private async ask(what: "fit" | "fewest"): Promise<void> {
    if (!this.server || this.busy) return;
    this.busy = true;
    byId(what).setAttribute("aria-busy", "true");
    const asked = this.store.move;
    try {
      const answer = await this.server[what](asked);
      if (this.store.move !== asked) return say("The move has been changed meanwhile; ask again.");
      let move: Move = { ...asked, frames: answer.frames };
      answer.tracks.forEach((track, t) => {
        const old = asked.tracks[t];
        const keys = old.keys.map((key, k) => ({ ...key, frame: track.keys[k].frame, hold: track.keys[k].hold }));
        const isMoved = keys.some((key, k) => key.frame !== old.keys[k].frame || key.hold !== old.keys[k].hold);
        const isNew = JSON.stringify(track.speed) !== JSON.stringify(old.speed);
        move = withTrack(move, t, {
          ...(isMoved ? { keys, moved: true } : {}),
          ...(isNew ? { speed: track.speed, touched: old.touched || what === "fit", path: track.path } : {}),
        });
      });
      this.store.edit(move);
      say(what === "fit" ? "The speed curve is fitted to the limits." : `${answer.frames} frames.`);
    } catch (error) {
      say((error as Error).message, true);
    } finally {
      this.busy = false;
      byId(what).removeAttribute("aria-busy");
    }
  }

  /** Edits go on counting from the text that was loaded, however often they are saved: undo reaches back over it. */
  async save(): Promise<void> {
    if (!this.server) return (await import("./alone")).download(this.store.move);
    if (this.saving) return this.later();
    const saved = this.store.move;
    clearTimeout(this.timer);
    this.saving = true;
    try {
      const { revision, kept } = await this.server.save(saved, this.known);
      this.known = revision;
      this.savedMove = saved;
      this.conflict = false;
      say(kept ? `Saved. The other version is in ${kept}.` : "Saved");
      if (this.isChanged) this.later();
    } catch (error) {
      if (error instanceof Refusal && error.status === 409) this.offer(error.revision!);
      else say((error as Error).message, true);
    } finally {
      this.saving = false;
    }
    this.draw();
  }

  private async watch(): Promise<void> {
    if (!this.server || this.conflict || this.busy) return;
    const { known } = this;
    try {
      const there = await this.server.revision();
      if (there !== known && this.known === known && !this.saving) this.offer(there);
    } catch {
      // Saving will tell.
    }
  }

  /** Somebody else has changed the file: nothing is lost, whatever is chosen. */
  private offer(there: string): void {
    this.conflict = true;
    this.draw();
    const dialog = byId("dialog") as HTMLDialogElement;
    if (dialog.open) return;
    const close = (act: () => Promise<void>) => (): void => {
      dialog.close();
      void act();
    };
    dialog.replaceChildren(
      html("h2", {}, `${this.store.move.file} has been changed outside the editor`),
      html("p", {}, "Both versions are kept, whichever you go on with."),
      html("div", { class: "tools" },
        button("Load the file", "Load the file; what is in the editor is kept as a copy", close(() => this.loadTheirs()), "load-theirs"),
        button("Save mine", "Save what is in the editor; the file is kept as a copy", close(() => {
          this.known = there;
          return this.save();
        }), "save-mine"),
        button("Later", "Decide later", close(async () => {}), "decide-later")));
    dialog.showModal();
  }

  private async loadTheirs(): Promise<void> {
    if (!this.server) return;
    try {
      const kept = this.isChanged ? await this.server.keep(this.store.move) : null;
      const theirs = await this.server.open();
      this.conflict = false;
      this.savedMove = theirs;
      this.known = theirs.revision;
      this.store.replace(theirs);
      say(kept ? `Loaded. Your version is in ${kept}.` : "Loaded");
    } catch (error) {
      say((error as Error).message, true);
    }
    this.draw();
  }
}
