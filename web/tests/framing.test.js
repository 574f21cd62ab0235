import assert from "node:assert/strict";
import { test } from "node:test";
import { fitted, framed, pixelAt, showing, sizeOf, sized, zoomWords, zoomed } from "../app/framing.js";

const size = { width: 960, height: 540 };
const room = { width: 800, height: 600 };

test("the point under the pointer stays, however often one zooms", () => {
  let view = fitted(room, size);
  const at = { x: 333, y: 300 };
  const before = { x: (at.x - view.left) / view.scale, y: (at.y - view.top) / view.scale };
  for (let i = 0; i < 40; i += 1) view = zoomed(view, size, 1.5, at.x, at.y);
  assert.equal(view.scale, 65_536);
  assert.ok(Math.abs((at.x - view.left) / view.scale - before.x) < 1e-6);
  assert.deepEqual(pixelAt(view, size, at.x, at.y), { x: Math.floor(before.x), y: Math.floor(before.y) });
});

test("a place of a link is shown as far as one can zoom, however large its numbers", () => {
  const view = framed(room, size, { x: 0.25, y: 0.5, scale: 2 });
  assert.deepEqual([view.scale, (400 - view.left) / 2, (300 - view.top) / 2], [2, 240, 270]);
  for (const frame of [{ x: 1e308, y: -1e308, scale: 1e308 }, { x: 0, y: 0, scale: 1e-308 }]) {
    const { scale, left, top } = framed(room, size, frame);
    assert.ok(scale > 0.1 && scale <= 65_536 && Number.isFinite(left) && Number.isFinite(top), JSON.stringify({ scale, left, top }));
  }
});

test("settings say how large a picture is, and another size takes the place of all of them", () => {
  assert.deepEqual(sizeOf({}, {}), { width: 960, height: 540 });
  assert.deepEqual(sizeOf({ width: "320" }, { width: 640, height: 400 }), { width: 320, height: 400 });
  assert.deepEqual(sizeOf({ size: "og" }, { width: 640, height: 400 }), { width: 1200, height: 630 });
  assert.deepEqual(sizeOf({ width: "301", dpr: "0.5" }, { width: 640, height: 400 }), { width: 151, height: 200 });
  assert.deepEqual(sized({ size: "og", dpr: "2", samples: "4" }, { width: 160, height: 84 }), { samples: "4", width: "160", height: "84" });
});

test("some of the picture stays in sight", () => {
  const view = zoomed(fitted(room, size), size, 1e-9, 0, 0);
  assert.ok(view.scale > 0.1);
  assert.equal(pixelAt(view, size, -5, 5), null);
});

test("a pixel that is out of sight is brought in, one in sight moves nothing", () => {
  const view = { ...room, scale: 10, left: 0, top: 0 };
  assert.equal(showing(view, size, { x: 20, y: 20 }), view);
  const moved = showing(view, size, { x: 200, y: 20 });
  assert.ok(moved.left + 201 * 10 <= 800 && moved.top === 0);
});

test("zoom in words", () => {
  assert.deepEqual([0.5, 1, 4.2, 16, 65_536].map(zoomWords), ["50 %", "100 %", "420 %", "× 16", "× 65,536"]);
});
