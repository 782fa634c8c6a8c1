// The page without the program: it reads a move and a rig that are dropped on it, and gives the move back as a download.
// It knows the plain kind of move; what else a file says is the program's to read.
import { parse, TomlError } from "smol-toml";
import { byId, html, say } from "./dom";
import { type Axis, cornerField, type Key, type Move, parseFps, plainKey, type Spline, type Track } from "./move";

type Table = Record<string, unknown>;

/** A table of a file, of which only `known` members are understood here. */
class Members {
  constructor(
    private readonly table: Table,
    readonly name: string,
    known: string | null,
  ) {
    const other = known === null ? undefined : Object.keys(table).find((member) => !known.split(" ").includes(member));
    if (other !== undefined)
      throw new Error(`${name}: the page alone does not know ${other}; open the file with inbetween edit`);
  }
  take(member: string): unknown {
    return this.table[member];
  }
  private as<T>(member: string, is: (value: unknown) => value is T, what: string): T | null {
    const value = this.take(member);
    if (value === undefined) return null;
    if (!is(value))
      throw new Error(
        `${this.name}: ${member} is not ${what}, and the page alone knows no other; open the file with inbetween edit`,
      );
    return value;
  }
  number(member: string): number | null {
    return this.as(member, isNumber, "a number");
  }
  needed(member: string): number {
    const value = this.number(member);
    if (value === null) throw new Error(`${this.name}: ${member} is missing`);
    return value;
  }
  flag(member: string): boolean {
    return this.as(member, (value): value is boolean => typeof value === "boolean", "true or false") ?? false;
  }
  text(member: string): string | null {
    return this.as(member, (value): value is string => typeof value === "string", "a text");
  }
  numbers(member: string): number[] | null {
    return this.as(
      member,
      (value): value is number[] => Array.isArray(value) && value.every(isNumber),
      "a list of numbers",
    );
  }
  tables(member: string): Table[] {
    return (
      this.as(
        member,
        (value): value is Table[] => Array.isArray(value) && value.every((one) => typeof one === "object"),
        "a list",
      ) ?? []
    );
  }
}
const isNumber = (value: unknown): value is number => typeof value === "number" && Number.isFinite(value);

function keyOf(table: Table, name: string, axes: number): Key {
  const key = new Members(table, name, "at tension continuity bias frame hold break ease overlap round");
  const at = key.numbers("at");
  if (at?.length !== axes) throw new Error(`${name}: at has a number for every axis`);
  const shape = {
    tension: key.number("tension") ?? 0,
    continuity: key.number("continuity") ?? 0,
    bias: key.number("bias") ?? 0,
  };
  return {
    ...plainKey(at),
    ...shape,
    frame: key.number("frame"),
    hold: key.number("hold"),
    break: key.flag("break"),
    ease: key.flag("ease"),
    overlap: key.number("overlap"),
    round: key.number("round"),
  };
}

function trackOf(table: Table, t: number): Track {
  const track = new Members(
    table,
    `track ${t}`,
    "axes spline closed timing kinetic overshoot overlap round keys speed weights",
  );
  const axes = track.take("axes") as string[];
  if (!Array.isArray(axes) || axes.length === 0 || !axes.every((axis) => typeof axis === "string"))
    throw new Error(
      `track ${t}: without axes it is a kind that the page alone does not know; open the file with inbetween edit`,
    );
  const spline = (track.text("spline") ?? "smooth") as Spline;
  const timing = (track.text("timing") ?? "speed") as Track["timing"];
  const kinetic =
    timing === "frames"
      ? ((track.text("kinetic") ?? (spline === "linear" ? "linear" : "curves")) as Track["kinetic"])
      : null;
  if (kinetic === "pace")
    throw new Error(`track ${t}: the smoothest pace is computed by the program; open the file with inbetween edit`);
  const overshoot = track.take("overshoot") !== false;
  const speed = track.numbers("speed");
  if (timing === "speed" && !speed) throw new Error(`track ${t}: speed is missing`);
  const found: Track = {
    axes,
    unit: "",
    coordinates: axes,
    spline,
    closed: track.flag("closed"),
    periodic: false,
    timing,
    kinetic,
    live: true,
    fixed_keys: null,
    overshoot,
    overlap: track.number("overlap"),
    round: track.number("round"),
    keys: track.tables("keys").map((key, k) => keyOf(key, `track ${t}, key ${k}`, axes.length)),
    lap: [],
    weights: track.numbers("weights") ?? [],
    rests: [true, true],
    speed,
    speed_is_played: false,
    path: null,
    table: null,
    network: null,
  };
  if (found.keys.length === 0) throw new Error(`track ${t}: there are no keys`);
  for (const name of ["overlap", "round"] as const) {
    const isSaid = found[name] !== null || found.keys.some((key) => key[name] !== null);
    if (isSaid && cornerField(found) !== name)
      throw new Error(
        `track ${t}: ${name} is for spline = "linear", ${name === "round" ? "with a speed curve" : 'with timing = "frames"'}`,
      );
  }
  return found;
}

