// The core, as WebAssembly. editor/solver/abi.cpp is the other side and says what each function reads and writes.
import { isRounded, perSecond, type Limits, type Move, type Rig, type Track } from "./move";
import { type RecordAbi, Records, textAt } from "./records";

interface Abi extends RecordAbi {
  _initialize(): void;
  ib_numbers(): number;
  ib_integers(): number;
  ib_error(): void;
  ib_error_what(): number;
  ib_error_remedy(): number;
  ib_solve(track: number): number;
  ib_assemble(): number;
  ib_track(track: number): number;
  ib_played_values(track: number): number;
  ib_path(track: number, perSegment: number): number;
  ib_frames(track: number): number;
  ib_speed(track: number, samples: number): number;
  ib_key_frames(track: number): number;
  ib_at(track: number, s: number): number;
  ib_certificate(): number;
  ib_joints(joints: number, coordinates: number): number;
  ib_poses(count: number): number;
  ib_motion(first: number, step: number, samples: number): number;
}

export interface SolverError {
  readonly what: string;
  readonly remedy: string;
  readonly track: number;
  readonly key: number;
  readonly axis: number;
}

export interface SolvedTrack {
  readonly hash: string; // of the table, as in `plan --json`
  readonly segments: number;
  readonly length: number;
  readonly path: Float64Array; // positions, axes at a time
  readonly perSegment: number;
  readonly begins: Float64Array; // s of every segment and of the end
  readonly table: Float64Array; // for every frame s, distance, speed, acceleration, positions
  readonly stride: number; // of the table
  readonly keyFrames: readonly number[]; // of each key, and of the return to key 0
  readonly keyPlaces: readonly Float64Array[]; // of each key where the path is then, which is beside a rounded corner
  readonly played: Float64Array; // control values
  readonly unitPerValue: number; // speed along the path for a control value of 1
}

export interface Peak {
  readonly value: number;
  readonly frame: number;
}

export interface Ceiling {
  readonly rate: number; // so many times faster every limit still holds
  readonly axis: number;
  readonly quantity: number;
}

export interface Certificate {
  readonly firstFrame: number;
  readonly lastFrame: number;
  readonly fits: boolean;
  readonly reason: string;
  readonly highestRate: number;
  readonly longestStop: number | null; // seconds
  readonly peaks: readonly { lowest: Peak; highest: Peak; velocity: Peak; acceleration: Peak; jerk: Peak }[];
  readonly ceilings: readonly (readonly Ceiling[])[]; // of each track, cell by cell
  readonly steps: readonly {
    track: number;
    key: number;
    axis: number;
    frame: number;
    velocity: number;
    acceleration: number;
  }[];
}

export interface Solution {
  readonly tracks: readonly SolvedTrack[];
  readonly certificate: Certificate | null; // without a rig there is none
  readonly firstFrame: number;
  readonly lastFrame: number;
}

const splines = ["smooth", "catmull-rom", "tcb", "linear"];
const kinetics = { linear: 0, monotone: 1, curves: 2, pace: 0 };
export const quantities = ["velocity", "acceleration", "jerk"];

class Failure extends Error {
  constructor(readonly error: SolverError) {
    super(error.what);
  }
}

export class Solver {
  private readonly numbers: number;
  private readonly integers: number;
  private readonly records: Records;
  private constructor(private readonly abi: Abi) {
    abi._initialize();
    this.numbers = abi.ib_numbers();
    this.integers = abi.ib_integers();
    this.records = new Records(abi);
  }

  static async load(bytes: BufferSource | Response): Promise<Solver> {
    // The core asks nothing of a system. What the C library would ask for is never called.
    const none = new Proxy({}, { get: () => () => 52 });
    const imports = { wasi_snapshot_preview1: none };
    const source = bytes instanceof Response ? await bytes.arrayBuffer() : bytes;
    const { instance } = await WebAssembly.instantiate(source, imports);
    return new Solver(instance.exports as unknown as Abi);
  }

  /** Solves every track and holds the move against the limits of its rig. */
  solve(move: Move): Solution | SolverError {
    try {
      move.tracks.forEach((track, t) => this.solveTrack(move, track, t));
      this.assemble(move);
      const tracks = move.tracks.map((_, t) => this.readTrack(move, t));
      const certificate = this.readCertificate(move);
      return {
        tracks,
        certificate,
        firstFrame: certificate?.firstFrame ?? 0,
        lastFrame: certificate?.lastFrame ?? move.frames,
      };
    } catch (error) {
      if (error instanceof Failure) return error.error;
      throw error;
    }
  }

