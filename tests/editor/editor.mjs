// The editor as a person has it: the program, a browser, a move of its own in a folder of its own.
import { spawn, execFileSync, spawnSync } from "node:child_process";
import { cpSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";

const root = new URL("../..", import.meta.url).pathname;
const require = createRequire(join(root, "editor/page/package.json"));
const { chromium } = require("playwright-core");

export const program = process.env.INBETWEEN ?? join(root, "build/release/inbetween");
export const pictures = process.env.INBETWEEN_PICTURES ?? join(root, "build/release/tests/editor/pictures");
mkdirSync(pictures, { recursive: true });

let browser = null;
const programs = new Set(); // that run: one whose test has failed would keep the tests from ending
export async function startBrowser() {
  // A container's root has no sandbox to give.
  const args = process.getuid() === 0 ? ["--no-sandbox"] : [];
  browser = await chromium.launch({
    executablePath: "/usr/bin/chromium-headless-shell",
    args: [...args, "--use-gl=swiftshader", "--enable-unsafe-swiftshader"],
  });
}
export async function stopBrowser() {
  await browser.close();
  for (const running of programs) running.kill("SIGTERM");
}

/** Waits until `is` gives true, or a promise of it. */
export async function eventually(is, never) {
  for (let tries = 0; tries < 1500; ++tries) {
    if (await is()) return;
    await new Promise((done) => setTimeout(done, 20));
  }
  throw new Error(`never: ${never}`);
}
/** Waits until `ask` is true in the page. (Playwright's own waitForFunction evaluates text, which the page's policy
 * forbids, and that policy is part of what is tested.) */
export const until = (page, ask, argument) => eventually(() => page.evaluate(ask, argument), ask);
/** Waits until the file is as it shall be. */
export const written = (is) => eventually(is, "the file is written so");

/** Waits until what was done is in the picture: the page solves and draws before the next one, and not at once. */
export const settled = (page) =>
  page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
/** Hashes of the tables that the page shows. */
export async function shown(page) {
  await settled(page);
  return page.locator("#verdict").getAttribute("data-hash");
}

export const centre = async (locator) => {
  await settled(locator.page());
  const box = await locator.boundingBox();
  return [box.x + box.width / 2, box.y + box.height / 2];
};
/** Clicks once the picture stands still: what was done before may still move it, and a person waits to see it. */
export async function pick(page, locator) {
  await settled(page);
  await locator.click();
}
export const key = (page, k) => page.locator("#plan .key .knob").nth(k);
export const value = (page, i) => page.locator("#speed .value .knob").nth(i);

/** Starts `inbetween edit` on a copy of the examples, with `text` in place of the move if it is given, and
 * `rigText` in place of the rig. With `browser` it opens one, in that environment. */
export async function edit(
  move,
  rig,
  { text, rigText, viewport = { width: 1280, height: 720 }, touch = false, browser: desktop } = {},
) {
  const folder = mkdtempSync(join(tmpdir(), "inbetween-editor-"));
  cpSync(join(root, "examples"), folder, { recursive: true });
  const path = join(folder, move);
  if (text !== undefined) writeFileSync(path, text);
  if (rigText !== undefined) writeFileSync(join(folder, rig), rigText);
  const words = ["edit", path, ...(desktop ? [] : ["--no-browser"]), ...(rig ? ["--rig", join(folder, rig)] : [])];
  let running = null;
  let said = "";
  const launch = () =>
    new Promise((resolve, reject) => {
      running = spawn(program, words, {
        stdio: ["ignore", "pipe", "pipe"],
        env: { ...process.env, ...desktop, XDG_STATE_HOME: join(folder, "state") },
      });
      const launched = running;
      programs.add(launched);
      said = "";
      launched.stdout.on("data", (bytes) => {
        said += bytes;
        const found = /http:\/\/\S+/.exec(said);
        if (found) resolve(found[0]);
      });
      launched.stderr.on("data", (bytes) => (said += bytes));
      launched.on("exit", () => {
        programs.delete(launched);
        reject(new Error(said));
      });
    });
  const stop = async (signal) => {
    if (running.exitCode !== null || running.signalCode !== null) return;
    const ended = new Promise((done) => running.on("exit", done));
    running.kill(signal);
    await ended;
  };
  const address = await launch();
  const context = await browser.newContext({ viewport, hasTouch: touch });
  const page = await context.newPage();
  const complaints = [];
  page.on("pageerror", (error) => complaints.push(String(error)));
  page.on("console", (message) => {
    if (message.type() === "error" && !/409|422|ERR_CONNECTION/.test(message.text())) complaints.push(message.text());
  });
  await page.goto(address);
  await page.waitForSelector("#frames");
  // A path of cubics takes more than the megabyte that node allows a program to say.
  const plan = () =>
    JSON.parse(
      execFileSync(program, ["plan", path, ...(rig ? ["--rig", join(folder, rig)] : []), "--json", "-"], {
        stdio: ["ignore", "pipe", "ignore"],
        maxBuffer: 64 * 1024 * 1024,
      }),
    );
  // Its exit status is 3 where the move does not fit.
  const check = () => JSON.parse(spawnSync(program, ["check", path, "--rig", join(folder, rig), "--json", "-"]).stdout);
  return {
    page,
    context,
    path,
    folder,
    address,
    complaints,
    launch,
    kill: () => stop("SIGKILL"),
    get pid() {
      return running.pid;
    },
    said: () => said,
    read: () => readFileSync(path, "utf8"),
    plan,
    check,
    shown: () => shown(page),
    planned: () =>
      plan()
        .tracks.map((track) => track.hash ?? track.provenance?.hash)
        .join(" "),
    settled: () => settled(page),
    // Its words alone are not enough: a page that is drawn late still shows those of before.
    saved: () =>
      until(page, () => !window.inbetween.store.isChanged && document.getElementById("saved").textContent === "saved"),
    picture: (name) => page.screenshot({ path: join(pictures, `${name}.png`) }),
    async end() {
      await context.close();
      await stop("SIGTERM");
      rmSync(folder, { recursive: true });
    },
  };
}

/** The page in one file, opened from its folder without a program behind it. */
export async function alone() {
  const file = process.env.INBETWEEN_ALONE ?? join(root, "build/release/editor/alone/inbetween.html");
  const context = await browser.newContext({ viewport: { width: 1280, height: 720 }, acceptDownloads: true });
  const page = await context.newPage();
  await page.goto(`file://${file}`);
  return { page, end: () => context.close() };
}
export const example = (name) => join(root, "examples", name);
export const hashes = (move, rig) =>
  JSON.parse(
    execFileSync(program, ["plan", move, "--rig", rig, "--json", "-"], { stdio: ["ignore", "pipe", "ignore"] }),
  )
    .tracks.map((track) => track.hash ?? track.provenance?.hash)
    .join(" ");

/** A move of a hundred keys on three axes, with a curve of forty control values. */
export function hundredKeys() {
  const keys = [];
  for (let k = 0; k < 100; ++k) {
    keys.push(
      `  { at = [${(60 + 15 * k).toFixed(1)}, ${(40 * Math.sin(k / 7)).toFixed(2)}, ${(20 * Math.cos(k / 5)).toFixed(2)}] },`,
    );
  }
  const speed = [0, 0, ...Array.from({ length: 36 }, (_, i) => 8 + (3 * Math.round(Math.sin(i) * 10)) / 10), 0, 0];
  return `name = "hundred keys"\nfps = 24\nframes = 960\n[[track]]\naxes = ["slide", "pan", "tilt"]\nkeys = [\n${keys.join("\n")}\n]\nspeed = [${speed.map((v) => Number(v.toFixed(2))).join(", ")}]\nweights = [1.0, 6.0, 6.0]\n`;
}
