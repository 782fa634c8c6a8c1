// Random sequences of what happens to a move that is edited: edits, undo, saves, outside writes, kills of the program, a
// full disk, more tabs, reloads, closed and crashed tabs. After every sequence, every text that was typed or saved is in
// the file, in a version kept beside it, or on a page.
//
//   INBETWEEN=build/release/inbetween node --test tests/editor/sequences_test.mjs
//
// The seeds are fixed. The first eight sessions are run, all 25 where INBETWEEN_CASES=all says so, as scripts/test --long
// does. INBETWEEN_SESSION=17 runs session 17 alone, and says what it does.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readdirSync, readFileSync, renameSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { edit, startBrowser, stopBrowser } from "./editor.mjs";

const { parse } = createRequire(new URL("../../editor/page/package.json", import.meta.url).pathname)("smol-toml");
const sessions = process.env.INBETWEEN_CASES === "all" ? 25 : 8;
const sequencesEach = 40; // 1 000 in all

before(startBrowser);
after(stopBrowser);

/** mulberry32: the same numbers on every machine. */
function randomOf(seed) {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 2 ** 32;
  };
}

/** What a text says of the move, in the words of `identify` in the page. */
function idOfText(text) {
  try {
    const { frames, track } = parse(text);
    return JSON.stringify([
      frames,
      track.map(({ keys, speed }) => [keys.map((key) => [key.at, key.frame ?? null]), speed]),
    ]);
  } catch {
    return null; // it is no move
  }
}

class Session {
  constructor(seed, tell) {
    this.random = randomOf(seed);
    this.tell = tell;
    this.counter = 0;
    this.typed = new Map(); // id -> what typed it
    this.outside = new Map(); // text -> when
    this.isDown = false;
    this.isFull = false;
    this.tabs = [];
    this.most = 0;
  }
  pick(from) {
    return from[Math.floor(this.random() * from.length)];
  }

  async start() {
    this.editor = await edit("reveal.toml", "camera_rig.toml", { viewport: { width: 800, height: 450 } });
    this.typed.set(idOfText(this.editor.read()), "the file at first");
    await this.editor.page.locator("#autosave").uncheck();
    await this.enter(this.editor.page);
  }
  async enter(page) {
    if (!this.tabs.includes(page)) this.tabs.push(page);
    this.most = Math.max(this.most, this.tabs.length);
    await page.waitForSelector("#frames, #said.error");
    if ((await page.locator("#frames").count()) === 0) {
      // a page without anything to show, of a file that is no move
      assert.equal(idOfText(this.fileText() ?? ""), null, await page.locator("#said").textContent());
      this.tabs.splice(this.tabs.indexOf(page), 1);
      await page.close();
      return false;
    }
    await page.evaluate(() => {
      const { store, bar } = window.inbetween;
      for (const name of ["save", "loadTheirs"]) {
        // so that they can be waited for
        const act = bar[name].bind(bar);
        bar[name] = (...words) => (bar.waitedFor = act(...words));
      }
      const ids = new WeakMap();
      const words = (move) =>
        JSON.stringify([
          move.frames,
          move.tracks.map((track) => [track.keys.map((key) => [key.at, key.frame]), track.speed]),
        ]);
      const identify = (move) => ids.get(move) ?? (ids.set(move, words(move)), ids.get(move));
      window.keeping = { store, bar, identify };
    });
    return true;
  }
  fileText() {
    try {
      return this.editor.read();
    } catch {
      return null; // it is gone
    }
  }
  tab() {
    return this.pick(this.tabs);
  }

  /** Every state and every text that open pages have; with `edited` of those only in which something was edited. */
  async onPages({ edited = false } = {}) {
    const ids = new Set();
    const texts = new Set();
    for (const page of this.tabs) {
      const { states, bases } = await page.evaluate(() => {
        const { store, identify } = window.keeping;
        return { states: store.states.map(identify), bases: [...new Set(store.states.map((state) => state.text))] };
      });
      if (edited && states.length < 2) continue;
      for (const id of states) ids.add(id);
      for (const text of bases) texts.add(text);
    }
    return { ids, texts };
  }
  files() {
    return readdirSync(this.editor.folder)
      .filter((name) => /^reveal\.(.*\.)?toml(\.part)?$/.test(name))
      .map((name) => readFileSync(join(this.editor.folder, name), "utf8"));
  }
  async check() {
    const { ids, texts } = await this.onPages();
    for (const text of this.files()) {
      texts.add(text);
      ids.add(idOfText(text));
    }
    for (const [id, how] of this.typed) assert.ok(ids.has(id), `gone: what ${how}: ${id}`);
    for (const [text, how] of this.outside) assert.ok(texts.has(text), `gone: what ${how}: ${text.slice(0, 60)}`);
  }

