import assert from "node:assert/strict";
import { test } from "node:test";
import { rowsOf, sentenceOf, totalsOf } from "../app/panels/plan-rows.js";
import { without } from "../app/panels/plan-without.js";

const effect = (name, ms, rays = 100, more = {}) => ({ effect: name, state: "on", reason: "", because: [], est: { rays, rays_ci: [rays / 2, rays * 2], ms }, ...more });
const depth = { requested: null, proved_sufficient: null, why: "", because: [], reached: null };
const plan = {
  effects: [effect("shadows", 5), effect("ambient_light", null, 0), effect("gloss", 40, 1000), { ...effect("fog", 0, 0), state: "off" }, { ...effect("bump_mapping", 0, 0), state: "removed" }],
  estimate: { ms: 50, ms_ci: [20, 80], rays: 2000, rays_ci: [1000, 4000] }, depth,
};
const measured = {
  ...plan,
  effects: [effect("shadows", 5, 100, { act: { rays: 420, share_ms: 21, saves_ms: 30 } }), effect("gloss", 40, 1000, { act: { rays: 900, share_ms: 36, saves_ms: null } })],
  actual: { wall_ms: 90, phases_ms: { trace: 81 }, rays: { camera: 500, shadow: 420, reflected: 900, transmitted: 0, gathered: 0, dropped: 7 } },
  depth: { ...depth, reached: 4 },
};

test("rows are those that are on or removed, the longest first", () => {
  const rows = rowsOf(plan);
  assert.deepEqual(rows.map(({ name }) => name), ["gloss", "shadows", "ambient_light", "bump_mapping"]);
  assert.deepEqual([rows[0].low, rows[0].high, rows[0].title], [20, 80, "Gloss"]);
  assert.equal(rows[2].ms, null);
});

test("what was measured stands beside the estimate, and says if it lies outside of the interval", () => {
  const [gloss, shadows] = rowsOf(plan, measured);
  assert.deepEqual([gloss.took, gloss.outside, shadows.took, shadows.outside], [36, "", 21, "4.2 times more"]);
  const [time, rays] = totalsOf(plan, measured);
  assert.deepEqual([time.actual, time.isOutside, rays.actual, rays.isOutside], ["81 ms", true, "1820", false]);
});

test("the plan in a sentence", () => {
  const plain = (...of) => sentenceOf(...of).replaceAll("\u00a0", " ");
  assert.equal(plain(plan, rowsOf(plan)), "3 effects are on. Gloss takes 80 % of 50 ms.");
  assert.equal(plain(plan, rowsOf(plan, measured), measured), "3 effects are on. Gloss takes 44 % of 90 ms. The longest chain had 4 rays.");
  const proved = { ...plan, effects: [effect("shadows", null, 0)], depth: { ...depth, proved_sufficient: 1 } };
  assert.equal(plain(proved, rowsOf(proved)), "1 effect is on. The picture should take 50 ms. Depth 1 is enough, proved.");
});

test("a scene without an effect asks for nothing of it, and is otherwise the same", () => {
  const scene = {
    ambient: 0.4, lights: [{ point: { position: [0, 1, 0], area: { disc: { radius: 1 } } } }],
    materials: { a: { roughness: 0.2, diffuse: { checker: { a: [1, 0, 0], b: 0, size: 1 } } }, b: { diffuse: 0.5 } },
    objects: [{ group: { objects: [{ sphere: { name: "motion" } }], motion: { translate: [1, 0, 0] } } }],
  };
  const before = JSON.stringify(scene);
  const text = (name, settings = {}) => JSON.parse(without(scene, settings, name)?.text ?? "null");
  assert.equal("roughness" in text("gloss").materials.a, false);
  assert.deepEqual(text("checker_texture").materials, { a: { roughness: 0.2, diffuse: [0.5, 0, 0] }, b: { diffuse: 0.5 } });
  assert.equal(text("soft_shadows").lights[0].point.area, undefined);
  assert.deepEqual(text("motion_blur").objects, [{ group: { objects: [{ sphere: { name: "motion" } }] } }]);
  assert.deepEqual(text("ambient_light").ambient, [0, 0, 0]);
  assert.equal(text("shadows").render.shadows, "none");
  assert.deepEqual(without(scene, { antialias: "true", samples: "4" }, "antialiasing").settings, { samples: "4" });
  assert.equal(without(scene, {}, "fog"), null);
  assert.equal(without(scene, {}, "hollow_bodies"), null);
  assert.equal(without(null, {}, "gloss"), null);
  assert.equal(JSON.stringify(scene), before);
});
