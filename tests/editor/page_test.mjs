// Every operation of the editor as a person does it, by pointer and keyboard; what is saved is then planned by the
// command line, and has the hash that the page showed.
//
//   INBETWEEN=build/release/inbetween node --test tests/editor/page_test.mjs
import assert from "node:assert/strict";
import { existsSync, mkdtempSync, readFileSync, rmSync, statSync, writeFileSync } from "node:fs";
import { connect } from "node:net";
import { tmpdir } from "node:os";
import { basename, dirname, join } from "node:path";
import { after, before, test } from "node:test";
import {
  alone,
  centre,
  edit,
  example,
  hashes,
  hundredKeys,
  key,
  pick,
  pictures,
  shown,
  startBrowser,
  stopBrowser,
  until,
  value,
  written,
} from "./editor.mjs";

before(startBrowser);
after(stopBrowser);

/** Makes tests that open the editor with what `edit` takes, and in which the page complains of nothing. */
const testWith =
  (...opened) =>
  (name, act) =>
    test(name, async () => {
      const editor = await edit(...opened);
      await act(editor, editor.page);
      assert.deepEqual(editor.complaints, []);
      await editor.end();
    });
const withReveal = testWith("reveal.toml", "camera_rig.toml");
const withStoryboard = testWith("storyboard.toml", "camera_rig.toml");
const withFish = testWith("fish.toml", "fish_rig.toml");
const withCrane = testWith("crane/over_the_table.toml", "crane/rig.toml");
const onTablet = testWith("reveal.toml", "camera_rig.toml", { viewport: { width: 1024, height: 768 }, touch: true });
const withHundredKeys = testWith("reveal.toml", "camera_rig.toml", { text: hundredKeys() });

/** Runs `act` in the editor, saves, and holds what is saved to what is shown. */
async function afterwards(editor, act) {
  await act(editor.page);
  const hash = await editor.shown();
  await editor.page.keyboard.press("Control+s");
  await editor.saved();
  assert.equal(editor.planned(), hash, "the command line plans what the page showed");
  assert.deepEqual(editor.complaints, []);
}

/** Types `text` into a field, in place of what it had. */
async function enter(page, field, text) {
  await page.locator(field).fill(text);
  await page.locator(field).press("Enter");
}
async function drag(page, locator, dx, dy) {
  const [x, y] = await centre(locator);
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let i = 1; i <= 5; ++i) await page.mouse.move(x + (dx * i) / 5, y + (dy * i) / 5);
  await page.mouse.up();
}
withReveal("what is opened is shown with the numbers of the command line, and nothing is written", async (editor) => {
  const text = editor.read();
  assert.equal(await editor.shown(), editor.planned());
  assert.match(await editor.page.locator("#verdict").textContent(), /within the limits/);
  await editor.picture("opened");
  assert.equal(editor.read(), text);
});

withReveal("a control value is dragged, undone and done again", async (editor) => {
  const text = editor.read();
  await afterwards(editor, async (page) => {
    const first = await editor.shown();
    await drag(page, value(page, 4), 0, 40);
    const second = await editor.shown();
    assert.notEqual(second, first);
    await page.keyboard.press("Control+z");
    assert.equal(await editor.shown(), first);
    await page.keyboard.press("Control+Shift+z");
    assert.equal(await editor.shown(), second);
  });
  const lines = editor.read().split("\n");
  const changed = text.split("\n").filter((line, i) => line !== lines[i]);
  assert.equal(changed.length, 1, "one line changes, and every comment stays");
  assert.match(changed[0], /^speed/);
  await editor.picture("speed_dragged");
});

withReveal("control values by keyboard: raised, inserted, deleted, several at once", async (editor) => {
  await afterwards(editor, async (page) => {
    await pick(page, value(page, 3));
    await page.keyboard.press("ArrowRight");
    for (let i = 0; i < 3; ++i) await page.keyboard.press("ArrowDown");
    await page.keyboard.press("i");
    await page.keyboard.press("ArrowLeft");
    await page.keyboard.press("Delete");
    await page.keyboard.press("Shift+ArrowUp");
    await page.locator("#speed .value").nth(5).press("ArrowDown");
    const [x0] = await centre(value(page, 2));
    const [x1] = await centre(value(page, 4));
    const plot = await page.locator("#speed svg").boundingBox();
    await page.mouse.move(x0 - 20, plot.y + 3);
    await page.mouse.down();
    await page.mouse.move(x1, plot.y + 30);
    await page.mouse.move(x1 + 20, plot.y + plot.height - 3);
    await page.mouse.up();
    await editor.settled();
    assert.ok((await page.locator("#speed .value.selected").count()) >= 2);
    await page.locator("#lower").click();
  });
});

