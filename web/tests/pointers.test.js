import assert from "node:assert/strict";
import { test } from "node:test";
import { editOf, nodeAt, nodeOf, objectOf, plain, scan, valueAt, written } from "../app/pointers.js";

const text = `{
  "name": "a \\"b\\" / c",
  "objects": [
    { "sphere": { "center": [0, 1.5e0, -2], "radius": 1 } }
  ]
}`;
const apply = (of, change) => of.slice(0, change.from) + change.insert + of.slice(change.to);

test("every value has its place", () => {
  const { nodes, error } = scan(text);
  assert.equal(error, null);
  const value = JSON.parse(text);
  for (const [pointer, node] of nodes) assert.deepEqual(JSON.parse(text.slice(node.from, node.to)), valueAt(value, pointer), pointer);
  assert.ok(nodes.has("/objects/0/sphere/center/2"));
});

test("what is before a mistake keeps its place", () => {
  for (let end = 0; end < text.length; end += 1) {
    const { error, nodes } = scan(text.slice(0, end));
    assert.ok(error, `cut at ${end}`);
    if (end > 40) assert.ok(nodes.has("/name"));
  }
  assert.equal(scan('{ "a": 1, }').error.detail, "there is nothing after this comma");
  assert.equal(scan('{ "a": 1 } x').error.detail, "there is something after the end");
  assert.equal(scan('{ "a": tru }').error.detail, "a value is missing here");
  assert.ok(scan("[".repeat(100_000)).error, "deep texts end");
});

test("places have their innermost value", () => {
  const syntax = scan(text);
  assert.equal(nodeAt(syntax, text.indexOf("1.5")).pointer, "/objects/0/sphere/center/1");
  assert.equal(nodeAt(syntax, text.indexOf('"radius"') + 2).pointer, "/objects/0/sphere/radius");
  assert.equal(nodeOf(syntax, "#/objects/0/sphere/material").pointer, "/objects/0/sphere");
  assert.equal(objectOf("/objects/0/sphere/radius"), "/objects/0");
  assert.equal(objectOf("/camera"), null);
  assert.equal(plain("#/materials/a%20b"), "/materials/a b");
});

test("edits change one value or add a key", () => {
  const edited = (pointer, value) => JSON.parse(apply(text, editOf(text, scan(text), pointer, value)));
  assert.equal(edited("/objects/0/sphere/radius", 2).objects[0].sphere.radius, 2);
  assert.equal(edited("/objects/0/sphere/material", "glass").objects[0].sphere.material, "glass");
  assert.deepEqual(edited("/render/accuracy", { proved: { max_codes: 0 } }).render, { accuracy: { proved: { max_codes: 0 } } });
  assert.equal(apply("{}", editOf("{}", scan("{}"), "/a~1b", 1)), '{ "a/b": 1 }');
  assert.equal(editOf("[1]", scan("[1]"), "/x", 1), null);
  assert.equal(written({ a: [1, { b: null }], c: {} }), '{ "a": [1, { "b": null }], "c": {} }');
});

test("a mesh does not give each number a node", () => {
  const mesh = JSON.stringify({ objects: [{ mesh: { vertices: Array.from({ length: 20_000 }, (_, i) => [i, i, i]) } }] });
  assert.ok(scan(mesh).nodes.size < 2000);
});
