import assert from "node:assert/strict";
import test from "node:test";
import { colorOf, painted, unpacked } from "../app/panels/maps-objects.js";

test("runs become a number for each pixel", () => {
  const map = unpacked({ columns: 3, rows: 2, runs: [[0, 2], [2, 3], [1, 1]], objects: [] });
  assert.deepEqual([...map.values], [0, 0, 2, 2, 2, 1]);
});

test("the colors of neighbours differ, and nothing lets the picture through", () => {
  for (let n = 1; n < 40; n += 1) {
    const [a, b] = [colorOf(n), colorOf(n + 1)];
    assert.ok(a.every((value) => value >= 0 && value <= 255));
    assert.ok(a.reduce((sum, value, i) => sum + Math.abs(value - b[i]), 0) > 60, `${n}: ${a} and ${b}`);
  }
  assert.deepEqual([...painted(Float32Array.of(0, 1))].filter((_, i) => i % 4 === 3), [0, 255]);
});