withReveal("keys: dragged, moved by keyboard, typed, added, inserted, copied, deleted", async (editor) => {
  await afterwards(editor, async (page) => {
    await drag(page, key(page, 1), 12, -18);
    await pick(page, key(page, 2));
    await page.keyboard.press("Alt+ArrowUp");
    await page.keyboard.press("Alt+Shift+ArrowRight");
    await page.getByLabel("tilt of key 3").fill("7.5");
    await page.keyboard.press("Enter");
    await pick(page, key(page, 2));
    await page.locator("#insert-key").click();
    await editor.settled();
    assert.equal(await page.locator("#plan .key").count(), 6);
    await page.keyboard.press("Control+d");
    await editor.settled();
    assert.equal(await page.locator("#plan .key").count(), 7);
    await page.locator("#delete-key").click();
    await editor.settled();
    assert.equal(await page.locator("#plan .key").count(), 6);
  });
  assert.match(editor.read(), /7\.5\]/);
  assert.match(editor.read(), /# one degree of pan or tilt counts/);
  await editor.picture("keys");
});

testWith("paper_figure_4.toml")("a key inserted by a double click lies on the path", async (editor) => {
  await afterwards(editor, async (page) => {
    const before = await page.locator("#plan .path-hit").getAttribute("d");
    const [a, b] = [await centre(key(page, 1)), await centre(key(page, 2))];
    const middle = before.split("L").map((point) => point.replace("M", "").split(" ").map(Number));
    const box = await page.locator("#plan svg").boundingBox();
    const wanted = [(a[0] + b[0]) / 2 - box.x, (a[1] + b[1]) / 2 - box.y];
    const nearest = middle.reduce((best, point) =>
      Math.hypot(point[0] - wanted[0], point[1] - wanted[1]) < Math.hypot(best[0] - wanted[0], best[1] - wanted[1])
        ? point
        : best,
    );
    const count = await page.locator("#plan .key").count();
    await page.mouse.dblclick(box.x + nearest[0], box.y + nearest[1]);
    await editor.settled();
    assert.equal(await page.locator("#plan .key").count(), count + 1);
  });
});

withReveal("a key is locked a frame later by the arrow, held, eased; the path is closed and shaped", async (editor) => {
  await afterwards(editor, async (page) => {
    await pick(page, key(page, 2));
    await page.locator("#later").click();
    await page.keyboard.press("]");
    await pick(page, key(page, 1));
    await page.locator("#key-ease").check();
  });
  assert.match(editor.read(), /frame = \d+/);
  assert.match(editor.read(), /ease = true/);
  await afterwards(editor, async (page) => {
    await page.locator("#key-ease").uncheck();
    await editor.settled();
    await page.locator("#spline").selectOption("tcb");
    await pick(page, key(page, 2));
    await page.locator("#key-tension").fill("0.5");
    await page.locator("#key-bias").fill("-0.25");
  });
  assert.match(editor.read(), /spline = "tcb"/);
  assert.match(editor.read(), /tension = 0\.5/);
  await editor.picture("shaped");
});

withReveal("Shift or Ctrl with a click adds to what is selected", async (editor, page) => {
  const chosen = async (what) => {
    await editor.settled(); // the page draws what is selected in its next frame
    return page.locator(`${what}.selected`).count();
  };
  await pick(page, key(page, 1));
  await key(page, 3).click({ modifiers: ["Shift"] });
  assert.equal(await chosen("#plan .key"), 2);
  await key(page, 1).click({ modifiers: ["ControlOrMeta"] });
  assert.equal(await chosen("#plan .key"), 1);
  await pick(page, value(page, 3));
  await value(page, 5).click({ modifiers: ["Shift"] });
  await value(page, 6).click({ modifiers: ["ControlOrMeta"] });
  assert.equal(await chosen("#speed .value"), 3);
  await page.locator("table.keys tbody tr").nth(1).locator("input").first().click();
  await page
    .locator("table.keys tbody tr")
    .nth(2)
    .locator("input")
    .first()
    .click({ modifiers: ["Shift"] });
  assert.equal(await chosen("table.keys tr"), 2);
});

withReveal("what is inserted is raised alone, and Escape takes back what is typed", async (editor) => {
  await afterwards(editor, async (page) => {
    await pick(page, value(page, 4));
    await page.keyboard.press("i");
    await editor.settled();
    await page.keyboard.press("ArrowUp");
  });
  assert.match(editor.read(), /speed {3}= \[0, 0, 3, 4, 9, 11, 12, 8, 5, 0, 0\]/);
  const field = editor.page.locator("table.keys tbody tr").nth(1).locator("input").first();
  await field.fill("999");
  await field.press("Escape");
  assert.equal(await field.inputValue(), "420");
  await editor.page.locator("#frames").fill("7");
  await editor.page.locator("#frames").press("Escape");
  assert.equal(await editor.page.locator("#frames").inputValue(), "192");
});

withStoryboard("a key with a frame is copied to a free one", async (editor) => {
  await afterwards(editor, async (page) => {
    await pick(page, key(page, 1));
    await page.locator("#copy-key").click();
  });
  assert.match(editor.read(), /frame = 72/);
  await afterwards(editor, async (page) => {
    await pick(page, key(page, 6));
    await page.locator("#copy-key").click();
  });
  assert.match(editor.read(), /frame = 252/);
});

