import assert from "node:assert/strict";
import { test } from "node:test";
import { scan } from "../app/pointers.js";
import { fixOf, isOfText, lineOf, placeOf, rangeOf, wordsOf } from "../app/problems.js";

const text = '{ "größe 😀": 1,\n  "camera": { "pinhol": {} },\n  "a": "glas" }';
const syntax = scan(text);
const cut = ({ from, to }) => text.slice(from, to);

test("bytes become places", () => {
  const bytes = new TextEncoder().encode('{ "größe 😀": ').length;
  assert.equal(text[placeOf(text, 1, bytes + 1)], "1");
  assert.equal(placeOf(text, 9, 1), text.length);
  assert.equal(lineOf(text, text.indexOf("pinhol")), 2);
});

test("unknown keys are underlined and mended, values likewise", () => {
  const key = { pointer: "#/camera/pinhol", code: "unknown-key", detail: 'no such kind "pinhol"; did you mean "pinhole"?', line: 2, column: 15 };
  assert.equal(cut(rangeOf(text, syntax, key)), '"pinhol"');
  const { from, to, insert } = fixOf(syntax, key);
  assert.deepEqual([text.slice(from, to), insert], ['"pinhol"', '"pinhole"']);
  const value = { pointer: "#/a", code: "unknown-reference", detail: 'no material "glas"; did you mean "glass"?', line: 3, column: 8 };
  assert.equal(cut(fixOf(syntax, value)), '"glas"');
  assert.equal(fixOf(syntax, { ...value, detail: 'no material "glas"' }), null);
});

test("a problem of a setting has no place in the text, but words", () => {
  const setting = { parameter: "samples", code: "out-of-range", detail: "expected a whole number" };
  assert.equal(isOfText(setting), false);
  assert.equal(wordsOf(setting), "samples: expected a whole number");
  assert.ok(isOfText({ pointer: "", code: "x", detail: "" }), "the whole scene is a place, too");
});

test("without a node the line and column count", () => {
  const nff = "from 0 0 1\nfoo bar";
  assert.deepEqual(rangeOf(nff, { nodes: new Map(), root: null, error: null }, { pointer: "", code: "x", detail: "", line: 2, column: 5 }), { from: 15, to: 18 });
});
