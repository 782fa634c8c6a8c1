// A file of another program is dropped on the page: it asks, writes a move beside the one that is open, and opens it.
//
//   INBETWEEN=build/release/inbetween node --test tests/editor/import_test.mjs
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, readdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import {
  alone,
  edit,
  eventually,
  example,
  hashes,
  pick,
  program,
  startBrowser,
  stopBrowser,
  until,
  value,
} from "./editor.mjs";

before(startBrowser);
after(stopBrowser);

// A second is not a whole number of its steps: what is drawn is what rows say, and not what a pretty number would.
const rows = Array.from({ length: 49 }, (_, f) => {
  const ease = (1 - Math.cos((Math.PI * f) / 48)) / 2;
  return `${f + 1},${(40 * ease).toFixed(4)},${(30 * ease).toFixed(4)},7`;
});
const shot = `frame,PAN,TRACK [cm],junk\n${rows.join("\n")}\n`;

const drop = (page, ...files) =>
  page.evaluate((dropped) => {
    const dataTransfer = new DataTransfer();
    for (const { name, text } of dropped) dataTransfer.items.add(new File([text], name));
    document.dispatchEvent(new DragEvent("drop", { dataTransfer, cancelable: true }));
  }, files);
const asked = (page) => page.waitForSelector("#import[open]");
const says = (page, words) => until(page, (w) => document.getElementById("said").textContent.includes(w), words);
const filesOf = (editor) => readdirSync(editor.folder).sort().join();

const testOn =
  (viewport) =>
  (name, act, viewed = viewport) =>
    test(name, async () => {
      const editor = await edit("reveal.toml", "camera_rig.toml", { viewport: viewed });
      await act(editor, editor.page);
      assert.deepEqual(editor.complaints, []);
      await editor.end();
    });
const onDesk = testOn({ width: 1280, height: 720 });
const onPhone = testOn({ width: 390, height: 844 });

/** Waits until the form has seen the answers. */
const seen = (page) =>
  until(page, () => document.querySelector("#import").textContent.includes("48 frames of pan, slide"));
/** Answers all that `shot` leaves open but the name, which is suggested. */
async function answerShot(page) {
  await page.locator("#import-fps").fill("24");
  await page.keyboard.press("Enter");
  await page.locator("#import-axis-2").selectOption("slide");
  await page.locator("#import-axis-3").selectOption("-");
  await page.locator("#import-phase").selectOption("boundary");
}
/** What is open, once the page has come to the move that was made. */
const openedAs = (page, file) =>
  eventually(
    // Between two pages there is none to be asked.
    () => page.evaluate((name) => window.inbetween?.store.move.file === name, file).catch(() => false),
    `${file} is open`,
  );