testWith("reveal.toml", "camera_rig.toml", {
  text: readFileSync(example("reveal.toml"), "utf8").replace(
    "{ at = [ 860.0, -30.0,   4.0] }",
    "{ at = [ 860.0, -30.0,   4.0], frame = 90, hold = 20 }",
  ),
})("a held key is moved one frame from where its hold begins", async (editor) => {
  const frame = editor.page.locator("table.keys tbody tr").nth(2).locator("input").last();
  assert.equal(await frame.inputValue(), "90");
  await afterwards(editor, async (page) => {
    await pick(page, key(page, 2));
    await frame.fill("");
    await frame.press("Enter");
    await editor.settled();
    const met = Number(await frame.getAttribute("placeholder"));
    // It rests from there on: at the end of the hold it would not.
    const rests = await page.evaluate((first) => {
      const { table, stride } = window.inbetween.store.solution.tracks[0];
      return [Math.ceil(first), Math.floor(first) + 19].map((frame) => table[frame * stride + 4]);
    }, met);
    for (const slide of rests) assert.ok(Math.abs(slide - 860) < 1e-6, `at ${slide}`);
    await page.locator("#earlier").click();
    await editor.settled();
    assert.equal(Number(await frame.inputValue()), Math.round(met) - 1);
  });
});

/** From a key to where the path passes it, in pixels. */
const missOf = (page, k) =>
  page
    .locator("#plan .key .miss")
    .nth(k)
    .evaluate((line) => Math.hypot(Number(line.getAttribute("x2")), Number(line.getAttribute("y2"))));

withStoryboard("actions overlap at a key by the number that is typed, and the miss is drawn", async (editor) => {
  const before = await missOf(editor.page, 3);
  assert.ok(before > 1, "the path passes beside key 3");
  assert.equal(await missOf(editor.page, 0), 0, "the first key is met");
  await afterwards(editor, async (page) => {
    await pick(page, key(page, 3));
    assert.equal(await page.locator("#key-corner").getAttribute("placeholder"), "12");
    await enter(page, "#key-corner", "30");
  });
  assert.match(editor.read(), /frame = 168, overlap = 30 }/);
  assert.ok((await missOf(editor.page, 3)) > 1.5 * before);
  await editor.picture("overlap");
  await afterwards(editor, async (page) => {
    await enter(page, "#key-corner", "");
  });
  assert.doesNotMatch(editor.read(), /overlap = 30/);
  assert.ok(Math.abs((await missOf(editor.page, 3)) - before) < 0.2);
});

testWith("reveal.toml", "camera_rig.toml", {
  text: readFileSync(example("reveal.toml"), "utf8").replace('"smooth"', '"linear"'),
})("a corner of a straight path is rounded by the distance that is typed", async (editor) => {
  assert.equal(await missOf(editor.page, 2), 0);
  await afterwards(editor, async (page) => {
    await pick(page, key(page, 2));
    await enter(page, "#key-corner", "25");
    await pick(page, key(page, 3));
    await page.locator("#key-ease").check();
  });
  assert.match(editor.read(), /round = 25 }/);
  assert.ok((await missOf(editor.page, 2)) > 1);
  await editor.picture("round");
  // What is inserted on the path of a track with more segments than keys is between its keys.
  await afterwards(editor, async (page) => {
    await pick(page, key(page, 3));
    await page.locator("#insert-key").click();
  });
  await afterwards(editor, async (page) => page.locator("#spline").selectOption("smooth"));
  assert.doesNotMatch(editor.read(), /round/);
});

withFish("a fin is seen as a row of axes, and a curve of it is drawn by hand", async (editor) => {
  await editor.page.waitForSelector("#row:not([hidden]) canvas");
  await editor.picture("row");
  assert.equal(await editor.page.locator("#saved").textContent(), "saved", "nothing has been edited");
  const first = await editor.shown();
  await editor.page.keyboard.press("d");
  const row = await editor.page.locator("#row svg").boundingBox();
  const [x, y] = [row.x + row.width / 2, row.y + row.height * 0.93]; // in the row of the last ray
  await editor.page.mouse.move(x, y);
  await editor.page.mouse.down();
  for (let i = 1; i <= 40; ++i) await editor.page.mouse.move(x, y - 30 * Math.sin((i / 40) * 2 * Math.PI) - (i % 2));
  await editor.page.mouse.up();
  await written(() => /ray_8 = \[\{ frame = 0, at = 0 }, /.test(editor.read()));
  // The program works the others out, and what it plans is what the page shows.
  await until(editor.page, (before) => document.querySelector("#verdict").dataset.hash !== before, first);
  await written(async () => (await editor.shown()) === editor.planned());
  assert.match(editor.read(), /frame = 96, at = 0 }\] }/, "the last key is met");
  await editor.picture("row_drawn");
  await editor.page.keyboard.press("Control+z");
  await written(async () => (await editor.shown()) === first);
});

