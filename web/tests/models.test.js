import assert from "node:assert/strict";
import { test } from "node:test";
import { laidOut, modelType, placed, reasonOf } from "../app/scenes.js";

test("models are told by their names, else by how they begin", () => {
  for (const [name, type] of [["Box.GLB", "model/gltf-binary"], ["a.b.gltf", "model/gltf+json"], ["a.obj", "model/obj"], ["a.stl", "model/stl"], ["a.ply", "model/ply"]]) assert.equal(modelType(name, ""), type);
  const any = "application/octet-stream";
  for (const start of ["glTF\u0002\0\0\0", "ply\r\nformat", "\n solid cube\n", '{ "scenes": [], "asset": { "version": "2.0" } }', "# by Blender\n\nmtllib a.mtl\n", "v -1.0 2 3\nf 1 1 1", "o cube\n", "FBX\0"]) assert.equal(modelType("download", start), any, start);
  for (const [name, start] of [
    ["scene.json", '{ "version": 1, "objects": [{ "model": { "asset": "sha256:00" } }] }'], ["a.nff", "v\nfrom 0 0 5\nat 0 0 0"], ["balls", "# v 1 2 3\ns 0 0 0 1\n"],
    ["constructor", "{}"], ["x.toString", "{}"], ["glb", ""], ["blank", `${"\n".repeat(60_000)}{}`],
  ]) assert.equal(modelType(name, start), null, name);
});

const floor = { mesh: { vertices: [[0, 0, 0]], faces: [], material: "floor", name: "floor" } };
const scene = {
  version: 1, camera: { pinhole: {} }, definitions: { mesh: [] }, film: { tone: "agx" }, image: { width: 512, height: 512 }, name: "a box",
  materials: { Red: { pbr: { base_color: [1, 0, 0] } }, floor: { pbr: { shadow_catcher: true } } },
  objects: [{ instance: { of: "mesh" } }, floor],
};

test("an asset takes the place of a model's shapes and materials, and the floor stays", () => {
  const of = placed(scene, "sha256:00");
  assert.deepEqual(of.objects, [{ model: { asset: "sha256:00" } }, floor]);
  assert.deepEqual(of.materials, { floor: { pbr: { shadow_catcher: true } } });
  assert.deepEqual(Object.keys(of), ["version", "image", "camera", "film", "name", "materials", "objects"]);
  // A scene with lamps of its file has no floor.
  assert.deepEqual(placed({ ...scene, objects: [floor], materials: { floor: { pbr: {} } } }, "sha256:00").objects, [{ model: { asset: "sha256:00" } }]);
});

test("a scene keeps the warnings about its view alone", () => {
  const said = (detail) => ({ code: detail.split(":")[0], detail });
  const all = ["assumed: exposure: -5.1 stops", "skipped: colors: of facets", "skipped: backs: nothing is seen"].map(said);
  assert.deepEqual(placed({ ...scene, import_warnings: all }, "sha256:00").import_warnings, [all[0], all[2]]);
});

test("a scene is laid out for people, and says the same", () => {
  const value = { version: 1, empty: {}, camera: { pinhole: { eye: [0, 1, 5] } }, objects: [{ mesh: { vertices: Array.from({ length: 40 }, (_, i) => [i, 0.1, -1e-9]) } }, { name: "a, b".repeat(40) }] };
  const text = laidOut(value);
  assert.deepEqual(JSON.parse(text), value);
  assert.ok(text.startsWith('{\n  "version": 1,\n  "empty": {},\n  "camera": { "pinhole": { "eye": [0, 1, 5] } },\n'), text.slice(0, 100));
  assert.ok(text.includes("\n          [3, 0.1, -1e-9],\n"));
});

test("what is wrong with a model is said without the words of a program", () => {
  const reason = (...errors) => reasonOf({ message: "the scene is not valid", errors });
  assert.equal(reason({ code: "missing-part", pointer: "#/buffers/0/uri", detail: '"a.bin" cannot be read: files are not read here.' }), 'it needs "a.bin". Open both together, or make one .glb of them');
  assert.equal(reason({ pointer: "#/accessors/0", detail: "there is no bufferView 0" }, {}, {}), "there is no bufferView 0, at accessors › 0, and 2 more");
  assert.equal(reason({ pointer: "#", detail: "this is JSON, not a model: read it as json (--input json; Content-Type: application/json)" }), "this is JSON, not a model: read it as json");
  assert.equal(reasonOf(new Error("it cannot be read")), "it cannot be read");
});
