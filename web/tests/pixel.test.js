import assert from "node:assert/strict";
import { test } from "node:test";
import { partsOf } from "../app/panels/pixel-icicle.js";
import { outlineOf } from "../app/panels/pixel-objects.js";
import { runsOf } from "../app/panels/pixel-outside.js";
import { cameraOf, pathOf } from "../app/panels/pixel-projection.js";
import { addUp, codeOf, codesOf, grow, mediaOf, oddOne, rowsOf, short, targetOf } from "../app/panels/pixel-rays.js";

const ray = (id, parent, kind, contribution, more = {}) => ({
  id, parent, kind, depth: 1, weight: [1, 1, 1], contribution, origin: [0, 0, 0], direction: [0, 0, 1], media: [], ...more,
});

/** One sample in single precision, whose value needs the rounding errors of the additions. */
function single() {
  const tiny = Math.fround(2 ** -25);
  return {
    pixel: [0, 0], precision: "single", samples: 1, codes: [0, 0, 0], codes_off: 0, raised: [0, 0, 0], lacking: [0, 0, 0], truncated: false,
    value: [1 + 2 * tiny, 0.5, 0],
    rays: [ray(0, null, "camera", [1, 0.5, 0]), ray(1, 0, "shadow", [tiny, 0, 0], { light: 0, transmittance: [0, 0, 0] }), ray(2, 0, "reflected", [tiny, 0, 0])],
  };
}

test("contributions add up in single precision together with their rounding errors", () => {
  const { sum, verdict } = addUp(grow(single()));
  assert.equal(verdict, "exact");
  assert.deepEqual(sum, [1 + 2 ** -24, 0.5, 0]);
});

test("contributions that are far smaller than the sum count with their errors", () => {
  // A double holds no sum of 1 and 2^-60; the errors of single precision do.
  const tree = { ...single(), value: [1 + 2 ** -52, 0, 0], rays: [ray(0, null, "camera", [1, 0, 0]), ...Array.from({ length: 256 }, (_, at) => ray(at + 1, 0, "shadow", [2 ** -60, 0, 0]))] };
  assert.equal(addUp(grow(tree)).verdict, "exact");
});

test("a pixel that differs in its last bit is told apart", () => {
  const tree = single();
  tree.value[1] += 2 ** -53;
  assert.equal(addUp(grow(tree)).verdict, "off");
  assert.equal(addUp(grow({ ...single(), truncated: true })).verdict, "truncated");
});

test("samples are added in halves of a batch, and what was raised on top", () => {
  // In another order of additions the three small ones would be lost.
  const small = 2 ** -53;
  const lights = [1, small, small, small];
  const rays = lights.map((light, id) => ray(id, null, "camera", [light / 4, 0, 0]));
  const tree = { ...single(), precision: "double", samples: 4, raised: [0, 0.25, 0], value: [(1 + (small + small)) / 4, 0.25, 0], rays };
  const { verdict, samples } = addUp(grow(tree));
  assert.equal(verdict, "exact");
  assert.deepEqual(samples.map(([red]) => red), lights);
  assert.equal(oddOne(samples), 0);
  assert.equal(oddOne([[0, 0, 0], [0, 0, 0], [0, 0, 5]]), 2);
});

test("rows follow the branches, and stubs stand before what was followed", () => {
  const stub = { kind: "transmitted", weight: [0.1, 0.1, 0.1], why: "depth", codes: 2 };
  const tree = { ...single(), rays: [ray(0, null, "camera", [0, 0, 0], { not_followed: [stub] }), ray(1, 0, "reflected", [0, 0, 0]), ray(2, 1, "shadow", [0, 0, 0]), ray(3, 0, "shadow", [0, 0, 0])] };
  const grown = grow(tree);
  const all = rowsOf(grown, 0, new Set());
  assert.deepEqual(all.map((row) => [row.ray.id, row.stub !== null, row.level, row.place, row.siblings]), [[0, false, 1, 1, 1], [0, true, 2, 1, 3], [1, false, 2, 2, 3], [2, false, 3, 1, 1], [3, false, 2, 3, 3]]);
  assert.deepEqual(rowsOf(grown, 0, new Set([1])).map(({ ray: of }) => of.id), [0, 0, 1, 3]);
});

test("a chain of 100,000 rays has its rows", () => {
  const rays = Array.from({ length: 100_000 }, (_, id) => ray(id, id === 0 ? null : id - 1, "reflected", [0, 0, 0]));
  assert.equal(rowsOf(grow({ ...single(), rays }), 0, new Set()).length, 100_000);
});

test("names of what a ray ends at", () => {
  const hit = { t: 1, point: [0, 0, 0], normal: [0, 1, 0], object: "/objects/3", material: "default", entering: true };
  assert.deepEqual(targetOf(ray(0, null, "camera", [0, 0, 0], { hit })), { name: "object 3", pointer: "/objects/3" });
  assert.deepEqual(targetOf(ray(0, null, "camera", [0, 0, 0], { hit: { ...hit, name: "<b>", body: "/definitions/a~1b/0" } })), { name: "<b>", pointer: "/definitions/a~1b/0" });
  assert.deepEqual(targetOf(ray(0, null, "shadow", [0, 0, 0], { light: 2 })), { name: "light 2", pointer: "/lights/2" });
  assert.equal(targetOf(ray(0, null, "camera", [0, 0, 0])).name, "background");
});