withReveal("a press, a choice and a word being typed outlast pictures within them", async (editor, page) => {
  await pick(page, key(page, 2));
  await page.evaluate(() => {
    // a picture at every chance
    window.pictures = 0;
    window.inbetween.store.onChange(() => ++window.pictures);
    const again = () => {
      window.inbetween.store.select({});
      requestAnimationFrame(again);
    };
    again();
  });
  const pictures = async () => {
    const drawn = await page.evaluate(() => window.pictures);
    await until(page, (least) => window.pictures > least + 2, drawn);
  };
  for (const box of ["#key-ease", "#closed"]) {
    await page.mouse.move(...(await centre(page.locator(box))));
    await page.mouse.down();
    await pictures();
    await page.mouse.up();
    assert.ok(await page.locator(box).isChecked(), `${box} is pressed`);
    await page.locator(box).uncheck();
  }
  await page.locator("#key-hold").click();
  for (const digit of ["1", "2"]) {
    await page.keyboard.press(digit);
    await pictures();
  }
  await page.keyboard.press("Enter");
  await until(page, () => window.inbetween.store.move.tracks[0].keys[2].hold === 12);
  await page.locator("#spline").focus();
  await page.keyboard.press("ArrowDown");
  await pictures();
  await page.keyboard.press("ArrowDown");
  await until(page, () => window.inbetween.store.move.tracks[0].spline === "tcb");
  // A press on a slider that changes nothing opens no step of undo that would swallow the next one.
  await page.locator("#key-tension").click();
  await pictures();
  assert.equal(await page.evaluate(() => window.inbetween.store.isDragging), false);
});

/** A stroke of the pointer through the path view, eased along an arch, in so many steps. */
async function stroke(page, to, steps = 40) {
  const box = await page.locator("#plan svg").boundingBox();
  for (let i = 0; i <= steps; ++i) {
    const share = (i / steps) ** 2 * (3 - (2 * i) / steps);
    await to(i, [
      box.x + box.width * (0.15 + 0.7 * share),
      box.y + box.height * (0.8 - 0.6 * Math.sin(Math.PI * share * 0.6)),
    ]);
    await page.evaluate(() => new Promise((done) => requestAnimationFrame(done)));
  }
}

withReveal("a motion is drawn by hand, becomes keys and a curve, and is taken back in one step", async (editor) => {
  const text = editor.read();
  await afterwards(editor, async (page) => {
    const first = await editor.shown();
    await page.locator("#tab-space").click();
    await page.waitForSelector("#space canvas");
    await page.keyboard.press("d"); // which brings the plan back
    await page.locator("#tolerance").fill("3");
    await stroke(page, async (i, [x, y]) => {
      await page.mouse.move(x, y);
      if (i === 0) await page.mouse.down();
    });
    assert.notEqual(await page.locator("#plan .trace").getAttribute("points"), null);
    await editor.picture("drawing");
    await page.mouse.up();
    await until(page, () => document.getElementById("said").textContent.startsWith("Drawn"));
    assert.match(await page.locator("#said").textContent(), /keys within \d\.\d of 3 px/);
    assert.notEqual(await editor.shown(), first);
    assert.equal(await page.locator("#draw").getAttribute("aria-pressed"), "false");
    const move = await page.evaluate(() => window.inbetween.store.move);
    assert.ok(move.tracks[0].keys.length >= 2 && move.tracks[0].keys.length < 12, `${move.tracks[0].keys.length} keys`);
    assert.equal(await page.evaluate(() => document.querySelectorAll("#plan .key").length), move.tracks[0].keys.length);
    await page.locator("body").click({ position: { x: 3, y: 3 } });
    await page.keyboard.press("Control+z");
    assert.equal(await editor.shown(), first, "undone in one step");
    await page.keyboard.press("Control+Shift+z");
  });
  assert.notEqual(editor.read(), text);
  await editor.picture("drawn");
});

withReveal("limits that are exceeded are red, and fit and fewest frames cure them", async (editor) => {
  await afterwards(editor, async (page) => {
    await enter(page, "#frames", "110");
    await editor.settled();
    assert.match(await page.locator("#verdict").textContent(), /✗ .*allowed/);
    assert.match(
      await page.locator("#speed .over-text").textContent(),
      /(slide|pan|tilt): (velocity|acceleration|jerk) .* % too high/,
    );
    assert.notEqual(await page.locator("#speed .over").getAttribute("d"), "");
    await editor.picture("limits_exceeded");
    await page.locator("#fewest").click();
    await until(page, () => Number(document.getElementById("frames").value) > 110);
    await editor.settled();
    assert.match(await page.locator("#verdict").textContent(), /✓/);
    const fewest = Number(await page.locator("#frames").inputValue());
    await enter(page, "#frames", String(fewest - 8));
    await editor.settled();
    assert.match(await page.locator("#verdict").textContent(), /✗/);
    await page.locator("#fit").click();
    await until(page, () => document.getElementById("verdict").textContent.includes("✓"));
    await editor.picture("fitted");
  });
});

/** Whether two boxes have a pixel in common. */
const meet = (a, b) => a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;