  /** The position of every axis of a track at s, which is i at key i. */
  at(track: number, s: number, axes: number): number[] {
    return this.abi.ib_at(track, s) ? Array.from(this.out(axes)) : [];
  }

  /** The curve that is played in control values, or the speed along the path, in equal steps over the move. */
  speed(track: number, samples: number, real: boolean): Float64Array {
    this.abi.ib_speed(track, samples);
    const pairs = this.out(2 * samples);
    return Float64Array.from({ length: samples }, (_, i) => pairs[2 * i + Number(real)]);
  }

  /** Position, velocity, acceleration and jerk of every axis of the move, sample by sample. */
  motion(first: number, step: number, samples: number, axes: number): Float64Array {
    this.abi.ib_motion(first, step, samples);
    return this.out(samples * axes * 4).slice();
  }

  /** Where every link of the rig is at `samples` frames, x y z in metres; null where the rig has no joints. */
  places(rig: Rig, axes: number, first: number, step: number, samples: number): Float64Array | null {
    const { joints, coordinates } = rig;
    if (!joints || !coordinates) return null;
    if (rig !== this.rig) {
      const { numbers, integers } = this.view();
      joints.forEach((joint, j) => {
        integers.set([joint.kind, joint.parent, joint.coordinate], 3 * j);
        numbers.set(joint.numbers, joint.numbers.length * j);
      });
      if (!this.abi.ib_joints(joints.length, coordinates.length)) return null;
      this.rig = rig;
    }
    const motion = this.motion(first, step, samples, axes);
    const half = this.view().numbers.subarray(1 << 18);
    for (let i = 0; i < samples; ++i) {
      coordinates.forEach(({ axis, stays_at }, c) => {
        half[i * coordinates.length + c] = axis === null ? stays_at : motion[(i * axes + axis) * 4];
      });
    }
    return this.abi.ib_poses(samples) ? this.out(samples * joints.length * 3).slice() : null;
  }

  private rig: Rig | null = null; // whose joints the solver has
  private view(): { numbers: Float64Array; integers: Int32Array } {
    return {
      numbers: new Float64Array(this.abi.memory.buffer, this.numbers, 1 << 19),
      integers: new Int32Array(this.abi.memory.buffer, this.integers, 1 << 17),
    };
  }
  private out(count: number): Float64Array {
    return new Float64Array(this.abi.memory.buffer, this.numbers, count);
  }

  private solveTrack(move: Move, track: Track, index: number): void {
    const { numbers, integers } = this.view();
    const byFrames = track.timing === "frames" && track.kinetic !== "pace";
    const keys = track.keys;
    const isReturnedTo = track.closed && keys.length > 1;
    const hasOwnTiming = !byFrames && !track.speed_is_played;
    const locks = hasOwnTiming
      ? keys.map((key, k) => ({ key, k })).filter(({ key }) => key.frame !== null || key.hold !== null || key.ease)
      : [];
    const speed = byFrames ? [] : (track.speed ?? []);
    const shapes = track.spline === "tcb" ? keys.length : 0;
    const weights = track.path ? track.path.weights : track.weights;
    const segments = track.path ? track.path.knots.length / 4 : 0;
    const corners = cornersOf(track, byFrames);
    const overlaps = byFrames && corners.length > 0; // straight paths that are curves over time
    if (byFrames && keys.some((key) => key.frame === null)) {
      throw new Failure({
        what: "a key has no frame",
        remedy: "give it one: all keys of this track have frames",
        track: index,
        key: keys.findIndex((key) => key.frame === null),
        axis: -1,
      });
    }
    this.records.write("track_request", {
      spline: splines.indexOf(track.spline),
      kinetic: overlaps ? kinetics.curves : kinetics[track.kinetic ?? "curves"],
      is_closed: Number(isReturnedTo),
      is_periodic: Number(track.periodic),
      overshoots: Number(track.overshoot),
      rests_at_start: Number(track.rests[0]),
      rests_at_end: Number(track.rests[1]),
      frames: move.frames,
      fps_numerator: move.fps.numerator,
      fps_denominator: move.fps.denominator,
      axis_count: track.axes.length,
      key_count: keys.length,
      lap_count: track.lap.length,
      weight_count: weights.length,
      shape_count: shapes,
      control_value_count: speed.length,
      lock_count: locks.length,
      key_frame_count: byFrames ? keys.length + Number(isReturnedTo) : 0,
      corner_count: corners.length,
      segment_count: segments,
    });
    let i = 0;
    const put = (...values: number[]): void => values.forEach((value) => (integers[i++] = value));
    for (const { key, k } of locks) {
      put(k, key.frame ?? -1, key.hold ?? 0, Number(key.break), Number(key.ease));
    }
    if (byFrames) {
      put(...keys.map((key) => key.frame ?? 0));
      if (isReturnedTo) put(move.frames);
    }
    if (byFrames) put(...corners);
    if (track.path) put(...track.path.knots);
    let n = 0;
    const add = (values: readonly number[]): void => {
      for (const value of values) numbers[n++] = value;
    };
    // A path that the program made has its keys elsewhere; only their number counts.
    keys.forEach((key) => add(track.path ? track.axes.map(() => 0) : key.at));
    add(track.lap);
    add(weights);
    if (shapes > 0) keys.forEach((key) => add([key.tension, key.continuity, key.bias]));
    add(speed);
    if (!byFrames) add(corners);
    if (track.path) add(track.path.coefficients);
    if (!this.abi.ib_solve(index)) this.fail(index);
  }

