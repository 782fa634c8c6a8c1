// Nothing that was typed or saved is ever gone: it is in the file, in a version kept beside it, or on the page.
//
//   INBETWEEN=build/release/inbetween node --test tests/editor/keeping_test.mjs
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, readdirSync, readFileSync, rmSync, statSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { edit, eventually, pick, startBrowser, stopBrowser, until, value, written } from "./editor.mjs";

before(startBrowser);
after(stopBrowser);

/** Makes tests that open the editor on an example, with Autosave or without. */
const testWith = (autosave) => (name, act) =>
  test(name, async () => {
    const editor = await edit("reveal.toml", "camera_rig.toml");
    if (!autosave) await editor.page.locator("#autosave").uncheck();
    const first = editor.read();
    const beside = (version) => readFileSync(join(editor.folder, `reveal.${version}.toml`), "utf8");
    await act(Object.assign(editor, { first, beside }), editor.page);
    await editor.end();
  });
const withReveal = testWith(false);
const withAutosave = testWith(true);

/** A control value up by a step, as a person does it. */
async function raise(page, i) {
  await pick(page, value(page, i));
  const was = await page.evaluate(() => window.inbetween.store.move);
  await page.keyboard.press("ArrowUp");
  await until(page, (old) => JSON.stringify(window.inbetween.store.move.tracks) !== old, JSON.stringify(was.tracks));
}
const move = (page) =>
  page.evaluate(() => {
    const { frames, tracks } = window.inbetween.store.move;
    return JSON.stringify([frames, tracks.map((track) => [track.keys, track.speed])]);
  });
async function another(editor) {
  const page = await editor.context.newPage();
  await page.goto(editor.address);
  await page.waitForSelector("#frames");
  return page;
}
async function loadAgain(page) {
  await page.reload();
  await page.waitForSelector("#frames");
}
async function answer(page, choice) {
  await page.waitForSelector("dialog[open]");
  await page.locator(`#${choice}`).click();
}
const noticed = (page, id, words) =>
  until(page, ([notice, text]) => document.getElementById(notice)?.textContent.includes(text), [`notice-${id}`, words]);
async function downloaded(page, button) {
  const [taken] = await Promise.all([page.waitForEvent("download"), page.locator(button).click()]);
  return readFileSync(await taken.path(), "utf8");
}
const limitFiles = (editor, bytes) =>
  execFileSync("prlimit", ["--pid", String(editor.pid), `--fsize=${bytes}:unlimited`]);

withReveal("the hundredth save is as good as the first", async (editor, page) => {
  await pick(page, value(page, 4));
  let last = editor.first;
  for (let i = 0; i < 100; ++i) {
    await page.keyboard.press(i % 2 ? "ArrowDown" : "Shift+ArrowUp");
    await page.keyboard.press("Control+s");
    await written(() => editor.read() !== last);
    await editor.saved();
    last = editor.read();
  }
});

withAutosave("what was saved, then changed outside, is kept when the file is loaded", async (editor, page) => {
  await raise(page, 4);
  await written(() => editor.read() !== editor.first);
  await editor.saved();
  const mine = editor.read();
  const shape = await move(page);
  writeFileSync(editor.path, `# from elsewhere\n${editor.first}`);
  await answer(page, "load-theirs");
  await until(page, () => document.getElementById("said").textContent.startsWith("Loaded"));
  assert.equal(editor.beside("mine-1"), mine);
  await page.keyboard.press("Control+z");
  await eventually(async () => (await move(page)) === shape, "the move is as it was"); // and saved so
  await written(() => editor.read() === mine);
});

withReveal("Save mine in a second tab keeps what the first has saved", async (editor) => {
  const second = await another(editor);
  await raise(editor.page, 4);
  await editor.page.keyboard.press("Control+s");
  await editor.saved();
  const saved = editor.read();
  await second.bringToFront();
  await answer(second, "decide-later");
  await raise(second, 5);
  await second.keyboard.press("Control+s");
  await second.locator("#save-mine").click();
  await written(() => editor.read() !== saved);
  assert.equal(editor.beside("outside-1"), saved);
});

