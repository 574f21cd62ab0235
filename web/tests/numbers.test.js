import assert from "node:assert/strict";
import test from "node:test";
import { bent, earlyPoint, front, layout, nameOf, ofOneSize, pointOf, queryOf, ticks } from "../app/pareto.js";
import { readPfm } from "../app/panels/pfm.js";
import { along, at, colored, histogram, ramp, scaleOf } from "../app/ramps.js";

function pfm(kind, width, height, values, little = true) {
  const head = new TextEncoder().encode(`${kind}\n${width} ${height}\n${little ? "-1.0" : "1.0"}\n`);
  const buffer = new ArrayBuffer(head.length + values.length * 4);
  new Uint8Array(buffer).set(head);
  const view = new DataView(buffer, head.length);
  values.forEach((value, i) => view.setFloat32(4 * i, value, little));
  return buffer;
}

test("a float map has its rows from the top down, in both orders of bytes", () => {
  for (const little of [true, false]) {
    assert.deepEqual([...readPfm(pfm("Pf", 2, 2, [3, 4, 1, 2], little)).values], [1, 2, 3, 4]);
  }
  const colors = readPfm(pfm("PF", 1, 2, [4, 5, 6, 1, 2, 3]));
  assert.deepEqual([...colors.values], [1, 2, 3, 4, 5, 6]);
});

test("a float map that is cut off, or none, is refused", () => {
  const whole = pfm("PF", 2, 2, new Array(12).fill(0));
  assert.throws(() => readPfm(whole.slice(0, -1)), /not a whole PFM/);
  assert.throws(() => readPfm(new TextEncoder().encode('{"type":"about:blank"}').buffer), /not a whole PFM/);
  assert.throws(() => readPfm(pfm("Pf", 1e9, 1e9, [])), /not a whole PFM/);
});

test("ramps go from dark to bright, ever brighter", () => {
  for (const name of ["cividis", "viridis"]) {
    const colors = ramp(name);
    const bright = Array.from({ length: 256 }, (_, i) => 0.2126 * colors[3 * i] + 0.7152 * colors[3 * i + 1] + 0.0722 * colors[3 * i + 2]);
    for (let i = 8; i < 256; i += 8) assert.ok(bright[i] > bright[i - 8], `${name} at ${i}`);
  }
});

test("a scale leads there and back, and clips one of fifty at each end", () => {
  const values = Float32Array.from({ length: 1000 }, (_, i) => i + 1);
  for (const isLogarithmic of [false, true]) {
    const scale = scaleOf(values, { isLogarithmic, isClipped: true });
    assert.deepEqual([scale.low, scale.high], [21, 981]);
    for (const part of [0, 0.25, 1]) assert.ok(Math.abs(along(scale, at(scale, part)) - part) < 1e-6);
  }
  assert.equal(scaleOf(values, { isLogarithmic: false, isClipped: false }).high, 1000);
});

test("a map that is nearly empty keeps its few pixels, and an empty one has a scale", () => {
  const few = new Float32Array(1000);
  few[3] = 7;
  assert.equal(scaleOf(few, { isLogarithmic: false, isClipped: true }).high, 7);
  assert.ok(scaleOf(new Float32Array(4), { isLogarithmic: true, isClipped: true }).low > 0);
  assert.equal(histogram(few, { low: 0, high: 7, isLogarithmic: false }, 7)[6], 1);
});

test("pixels without a number let the picture through", () => {
  const pixels = colored(Float32Array.of(0, Number.POSITIVE_INFINITY, 1, Number.NaN), { low: 0, high: 1, isLogarithmic: false }, "cividis", true);
  assert.deepEqual([3, 7, 11, 15].map((i) => pixels[i]), [0, 0, 255, 0]);
});

test("the front holds what no other beats, and nothing else", () => {
  let state = 7;
  const random = () => (state = (state * 16807) % 2147483647) / 2147483647;
  const points = Array.from({ length: 60 }, () => ({ ms: Math.ceil(random() * 20), error: Math.ceil(random() * 20) }));
  const found = front(points);
  const beats = (a, b) => a.ms <= b.ms && a.error <= b.error && (a.ms < b.ms || a.error < b.error);
  points.forEach((point, i) => {
    const isBeaten = points.some((of) => beats(of, point));
    const isTwin = found.some((of) => points[of].ms === point.ms && points[of].error === point.error);
    assert.equal(!isBeaten, isTwin, `point ${i}`);
  });
});

test("a point that is still measured has what the service knows of it", () => {
  const point = earlyPoint({ part: "choices", index: 0, settings: { max_depth: 3, min_weight: 0.001 }, time_ms: 2, rays: { camera: 4, dropped: 9 }, proved_codes: 7, error: { max_codes: 9, p999_codes: 8, identical: 0.5 } });
  assert.deepEqual([point.name, point.ms, point.rays, point.errors.p999, point.proved], ["depth 3", 2, 4, 8, 7]);
  assert.ok(Number.isNaN(point.errors.flip));
});

test("points that are still measured are compared on pictures of one size", () => {
  const small = [1, 2, 3].map((index) => ({ index, width: 10, height: 10 }));
  const large = (count) => small.slice(0, count).map(({ index }) => ({ index, width: 20, height: 20 }));
  assert.deepEqual(ofOneSize([]), []);
  assert.deepEqual(ofOneSize([...small, ...large(1)]), small);
  assert.deepEqual(ofOneSize([...small, ...large(2)]), large(2));
});

test("settings of a trade-off become the parameters of a request", () => {
  assert.deepEqual(queryOf({ max_depth: null, min_weight: 0.001, max_codes: 0, samples: 1, antialias: true, precision: "double" }), {
    accuracy: "proved:0", min_weight: "0.001", samples: "1", antialias: "true", precision: "double",
  });
  assert.equal(queryOf({ max_depth: 3, samples: 1 }).accuracy, "fixed");
  assert.equal(nameOf({ max_depth: 100, min_weight: 0.1, samples: 4, antialias: true, precision: "double" }), "depth 100, weight 0.1, 4 samples, antialiased, double");
});

test("the plot holds all points within its frame, also those without error or bound", () => {
  const codes = (max) => ({ codes: { error: { max, p999: max }, identical: 1 }, rms_codes: max / 3, flip: { mean: max / 255 } });
  const choices = [3, 30, 300].map((ms, i) => ({ name: `${ms}`, settings: {}, request_ms: ms, rays: { camera: 5, dropped: 9 }, difference: codes([255, 1, 0][i]), proved_codes: [null, 2, 0][i] }));
  const points = choices.map(pointOf);
  assert.deepEqual(points.map(({ rays }) => rays), [5, 5, 5]);
  const frame = { width: 340, height: 220, left: 30, right: 10, top: 10, bottom: 24 };
  for (const error of ["p999", "max", "rms", "flip"]) {
    const plot = layout(points, error, frame);
    for (const { x, y } of plot.points) assert.ok(x >= 30 && x <= 330 && y >= 10 && y <= 196, `${error}: ${x}, ${y}`);
    assert.deepEqual(plot.front, [0, 1, 2]);
    assert.ok(plot.times.length >= 2 && plot.errors.length >= 3);
  }
  assert.equal(bent(0, 1), 0);
  assert.ok(ticks(0.2, 5000, 6).length <= 6);
});
