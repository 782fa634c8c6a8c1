import "./style.css";
import { AxisGraphs, KeyTable } from "./side";
import { askForFiles } from "./alone";
import { Bar } from "./bar";
import { attributes, button, byId, html, notice, say } from "./dom";
import { Draft, type KeptHistory } from "./drafts";
import { copyKeys, insertOnPath, insertValue, removeKeys, removeValues, setValues, shiftKeys } from "./edits";
import { Hand } from "./hand";
import { importing } from "./import";
import { fixedSpeed } from "./move";
import { PlanView, planPanel } from "./plan_view";
import { Preview } from "./preview";
import { RowView, rowPanel, showRowTab } from "./row_view";
import { Server } from "./server";
import { Solver } from "./solver";
import { SpaceView } from "./space_view";
import { SpeedView } from "./speed_view";
import { Store } from "./store";
import { TimeBar } from "./time_bar";

/** Buttons of which one is chosen; the panels of the others are hidden. */
function tabs(
  label: string,
  panels: { name: string; id: string; panel: HTMLElement; show: () => void }[],
): HTMLElement {
  const row = html("div", { class: "tabs", role: "tablist", "aria-label": label });
  const buttons = panels.map(({ name, id, panel, show }) => {
    const one = html("button", { type: "button", role: "tab", id: `tab-${id}` }, name);
    one.addEventListener("click", () => {
      for (const [i, other] of panels.entries()) {
        const chosen = other.name === name;
        buttons[i].setAttribute("aria-selected", String(chosen));
        buttons[i].tabIndex = chosen ? 0 : -1;
        if (other.panel !== panel) other.panel.hidden = true;
      }
      panel.hidden = false;
      show();
    });
    one.addEventListener("keydown", (event) => {
      const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (by === undefined) return;
      const next = buttons[(buttons.indexOf(one) + by + buttons.length) % buttons.length];
      next.click();
      next.focus();
      event.stopPropagation();
    });
    return one;
  });
  row.append(...buttons);
  buttons[0].click();
  return row;
}

function pathSection(store: Store, hand: Hand): void {
  const place = byId("path");
  const plan = planPanel();
  const space = html("div", { id: "space", class: "fill" });
  const row = rowPanel();
  const views = html("div", { class: "fill views" }, plan, space, row);
  const view = (): PlanView => planView;
  const axisChoice = (name: string, id: string, first: number, choose: (axis: number) => void): HTMLSelectElement => {
    const select = html("select", { id, "aria-label": name });
    const fill = (): void => {
      const axes = store.move.tracks[store.selection.track].axes;
      if ([...select.options].map((option) => option.text).join() === axes.join()) return;
      select.replaceChildren(...axes.map((axis, a) => html("option", { value: a }, axis)));
      select.value = String(Math.min(first, axes.length - 1));
      choose(Number(select.value));
    };
    select.addEventListener("change", () => {
      choose(Number(select.value));
      view().draw();
    });
    store.onChange(fill);
    queueMicrotask(fill);
    return select;
  };
  const across = axisChoice("Axis across", "across", 0, (axis) => (view().horizontal = axis));
  const up = axisChoice("Axis up", "up", 1, (axis) => (view().vertical = axis));
  const head = html("div", { class: "head" });
  place.append(head, views);
  const planView = new PlanView(store, plan, hand);
  const spaceView = new SpaceView(store, space);
  const rowView = new RowView(store, row, hand);
  const switched = hand.onSwitch;
  hand.onSwitch = () => {
    switched();
    // A pointer draws in a plane, or in a row.
    const isRow = store.move.tracks[store.selection.track].network !== null;
    if (hand.isOn && (isRow ? row : plan).hidden) byId(isRow ? "tab-row" : "tab-plan").click();
  };
  const show = (axis: number) => () => {
    const axes = store.move.tracks[store.selection.track].axes.length;
    planView.vertical = Math.min(axis, axes - 1);
    up.value = String(planView.vertical);
    planView.draw();
  };
  head.append(
    tabs("View of the path", [
      { name: "Plan", id: "plan", panel: plan, show: show(1) },
      { name: "Elevation", id: "elevation", panel: plan, show: show(2) },
      {
        name: "3-D",
        id: "space",
        panel: space,
        show: () => void spaceView.show().catch((error) => say(String(error), true)),
      },
      { name: "Row", id: "row", panel: row, show: () => rowView.draw() },
    ]),
    html("span", { class: "spring" }),
    hand.tools,
    html("label", {}, "across ", across),
    html("label", {}, "up ", up),
  );
  byId("tab-row").hidden = true;
  store.onChange(() => showRowTab(store));
  queueMicrotask(() => showRowTab(store));
}

