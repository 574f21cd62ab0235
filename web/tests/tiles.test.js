import assert from "node:assert/strict";
import { test } from "node:test";
import { inSight, within } from "../app/tiles.js";

const size = { width: 960, height: 540 };
const view = { left: 0, top: 0, scale: 2, width: 1920, height: 1080 };
const near = { x: 0, y: 0 };

test("tiles of any edge cover the view, the nearest first", () => {
  for (const [edge, count] of [[512, 12], [256, 40], [128, 135]]) {
    const places = inSight(view, size, 1, near, edge);
    assert.equal(places.length, count);
    assert.deepEqual([places[0].name, new Set(places.map(({ name }) => name)).size], ["1/0/0", count]);
  }
  const inside = inSight({ ...view, left: -1024, width: 100, height: 100 }, size, 1, near, 256);
  assert.deepEqual(inside.map(({ name }) => name), ["1/4/0"]);
});

test("smaller tiles lie where a larger one does, and none beyond the picture", () => {
  const place = (column, row) => ({ level: 1, column, row, name: `1/${column}/${row}` });
  assert.deepEqual(within(place(1, 1), 512, 512, size), ["1/1/1"]);
  assert.deepEqual(within(place(1, 1), 512, 256, size), ["1/2/2", "1/3/2", "1/2/3", "1/3/3"]);
  // 1920 x 1080 pixels: the last tile of 512 has 384 x 56.
  assert.deepEqual(within(place(3, 2), 512, 256, size), ["1/6/4", "1/7/4"]);
  assert.deepEqual(within(place(3, 2), 512, 128, size), ["1/12/8", "1/13/8", "1/14/8"]);
  const all = inSight(view, size, 1, near, 512).flatMap((of) => within(of, 512, 128, size));
  assert.deepEqual(all.sort(), inSight(view, size, 1, near, 128).map(({ name }) => name).sort());
});
