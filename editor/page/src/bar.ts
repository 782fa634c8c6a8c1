// The bar at the top: name, frames, rate, what the limits say, and what is asked of the program.
import { download, textOf, textWithoutProgram } from "./alone";
import { attributes, button, byId, html, notice, say } from "./dom";
import type { Draft } from "./drafts";
import { max_frames, type Move, parseFps, withRigOf, withTrack } from "./move";
import { type FileState, Refusal, type Server } from "./server";
import type { Store } from "./store";

export class Bar {
  private readonly frames = html("input", {
    id: "frames",
    type: "number",
    min: 1,
    max: max_frames,
    "aria-label": "Frames",
  });
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
  private saving = false;
  private saveAgain = false;
  private hasRoom = true;

  /** `known` is the revision of the file of which this page has the text; with `draft` goes what is edited. */
  constructor(
    private readonly store: Store,
    private readonly server: Server | null,
    private known: string,
    private readonly draft: Draft | null,
  ) {
    this.undo = button("↶", "Undo (Ctrl+Z)", () => store.undo(), "undo");
    this.redo = button("↷", "Redo (Ctrl+Shift+Z)", () => store.redo(), "redo");
    const name = html("h1", {}, store.move.name);
    const tools: Node[] = [
      name,
      this.track,
      html("label", {}, "Frames ", this.frames),
      html("label", {}, "fps ", this.fps),
      this.undo,
      this.redo,
    ];
    if (store.move.rig) {
      tools.push(
        button(
          "Fit",
          "Change the speed curve as little as can be, so that it keeps the limits",
          () => void this.ask("fit"),
          "fit",
        ),
        button(
          "Fewest frames",
          "The fewest frames in which this curve keeps the limits",
          () => void this.ask("fewest"),
          "fewest",
        ),
      );
    }
    tools.push(this.verdict);
    if (server) {
      this.auto.checked = localStorage.getItem("inbetween-autosave") !== "no";
      this.auto.addEventListener("change", () => {
        localStorage.setItem("inbetween-autosave", this.auto.checked ? "yes" : "no");
        this.later();
      });
      tools.push(
        html("label", { title: "Save a second after every change" }, this.auto, " Autosave"),
        this.saved,
        button("Save", "Save (Ctrl+S)", () => this.saveTyped(), "save"),
      );
    } else {
      tools.push(button("Download", "Download the move as a file (Ctrl+S)", () => this.saveTyped(), "save"));
      for (const tool of tools) {
        if (!(tool instanceof HTMLButtonElement) || !["fit", "fewest"].includes(tool.id)) continue;
        attributes(tool, { disabled: true, title: `${tool.textContent} needs the program: start inbetween edit` });
      }
    }
    byId("bar").append(...tools);
    this.frames.addEventListener("change", () => {
      const frames = Number(this.frames.value);
      const rows = store.move.tracks.find(({ table }) => table !== null)?.table;
      if (!Number.isInteger(frames) || frames < 1 || frames > max_frames) {
        say(`Frames: a whole number from 1 to ${max_frames}.`, true);
      } else if (rows && frames !== store.move.frames) {
        say(`The rows of ${rows} are on frames 0 to ${store.move.frames}: bake others for another number.`, true);
        this.frames.value = String(store.move.frames);
      } else {
        store.edit({ ...store.move, frames });
      }
      this.draw();
    });
    for (const field of [this.frames, this.fps]) {
      field.addEventListener("keydown", (event) => {
        if (event.key !== "Escape") return;
        field.value = field === this.frames ? String(this.store.move.frames) : this.store.move.fps.text;
        field.select();
        event.stopPropagation();
      });
    }
    this.fps.addEventListener("change", () => {
      const fps = parseFps(this.fps.value);
      if (!fps) say("Frames per second: a whole number, or a fraction such as 24000/1001.", true);
      else store.edit({ ...store.move, fps });
      this.draw();
    });
    this.track.addEventListener("change", () =>
      store.select({ track: Number(this.track.value), keys: new Set(), values: new Set() }),
    );
    store.onChange(() => this.draw());
    store.onCommit = () => {
      this.keepDraft();
      void this.resolve();
      this.later();
    };
    if (server) window.setInterval(() => void this.watch(), 2000);
    window.addEventListener("beforeunload", (event) => {
      this.takeTyped();
      if (this.store.isChanged && !(this.draft && this.hasRoom)) event.preventDefault();
    });
    void this.resolve();
    this.draw();
  }

  /** A number that is being typed counts as soon as its field is left. */
  private takeTyped(): void {
    const field = document.activeElement;
    if (!(field instanceof HTMLInputElement)) return;
    field.blur();
    field.focus();
  }
  saveTyped(): void {
    this.takeTyped();
    void this.save();
  }

