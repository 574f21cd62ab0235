import assert from "node:assert/strict";
import test from "node:test";
import { STOPS, accuracyOf, edits, finest, settingsOf, typed } from "../app/panels/accuracy-stops.js";
import { difference, exposed, measure } from "../app/panels/compare-metrics.js";

test("the dial has twelve stops, the lecture's 3, 5 and 100 among them", () => {
  assert.equal(STOPS.length, 12);
  assert.equal(new Set(STOPS.map(({ id }) => id)).size, 12);
  for (const depth of ["3", "5", "100"]) assert.ok(STOPS.some(({ settings }) => settings.max_depth === depth));
});

test("a stop replaces what ends the recursion and keeps the rest", () => {
  const [deep] = STOPS.filter(({ id }) => id === "depth-100");
  assert.deepEqual(settingsOf(deep, { width: "320", accuracy: "proved:2", min_weight: "0.1" }, "double"), { width: "320", precision: "double", accuracy: "fixed", max_depth: "100" });
  const [double] = STOPS.filter(({ id }) => id === "proved-0-double");
  assert.equal(settingsOf(double, {}, "single").precision, "double", "its own precision wins");
});

test("settings become what the scene says", () => {
  assert.deepEqual(edits({ accuracy: "proved:0", min_weight: "0.5" }), [["/render/accuracy", { proved: { max_codes: 0 } }]]);
  assert.deepEqual(edits({ accuracy: "fixed", max_depth: "3", antialias: "false", samples: "4", precision: "double" }), [
    ["/render/accuracy", { fixed: {} }], ["/render/max_depth", 3], ["/render/samples", 4], ["/render/antialias", false], ["/render/precision", "double"],
  ]);
  assert.deepEqual(accuracyOf("statistical:2,0.99"), { statistical: { half_width: 2, confidence: 0.99 } });
  assert.deepEqual(accuracyOf("time:33"), { time: { ms: 33 } });
});

test("parameters become JSON", () => {
  assert.deepEqual(typed({ width: "320", antialias: "false", accuracy: "time:33", bits: "8" }), { width: 320, antialias: false, accuracy: "time:33", bits: "8" });
});

test("the finest is the closest to recursion without end; samples are another matter", () => {
  assert.equal(finest(["time-300", "depth-3", "statistical-2"]).id, "time-300");
  assert.equal(finest(["proved-0", "depth-100"]).id, "proved-0");
  assert.equal(finest([]), null);
});

/** @param {Generator} run */
function result(run) {
  for (;;) {
    const { done, value } = run.next();
    if (done) return value;
  }
}

test("metrics are those of the definition, also across slices", () => {
  const pixels = 900_001;
  const a = new Uint8ClampedArray(pixels * 4).fill(100);
  const b = a.slice();
  b[4 * 800_000 + 1] = 180;
  for (let i = 0; i < 2000; i += 1) b[4 * i] = 103;
  const found = result(measure(a, b, 1000));
  assert.deepEqual([found.max, found.p999, found.worst], [80, 3, { x: 0, y: 800 }]);
  assert.equal(found.identical, (pixels - 2001) / pixels);
  assert.ok(Math.abs(found.rms - Math.sqrt((80 ** 2 + 2000 * 9) / (3 * pixels))) < 1e-12);
  assert.deepEqual(result(measure(a, a, 1000)), { max: 0, p999: 0, rms: 0, identical: 1, worst: { x: 0, y: 0 } });
});

test("a difference is opaque, and its gain stops at white", () => {
  assert.deepEqual([...difference(Uint8ClampedArray.of(10, 20, 30, 255), Uint8ClampedArray.of(12, 20, 90, 255), 16)], [32, 0, 255, 255]);
});

test("linear light becomes sRGB codes", () => {
  const floats = { width: 1, height: 2, channels: 3, values: Float32Array.of(0, 0.2158605, 1, 4, -1, 0.0005) };
  assert.deepEqual([...exposed(floats, 0)], [0, 128, 255, 255, 255, 0, 2, 255]);
  assert.deepEqual([...exposed(floats, -1)].slice(0, 3), [0, 92, 188]);
});