  // What happens. Each returns once it is over.
  async edit(page) {
    const kind = this.pick(["value", "value", "key", "frames", "unsolvable", "drag", "keyboard"]);
    const n = ++this.counter;
    if (kind === "keyboard") {
      await page.bringToFront();
      const before = await this.current(page);
      await page.locator("#speed .value .knob").nth(4).focus();
      await page.keyboard.press(n % 2 ? "ArrowUp" : "ArrowDown");
      return this.note(page, before, `edit ${n} typed with the keyboard`);
    }
    const before = await this.current(page);
    await page.evaluate(
      ([what, number]) => {
        const { store } = window.keeping;
        const { move } = store;
        const [track] = move.tracks;
        const withTrack = (change) => ({ ...move, tracks: [{ ...track, ...change }] });
        const raised = (by) => track.speed.map((value, i) => (i === 4 ? Math.round((5 + by) * 1000) / 1000 : value));
        if (what === "value") store.edit(withTrack({ speed: raised(number / 1000), touched: true }));
        else if (what === "key")
          store.edit(
            withTrack({
              keys: track.keys.map((key, k) =>
                k === 1 ? { ...key, at: [400 + number / 100, ...key.at.slice(1)] } : key,
              ),
              moved: true,
            }),
          );
        else if (what === "frames") store.edit({ ...move, frames: 150 + number });
        else if (what === "unsolvable")
          store.edit(
            withTrack({
              keys: track.keys.map((key, k) => ({ ...key, frame: k === 1 ? 100 + number : k === 2 ? 40 : null })),
              moved: true,
            }),
          );
        else {
          store.begin();
          for (let i = 1; i < 4; ++i)
            store.edit({
              ...store.move,
              tracks: [{ ...store.move.tracks[0], speed: raised(number / 1000 + i), touched: true }],
            });
          store.end();
        }
      },
      [kind, n],
    );
    await this.note(page, before, `edit ${n} (${kind}) typed`);
  }
  /** The state that is shown, and those that could be done again. */
  current(page) {
    return page.evaluate(() => {
      const { store, identify } = window.keeping;
      return { shown: identify(store.move), undone: store.states.slice(store.at + 1).map(identify) };
    });
  }
  /** A step was done in a page: who does one drops those that could be done again, unless the page keeps them. */
  async note(page, before, how) {
    const { shown, dropped } = await page.evaluate((undone) => {
      const { store, identify } = window.keeping;
      const states = new Set(undone.length > 0 ? store.states.map(identify) : []);
      return { shown: identify(store.move), dropped: undone.filter((id) => !states.has(id)) };
    }, before.undone);
    for (const id of dropped) this.typed.delete(id);
    if (!this.typed.has(before.shown)) this.typed.set(before.shown, "was there before");
    this.typed.set(shown, how);
  }
  async typeAndLeave(page) {
    const before = await this.current(page);
    const n = ++this.counter;
    await page.bringToFront();
    await page.locator("#frames").fill(String(1000 + n));
    if (this.random() < 0.5 && !this.isDown) {
      await page.reload();
      await this.enter(page);
    } else {
      await page.keyboard.press("Control+s");
      await this.saved(page);
    }
    await this.note(page, before, `edit ${n} typed without Enter`);
  }
  async undo(page) {
    await page.evaluate(() => window.keeping.store.undo());
  }
  async redo(page) {
    await page.evaluate(() => window.keeping.store.redo());
  }
  /** Waits for what was asked of the program, and answers the question if there is one. */
  async saved(page) {
    await page.evaluate(() => window.keeping.bar.waitedFor);
    await this.answer(page);
  }
  async save(page) {
    await page.evaluate(() => window.keeping.bar.save());
    await this.answer(page);
  }
  async watch(page) {
    await page.evaluate(() => window.keeping.bar.watch());
    await this.answer(page);
  }
  async answer(page) {
    for (let tries = 0; tries < 3; ++tries) {
      const choice = this.pick(["load-theirs", "save-mine", "decide-later"]);
      const answered = await page.evaluate(async (id) => {
        const dialog = document.getElementById("dialog");
        if (!dialog.open) return null;
        const button = document.getElementById(id) ?? document.getElementById("save-mine");
        button.click();
        await window.keeping.bar.waitedFor;
        return button.id;
      }, choice);
      if (answered === null) return;
      this.tell(`    ${answered}`);
    }
  }
  /** Another program writes the file: what it takes the place of is that program's to answer for. */
  writeOutside(kind = this.pick(["comment", "values", "broken", "gone", "renamed"])) {
    const { path } = this.editor;
    const there = this.fileText();
    if (there !== null) this.replaced = there;
    const n = ++this.counter;
    if (kind === "gone") {
      rmSync(path, { force: true });
      return;
    }
    const first = `name = "reveal"\nfps = 24\nframes = ${300 + n}\n[[track]]\naxes = ["slide", "pan", "tilt"]\nspline = "smooth"\nkeys = [{ at = [0, 0, 0] }, { at = [${100 + n}, 10, 2] }, { at = [600, 20, 4] }, { at = [900, 30, 5] }]\nspeed = [0, 0, 3, 4, 5, 4, 3, 0, 0]\nweights = [1.0, 6.0, 6.0]\n`;
    const text =
      kind === "broken" ? `frames = = ${n}\n` : kind === "comment" ? `# outside ${n}\n${there ?? first}` : first;
    if (kind === "renamed") {
      writeFileSync(`${path}.new`, text);
      renameSync(`${path}.new`, path);
    } else {
      writeFileSync(path, text);
    }
    this.outside.set(text, `was written outside (${n}, ${kind})`);
  }
  /** What another program has overwritten or deleted need not be anywhere, unless it belongs to what is edited in a page. */
  async forgetReplaced() {
    if (this.replaced === undefined) return;
    const text = this.replaced;
    this.replaced = undefined;
    const { texts } = await this.onPages({ edited: true });
    if (!texts.has(text) && !this.files().includes(text)) this.outside.delete(text);
  }
  async kill(page) {
    const isSaving = !this.isDown && this.random() < 0.5;
    if (isSaving) {
      await page.evaluate(() => void window.keeping.bar.save());
      if (this.random() < 0.5) await page.evaluate(() => new Promise((done) => setTimeout(done, 2)));
    }
    await this.editor.kill();
    this.isDown = true;
    this.isFull = false;
    if (isSaving) await this.saved(page);
  }
  async launch() {
    if (!this.isDown) return;
    const text = this.fileText();
    if (text === null || idOfText(text) === null) this.writeOutside("values"); // the program starts with a move only
    await this.forgetReplaced();
    const address = await this.editor.launch();
    assert.equal(address, this.editor.address, "the address is the same");
    this.isDown = false;
  }
  fill() {
    if (this.isDown) return;
    this.isFull = !this.isFull;
    const bytes = this.isFull ? Math.floor(this.random() * 600) : "unlimited";
    execFileSync("prlimit", ["--pid", String(this.editor.pid), `--fsize=${bytes}:unlimited`]);
  }
  async reload(page) {
    if (this.isDown) await this.launch();
    const states = () => page.evaluate(() => window.keeping.store.states.map(window.keeping.identify));
    const had = await states();
    await page.reload();
    if (!(await this.enter(page))) return assert.equal(had.length, 1, "what was edited is there without the file");
    if (had.length > 1) assert.deepEqual((await states()).slice(0, had.length), had, "the history is the same");
    await this.answer(page);
  }
  async open() {
    if (this.tabs.length > 2) return;
    await this.launch();
    const page = await this.editor.context.newPage();
    await page.goto(this.editor.address);
    if (await this.enter(page)) await this.answer(page);
  }
  async close(page) {
    if (this.tabs.length < 2) return;
    this.tabs.splice(this.tabs.indexOf(page), 1);
    if (this.random() < 0.3) {
      const crash = await page.context().newCDPSession(page);
      const crashed = page.waitForEvent("crash");
      crash.send("Page.crash").catch(() => {});
      await crashed;
    }
    await page.close();
    await this.open(); // it comes back in the next that is opened
  }

