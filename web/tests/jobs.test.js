import assert from "node:assert/strict";
import test from "node:test";
import { after, ago, filterOf, inside, labelsOf, nameOf, stateWords, submission, visible, withFilter } from "../app/panels/jobs-model.js";

const job = (id, change = {}) => ({ id, state: "running", progress: { fraction: 0.25, tiles_done: 5, tiles_total: 20, rays: 0 }, position: null, eta_ms: 900, labels: [], ...change });

test("events change what they are about, and ask for the list where they cannot", () => {
  const jobs = [job("a"), job("b")];
  const next = after(jobs, "tile", { job: "b", tiles_done: 10 });
  assert.deepEqual(next.map(({ progress }) => progress.fraction), [0.25, 0.5]);
  assert.equal(jobs[1].progress.fraction, 0.25, "the old list is as it was");
  assert.equal(after(jobs, "succeeded", { job: "a" }), null);
  assert.equal(after(jobs, "created", { job: "c" }), null);
  assert.equal(after(jobs, "snapshot", { job: "a", state: "canceled" }), null);
  assert.equal(after(jobs, "tile", { job: "unknown" }), jobs);
});

test("progress never goes back", () => {
  const [next] = after([job("a")], "snapshot", { job: "a", state: "running", tiles_done: 2, tiles_total: 20 });
  assert.equal(next.progress.fraction, 0.25);
});

test("names and states in words", () => {
  assert.equal(nameOf(job("0123456789ab")), "job 6789ab");
  assert.equal(nameOf(job("a", { labels: ["\u202Egnp.exe\u0000"] })), "\ufffdgnp.exe\ufffd");
  assert.equal(visible("Glas für März 🂡"), "Glas für März 🂡");
  assert.equal(stateWords(job("a", { state: "queued", position: 1 })), "next in line");
  assert.equal(stateWords(job("a", { state: "queued", position: 4 })), "3 ahead");
  assert.equal(stateWords(job("a", { progress: { fraction: 0.999 } })), "99 %");
  assert.equal(ago(61_000), "1 min ago");
});

test("labels are what the service takes: 16 of 64 letters, none twice, none empty", () => {
  assert.deepEqual(labelsOf(" night, ,day,night "), ["night", "day"]);
  assert.equal(Array.from(labelsOf("🂡".repeat(100))[0]).length, 64);
  assert.equal(labelsOf(Array.from({ length: 40 }, (_, i) => i).join()).length, 16);
});

test("a submission holds the scene as it is written", () => {
  const scene = '{\n  "version": 1 }\n';
  const body = submission(scene, { settings: { width: 8 }, labels: ["a\"b"] });
  assert.ok(body.includes(scene.trim()));
  assert.deepEqual(JSON.parse(body), { scene: { version: 1 }, settings: { width: 8 }, labels: ['a"b'] });
});

test("a filter goes into an address and comes back, and nonsense does not", () => {
  const url = withFilter(new URL("http://host/studio?x=1#z=abc"), { state: "failed", label: "a&b" });
  assert.equal(url.hash, "#z=abc");
  assert.deepEqual(filterOf(url), { state: "failed", label: "a&b" });
  assert.equal(withFilter(url, { state: "", label: "" }).search, "?x=1");
  assert.deepEqual(filterOf(new URL("http://host/studio?state=toString&label=")), { state: "", label: "" });
});

test("a picture of another shape lies in the middle of a canvas", () => {
  assert.deepEqual(inside({ width: 100, height: 100 }, { width: 176, height: 88 }), { x: 44, y: 0, w: 88, h: 88 });
  assert.deepEqual(inside({ width: 200, height: 50 }, { width: 100, height: 100 }), { x: 0, y: 37.5, w: 100, h: 25 });
});