for (const [where, testThere] of [
  ["desk", onDesk],
  ["phone", onPhone],
]) {
  testThere(
    `columns that the rig does not have are asked, and the move is seen, on a ${where}`,
    async (editor, page) => {
      const before = filesOf(editor);
      const text = editor.read();
      await drop(page, { name: "shot.csv", text: shot });
      await asked(page);
      // Suggested and not said; asked and not suggested; in the file and not asked.
      assert.equal(await page.locator("#import-axis-1").inputValue(), "pan");
      assert.match(await page.locator("#import-axis-1").getAttribute("class"), /suggested/);
      assert.equal(await page.locator("#import-unit-1").inputValue(), "deg", "asked of what is suggested");
      assert.equal(await page.locator("#import-axis-2").inputValue(), "");
      assert.equal(await page.locator("#import-fps").inputValue(), "");
      assert.match(await page.locator("label[for=import-phase]").textContent(), /where the shutter is closed/);
      assert.equal(await page.locator("#import-unit-2").count(), 0, "the file says cm");
      await editor.picture(`import_asks_${where}`);
      const box = await page.locator("#import").boundingBox();
      assert.ok(box.x >= 0 && box.x + box.width <= page.viewportSize().width, "it is as wide as the screen at most");
      await page.locator("#import-make").click(); // with questions open
      await until(page, () => document.activeElement.id === "import-fps");
      await answerShot(page);
      assert.equal(filesOf(editor), before, "nothing is written before somebody says so");
      await editor.picture(`import_answered_${where}`);
      await page.locator("#import-make").click();
      await page.waitForSelector("#import-open");
      assert.match(await page.locator("#import").textContent(), /column "junk" is of no axis and is left out/);
      await editor.picture(`import_written_${where}`);
      const address = page.url();
      await page.locator("#import-open").click();
      await openedAs(page, "shot.toml");
      assert.notEqual(page.url(), address, "each move has an address of its own");
      const [move, rig] = [join(editor.folder, "shot.toml"), join(editor.folder, "camera_rig.toml")];
      assert.equal(await editor.shown(), hashes(move, rig));
      const { table, stride } = await page.evaluate(() => {
        const { table, stride } = window.inbetween.store.solution.tracks[0];
        return { table: [...table], stride };
      });
      for (const [f, row] of rows.entries()) {
        const [, pan, track] = row.split(",").map(Number);
        assert.ok(Math.abs(table[f * stride + 4] - pan) < 1e-9);
        assert.ok(Math.abs(table[f * stride + 5] - 10 * track) < 1e-9, "cm are mm in the rig");
      }
      await editor.picture(`import_opened_${where}`);
      assert.equal(editor.read(), text, "the move that was open is as it was");
    },
  );
}

onDesk("a file that is wrong shows its lines, and nothing is written", async (editor, page) => {
  const before = filesOf(editor);
  await drop(page, { name: "wrong.csv", text: "frame,pan\n1,0\n2,x\n3,1,5\n5,0\n" });
  await asked(page);
  const told = await page.locator("#import .refused").textContent();
  assert.deepEqual(
    told.split("\n").map((line) => /^wrong\.csv:\d+(:\d+)?: error: .+; .+/.test(line)),
    [true, true, true],
    told,
  );
  assert.match(told, /wrong.csv:3:3: error: "x"/);
  assert.ok(await page.locator("#import-make").isDisabled());
  await editor.picture("import_refused");
  await page.keyboard.press("Escape");
  await until(page, () => !document.getElementById("import"));
  assert.equal(filesOf(editor), before);
});

onDesk(
  "a row outside the range of its axis is told once the axis is known, and another answer cures it",
  async (_, page) => {
    await drop(page, { name: "far.txt", text: "0\n170\n300\n" });
    await asked(page);
    await page.locator("#import-axis-1").selectOption("pan");
    await page.locator("#import-unit-1").selectOption("deg");
    await page.locator("#import-fps").fill("24");
    await page.keyboard.press("Enter");
    await page.locator("#import-phase").selectOption("boundary");
    await until(page, () => document.querySelector("#import .refused")?.textContent.includes("beyond its range"));
    await page.locator("#import-axis-1").selectOption("slide");
    await page.locator("#import-unit-1").selectOption("mm");
    await until(page, () => !document.querySelector("#import .refused"));
    assert.ok(await page.locator("#import-make").isEnabled());
  },
);