  private assemble(move: Move): void {
    const { numbers, integers } = this.view();
    const axes = move.rig ? move.axes : [];
    const moved = movedOf(move);
    const motors = moved.slice(axes.length);
    this.records.write("move_request", {
      track_count: move.tracks.length,
      axis_count: axes.length,
      motor_count: motors.length,
      rate_hz: move.rig ? move.rig.rate_hz : 1,
    });
    let i = 0;
    let n = 0;
    for (const { limits: l } of moved) {
      for (const value of [
        l.min,
        l.max,
        l.max_velocity,
        l.max_acceleration,
        l.max_jerk,
        l.max_acceleration_step,
        l.stop_acceleration,
        l.stop_jerk,
      ]) {
        numbers[n++] = value ?? Number.NaN;
      }
    }
    for (const { axis, marks } of motors) {
      integers[i++] = axis;
      integers[i++] = marks.length / 2;
      numbers.set(marks, n);
      n += marks.length;
    }
    if (!this.abi.ib_assemble()) this.fail(-1);
  }

  private readTrack(move: Move, index: number): SolvedTrack {
    this.abi.ib_track(index);
    const report = this.records.read("track_report");
    const { frames, segment_count: segments, length } = report;
    const half = (integer: number): string => (integer >>> 0).toString(16).padStart(8, "0");
    const hash = half(report.hash_high) + half(report.hash_low);
    const perSegment = Math.max(4, Math.min(24, Math.round(2400 / Math.max(segments, 1))));
    const points = this.abi.ib_path(index, perSegment);
    const rows = move.tracks[index].axes.length;
    const path = this.out(points * rows).slice();
    const stride = 4 + rows;
    this.abi.ib_frames(index);
    const table = this.out((frames + 1) * stride).slice();
    const played = this.out(this.abi.ib_played_values(index)).slice();
    const met = this.abi.ib_key_frames(index);
    const { numbers: at, integers: of } = this.view();
    const keyFrames = new Array<number>(report.key_count).fill(0);
    const keyPlaces = new Array<Float64Array>(report.key_count);
    const begins = new Float64Array(met);
    let last = 0;
    for (let i = 0; i < met; ++i) {
      const first = i * (2 + rows);
      last = at[first];
      begins[i] = at[first + 1];
      if (of[i] < 0 || (i === met - 1 && of[i] === 0)) continue;
      keyFrames[of[i]] = last;
      keyPlaces[of[i]] = at.slice(first + 2, first + 2 + rows);
    }
    if (keyFrames.length > 0) keyFrames.push(last);
    // L(s) = K Phi(a), and a runs through f spans in the time of the move: speed = K phi da/dt.
    const { constant, total_integral: integral, played_value_count: values } = report;
    const unitPerValue = integral > 0 && values > 1 ? (constant * (values - 1) * perSecond(move.fps)) / frames : 0;
    return {
      hash,
      segments,
      length,
      path,
      perSegment,
      table,
      begins,
      stride,
      keyFrames,
      keyPlaces,
      played,
      unitPerValue,
    };
  }