function sideSection(store: Store): void {
  const keys = new KeyTable(store);
  const graphs = new AxisGraphs(store);
  const head = html("div", { class: "head" });
  byId("side").append(head, keys.element, graphs.element);
  head.append(
    tabs("Keys and axes", [
      { name: "Keys", id: "keys", panel: keys.element, show: () => keys.draw() },
      { name: "Axes over time", id: "axes", panel: graphs.element, show: () => graphs.draw() },
    ]),
  );
}

function speedSection(store: Store): void {
  const place = html("div", { class: "fill" });
  const overText = html("span", { class: "over-text bad" });
  const hint = html("small", { class: "hint" });
  const tell = (): void => {
    const why = fixedSpeed(store.move.tracks[store.selection.track]);
    attributes(hint, { title: why ?? undefined });
    hint.textContent = why ?? "drag a square up for faster, down for slower";
  };
  store.onChange(tell);
  tell();
  const many = (by: number) => (): void => {
    const { track, values } = store.selection;
    if (values.size === 0) return say("Select control values first; drag a frame around them.");
    store.edit(setValues(store.move, track, (value, i) => (values.has(i) ? value + by : value)));
  };
  byId("speed").append(
    html(
      "div",
      { class: "head" },
      html("h2", {}, "Speed curve"),
      overText,
      hint,
      html("span", { class: "spring" }),
      button(
        "Insert",
        "Insert a control value behind the selected one (I; or double-click the curve)",
        () => {
          const { values } = store.selection;
          if (values.size === 0) return say("Select a control value first.");
          insertValue(store, Math.max(...values) + 1);
        },
        "insert-value",
      ),
      button("Delete", "Delete the selected control values (Delete)", () => removeValues(store), "delete-value"),
      button("Lower", "Lower the selected control values (Down)", many(-1), "lower"),
      button("Raise", "Raise the selected control values (Up)", many(1), "raise"),
    ),
    place,
  );
  new SpeedView(store, place, overText);
}

let listening: AbortController | null = null; // of the move that is shown
function shortcuts(store: Store, bar: Bar, preview: Preview, hand: Hand): void {
  listening?.abort();
  listening = new AbortController();
  document.addEventListener(
    "keydown",
    (event) => {
      const target = event.target as HTMLElement;
      const control = event.ctrlKey || event.metaKey;
      if (control && event.key.toLowerCase() === "z") {
        if (event.shiftKey) store.redo();
        else store.undo();
      } else if (control && event.key.toLowerCase() === "y") {
        store.redo();
      } else if (control && event.key.toLowerCase() === "s") {
        bar.saveTyped();
      } else if (control && event.key.toLowerCase() === "d") {
        copyKeys(store);
      } else if (control || event.altKey || target.closest("input, select, textarea, dialog")) {
        return;
      } else if (event.key === " " && !target.closest("button")) {
        preview.play(1);
      } else if (event.key.toLowerCase() === "r") {
        preview.play(-1);
      } else if (event.key.toLowerCase() === "d" || (event.key === "Escape" && hand.isOn)) {
        hand.toggle();
      } else if (event.key === ".") {
        preview.step(1);
      } else if (event.key === ",") {
        preview.step(-1);
      } else if (event.key === "[") {
        shiftKeys(store, -1);
      } else if (event.key === "]") {
        shiftKeys(store, 1);
      } else if (event.key === "Delete") {
        if (store.selection.values.size > 0) removeValues(store);
        else removeKeys(store);
      } else if (event.key.toLowerCase() === "i" && store.selection.keys.size > 0) {
        insertOnPath(store, Math.min(...store.selection.keys) + 0.5);
      } else {
        return;
      }
      event.preventDefault();
    },
    { signal: listening.signal },
  );
}