/** Axes by name, with their limits. What drives them and where they stand is nothing to the page. */
function rigOf(text: string): { rig: Move["rig"]; axes: Map<string, Axis> } {
  const file = parse(text) as Table;
  const axes = new Map<string, Axis>();
  for (const table of (file.axis ?? []) as Table[]) {
    const axis = new Members(table, `axis ${String(table.name)}`, null);
    if (table.wrap !== undefined)
      throw new Error(
        `${axis.name}: it counts round, which the page alone does not know; open the file with inbetween edit`,
      );
    for (const name of ["calibration", "backlash"])
      if (table[name] !== undefined)
        throw new Error(
          `${axis.name}: it has a ${name}, which the page alone cannot judge; open the file with inbetween edit, or leave the rig out`,
        );
    axes.set(axis.text("name") ?? "", {
      name: axis.text("name") ?? "",
      unit: axis.text("unit") ?? "",
      limits: {
        min: axis.needed("min"),
        max: axis.needed("max"),
        max_velocity: axis.needed("max_velocity"),
        max_acceleration: axis.needed("max_acceleration"),
        max_jerk: axis.number("max_jerk"),
        max_acceleration_step: axis.number("max_acceleration_step"),
        stop_acceleration: axis.number("stop_acceleration"),
        stop_jerk: axis.number("stop_jerk"),
      },
      motor: null,
    });
  }
  return {
    rig: {
      name: new Members(file, "rig", null).text("name") ?? "rig",
      revision: "",
      rate_hz: Number(file.rate_hz ?? 250),
    },
    axes,
  };
}

/** Throws an Error, one line, where the page alone cannot read it. */
export function moveOf(file: string, text: string, rigText: string | null): Move {
  const move = new Members(parse(text), file, "name fps frames track");
  const fps = parseFps(String(move.take("fps")));
  if (!fps) throw new Error(`${file}: fps is a whole number or a fraction`);
  const tracks = move.tables("track").map(trackOf);
  const { rig, axes: known } = rigText === null ? { rig: null, axes: null } : rigOf(rigText);
  const axes = tracks
    .flatMap((track) => track.axes)
    .map((name): Axis => {
      const axis = known?.get(name);
      if (known && !axis) throw new Error(`${file}: the rig has no axis ${name}`);
      return axis ?? { name, unit: "", limits: null, motor: null };
    });
  let first = 0;
  const withUnits = tracks.map((track): Track => {
    const units = new Set(axes.slice(first, (first += track.axes.length)).map((axis) => axis.unit));
    return units.size === 1 ? { ...track, unit: [...units][0] } : track;
  });
  const found: Move = {
    file,
    id: "",
    text,
    revision: "",
    name: move.text("name") ?? file,
    fps,
    frames: move.needed("frames"),
    rig,
    axes,
    tracks: withUnits,
  };
  return found;
}

/** The move as a new file; the comments of the old one are not in it. */
export function textOf(move: Move): string {
  const word = (value: unknown): string => JSON.stringify(value);
  const lines = [
    `name   = ${word(move.name)}`,
    `fps    = ${/^\d+$/.test(move.fps.text) ? move.fps.text : word(move.fps.text)}`,
    `frames = ${move.frames}`,
  ];
  for (const track of move.tracks) {
    lines.push("", "[[track]]", `axes   = ${word(track.axes)}`, `spline = ${word(track.spline)}`);
    if (track.closed) lines.push("closed = true");
    if (!track.overshoot) lines.push("overshoot = false");
    for (const name of ["overlap", "round"] as const) if (track[name] !== null) lines.push(`${name} = ${track[name]}`);
    if (track.timing === "frames") lines.push('timing = "frames"', `kinetic = ${word(track.kinetic)}`);
    lines.push("keys   = [");
    for (const key of track.keys) {
      const more = (["tension", "continuity", "bias"] as const)
        .filter((name) => key[name] !== 0)
        .map((name) => `, ${name} = ${key[name]}`);
      if (key.frame !== null) more.push(`, frame = ${key.frame}`);
      if (key.hold !== null) more.push(`, hold = ${key.hold}`);
      for (const name of ["break", "ease"] as const) if (key[name]) more.push(`, ${name} = true`);
      for (const name of ["overlap", "round"] as const) if (key[name] !== null) more.push(`, ${name} = ${key[name]}`);
      lines.push(`  { at = ${word(key.at)}${more.join("")} },`);
    }
    lines.push("]");
    if (track.speed) lines.push(`speed  = ${word(track.speed)}`);
    if (track.weights.length > 0) lines.push(`weights = ${word(track.weights)}`);
  }
  return `${lines.join("\n")}\n`;
}