test("media change where a ray passes a surface; empty space in a body is air", () => {
  const glass = [{ object: "/objects/0", ior: 1.5 }];
  const rays = [ray(0, null, "camera", [0, 0, 0]), ray(1, 0, "transmitted", [0, 0, 0], { media: glass }), ray(2, 1, "transmitted", [0, 0, 0], { media: [{ object: "/objects/1", ior: 1 }, ...glass] })];
  const grown = grow({ ...single(), rays });
  assert.deepEqual(rays.map((of) => mediaOf(grown, of, () => "glass")), [["air", "glass"], ["glass", "air"], ["air"]]);
});

test("numbers for people", () => {
  assert.deepEqual([0, 0.012345, 123456, 1.5e-7, 2e9].map((value) => short(value)), ["0", "0.0123", "123000", "1.50e-7", "2.00e9"]);
  assert.deepEqual([0, 1, 2, 255].map(codesOf), ["less than half a code", "at most 1 code", "at most 2 codes", "without a bound"]);
  assert.deepEqual([0, 0.2140411, 1, 7].map((value) => Math.round(codeOf(value))), [0, 127, 255, 255]);
});

test("parts of the icicle are as wide as their share", () => {
  const rays = [ray(0, null, "camera", [0.1, 0.1, 0.1]), ray(1, 0, "reflected", [0.3, 0.3, 0.3]), ray(2, 0, "shadow", [0.1, 0.1, 0.1])];
  const parts = partsOf(grow({ ...single(), rays }), 0, 0);
  assert.deepEqual(parts.map(({ id, from, width }) => [id, Math.round(from), Math.round(width)]).sort((a, b) => a[0] - b[0]), [[0, 0, 1000], [1, 0, 600], [2, 600, 200]]);
  assert.equal(Math.round(partsOf(grow({ ...single(), rays }), 0, 1.5)[0].width), 500);
});

test("points go to pixels and pixels to rays through the same points", () => {
  const view = { eye: [1, 2, 5], look_at: [0, 0.5, -1], up: [0.1, 1, 0] };
  const size = { width: 320, height: 200 };
  const cameras = { pinhole: { vfov_deg: 50 }, orthographic: { height: 4 }, fisheye: { fov_deg: 170 }, omnimax: { fov_deg: 160 }, panorama: {}, cylinder: {} };
  for (const [kind, more] of Object.entries(cameras)) {
    const camera = cameraOf({ camera: { [kind]: { ...view, ...more } } }, size);
    for (const at of [[160, 100], [200, 40], [120.5, 130.25]]) {
      const { origin, direction } = camera.ray(at);
      const there = camera.project(origin.map((value, c) => value + 3 * direction[c]));
      assert.ok(Math.hypot(there[0] - at[0], there[1] - at[1]) < 1e-9, `${kind} ${at} ${there}`);
    }
  }
  assert.equal(cameraOf({ camera: { pinhole: { eye: [0, 0, 0], look_at: [0, 1, 0] } } }, size), null);
  assert.equal(cameraOf({ camera: { pinhole: { eye: "x" } } }, size), null);
  assert.equal(cameraOf(null, size), null);
});

test("segments are cut where the eye is, and where a panorama ends", () => {
  const size = { width: 360, height: 180 };
  const view = { eye: [0, 0, 0], look_at: [0, 0, -1] };
  const pinhole = cameraOf({ camera: { pinhole: view } }, size);
  assert.deepEqual(pathOf(pinhole, [0, 0, 1], [1, 0, 2], 360), []);
  const [[from, to]] = pathOf(pinhole, [0, 0, -2], [1, 0, 2], 360);
  assert.deepEqual(from, [180, 90]);
  assert.ok(to[0] > 1e5);
  const panorama = cameraOf({ camera: { panorama: view } }, size);
  assert.equal(pathOf(panorama, [-1, 0, 1], [1, 0, 1], 360).length, 2);
});

test("hidden parts are runs", () => {
  assert.deepEqual(runsOf([true, true, false, true]), [{ from: 0, to: 0.5, isHidden: true }, { from: 0.5, to: 0.75, isHidden: false }, { from: 0.75, to: 1, isHidden: true }]);
  assert.equal(runsOf(undefined).length, 1);
});

test("outlines go around the cells of an object, of what holds it, and of its copies", () => {
  const ids = Int32Array.from([-1, 0, 0, -1, -1, 0, 0, 1, -1, -1, -1, -1]);
  const of = { columns: 4, rows: 3, step: 100, ids, pointers: ["/objects/0/group/objects/2", "/objects/1"], copies: [null, "/definitions/d"] };
  const [loop, ...others] = outlineOf(of, "/objects/0");
  assert.equal(others.length, 0);
  const xs = loop.map(([x]) => x);
  assert.ok(Math.min(...xs) > 90 && Math.max(...xs) < 310);
  assert.deepEqual(outlineOf(of, "/objects/0/group/objects/2/sphere"), [loop]);
  assert.deepEqual(outlineOf(of, "/objects/0/group/objects/1"), []);
  assert.equal(outlineOf(of, "/definitions/d/0").length, 1);
  assert.deepEqual(outlineOf(of, "/objects/10"), []);
});