for (const [width, height] of [
  [1600, 900],
  [1280, 720],
  [390, 844],
]) {
  const inViewport = testWith("reveal.toml", "camera_rig.toml", { viewport: { width, height } });
  inViewport(`at ${width} pixels nothing lies over another, and every button can be reached`, async (editor, page) => {
    await enter(page, "#frames", "4");
    await page.keyboard.press("Control+s");
    await editor.saved();
    const box = (selector) => page.locator(selector).boundingBox();
    const said = await box("#said");
    assert.ok(said.y + said.height <= height && said.height > 20);
    assert.ok(!meet(said, await box("main")), "a line of its own");
    const words = page.locator("#speed .over-text");
    assert.match(await words.textContent(), /slide: velocity is 42 times what is allowed near frame 2/);
    assert.ok(!meet(await words.boundingBox(), await box("#speed .plot")), "beside the curve");
    for (const part of ["path", "side", "speed", "time", "preview"]) {
      const around = await box(`#${part}`);
      for (const control of await page.locator(`#${part} :is(button, select, input):visible`).all()) {
        const { x, width: wide } = await control.boundingBox();
        assert.ok(
          x >= around.x && x + wide <= around.x + around.width,
          `${part}: ${await control.getAttribute("aria-label")}`,
        );
      }
    }
    assert.ok((await box("#plan")).width > 250, "there is room for the path");
    await editor.picture(`at_${width}`);
  });
}

withReveal("new limits of the rig are seen, and a file that is no rig is said", async (editor) => {
  const { page, folder } = editor;
  const rig = join(folder, "camera_rig.toml");
  const first = readFileSync(rig, "utf8");
  await pick(page, value(page, 4));
  await page.keyboard.press("ArrowUp");
  await editor.saved();
  const verdict = () => page.locator("#verdict").textContent();
  assert.match(await verdict(), /within the limits/);
  writeFileSync(rig, first.replace("max_velocity = 500.0", "max_velocity = 50.0"));
  await until(page, () => document.getElementById("verdict").textContent.includes("50 is allowed"));
  await editor.picture("new_limits");
  assert.equal(await page.locator("#saved").textContent(), "saved", "nothing of the move has changed");
  await page.keyboard.press("Control+z");
  await editor.settled();
  assert.match(await verdict(), /50 is allowed/, "every step of undo has them");
  writeFileSync(rig, "[[axis]]\n");
  await page.waitForSelector("#notice-rig");
  assert.match(await page.locator("#notice-rig").textContent(), /camera_rig\.toml:1.*The limits are those of before/);
  assert.match(await verdict(), /50 is allowed/);
  writeFileSync(rig, first);
  await until(
    page,
    () =>
      !document.getElementById("notice-rig") &&
      document.getElementById("verdict").textContent.includes("within the limits"),
  );
  await page.locator("#notice-rig").waitFor({ state: "detached" });
});

test("the browser is led to the move without its key on a command line", async () => {
  const desktop = mkdtempSync(join(tmpdir(), "inbetween-desktop-"));
  const told = join(desktop, "told");
  writeFileSync(join(desktop, "xdg-open"), `#!/bin/sh\nprintf '%s\\n' "$*" >"${told}"\n`, { mode: 0o755 });
  const editor = await edit("reveal.toml", "camera_rig.toml", {
    browser: { PATH: `${desktop}:${process.env.PATH}`, DISPLAY: ":9" },
  });
  await written(() => existsSync(told) && readFileSync(told, "utf8").endsWith("\n"));
  const opened = readFileSync(told, "utf8").trim();
  const key = editor.address.split("#")[1];
  assert.ok(!opened.includes(key), opened);
  assert.equal(statSync(opened).mode & 0o777, 0o600);
  assert.equal(statSync(dirname(opened)).mode & 0o777, 0o700);
  const page = await editor.context.newPage();
  await page.goto(`file://${opened}`);
  await page.waitForSelector("#frames");
  assert.equal(await editor.shown(), await shown(page));
  assert.deepEqual(editor.complaints, []);
  await editor.end();
  assert.ok(!existsSync(opened), "it goes with the program");
  rmSync(desktop, { recursive: true });
});

withReveal("the preview plays in true time, backward, in a loop, by steps, and is scrubbed", async (editor, page) => {
  const frame = () => page.evaluate(() => window.inbetween.store.frame);
  // The frames that are shown and when, by the clock of the pictures: a slow machine shows few, and not at another speed.
  await page.evaluate(() => {
    window.shown = [];
    const { store } = window.inbetween;
    store.onFrame(() => window.shown.push([document.timeline.currentTime, store.frame]));
  });
  await page.locator("#play").click();
  await until(page, () => window.shown.length > 1 && window.shown.at(-1)[1] > window.shown[0][1] + 24);
  const seen = await page.evaluate(() => window.shown);
  const rate = ((seen.at(-1)[1] - seen[0][1]) * 1000) / (seen.at(-1)[0] - seen[0][0]);
  assert.ok(rate > 23 && rate < 25, `${rate} frames a second, and 24 are asked for`);
  await page.locator("#play").click();
  await page.locator("#to-end").click();
  assert.equal(await frame(), 192);
  await page.locator("#reverse").click();
  await until(page, () => window.inbetween.store.frame < 190);
  await page.locator("#reverse").click();
  await page.locator("#to-start").click();
  await page.locator("#step").click();
  await page.keyboard.press(".");
  await page.keyboard.press(",");
  assert.equal(await frame(), 1);
  assert.equal(await page.locator(".counter").textContent(), "1 / 192");
  await page.locator("#scrub").fill("96");
  assert.equal(await frame(), 96);
  for (const mode of ["loop", "ping-pong"]) {
    await page.locator("#mode").selectOption(mode);
    await page.evaluate(() => window.inbetween.store.setFrame(190));
    await page.locator("#play").click();
    await until(page, () => window.inbetween.store.frame < 189);
    const playing = await page.locator('[aria-pressed="true"]').getAttribute("id");
    assert.equal(playing, mode === "loop" ? "play" : "reverse");
    await page.locator(`#${playing}`).click();
  }
  await page.locator("#time svg").click();
  assert.ok((await frame()) > 10 && (await frame()) < 182);
});

