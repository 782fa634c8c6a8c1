// The move as the page edits it. Documents are never changed: an edit makes a new one, so that undo keeps the old.

export interface Key {
  readonly from: number | null; // its number in the file that was loaded; null: a new key
  readonly at: readonly number[];
  readonly tension: number;
  readonly continuity: number;
  readonly bias: number;
  readonly frame: number | null;
  readonly hold: number | null;
  readonly break: boolean;
  readonly ease: boolean;
  readonly overlap: number | null; // frames; null: as the track has it
  readonly round: number | null; // weighted distance; null: as the track has it
}

export type Spline = "smooth" | "catmull-rom" | "tcb" | "linear";

export interface Cubics {
  readonly coefficients: readonly number[];
  readonly weights: readonly number[];
  readonly knots: readonly number[];
}

/** A row of axes that goes together: some are drawn over time, the others follow between them. */
export interface Network {
  readonly places: readonly number[];
  readonly drawn: readonly DrawnCurve[];
}

export interface DrawnCurve {
  readonly axis: number;
  readonly frames: readonly number[];
  readonly at: readonly number[];
  readonly keys: readonly number[]; // that have a position of their own for this axis
  readonly redrawn?: boolean;
}

export interface Track {
  readonly axes: readonly string[];
  readonly unit: string;
  readonly coordinates: readonly string[];
  readonly spline: Spline;
  readonly closed: boolean;
  readonly periodic: boolean;
  readonly timing: "speed" | "frames";
  readonly kinetic: "linear" | "curves" | "pace" | "monotone" | null;
  readonly live: boolean;
  readonly fixed_keys: string | null;
  readonly overshoot: boolean;
  readonly overlap: number | null; // frames
  readonly round: number | null; // weighted distance
  readonly keys: readonly Key[];
  readonly lap: readonly number[];
  readonly weights: readonly number[];
  readonly rests: readonly boolean[];
  readonly speed: readonly number[] | null;
  readonly speed_is_played: boolean;
  readonly path: Cubics | null;
  readonly table: string | null; // the file whose rows are played as they are
  readonly network: Network | null;
  readonly touched?: boolean; // the speed curve has been edited
  readonly moved?: boolean; // the keys have been edited
}

export interface Limits {
  readonly min: number;
  readonly max: number;
  readonly max_velocity: number;
  readonly max_acceleration: number;
  readonly max_jerk: number | null;
  readonly max_acceleration_step: number | null;
  readonly stop_acceleration: number | null;
  readonly stop_jerk: number | null;
}

/** What turns an axis through a calibration. */
export interface Motor {
  readonly unit: string;
  readonly marks: readonly number[]; // the place of the axis and that of the motor, mark by mark
  readonly limits: Limits;
}

export interface Axis {
  readonly name: string;
  readonly unit: string;
  readonly limits: Limits | null;
  readonly motor: Motor | null;
}

export interface FrameRate {
  readonly text: string;
  readonly numerator: number;
  readonly denominator: number;
}

export interface Joint {
  readonly link: string;
  readonly kind: number;
  readonly parent: number;
  readonly coordinate: number;
  readonly numbers: readonly number[]; // factor, offset, place, three axes, its own axis
}

export interface Rig {
  readonly name: string;
  readonly revision: string; // of its file, with the URDF file that it names
  readonly rate_hz: number;
  /** Of a rig with kinematics. */
  readonly joints?: readonly Joint[];
  readonly coordinates?: readonly { readonly axis: number | null; readonly stays_at: number }[];
  readonly tip?: number | null;
}

export interface Move {
  readonly file: string;
  readonly id: string; // tells the file from every other one of its machine
  readonly text: string; // of the file that the edits are meant for
  readonly revision: string; // of that text
  readonly name: string;
  readonly fps: FrameRate;
  readonly frames: number;
  readonly rig: Rig | null;
  readonly axes: readonly Axis[];
  readonly tracks: readonly Track[];
}