  async step() {
    const what = this.pick([
      ...Array(16).fill("edit"),
      ...Array(8).fill("save"),
      ...Array(4).fill("outside"),
      ...Array(3).fill("launch"),
      ...Array(3).fill("undo"),
      ...Array(2).fill("redo"),
      ...Array(2).fill("watch"),
      ...Array(2).fill("kill"),
      ...Array(2).fill("fill"),
      "reload",
      "open",
      "close",
      "typeAndLeave",
    ]);
    while (this.tabs.length === 0) {
      // the last had nothing to show, because the file is no move
      this.writeOutside("values");
      await this.forgetReplaced();
      await this.open();
    }
    const page = this.tab();
    this.tell(`  ${what} in tab ${this.tabs.indexOf(page)}`);
    if (what === "outside") {
      this.writeOutside();
      await this.forgetReplaced();
    } else {
      await this[what](page);
    }
  }
  async sequence() {
    const steps = 3 + Math.floor(this.random() * 8);
    for (let i = 0; i < steps; ++i) await this.step();
    await this.check();
  }
  /** All tabs are closed, and opened again: what they had is there. */
  async closeAndOpenAll() {
    await this.launch();
    if (this.isFull) this.fill();
    for (const page of this.tabs) await page.close();
    this.tabs = [];
    for (let i = 0; i < this.most; ++i) {
      const page = await this.editor.context.newPage();
      await page.goto(this.editor.address);
      await this.enter(page);
    }
    await this.check();
  }
}

const only = process.env.INBETWEEN_SESSION;
test("nothing typed or saved is gone after 1000 random sequences", { concurrency: 2 }, async (t) => {
  const chosen = only === undefined ? Array.from({ length: sessions }, (_, i) => i + 1) : [Number(only)];
  await Promise.all(
    chosen.map((seed) =>
      t.test(`session ${seed}: ${sequencesEach} sequences`, async () => {
        const session = new Session(seed, only === undefined ? () => {} : (line) => console.log(line));
        await session.start();
        for (let i = 0; i < sequencesEach; ++i) {
          session.tell(`sequence ${i}`);
          await session.sequence();
        }
        await session.closeAndOpenAll();
        assert.deepEqual(
          session.editor.complaints.filter((complaint) => !complaint.startsWith("Failed to load resource")),
          [],
        );
        await session.editor.end();
      }),
    ),
  );
});