withReveal("elevation, space and the axes over time", async (editor, page) => {
  await page.locator("#tab-elevation").click();
  await editor.picture("elevation");
  await page.locator("#tab-axes").click();
  await page.locator("#tab-space").click();
  await page.waitForSelector("#space canvas");
  await page.evaluate(() => window.inbetween.store.setFrame(90));
  await editor.settled();
  await editor.picture("space_and_axes");
  assert.equal(await page.locator("#side .graph").count(), 9);
});

const withMotor = (most) =>
  readFileSync(example("camera_rig.toml"), "utf8").replace(
    "max_jerk = 8000.0",
    `max_jerk = 8000.0\ncalibration = { unit = "deg", marks = [[0, 0], [600, 200], [1200, 500], [1800, 700]], max_velocity = ${most}, max_acceleration = 2000, max_jerk = 20000 }`,
  );
for (const [most, verdict] of [
  [300, /within the limits/],
  [100, /✗ the motor of slide: velocity/],
]) {
  const behindMotor = testWith("reveal.toml", "camera_rig.toml", { rigText: withMotor(most) });
  behindMotor(`with a motor of ${most} deg/s the page says to the last bit what check says`, async (editor, page) => {
    const { peaks, ...certificate } = await page.evaluate(() => window.inbetween.store.solution.certificate);
    const program = editor.check();
    assert.equal(program.motors.length, 1);
    for (const [d, moved] of [...program.axes, ...program.motors].entries()) {
      for (const quantity of ["velocity", "acceleration", "jerk"])
        assert.equal(peaks[d][quantity].value, moved[quantity].peak, `${moved.name ?? "motor"}: ${quantity}`);
    }
    assert.equal(certificate.highestRate, program.highest_rate);
    assert.equal(certificate.longestStop, program.stop.longest_s);
    assert.equal(certificate.fits, program.fits);
    assert.match(await editor.page.locator("#verdict").textContent(), verdict);
    await editor.picture(`motor-${most}`);
  });
}

withCrane("a rig with joints is shown as it stands, its tip where the command line has it", async (editor, page) => {
  await page.locator("#tab-space").click();
  await page.waitForSelector("#space canvas");
  assert.equal(await page.locator("#space").getAttribute("data-shows"), "rig");
  await page.evaluate(() => window.inbetween.store.setFrame(100));
  await editor.settled();
  await editor.picture("rig");
  const tip = editor.plan().tips[0];
  for (const frame of [0, 100, 191]) {
    const place = await page.evaluate((at) => {
      const { move, solver } = window.inbetween.store;
      const places = solver.places(move.rig, move.axes.length, at, 0, 1);
      return Array.from(places.slice(3 * move.rig.tip, 3 * move.rig.tip + 3));
    }, frame);
    for (const [axis, name] of ["x", "y", "z"].entries())
      assert.ok(Math.abs(place[axis] - tip.position[frame][axis]) < 1e-9, `${name} at frame ${frame}`);
  }
});

withReveal("an outside change is offered, and both versions are kept", async (editor, page) => {
  await page.locator("#autosave").uncheck();
  await pick(page, value(page, 4));
  await page.keyboard.press("ArrowUp");
  const outside = `# from elsewhere\n${editor.read()}`;
  writeFileSync(editor.path, outside);
  await page.keyboard.press("Control+s");
  await page.waitForSelector("dialog[open]");
  assert.equal(editor.read(), outside, "nothing is written over it");
  await editor.picture("outside_change");
  await page.locator("#save-mine").click();
  await editor.saved();
  assert.ok(existsSync(join(editor.folder, "reveal.outside-1.toml")));
  assert.doesNotMatch(editor.read(), /from elsewhere/);

  await pick(page, value(page, 5));
  await page.keyboard.press("ArrowUp");
  writeFileSync(editor.path, outside); // last: the page looks every two seconds, and its question would be in the way
  await page.waitForSelector("dialog[open]");
  await page.locator("#load-theirs").click();
  await editor.saved();
  assert.equal(editor.read(), outside);
  assert.ok(existsSync(join(editor.folder, "reveal.mine-1.toml")));
  assert.equal(await editor.shown(), editor.planned());
});

withReveal("a change is saved by itself, and undo reaches back over it", async (editor, page) => {
  const text = editor.read();
  await pick(page, value(page, 4));
  await page.keyboard.press("ArrowUp");
  // What a slow machine shows in between is not waited for: the file tells.
  await until(page, () => window.inbetween.store.canUndo);
  await written(() => editor.read() !== text);
  await page.keyboard.press("Control+z");
  await written(() => editor.read() === text); // to the last byte
});