/** A move of the program, without the program: written anew where the page knows all that its file says, and else as the
 * file was. What is not in force is there as comments. */
export function textWithoutProgram(move: Move): string {
  const edited = textOf(move);
  const commented = (text: string): string => text.replace(/^(?=.)/gm, "# ").replace(/\r/g, "");
  try {
    moveOf(move.file, move.text, null);
  } catch (error) {
    return (
      `# The edits could not be put into this file without the program: ${(error as Error).message.split("\n")[0]}\n` +
      `# This is the file as it was:\n\n${move.text.replace(/^\ufeff/, "")}\n# The edits are these:\n\n${commented(edited)}`
    );
  }
  return `${edited}\n# This was written without the program. The file as it was, with its comments:\n\n${commented(move.text.replace(/^\ufeff/, ""))}`;
}

export function download(file: string, text: string): void {
  const link = html("a", { href: URL.createObjectURL(new Blob([text], { type: "application/toml" })), download: file });
  link.click();
  URL.revokeObjectURL(link.href);
}

/** Asks for files until there is a move; a rig among them gives it units and limits. `edited` is the move that is shown
 * where it is not downloaded as it is. */
export function askForFiles(open: (move: Move) => void, edited: () => Move | null): void {
  const told = html("p", { class: "bad", role: "alert" });
  const input = html("input", {
    type: "file",
    id: "files",
    accept: ".toml",
    multiple: true,
    "aria-label": "A move, and its rig",
  });
  byId("path").replaceChildren(
    html(
      "div",
      { class: "empty" },
      html("h2", {}, "Drop a move here, and its rig if you have one"),
      html(
        "p",
        {},
        "Two .toml files, together or one after the other. Without the program there is no Fit, no Fewest frames, no drawing by hand and no saving: take the result with Download.",
      ),
      html("label", {}, "or choose them ", input),
      told,
    ),
  );
  const texts = new Map<string, string>();
  const read = async (files: Iterable<File>): Promise<void> => {
    told.textContent = "";
    const dropped = [...files];
    const now = edited();
    if (now && dropped.some((file) => file.name === now.file)) {
      return say("What was edited here would be lost. Take it with Save first, then drop the move again.", true);
    }
    const other = dropped.find((file) => !file.name.endsWith(".toml"));
    if (other) {
      const why = `${other.name} is no .toml file. A motion of another program is imported by the program: inbetween edit, or inbetween import.`;
      told.textContent = why;
      return say(why, true);
    }
    for (const file of dropped) texts.set(file.name, await file.text());
    if (now) texts.set(now.file, textOf(now)); // a rig that comes later is for the move as it is
    try {
      const all = [...texts].map(([name, text]) => ({ name, text, table: parse(text) }));
      const move = all.find(({ table }) => table.track !== undefined);
      const rig = all.find(({ table }) => table.axis !== undefined);
      if (move) open(moveOf(move.name, move.text, rig?.text ?? null));
      else
        told.textContent = rig
          ? "This is a rig; drop the move as well."
          : "There is no [[track]] in it, so it is no move.";
    } catch (error) {
      told.textContent =
        error instanceof TomlError ? `This is no TOML: ${error.message.split("\n")[0]}` : (error as Error).message;
      texts.clear();
    }
  };
  input.addEventListener("change", () => void read(input.files ?? []));
  document.addEventListener("dragover", (event) => event.preventDefault());
  document.addEventListener("drop", (event) => {
    event.preventDefault();
    void read(event.dataTransfer?.files ?? []);
  });
}
