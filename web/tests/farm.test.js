import assert from "node:assert/strict";
import { test } from "node:test";
import { age, alarmsOf, sentenceOf, tilesPerSecond } from "../app/panels/farm-model.js";

const calm = {
  connected: true,
  slots: 8,
  busy: 0,
  nodes: { ready: 2, draining: 0, excluded: 0 },
  backlog_seconds: { hi: 0, norm: 0, bulk: 0 },
  done: { pieces: 0, tiles: 100, failures: 0 },
  trouble: { sent_again: 0, rendered_twice: 0, dead_letters: 0, determinism_alarms: 0, queue_full: 0, broker_errors: 0 },
  each: null,
};

test("a farm in a sentence", () => {
  assert.equal(sentenceOf(calm), "0 of 8 slots are busy, on 2 nodes.");
  assert.equal(sentenceOf({ ...calm, slots: 1, busy: 1, nodes: { ...calm.nodes, ready: 1 } }), "1 of 1 slot is busy, on 1 node.");
  assert.equal(sentenceOf({ ...calm, nodes: { ...calm.nodes, ready: 0 } }), "No node takes work.");
});

test("only what somebody should look after is an alarm", () => {
  assert.deepEqual(alarmsOf(calm), []);
  assert.deepEqual(alarmsOf({ ...calm, nodes: { ...calm.nodes, ready: 0 } }), [], "a farm may have scaled to nothing");
  const lost = { ...calm, connected: false, nodes: { ready: 0, draining: 0, excluded: 1 }, backlog_seconds: { hi: 0, norm: 3, bulk: 0 }, trouble: { ...calm.trouble, determinism_alarms: 2, dead_letters: 1 } };
  assert.equal(alarmsOf(lost).length, 5);
  assert.match(alarmsOf(lost)[1], /different pixels of 2 tiles/);
});

test("a rate needs two answers", () => {
  const now = { at: 4000, farm: calm };
  const before = { at: 2000, farm: { ...calm, done: { ...calm.done, tiles: 60 } } };
  assert.equal(tilesPerSecond(null, now), null);
  assert.equal(tilesPerSecond(before, now), 20);
  assert.equal(tilesPerSecond(now, { ...before, at: 6000 }), 0, "a node went");
});

test("ages", () => {
  assert.deepEqual([0.4, 59, 60, 3600, 200_000].map(age), ["0 s", "59 s", "1 min", "1 h", "2 d"]);
});
