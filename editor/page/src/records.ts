// What the page and the solver hand to each other by name: records in the memory of the module. editor/solver/records.hpp
// is the other side; its table says where each field is, and a module with other names than these is refused.

export interface RecordAbi {
  memory: WebAssembly.Memory;
  ib_records(): number;
  ib_field_count(): number;
  ib_field_name(field: number): number;
  ib_field_offset(field: number): number;
  ib_field_is_number(field: number): number;
}

const names = {
  track_request: [
    "spline",
    "kinetic",
    "is_closed",
    "is_periodic",
    "overshoots",
    "rests_at_start",
    "rests_at_end",
    "frames",
    "fps_numerator",
    "fps_denominator",
    "axis_count",
    "key_count",
    "lap_count",
    "weight_count",
    "shape_count",
    "control_value_count",
    "lock_count",
    "key_frame_count",
    "corner_count",
    "segment_count",
  ],
  move_request: ["track_count", "axis_count", "motor_count", "rate_hz"],
  error_report: ["code", "key", "axis", "control_value", "frame", "needed"],
  track_report: [
    "hash_low",
    "hash_high",
    "frames",
    "segment_count",
    "key_count",
    "piece_count",
    "played_value_count",
    "length",
    "constant",
    "total_integral",
  ],
  move_report: [
    "first_frame",
    "last_frame",
    "axis_count",
    "motor_count",
    "cell_count",
    "step_count",
    "steps_left_out",
    "stops_are_proven",
    "breach_kind",
    "breach_axis",
    "breach_quantity",
    "highest_rate",
    "longest_stop_seconds",
    "longest_stop_frames",
    "longest_stop_from_frame",
    "breach_value",
    "breach_limit",
    "breach_frame",
  ],
} as const;

type RecordName = keyof typeof names;
type Values<R extends RecordName> = Readonly<Record<(typeof names)[R][number], number>>;

interface Field {
  readonly name: string;
  readonly at: number; // in the memory
  readonly isNumber: boolean; // a double; otherwise an integer of 32 bits
}

/** The text at an address of the module, which a 0 ends. */
export function textAt(memory: WebAssembly.Memory, begin: number): string {
  const bytes = new Uint8Array(memory.buffer, begin);
  return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
}

export class Records {
  private readonly fields: ReadonlyMap<RecordName, readonly Field[]>;

  /** Throws where the module has other fields than this page. */
  constructor(private readonly abi: RecordAbi) {
    const offsets = new Map<string, Pick<Field, "at" | "isNumber">>();
    for (let i = 0; i < abi.ib_field_count(); ++i) {
      offsets.set(textAt(abi.memory, abi.ib_field_name(i)), {
        at: abi.ib_records() + abi.ib_field_offset(i),
        isNumber: abi.ib_field_is_number(i) !== 0,
      });
    }
    const missing: string[] = [];
    const fields = new Map<RecordName, Field[]>();
    for (const record of Object.keys(names) as RecordName[]) {
      const ofRecord: Field[] = [];
      for (const name of names[record]) {
        const found = offsets.get(`${record}.${name}`);
        if (found) ofRecord.push({ name, ...found });
        else missing.push(`${record}.${name}`);
        offsets.delete(`${record}.${name}`);
      }
      fields.set(record, ofRecord);
    }
    this.fields = fields;
    if (missing.length === 0 && offsets.size === 0) return;
    throw new Error(
      `The page and its solver are of different versions: ${[
        ...missing.map((name) => `the solver has no ${name}`),
        ...[...offsets.keys()].map((name) => `the page has no ${name}`),
      ].join(", ")}. Build both again.`,
    );
  }

  /** Writes every field of a record. */
  write<R extends RecordName>(record: R, values: Values<R>): void {
    const memory = new DataView(this.abi.memory.buffer);
    for (const { name, at, isNumber } of this.fields.get(record)!) {
      const value = values[name as keyof Values<R>];
      if (isNumber) {
        memory.setFloat64(at, value, true);
      } else {
        if (value !== (value | 0))
          throw new Error(`${record}.${name} is ${value}, and a whole number of 32 bits is needed`);
        memory.setInt32(at, value, true);
      }
    }
  }

  read<R extends RecordName>(record: R): Values<R> {
    const memory = new DataView(this.abi.memory.buffer);
    return Object.fromEntries(
      this.fields
        .get(record)!
        .map(({ name, at, isNumber }) => [name, isNumber ? memory.getFloat64(at, true) : memory.getInt32(at, true)]),
    ) as Values<R>;
  }
}