  keepDraft(): void {
    const { states, at, saved } = this.store;
    if (this.draft) this.tellRoom(this.draft.write({ states, at, saved, known: this.known }));
  }
  tellRoom(hasRoom: boolean): void {
    this.hasRoom = hasRoom;
    notice(
      "room",
      hasRoom
        ? null
        : "This browser has no room left to keep what you edit: what is not saved is lost when this page is closed.",
      this.downloadButton("download-room"),
      button(
        "Forget older steps",
        "Undo will end here; that makes room",
        () => {
          this.store.restore([this.store.move], 0, this.store.isChanged ? null : this.store.move);
          this.keepDraft();
        },
        "forget",
      ),
    );
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
      this.track.replaceChildren(
        ...move.tracks.map((track, t) => html("option", { value: t }, track.axes.join(" · "))),
      );
    }
    if (this.track.value !== String(store.selection.track)) this.track.value = String(store.selection.track);
    this.track.hidden = move.tracks.length < 2;
    const { certificate } = store.solution;
    let words = `${((move.frames * move.fps.denominator) / move.fps.numerator).toFixed(2)} s`;
    let state = "";
    if (store.error) {
      const place = store.error.key >= 0 ? `key ${store.error.key}: ` : "";
      words = `${place}${store.error.what}; ${store.error.remedy}`;
      state = "bad";
    } else if (certificate) {
      const stop = certificate.longestStop !== null ? `, stops in ${certificate.longestStop.toFixed(2)} s` : "";
      words = certificate.fits
        ? `✓ within the limits, up to ${(certificate.highestRate * 100).toFixed(0)} %${stop}`
        : `✗ ${certificate.reason}`;
      state = certificate.fits ? "good" : "bad";
    }
    if (this.verdict.textContent !== words) this.verdict.textContent = words;
    attributes(this.verdict, { title: words, class: state });
    this.verdict.dataset.hash = store.solution.tracks.map((track) => track.hash).join(" ");
    const saved = this.conflict ? "changed outside" : store.isChanged ? "not saved" : "saved";
    if (this.server && this.saved.textContent !== saved) this.saved.textContent = saved;
    this.saved.className = this.conflict ? "bad" : store.isChanged ? "" : "good";
  }

  private later(): void {
    clearTimeout(this.timer);
    if (!this.server || !this.auto.checked) return;
    this.timer = window.setTimeout(() => {
      if (this.store.isChanged && !this.store.error && !this.conflict) void this.save();
    }, 1000);
  }

  /** What the page cannot solve by itself is asked of the program after every edit. */
  private async resolve(): Promise<void> {
    const asked = this.store.move;
    if (!this.server || asked.tracks.every((track) => track.live)) return;
    try {
      const answer = await this.server.resolve(asked);
      if (this.store.move !== asked) return;
      this.store.amend((move) => (move === asked ? this.taken(asked, answer) : move));
    } catch (error) {
      say((error as Error).message, true);
    }
  }
  /** Of the program's answer what the page does not work out itself. */
  private taken(move: Move, answer: Move): Move {
    return move.tracks.reduce((result, track, t) => {
      if (track.live) return result;
      const { path, speed, keys } = answer.tracks[t];
      // A key of a network may be where its curve is.
      const follows = track.network !== null && !track.moved;
      return withTrack(result, t, {
        path,
        speed: track.touched ? track.speed : speed,
        keys: follows ? keys : track.keys,
      });
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
        if (!isMoved && !isNew) return;
        move = withTrack(move, t, {
          ...(isMoved ? { keys, moved: true } : {}),
          ...(isNew ? { speed: track.speed, touched: old.touched || what === "fit", path: track.path } : {}),
        });
      });
      if (move.frames === asked.frames && move.tracks.every((track, t) => track === asked.tracks[t]))
        return say(
          `Nothing is changed: ${what === "fit" ? "the limits are kept" : "these are the fewest frames"} already.`,
        );
      this.store.edit(move);
      say(what === "fit" ? "The speed curve is fitted to the limits." : `${answer.frames} frames.`);
    } catch (error) {
      say((error as Error).message, true);
    } finally {
      this.busy = false;
      byId(what).removeAttribute("aria-busy");
    }
  }

  /** Edits go on counting from the text that was loaded, however often they are saved: undo reaches back over it. The file
   * is expected to have the revision `there`. */
  async save(there = this.known): Promise<void> {
    if (!this.server) {
      download(this.store.move.file, textOf(this.store.move));
      this.store.saved = this.store.move;
      return this.draw();
    }
    if (this.saving) return void (this.saveAgain = true);
    const saved = this.store.move;
    clearTimeout(this.timer);
    this.saving = true;
    this.saveAgain = false;
    this.store.sent = saved;
    try {
      const { revision, kept } = await this.server.save(saved, there, there === this.known);
      this.known = revision;
      this.store.saved = this.store.sent;
      this.conflict = false;
      this.keepDraft();
      notice("save", null);
      notice("back", null);
      say(kept ? `Saved. The other version is in ${kept}.` : "Saved");
      if (this.store.isChanged) this.later();
    } catch (error) {
      await this.notSaved(error as Error);
    } finally {
      this.saving = false;
    }
    this.draw();
    if (this.saveAgain && this.store.isChanged && !this.conflict) await this.save();
  }
  private async notSaved(error: Error): Promise<void> {
    const refusal = error instanceof Refusal ? error : null;
    if (refusal?.status === 409) return this.offer(refusal.revision ?? (await this.server!.revision()).revision);
    if (refusal?.status === 0) return this.tellAway("The program has ended");
    notice(
      "save",
      `Not saved: ${error.message}. Your edits stay here${this.hasRoom ? ", also when this page is closed" : ""}.`,
      this.downloadButton("download-save"),
    );
  }

  private downloadButton(id: string): HTMLButtonElement {
    return button("Download", "Download the move as a file", () => void this.download(), id);
  }
  /** As the program would write it; without it as well as the page can. */
  private async download(): Promise<void> {
    const { move } = this.store;
    download(move.file, await this.server!.text(move).catch(() => textWithoutProgram(move)));
  }

  private async watch(): Promise<void> {
    if (!this.server) return;
    const { known } = this;
    let there: string;
    try {
      const file = await this.server.revision();
      if (file.id !== this.store.move.id) return this.tellAway("The program at this address edits another file now");
      there = file.revision;
      await this.seeRig(file);
    } catch (error) {
      if (error instanceof Refusal && error.status === 0) this.tellAway("The program has ended");
      else if (error instanceof Refusal && error.status === 403)
        this.tellAway("Another program has the address of this page now");
      return; // what else is wrong with the file, saving will tell
    }
    if (document.getElementById("notice-away")) {
      notice("away", null);
      say("The program is there again.");
      this.later();
    }
    if (there !== known && this.known === known && !this.saving && !this.conflict && !this.busy) this.offer(there);
  }
  /** New limits are seen as a new move is: every step of undo gets them. */
  private async seeRig({ rig, rig_error }: FileState): Promise<void> {
    const tell = (error: string | null): void =>
      notice("rig", error && `The rig cannot be taken as its file is now: ${error}. The limits are those of before.`);
    tell(rig_error);
    if (rig === (this.store.move.rig?.revision ?? null) || this.store.isDragging) return;
    const now = new Map<string, Move>();
    try {
      for (const { revision, text } of this.store.states)
        if (!now.has(revision)) now.set(revision, await this.server!.document(text));
    } catch (error) {
      return tell((error as Error).message);
    }
    if (this.store.isDragging) return; // a step that has been begun keeps its limits: the next look takes them
    this.store.amend((move) => {
      const there = now.get(move.revision);
      return there ? withRigOf(there, move) : move;
    });
    void this.resolve();
    say("The limits are those that the rig's file has now.");
  }
  private tellAway(what: string): void {
    notice(
      "away",
      `${what}. ${this.hasRoom ? "You can go on: this browser keeps your edits, and this page saves them when" : "Download your edits, or leave this page open until"} inbetween edit is started again for ${this.store.move.file}.`,
      this.downloadButton("download-away"),
    );
  }

  /** Somebody else has changed the file: nothing is lost, whatever is chosen. */
  offer(there: string): void {
    this.conflict = true;
    this.draw();
    const dialog = byId("dialog") as HTMLDialogElement;
    if (dialog.open) return;
    const close = (act: () => Promise<void>) => (): void => {
      dialog.close();
      void act();
    };
    const { file } = this.store.move;
    const isGone = there === "gone";
    const save = (label: string, title: string): HTMLButtonElement =>
      button(
        label,
        title,
        close(() => this.save(there)),
        "save-mine",
      );
    dialog.replaceChildren(
      html("h2", {}, isGone ? `${file} is gone` : `${file} has been changed outside the editor`),
      html("p", {}, isGone ? "Somebody has moved or deleted it." : "Both versions are kept, whichever you go on with."),
      html(
        "div",
        { class: "tools" },
        ...(isGone
          ? [save("Save it anew", "Write what is in the editor into a new file of this name")]
          : [
              button(
                "Load the file",
                "Load the file; what is in the editor is kept as a copy, and Undo goes back to it",
                close(() => this.loadTheirs()),
                "load-theirs",
              ),
              save("Save mine", "Save what is in the editor; the file is kept as a copy"),
            ]),
        button(
          "Later",
          "Decide later",
          close(async () => {}),
          "decide-later",
        ),
      ),
    );
    dialog.showModal();
  }

  private async loadTheirs(): Promise<void> {
    if (!this.server) return;
    try {
      const mine = this.store.move;
      const kept = await this.server.keep(mine);
      const theirs = await this.server.open();
      const refusal = this.store.refusalOf(theirs);
      if (refusal) throw new Error(refusal);
      await this.load(theirs);
      say(kept ? `Loaded. Your version is in ${kept}.` : "Loaded");
    } catch (error) {
      notice(
        "save",
        `Not loaded: ${(error as Error).message}. Your edits stay here.`,
        this.downloadButton("download-save"),
      );
    }
    this.draw();
  }
  /** What the file has now, as a step of the history. */
  async load(theirs: Move): Promise<void> {
    const take = (): void => {
      this.conflict = false;
      this.known = theirs.revision;
      notice("save", null);
      this.store.load(theirs);
    };
    await (this.draft ? this.draft.keepBase(theirs, take) : take());
  }
}
