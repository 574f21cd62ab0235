import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { isColor, keysAt, meaningAt, template, valuesAt } from "../app/schema.js";

const root = JSON.parse(readFileSync(new URL("../../api/scene.schema.json", import.meta.url), "utf8"));
const names = (choices) => choices.map(({ name }) => name);

test("keys of a place, without those that are there", () => {
  const keys = names(keysAt(root, ["objects", "0", "sphere"], ["radius"]));
  assert.ok(keys.includes("center") && keys.includes("material") && !keys.includes("radius"));
  assert.ok(names(keysAt(root, [], ["version"])).includes("lights"));
  assert.ok(names(keysAt(root, ["objects", "0"], [])).includes("torus"));
  assert.deepEqual(keysAt(root, ["objects", "0"], ["sphere"]), [], "an object has one kind");
  assert.deepEqual(keysAt(root, ["no", "such"], []), []);
});

test("what is inserted is JSON with all that is required", () => {
  for (const { name, insert } of keysAt(root, ["objects", "0"], [])) assert.doesNotThrow(() => JSON.parse(insert), `${name}: ${insert}`);
  assert.deepEqual(JSON.parse(keysAt(root, ["objects", "0"], []).find(({ name }) => name === "sphere").insert), { center: [0, 0, 0], radius: 1 });
  assert.doesNotThrow(() => JSON.parse(template(root, root.properties.render)));
});

test("values: words, names of the scene, defaults", () => {
  assert.deepEqual(names(valuesAt(root, ["render", "shadows"], null)).toSorted(), ['"none"', '"opaque"', '"transmissive"']);
  assert.deepEqual(names(valuesAt(root, ["objects", "3", "sphere", "material"], { materials: { glass: {} } })), ['"glass"']);
  assert.ok(names(valuesAt(root, ["render", "antialias"], null)).includes("false"));
  assert.ok(names(valuesAt(root, ["camera"], null)).includes("pinhole"));
});

test("meanings have description, range and default", () => {
  const { title, about, range } = meaningAt(root, ["image", "width"]);
  assert.equal(title, "width");
  assert.match(about, /Pixels across/);
  assert.match(range, /1 to 16384 · default 960/);
  assert.ok(meaningAt(root, ["objects", "0", "sphere"]).about.length > 0);
});

test("colors are known by the schema", () => {
  assert.ok(isColor(root, ["background"]) && isColor(root, ["materials", "x", "diffuse"]));
  assert.ok(!isColor(root, ["camera", "pinhole", "eye"]));
});