export const max_control_value = 100;
export const max_frames = 50_000;

export const perSecond = (fps: FrameRate): number => fps.numerator / fps.denominator;

export function parseFps(text: string): FrameRate | null {
  const match = /^\s*(\d{1,7})(?:\s*\/\s*(\d{1,7}))?\s*$/.exec(text);
  if (!match) return null;
  const numerator = Number(match[1]);
  const denominator = Number(match[2] ?? 1);
  if (numerator < 1 || denominator < 1 || numerator / denominator > 1000) return null;
  return { text: match[2] ? `${numerator}/${denominator}` : `${numerator}`, numerator, denominator };
}

export function withTrack(move: Move, index: number, change: Partial<Track>): Move {
  return { ...move, tracks: move.tracks.map((track, t) => (t === index ? { ...track, ...change } : track)) };
}

/** The move on the rig that `there` has, which is of the same text. */
export function withRigOf(there: Move, move: Move): Move {
  const tracks = move.tracks.map((track, t): Track => {
    const { unit, coordinates, weights, live } = there.tracks[t];
    return { ...track, unit, coordinates, weights, live };
  });
  return { ...move, rig: there.rig, axes: there.axes, tracks };
}

export function withKeys(move: Move, index: number, keys: readonly Key[]): Move {
  return withTrack(move, index, { keys, moved: true });
}

export function withSpeed(move: Move, index: number, speed: readonly number[]): Move {
  return withTrack(move, index, { speed, touched: true });
}

export const plainKey = (at: readonly number[]): Key => ({
  from: null,
  at,
  tension: 0,
  continuity: 0,
  bias: 0,
  frame: null,
  hold: null,
  break: false,
  ease: false,
  overlap: null,
  round: null,
});

/** Which of the two rounds the corners of a track: straight paths alone have corners. */
export function cornerField(track: Track): "overlap" | "round" | null {
  if (track.spline !== "linear" || track.path) return null;
  if (track.timing === "frames" && track.kinetic === "linear") return "overlap";
  return track.timing === "speed" || track.kinetic === "pace" ? "round" : null;
}

/** Whether the path may pass a key beside it. */
export function isRounded(track: Track): boolean {
  const field = cornerField(track);
  return field !== null && (track[field] !== null || track.keys.some((key) => key[field] !== null));
}

/** Why the speed curve of a track cannot be edited here, or null. */
export function fixedSpeed(track: Track): string | null {
  if (track.table !== null) return `The rows of ${track.table} are played as they are; there is no drawn curve.`;
  if (track.speed === null) return "The keys have frames; there is no drawn curve.";
  if (track.kinetic === "pace") return "The smoothest pace is computed from the frames of the keys.";
  if (track.speed_is_played) return "The curve shown is eased at corners; edit it as text.";
  return null;
}

/** The edits as the program takes them. */
export function editsOf(move: Move): object {
  return {
    id: move.id,
    base: move.text,
    frames: move.frames,
    fps: move.fps.text,
    tracks: move.tracks.map((track) => ({
      keys: track.moved ? track.keys : null,
      speed: track.touched ? track.speed : null,
      spline: track.spline,
      closed: track.closed,
      drawn:
        track.network?.drawn.filter(({ redrawn }) => redrawn).map(({ axis, frames, at }) => ({ axis, frames, at })) ??
        null,
    })),
  };
}

/** First axis of a track among those of the whole move. */
export function firstAxis(move: Move, track: number): number {
  return move.tracks.slice(0, track).reduce((sum, one) => sum + one.axes.length, 0);
}

/** A step that suits numbers of this size: 1, 0.1, 0.01 ... */
export function stepFor(range: number): number {
  return 10 ** Math.floor(Math.log10(Math.max(range, 1e-9) / 500));
}

export const roundTo = (value: number, step: number): number => {
  const digits = Math.max(0, Math.round(-Math.log10(step)));
  return Number((Math.round(value / step) * step).toFixed(Math.min(digits, 12)));
};