withReveal("an outside version that is no move is kept, also when it could not be loaded", async (editor, page) => {
  await raise(page, 4);
  const broken = "frames = = 7\n";
  writeFileSync(editor.path, broken);
  await answer(page, "load-theirs");
  await noticed(page, "save", "Not loaded: reveal.toml:1");
  assert.equal(editor.read(), broken);
  await page.keyboard.press("Control+s");
  await page.locator("#save-mine").click();
  await editor.saved();
  assert.equal(editor.beside("outside-1"), broken);
  await raise(page, 5);
  writeFileSync(editor.path, broken);
  await loadAgain(page); // the file cannot be opened, and the edits are there all the same
  await page.waitForSelector("dialog[open]");
  await editor.picture("draft_and_broken_file");
  await page.locator("#save-mine").click();
  await editor.saved();
  assert.notEqual(editor.read(), broken);
});

withReveal("a file that is gone is said, and written anew", async (editor, page) => {
  await raise(page, 4);
  rmSync(editor.path);
  await until(page, () => document.getElementById("dialog").textContent.includes("reveal.toml is gone"));
  await page.locator("#save-mine").click();
  await editor.saved();
  assert.equal(editor.plan().tracks.length, 1);
});

withReveal("what cannot be solved is not saved; it stays on the page and can be downloaded", async (editor, page) => {
  await page.evaluate(() => {
    const { store } = window.inbetween;
    const [track] = store.move.tracks;
    const keys = track.keys.map((key, k) => ({ ...key, frame: k === 1 ? 90 : k === 2 ? 40 : key.frame }));
    store.edit({ ...store.move, tracks: [{ ...track, keys, moved: true }] });
  });
  await page.keyboard.press("Control+s");
  await noticed(page, "save", "Not saved: reveal.toml:");
  assert.equal(editor.read(), editor.first);
  const text = await downloaded(page, "#download-save");
  assert.match(text, /frame = 40/);
  assert.match(text, /# one degree of pan or tilt counts/);
  await editor.picture("not_solved");
  await loadAgain(page);
  assert.equal(await page.evaluate(() => window.inbetween.store.move.tracks[0].keys[2].frame), 40);
  await page.keyboard.press("Control+z");
  await page.keyboard.press("Control+s");
  await editor.saved();
  assert.equal(editor.read(), editor.first);
});

withReveal("edits that were not saved come back with every step of undo and redo", async (editor, page) => {
  const shapes = [await move(page)];
  for (const i of [4, 5, 3]) {
    await raise(page, i);
    shapes.push(await move(page));
  }
  await page.locator("#frames").fill("180"); // and left without Enter
  await loadAgain(page);
  await noticed(page, "back", "not saved is back");
  assert.equal(JSON.parse(await move(page))[0], 180);
  await editor.picture("draft_is_back");
  for (const shape of shapes.toReversed()) {
    await page.keyboard.press("Control+z");
    assert.equal(await move(page), shape);
  }
  await page.keyboard.press("Control+Shift+z");
  await page.keyboard.press("Control+Shift+z");
  await loadAgain(page);
  assert.equal(await move(page), shapes[2]);
  await page.keyboard.press("Control+Shift+z");
  assert.equal(await move(page), shapes[3]);

  // A tab that was closed, or has crashed, or is open beside it.
  const crash = await page.context().newCDPSession(page);
  crash.send("Page.crash").catch(() => {});
  await page.waitForEvent("crash");
  const second = await another(editor);
  assert.equal(await move(second), shapes[3]);
  const third = await another(editor);
  assert.equal(await move(third), shapes[0], "a tab beside it has edits of its own");
  await raise(third, 2);
  const ofThird = await move(third);
  await second.close();
  await third.close();
  const both = [await another(editor), await another(editor)];
  assert.deepEqual(new Set(await Promise.all(both.map(move))), new Set([shapes[3], ofThird]));
  await noticed(both[0], "others", "1 more tab");
});

withReveal("a draft whose file was changed meanwhile is asked about like every outside change", async (editor) => {
  await raise(editor.page, 4);
  const mine = await move(editor.page);
  await editor.page.close();
  const outside = `# from elsewhere\n${editor.first}`;
  writeFileSync(editor.path, outside);
  const page = await another(editor);
  await page.waitForSelector("dialog[open]");
  assert.equal(await move(page), mine);
  await page.locator("#load-theirs").click();
  await until(page, () => document.getElementById("said").textContent.includes("reveal.mine-1.toml"));
  assert.equal(editor.read(), outside);
  // Loaded again, the file is what is shown, without a question, and undo still goes back to what was edited.
  writeFileSync(editor.path, `# again\n${outside}`);
  await loadAgain(page);
  assert.equal(await page.locator("dialog[open]").count(), 0);
  assert.equal(await page.locator("#saved").textContent(), "saved");
  for (let i = 0; i < 2; ++i) await page.keyboard.press("Control+z");
  assert.equal(await move(page), mine);
});

withAutosave("when the program is killed the page says so, gives the move, goes on, finds it", async (editor, page) => {
  await editor.kill();
  await raise(page, 4);
  await noticed(page, "away", "The program has ended. You can go on");
  await editor.picture("program_ended");
  const text = await downloaded(page, "#download-away");
  assert.match(text, /^# weights = .*# one degree of pan or tilt counts/m, "the old file is there with its comments");
  const mine = await move(page);
  assert.equal(editor.read(), editor.first);
  const state = join(editor.folder, "state/inbetween");
  const [kept] = readdirSync(state);
  assert.equal(statSync(join(state, kept)).mode & 0o777, 0o600);
  assert.equal(await editor.launch(), editor.address, "the address is the same");
  await written(() => editor.read() !== editor.first);
  await editor.saved();
  assert.equal(await page.locator("#notice-away").count(), 0);
  assert.equal(await move(page), mine);
  const path = join(editor.folder, "taken.toml");
  writeFileSync(path, text);
  const planned = editor.planned();
  writeFileSync(editor.path, text);
  assert.equal(editor.planned(), planned, "what was downloaded is the move");
});

withReveal("a port that another program has taken is named, and another is used", async (editor) => {
  const port = Number(new URL(editor.address).port);
  await editor.kill();
  const other = createServer((request, response) =>
    response.writeHead(403, { "Content-Type": "application/json" }).end("{}"),
  );
  await new Promise((done) => other.listen(port, "127.0.0.1", done));
  await noticed(editor.page, "away", "Another program has the address of this page now");
  const address = await editor.launch();
  assert.notEqual(address, editor.address);
  assert.match(editor.said(), new RegExp(`port ${port} is taken by another program`));
  const closed = new Promise((done) => other.close(done));
  other.closeAllConnections(); // the browser keeps some open
  await closed;
  await editor.kill();
  assert.equal(await editor.launch(), editor.address);
  await assert.rejects(editor.launch(), /another inbetween edit has it open/);
});

withReveal("a full disk is said in a line, the file stays whole, the edits stay on the page", async (editor, page) => {
  await raise(page, 4);
  limitFiles(editor, 100);
  await page.keyboard.press("Control+s");
  await noticed(page, "save", "Not saved: reveal.toml.inbetween-part could not be written completely");
  assert.equal(editor.read(), editor.first);
  assert.ok(!existsSync(`${editor.path}.inbetween-part`));
  await editor.picture("full_disk");
  const outside = `# from elsewhere\n${editor.first}`;
  writeFileSync(editor.path, outside);
  await answer(page, "save-mine");
  await noticed(page, "save", "Not saved: reveal.outside-1.toml.inbetween-part could not be written completely");
  assert.equal(editor.read(), outside, "nothing is replaced that could not be kept");
  limitFiles(editor, "unlimited");
  await page.keyboard.press("Control+s");
  await page.locator("#save-mine").click();
  await editor.saved();
  assert.equal(editor.beside("outside-1"), outside);
});

withReveal("a browser without room says so, and keeps again once there is some", async (editor, page) => {
  await page.evaluate(() => {
    for (let size = 2 ** 23, n = 0; size >= 1; size /= 2) {
      for (;;) {
        try {
          localStorage.setItem(`filler ${++n}`, "x".repeat(size));
        } catch {
          localStorage.removeItem(`filler ${n}`);
          break;
        }
      }
    }
  });
  await raise(page, 4);
  await noticed(page, "room", "no room left");
  await editor.picture("browser_full");
  const shape = await move(page);
  await page.evaluate(() =>
    Object.keys(localStorage)
      .filter((name) => name.startsWith("filler"))
      .forEach((name) => localStorage.removeItem(name)),
  );
  await page.locator("#forget").click();
  assert.equal(await page.locator("#notice-room").count(), 0);
  await loadAgain(page);
  assert.equal(await move(page), shape);
});
