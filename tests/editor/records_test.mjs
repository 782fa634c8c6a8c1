// What the page and the solver hand to each other by name (editor/page/src/records.ts), in the module that was built.
//
//   INBETWEEN_SOLVER=build/release/editor/page/solver.wasm node --test tests/editor/records_test.mjs
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { test } from "node:test";

const root = new URL("../..", import.meta.url).pathname;
const { transpileModule, ModuleKind, ScriptTarget } = createRequire(`${root}editor/page/package.json`)("typescript");
const { outputText } = transpileModule(readFileSync(`${root}editor/page/src/records.ts`, "utf8"), {
  compilerOptions: { module: ModuleKind.ESNext, target: ScriptTarget.ES2022 },
});
const { Records, textAt } = await import(`data:text/javascript,${encodeURIComponent(outputText)}`);
const module = await WebAssembly.compile(
  readFileSync(process.env.INBETWEEN_SOLVER ?? `${root}build/release/editor/page/solver.wasm`),
);

async function solver() {
  const none = new Proxy({}, { get: () => () => 52 });
  const { exports } = await WebAssembly.instantiate(module, { wasi_snapshot_preview1: none });
  exports._initialize();
  return exports;
}

/** Every record of the module with the names of its fields. */
function recordsOf(abi) {
  const records = new Map();
  for (let i = 0; i < abi.ib_field_count(); ++i) {
    const [record, field] = textAt(abi.memory, abi.ib_field_name(i)).split(".");
    records.set(record, [...(records.get(record) ?? []), field]);
  }
  return records;
}

/** The module with another table of fields: `fields` are numbers of its own. */
const withFields = (abi, fields) => ({
  memory: abi.memory,
  ib_records: () => abi.ib_records(),
  ib_field_count: () => fields.length,
  ib_field_name: (i) => abi.ib_field_name(fields[i]),
  ib_field_offset: (i) => abi.ib_field_offset(fields[i]),
  ib_field_is_number: (i) => abi.ib_field_is_number(fields[i]),
});

test("the page and the solver know the same fields, and each has a place of its own", async () => {
  const abi = await solver();
  const records = new Records(abi);
  const written = new Map();
  let next = 1;
  for (const [record, fields] of recordsOf(abi)) {
    written.set(record, Object.fromEntries(fields.map((field) => [field, next++])));
    records.write(record, written.get(record));
  }
  assert.ok(written.size >= 5);
  for (const [record, values] of written) assert.deepEqual(records.read(record), values);
});

test("an integer has 32 bits with a sign, and a number those of a double", async () => {
  const records = new Records(await solver());
  const values = { ...records.read("track_report"), hash_low: -0x80000000, hash_high: 0x7fffffff, length: 1 / 3 };
  records.write("track_report", values);
  assert.deepEqual(records.read("track_report"), values);
});

test("what is no whole number of 32 bits is refused where one is needed", async () => {
  const records = new Records(await solver());
  const values = records.read("move_request");
  for (const rate_hz of [0.5, NaN, 2 ** 31, undefined]) {
    assert.throws(() => records.write("move_request", { ...values, rate_hz }), /move_request\.rate_hz is/);
  }
});

test("a field that one side alone has is refused by its name", async () => {
  const abi = await solver();
  const all = Array.from({ length: abi.ib_field_count() }, (_, i) => i);
  const nameOf = (field) => textAt(abi.memory, abi.ib_field_name(field));
  for (const field of all) {
    const fewer = withFields(
      abi,
      all.filter((other) => other !== field),
    );
    assert.throws(() => new Records(fewer), { message: new RegExp(`the solver has no ${nameOf(field)}\\.`) });
  }
  // The text behind the first letter of a name is a name that the page has not.
  const more = {
    ...withFields(abi, [...all, 0]),
    ib_field_name: (i) => (i < all.length ? abi.ib_field_name(i) : abi.ib_field_name(0) + 1),
  };
  assert.throws(() => new Records(more), { message: new RegExp(`the page has no ${nameOf(0).slice(1)}\\.`) });
});

test("the order in which the solver has its fields is its own", async () => {
  const abi = await solver();
  const records = new Records(withFields(abi, Array.from({ length: abi.ib_field_count() }, (_, i) => i).reverse()));
  const values = { track_count: 1, axis_count: 2, motor_count: 3, rate_hz: 4 };
  records.write("move_request", values);
  assert.deepEqual(new Records(abi).read("move_request"), values);
});
