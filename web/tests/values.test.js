import assert from "node:assert/strict";
import { test } from "node:test";
import { fromHex, scrubbed, toHex } from "../app/values.js";

test("a step is one of the last digit; whole numbers below 10 get a decimal", () => {
  assert.equal(scrubbed("1", 1), "1.1");
  assert.equal(scrubbed("1.4", -2), "1.2");
  assert.equal(scrubbed("0.08", 1), "0.09");
  assert.equal(scrubbed("540", 1), "541");
  assert.equal(scrubbed("16384", 1), "16484");
  assert.equal(scrubbed("0.1", -1), "0");
  assert.equal(scrubbed("7", 0), "7");
  assert.equal(scrubbed("x", 1), "x");
  assert.ok(!Object.is(Number(scrubbed("-0.1", 1)), -0));
});

test("colors there and back", () => {
  for (const hex of ["#000000", "#ffffff", "#cc8844", "#0a141e"]) assert.equal(toHex(fromHex(hex)), hex);
  assert.equal(toHex(0.5), "#bcbcbc");
  assert.equal(toHex([3, 0, 0]), "#ff0000");
  assert.equal(toHex("#ABCDEF"), "#abcdef");
  for (const wrong of [null, [1, 2], "#12", [0, 0, -1], {}]) assert.equal(toHex(wrong), null);
});