onDesk("by keyboard, and a name that is taken is asked for again", async (editor, page) => {
  writeFileSync(join(editor.folder, "mine.csv"), "mine");
  mkdirSync(join(editor.folder, "given"));
  writeFileSync(join(editor.folder, "given", "shot.csv"), shot);
  const choosing = page.waitForEvent("filechooser");
  await page.locator("#import-button").focus();
  await editor.settled(); // until the browser gives its question about the file to the test
  await page.keyboard.press("Enter");
  const file = join(editor.folder, "given", "shot.csv");
  await (await choosing).setFiles(file);
  await asked(page);
  await answerShot(page);
  await seen(page);
  await page.locator("#import-name").fill("mine");
  await page.keyboard.press("Enter");
  await until(page, () => document.querySelector("#import").textContent.includes("mine.csv is there already"));
  await page.locator("#import-make").click();
  await until(page, () => document.activeElement.id === "import-name");
  await page.locator("#import-name").fill("ours");
  await page.keyboard.press("Tab");
  await until(page, () => !document.querySelector("#import").textContent.includes("is there already"));
  await page.keyboard.press("Enter"); // on the button that follows
  await page.waitForSelector("#import-open");
  assert.equal(readFileSync(join(editor.folder, "mine.csv"), "utf8"), "mine");
  assert.ok(existsSync(join(editor.folder, "ours.toml")));
  // What it wrote is what the command line writes.
  const words = "--axis PAN=pan --axis junk=- --unit deg --fps 24 --phase boundary".split(" ");
  const toml = join(editor.folder, "theirs.toml");
  const rig = join(editor.folder, "camera_rig.toml");
  execFileSync(program, ["import", file, "--rig", rig, "--to", toml, "--axis", "TRACK=slide", ...words], {
    stdio: "ignore",
  });
  const rowsOf = (name) => readFileSync(join(editor.folder, name), "utf8");
  assert.equal(rowsOf("ours.csv"), rowsOf("theirs.csv"));
});

for (const choice of ["import-save", "import-open"]) {
  onDesk(`what was edited and not saved is asked about first: ${choice}`, async (editor, page) => {
    const text = editor.read();
    await page.locator("#autosave").uncheck();
    await pick(page, value(page, 4));
    await page.keyboard.press("ArrowUp");
    await until(page, () => window.inbetween.store.canUndo);
    const address = page.url();
    const edited = await editor.shown();
    await drop(page, { name: "shot.csv", text: shot });
    await asked(page);
    await answerShot(page);
    await page.locator("#import-make").click(); // before the form has seen the last of them
    await page.waitForSelector("#import-open");
    assert.match(await page.locator("#import").textContent(), /What you edited in reveal.toml is not saved/);
    assert.equal(editor.read(), text);
    await page.locator(`#${choice}`).click();
    await openedAs(page, "shot.toml");
    assert.equal(editor.read() !== text, choice === "import-save");
    await page.goto(address);
    await openedAs(page, "reveal.toml");
    assert.equal(await editor.shown(), edited, "nothing is lost, whatever was chosen");
  });
}

onDesk("what is no file of another program is named", async (editor, page) => {
  const before = filesOf(editor);
  await drop(page, { name: "storyboard.toml", text: "" });
  await says(page, "inbetween edit storyboard.toml");
  await drop(page, { name: "a.csv", text: shot }, { name: "b.csv", text: shot });
  await says(page, "one file at a time");
  await drop(page, { name: "long.csv", text: "1,2\n".repeat(5_000_000) });
  await says(page, "more than 16 MiB");
  await drop(page, { name: "robot.urdf", text: "<robot/>" });
  await asked(page);
  assert.match(await page.locator("#import .refused").textContent(), /becomes a rig/);
  await page.locator("#import-close").click();
  assert.equal(filesOf(editor), before);
});

test("without a rig there are no axes for its columns", async () => {
  const editor = await edit("reveal.toml", null);
  await drop(editor.page, { name: "shot.csv", text: shot });
  await says(editor.page, "open the move with --rig");
  await editor.end();
});

test("without the program it says who imports it", async () => {
  const { page, end } = await alone();
  await page.waitForSelector("#files");
  await drop(page, { name: "shot.csv", text: shot });
  await until(page, () => document.querySelector("[role=alert]").textContent.includes("inbetween import"));
  const text = readFileSync(example("look_around.toml"), "utf8");
  await drop(page, { name: "look_around.toml", text });
  await until(page, () => document.querySelector("[role=alert]").textContent.includes("does not know table"));
  await end();
});