for (const [move, rig] of [
  ["nod.toml", "puppet_head.toml"],
  ["turntable.toml", "turntable_rig.toml"],
  ["track_and_focus.toml", null],
  ["jaw.toml", null],
  ["crane/over_the_table.toml", "crane/rig.toml"],
  ["marionette/walk.toml", "marionette/rig.toml"],
  ["brow/raise.toml", "brow/rig.toml"],
  ["storyboard.toml", "camera_rig.toml"],
  ["look_around.toml", null],
]) {
  testWith(move, rig)(`${move} opens with the hash of the command line`, async (editor) => {
    assert.equal(await editor.shown(), editor.planned());
  });
}

testWith("look_around.toml", "puppet_head.toml")(
  "the rows of a table are shown as the command line plans them, and what cannot be edited says why",
  async (editor, page) => {
    assert.equal(await editor.shown(), editor.planned());
    const { highest_rate } = editor.check();
    const verdict = await page.locator("#verdict").textContent();
    assert.match(verdict, new RegExp(`within the limits, up to ${(100 * highest_rate).toFixed(0)} %`));
    assert.match(await page.locator("#speed .hint").textContent(), /rows of look_around.csv are played as they are/);
    assert.ok(await page.locator("#spline").isDisabled());
    assert.ok(await page.locator("#closed").isDisabled());
    const says = (words) => until(page, (w) => document.getElementById("said").textContent.includes(w), words);
    await page.locator("#insert-key").click();
    await says("row by row; edit that file");
    await enter(page, "#frames", "80");
    await says("are on frames 0 to 96");
    await page.locator("#fit").click();
    await says("Nothing is changed");
    assert.equal(await page.locator("#frames").inputValue(), "96");
    assert.ok(!(await page.evaluate(() => window.inbetween.store.canUndo)), "none of it is a step of undo");
    await editor.picture("table");
    // The other track of the move is edited as ever, and the rate holds for both.
    await enter(page, "#fps", "60");
    await editor.saved();
    assert.equal(await editor.shown(), editor.planned());
    assert.equal(await page.locator("#verdict").getAttribute("class"), editor.check().fits ? "good" : "bad");
  },
);

test("without the program a move and a rig are dropped, edited and downloaded", async () => {
  const { page, end } = await alone();
  const drop = (...files) =>
    page.evaluate(
      (dropped) => {
        const dataTransfer = new DataTransfer();
        for (const { name, text } of dropped) dataTransfer.items.add(new File([text], name));
        document.dispatchEvent(new DragEvent("drop", { dataTransfer, cancelable: true }));
      },
      files.map((file) => ({ name: basename(file), text: readFileSync(file, "utf8") })),
    );
  await page.waitForSelector("#files");
  await drop(example("crane/rig.toml"));
  await until(page, () => document.querySelector("[role=alert]").textContent.includes("drop the move as well"));
  await drop(example("crane/round_the_puppet.toml"));
  await until(page, () =>
    document.querySelector("[role=alert]").textContent.includes("open the file with inbetween edit"),
  );
  await drop(example("reveal.toml"), example("camera_rig.toml"));
  await page.waitForSelector("#frames");
  assert.equal(await shown(page), hashes(example("reveal.toml"), example("camera_rig.toml")));
  assert.match(await page.locator("#verdict").textContent(), /within the limits/);
  for (const id of ["fit", "fewest", "draw"]) {
    assert.ok(await page.locator(`#${id}`).isDisabled());
    assert.match(await page.locator(`#${id}`).getAttribute("title"), /needs the program/);
  }
  await pick(page, value(page, 4));
  await page.keyboard.press("ArrowDown");
  await pick(page, key(page, 2));
  await page.keyboard.press("]");
  // A move that is dropped again would take the edits away; a rig that is dropped again is for what is edited.
  const edited = await shown(page);
  await drop(example("reveal.toml"));
  await until(page, () => document.querySelector("#said").textContent.includes("would be lost"));
  assert.equal(await shown(page), edited);
  await drop(example("camera_rig.toml"));
  await until(page, (before) => document.querySelector("#verdict").dataset.hash === before, edited);
  await pick(page, key(page, 2));
  await page.keyboard.press("]"); // once, though the page has been begun anew
  await page.keyboard.press("[");
  assert.equal(await shown(page), edited);
  const [taken] = await Promise.all([page.waitForEvent("download"), page.keyboard.press("Control+s")]);
  const folder = mkdtempSync(join(tmpdir(), "inbetween-alone-"));
  const path = join(folder, taken.suggestedFilename());
  await taken.saveAs(path);
  assert.equal(hashes(path, example("camera_rig.toml")), await shown(page));
  assert.notEqual(await shown(page), hashes(example("reveal.toml"), example("camera_rig.toml")));
  await page.screenshot({ path: join(pictures, "alone.png") });
  rmSync(folder, { recursive: true });
  await end();
});

withReveal("a thousand silent connections keep nobody out, and are left", async (editor) => {
  const port = Number(new URL(editor.address).port);
  const silent = Array.from({ length: 1000 }, (_, i) => {
    const socket = connect(port, "127.0.0.1");
    const closed = new Promise((done) => socket.on("close", done));
    socket.on("error", () => {});
    if (i % 2) socket.write("POST /api/save HTTP/1.1\r\nHost: ");
    return { socket, closed };
  });
  await Promise.all(
    silent.slice(0, 900).map(({ socket }) => new Promise((done) => socket.on("connect", done).on("error", done))),
  );
  const text = editor.read();
  const { page } = editor;
  assert.equal(
    await page.evaluate(() =>
      fetch("/api/move", { headers: { "X-Inbetween-Token": sessionStorage.getItem("inbetween-token") } }).then(
        (answer) => answer.status,
      ),
    ),
    200,
  );
  await silent[0].closed;
  for (const { socket } of silent) socket.destroy();
  assert.equal(editor.read(), text);
});

