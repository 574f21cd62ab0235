import assert from "node:assert/strict";
import { test } from "node:test";
import { count, duration, reportOf } from "../app/report.js";

test("headers of a picture are read", () => {
  const report = reportOf(new Headers({
    "server-timing": 'scene;desc=hit, queue;dur=0.5, parse;dur=0.25, trace;dur=10, png;dur=1.25, refine;dur=4.000;desc="part of trace"',
    "render-rays": "camera=10, shadow=20",
    "render-error": "proved=1, identical=0.982, estimated=0.4",
    "render-plan": "shadows, reflection",
    "repr-digest": "sha-256=:AAH/:",
    "content-length": "12",
  }));
  assert.equal(report.ms, 12);
  assert.equal(report.totalRays, 30);
  assert.deepEqual([report.proved, report.identical, report.estimated], [1, 0.982, 0.4]);
  assert.deepEqual(report.plan, ["shadows", "reflection"]);
  assert.equal(report.digest, "0001ff");
  const unproved = reportOf(new Headers({ "render-error": 'proved=?0, why="12 pixels, interpolated"' }));
  assert.deepEqual([unproved.proved, unproved.why], [null, "12 pixels, interpolated"]);
});

test("numbers for people", () => {
  assert.deepEqual([0.44, 44.2, 1300, 12_345, 125_000, 3_700_000].map(duration), ["0.4 ms", "44 ms", "1.3 s", "12 s", "2 min 5 s", "1 h 1 min"]);
  assert.deepEqual([812, 9_999, 13_400, 2_100_000, 13_402_283].map(count), ["812", "9999", "13 k", "2.1 M", "13 M"]);
});