function begin(store: Store, server: Server | null, known: string, draft: Draft | null): Bar {
  document.title = `${store.move.name} – inbetween`;
  for (const id of ["bar", "path", "side", "speed", "time", "preview"]) byId(id).replaceChildren();
  const bar = new Bar(store, server, known, draft);
  const hand = new Hand(store, server);
  pathSection(store, hand);
  sideSection(store);
  speedSection(store);
  new TimeBar(store, byId("time"));
  const preview = new Preview(store, byId("preview"));
  shortcuts(store, bar, preview, hand);
  if (server) byId("saved").before(...importing(store, server, bar));
  store.setFrame(0);
  Object.assign(window, { inbetween: { store, bar } }); // for tests of the page
  return bar;
}

/** The file, and what this browser has kept of edits in it. */
async function open(solver: Solver, server: Server): Promise<void> {
  const { id, revision } = await server.revision();
  let draft = await Draft.take(id);
  const theirs = await server.open().catch((error: Error) => error);
  let history: KeptHistory | null = null;
  try {
    // A draft in which nothing was edited has nothing to bring back.
    if (draft.head && (draft.isChanged || draft.head.count > 1)) {
      history = await draft.history((text, base) =>
        !(theirs instanceof Error) && theirs.revision === base ? Promise.resolve(theirs) : server.document(text),
      );
    }
  } catch (error) {
    notice(
      "back",
      `What was edited here before cannot be shown: ${(error as Error).message}. This browser goes on keeping it.`,
    );
    draft = await Draft.fresh(id);
  }
  const first = history?.base ?? theirs;
  if (first instanceof Error) throw first;
  const store = new Store(solver, first);
  if (history) store.restore(history.states, history.at, history.saved);
  const bar = begin(store, server, history?.known ?? first.revision, draft);
  if (!history) {
    await draft.keepBase(first, () => bar.keepDraft());
  } else if (store.isChanged) {
    notice(
      "back",
      `What was edited here and not saved is back, as it was ${new Date(draft.head!.time).toLocaleString()}. Undo goes back over it.`,
    );
  }
  if (history && revision !== history.known) {
    if (store.isChanged || theirs instanceof Error) bar.offer(revision);
    else await bar.load(theirs);
  }
  if (draft.others > 0)
    notice(
      "others",
      `This browser keeps edits of ${draft.others} more tabs that were closed: open the address again in a new tab for each.`,
    );
}

async function start(): Promise<void> {
  const inlined = document.getElementById("solver"); // of the page in one file
  const solver = await Solver.load(
    inlined
      ? await (await fetch(`data:application/wasm;base64,${inlined.textContent!.trim()}`)).arrayBuffer()
      : await fetch("solver.wasm"),
  );
  if (inlined) {
    let shown: Store | null = null;
    return askForFiles(
      (move) => {
        shown = new Store(solver, move);
        begin(shown, null, "", null);
      },
      () => (shown?.isChanged ? shown.move : null),
    );
  }
  const server = Server.find();
  if (!server) {
    byId("path").append(
      html("p", { class: "empty" }, "Open the address that “inbetween edit” printed: it has the key of the file."),
    );
    return;
  }
  await open(solver, server);
}

start().catch((error: Error) => say(error.message, true));