  private readCertificate(move: Move): Certificate | null {
    if (!this.abi.ib_certificate()) return null;
    const { numbers, integers } = this.view();
    const report = this.records.read("move_report");
    if (report.axis_count === 0) return null;
    const moved = movedOf(move);
    let i = 0;
    let n = 0;
    const peak = (): Peak => ({ value: numbers[n++], frame: numbers[n++] });
    const peaks = Array.from({ length: moved.length }, () => ({
      lowest: peak(),
      highest: peak(),
      velocity: peak(),
      acceleration: peak(),
      jerk: peak(),
    }));
    const ceilings = move.tracks.map(() =>
      Array.from({ length: report.cell_count }, () => ({
        rate: numbers[n++],
        axis: integers[i++],
        quantity: integers[i++],
      })),
    );
    const steps = Array.from({ length: report.step_count }, () => ({
      track: integers[i++],
      key: integers[i++],
      axis: integers[i++],
      frame: numbers[n++],
      velocity: numbers[n++],
      acceleration: numbers[n++],
    }));
    const fits = report.breach_kind === 0;
    return {
      firstFrame: report.first_frame,
      lastFrame: report.last_frame,
      highestRate: report.highest_rate,
      peaks,
      ceilings,
      steps,
      fits,
      reason: fits
        ? ""
        : reasonOf(moved[report.breach_axis], {
            kind: report.breach_kind,
            quantity: report.breach_quantity,
            value: report.breach_value,
            limit: report.breach_limit,
            frame: report.breach_frame,
          }),
      longestStop: report.stops_are_proven ? report.longest_stop_seconds : null,
    };
  }

  private fail(track: number): never {
    this.abi.ib_error();
    const { key, axis } = this.records.read("error_report");
    throw new Failure({
      what: textAt(this.abi.memory, this.abi.ib_error_what()),
      remedy: textAt(this.abi.memory, this.abi.ib_error_remedy()),
      track,
      key,
      axis,
    });
  }
}

interface Moved {
  readonly name: string;
  readonly unit: string;
  readonly limits: Limits;
  readonly axis: number; // that a motor follows; otherwise this one
  readonly marks: readonly number[]; // of a motor
}

/** s at a point of `path`. */
export function parameterOf({ begins, perSegment }: SolvedTrack, point: number): number {
  const segment = Math.floor(point / perSegment);
  const begin = begins[segment];
  return begin + ((begins[segment + 1] ?? begin) - begin) * (point / perSegment - segment);
}

/** What the corner of every key is rounded by; nothing where none is. A path that the program made has that already. */
function cornersOf(track: Track, byFrames: boolean): number[] {
  if (track.path || track.keys.length < 2) return [];
  if (!isRounded(track)) return [];
  const rounded = track.keys.map((key) => (byFrames ? (key.overlap ?? track.overlap) : (key.round ?? track.round)));
  // A closed path that is no loop ends at its seam.
  return rounded.map((value, k) => (!byFrames && k === 0 && !track.periodic ? 0 : (value ?? 0)));
}

/** All that has limits: every axis, and behind them the motor of every axis with a calibration. */
export function movedOf(move: Move): Moved[] {
  if (!move.rig) return [];
  const axes = move.axes.map((axis, a): Moved => ({
    name: axis.name,
    unit: axis.unit,
    limits: axis.limits!,
    axis: a,
    marks: [],
  }));
  const motors = move.axes.flatMap(({ name, motor }, a): Moved[] =>
    motor
      ? [{ name: `the motor of ${name}`, unit: motor.unit, limits: motor.limits, axis: a, marks: motor.marks }]
      : [],
  );
  return [...axes, ...motors];
}

interface Breach {
  readonly kind: number; // BreachKind of the solver, counted from 1
  readonly quantity: number;
  readonly value: number;
  readonly limit: number;
  readonly frame: number;
}

/** What is not kept, in words. */
function reasonOf({ name, unit }: Moved, { kind, quantity, value, limit, frame }: Breach): string {
  const at = frame.toFixed(0);
  const limits = ["position", "position", "velocity", "acceleration", "jerk"];
  if (kind <= limits.length) {
    const per = ["", "", "/s", "/s²", "/s³"][kind - 1];
    return `${name}: ${limits[kind - 1]} ${Number(value.toPrecision(3))} ${unit}${per} at frame ${at}, and ${limit} is allowed`;
  }
  return [
    `${name}: the velocity jumps at frame ${at}`,
    `${name}: the acceleration jumps at frame ${at}`,
    `no roll keeps the ${["position", ...quantities][quantity]} of ${name}`,
    `no stop keeps the ${quantity ? "jerk" : "acceleration"} of ${name} near frame ${at}`,
  ][kind - limits.length - 1];
}

export const isError = (result: Solution | SolverError): result is SolverError => "what" in result;