onTablet("by touch on a tablet", async (editor) => {
  await editor.page.touchscreen.tap(...(await centre(value(editor.page, 4))));
  await editor.settled();
  assert.equal(await editor.page.locator("#speed .value.selected").count(), 1);
  await editor.picture("tablet");
  const cdp = await editor.page.context().newCDPSession(editor.page);
  const touch = (type, points) => cdp.send("Input.dispatchTouchEvent", { type, touchPoints: points });
  await editor.page.touchscreen.tap(...(await centre(editor.page.locator("#draw"))));
  await stroke(editor.page, (i, [x, y]) => touch(i === 0 ? "touchStart" : "touchMove", [{ x, y }]));
  await touch("touchEnd", []);
  await until(editor.page, () => document.getElementById("said").textContent.startsWith("Drawn"));
});

withReveal("who has never seen it slows down the middle and saves, by what the page says", async (editor, page) => {
  const middle = () => editor.plan().tracks[0].table[96].speed;
  const before = middle();
  assert.match(await page.locator("#speed").innerText(), /Speed curve[^]*drag a square up for faster, down for slower/);
  const squares = await page.locator("#speed .value .knob").all();
  const places = await Promise.all(squares.map(centre));
  const nearest = places.reduce((best, [x], i) => (Math.abs(x - 640) < Math.abs(places[best][0] - 640) ? i : best), 0);
  await drag(page, squares[nearest], 0, 60);
  await page.getByText("Save", { exact: true }).click();
  await editor.saved();
  assert.ok(middle() < 0.9 * before, `${middle()} after ${before}`);
});

withReveal("in high contrast and in the colours of the system every area is drawn in them", async (editor, page) => {
  const cdp = await page.context().newCDPSession(page);
  await editor.settled(); // #frames is there before the views are drawn for the first time
  const first = await page
    .locator("#plan canvas")
    .first()
    .evaluate((canvas) => canvas.toDataURL());
  for (const [name, value] of [
    ["prefers-contrast", "more"],
    ["forced-colors", "active"],
  ]) {
    await cdp.send("Emulation.setEmulatedMedia", { features: [{ name, value }] });
    await until(page, (old) => document.querySelector("#plan canvas").toDataURL() !== old, first);
    await editor.picture(name);
    await cdp.send("Emulation.setEmulatedMedia", { features: [] });
    await until(page, (old) => document.querySelector("#plan canvas").toDataURL() === old, first);
  }
});

withHundredKeys("dragging a control value of a hundred keys keeps up with the screen", async (editor, page) => {
  await editor.picture("hundred_keys");
  const [x, y] = await centre(value(page, 20));
  await page.mouse.move(x, y);
  await page.mouse.down();
  await editor.settled();
  // From the moment when the page gets the event to the first task after the frame that shows what it does: solving,
  // drawing, layout, paint and the hand-over to the compositor. The stamp of an event is older: the browser keeps it for
  // the next frame, which takes up to 16.7 ms.
  await page.evaluate(() => {
    window.took = { page: [], stamp: [], solve: [], made: 0 };
    const channel = new MessageChannel();
    let arrived = 0;
    let stamp = 0;
    channel.port1.onmessage = () => {
      const now = performance.now();
      window.took.page.push(now - arrived);
      window.took.stamp.push(now - stamp);
      window.took.solve.push(window.inbetween.store.solveMs);
    };
    document.addEventListener(
      "pointermove",
      (event) => {
        arrived = performance.now();
        stamp = event.timeStamp;
        requestAnimationFrame(() => channel.port2.postMessage(0));
      },
      true,
    );
    new MutationObserver((changes) => {
      for (const { addedNodes } of changes)
        for (const node of addedNodes) window.took.made += Number(node.nodeType === Node.ELEMENT_NODE);
    }).observe(document.body, { subtree: true, childList: true });
  });
  for (let i = 0; i < 80; ++i) {
    await page.mouse.move(x, y - 30 * Math.sin(i / 6));
    await page.evaluate(() => new Promise((done) => requestAnimationFrame(done)));
  }
  const took = await page.evaluate(() => window.took);
  await page.mouse.up();
  const at = (times) =>
    [0.5, 0.95]
      .map(
        (share, i) =>
          `${["p50", "p95"][i]} ${times.sort((a, b) => a - b)[Math.floor(share * (times.length - 1))].toFixed(1)} ms`,
      )
      .join(", ");
  console.log(
    `# pointer to picture, from its arrival in the page: ${at(took.page)}; from its stamp: ${at(took.stamp)}; of it solving: ${at(took.solve)}`,
  );
  assert.ok(took.page.length > 50);
  assert.equal(took.made, 0, "a drag makes no elements");
});
