// What users do, against the real service.
import assert from "node:assert/strict";
import fs from "node:fs";
import path from "node:path";
import { after, before, test } from "node:test";
import { Client, Problem } from "../src/index.js";
import { ROOT, SCENE, busyScene, start } from "./service.js";

let service, client;
before(async () => { service = await start(); client = new Client(service.url); });
after(() => service.stop());

const problem = (slug, more = () => true) => (error) => error instanceof Problem && error.slug === slug && more(error);

test("a picture says what it cost and how accurate it is", async () => {
  const picture = await client.render(SCENE);
  assert.equal(picture.mediaType, "image/png");
  assert.deepEqual([...picture.bytes.subarray(1, 4)], [...Buffer.from("PNG")]);
  assert(picture.error.proved !== null && picture.error.identical > 0 && picture.rays.camera >= 48 * 32 && picture.effects.length);
  assert.deepEqual((await client.image(picture.imageId)).bytes, picture.bytes);
  assert((await client.render(SCENE)).cached && (await client.render(SCENE, { samples: 3 })).timing.trace > 0);
  assert.equal(picture.blob().type, "image/png");
  assert.deepEqual((await client.render(JSON.stringify(SCENE))).bytes, picture.bytes);
  assert.deepEqual((await client.render(new TextEncoder().encode(JSON.stringify(SCENE)))).bytes, picture.bytes);
});

test("linear light, tiles and NFF", async () => {
  const { width, height, channels, data } = (await client.render(SCENE, { format: "pfm" })).floats();
  assert.deepEqual([width, height, channels, data.length], [48, 32, 3, 48 * 32 * 3]);
  assert(Math.abs(data[0] - 0.3) < 1e-6 && Math.abs(data[2] - 0.8) < 1e-6, "the first pixel is the sky at the left top");
  const tile = (await client.tile(SCENE, [8, 4, 16, 12], { format: "pfm" })).floats();
  for (let x = 0; x < 16 * 3; x++) assert.equal(tile.data[x], data[4 * 48 * 3 + 8 * 3 + x]);
  const nff = new Blob(["v\nfrom 0 0 5\nat 0 0 0\nup 0 1 0\nangle 45\nhither 1\nresolution 16 16\nl 3 3 3\nf 1 0.5 0.2 0.8 0.2 10 0 1\ns 0 0 0 1\n"], { type: "text/x-nff" });
  assert.equal((await client.render(nff, { format: "pfm" })).floats().width, 16);
  await assert.rejects(client.jobs.submit(nff), TypeError);
  const model = new TextEncoder().encode("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  for (const sent of [model, model.buffer, new Blob([model]), new Blob([model], { type: "model/obj" })]) {
    assert.equal((await client.render(sent, { width: 20, height: 16, format: "pfm" })).floats().width, 20);
    await assert.rejects(client.jobs.submit(sent), TypeError);
  }
  const json = new TextEncoder().encode(JSON.stringify(SCENE));
  const { buffer } = new TextEncoder().encode(`no JSON${JSON.stringify(SCENE)}`), view = new DataView(buffer, "no JSON".length);
  for (const sent of [json, json.buffer, view, new Uint8ClampedArray(json), new Blob([json]), new Blob([json], { type: "application/json; charset=utf-8" })]) {
    assert.equal((await client.rays(sent, [{ origin: [0, 1, 5], direction: [0, 0, -1] }])).length, 1);
    assert((await client.render(sent)).bytes.length);
  }
});

test("turntables, sequences and assets", async () => {
  const size = { width: 24, height: 16 };
  const around = await client.turntable(SCENE, { count: 3, format: "gif", ...size });
  assert.deepEqual([around.mediaType, new TextDecoder().decode(around.bytes.subarray(0, 6))], ["image/gif", "GIF89a"]);
  assert.equal((await client.turntable(SCENE, { count: 4, sheet: [4, 1], ...size })).mediaType, "image/png");
  const job = await client.jobs.submit(SCENE, { frames: { count: 2, turntable: {} }, ...size });
  assert.equal((await job.wait()).mediaType, "image/apng");
  assert.deepEqual((await job.frames()).frames.map(({ number }) => number), [0, 1]);
  assert.equal((await job.frame(1)).mediaType, "image/png");
  for (const [format, type] of [["png", "image/apng"], ["webp", "image/webp"], ["gif", "image/gif"]]) {
    assert.equal((await job.animation({ format })).mediaType, type);
  }
  assert.equal((await job.sheet({ columns: 1 })).mediaType, "image/png");
  await assert.rejects(job.frame(2), problem("not-found"));

  const model = new TextEncoder().encode("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  const name = await client.assets.add(model);
  for (const same of [model.buffer, new DataView(model.buffer), new Blob([model])]) assert.equal(await client.assets.add(same), name);
  assert.deepEqual(await client.assets.missing([name, "0".repeat(64)]), ["0".repeat(64)]);
  const placed = { ...SCENE, objects: [...SCENE.objects, { model: { asset: name } }] };
  assert.notDeepEqual((await client.render(placed)).bytes, (await client.render(SCENE)).bytes);
  await client.assets.delete(name);
  assert.equal((await client.assets.missing([name])).length, 1);
});

test("questions about a scene", async () => {
  assert.deepEqual(await client.validate(SCENE), []);
  assert((await client.analyze(SCENE)).actual.rays.camera > 0 && (await client.explain(SCENE)).effects.length);
  assert((await client.tradeoff(SCENE, { seconds: 1 })).advice.length);
  assert.equal((await client.map(SCENE, "depth")).floats().width, 48);
  assert.deepEqual((await client.tree(SCENE, 20, 16)).pixel, [20, 16]);
  const hits = await client.rays(SCENE, [{ origin: [0, 1, 5], direction: [0, 0, -1] }, { origin: [0, 1, 5], direction: [0, 1, 0] }]);
  assert.deepEqual(hits.map(({ hit }) => hit), [true, false]);
  assert.equal((await client.addScene(SCENE, { zoom: 2 })).zoom, 2);
  assert.equal((await client.version()).name, "strahl");
  assert((await client.limits()).request);
});

test("a picture streams from coarse to fine", async () => {
  const passes = [], options = { width: 320, height: 200 };
  for await (const pass of client.stream(SCENE, options)) passes.push(pass);
  const last = passes.at(-1), whole = await client.render(SCENE, options);
  assert(passes.length > 1 && passes.every(({ scale, final }, i) => final === (i === passes.length - 1) && (!i || scale < passes[i - 1].scale)));
  assert.deepEqual(last.picture.bytes, whole.bytes);
  const { identical, ...told } = last.picture.error, { identical: rounded, ...said } = whole.error;
  assert(Math.abs(identical - rounded) < 0.001);
  assert.deepEqual([told, last.picture.imageId, last.picture.effects, last.report.cost.rays.camera], [said, whole.imageId, whole.effects, whole.rays.camera]);
  assert.deepEqual(passes[0].region, [0, 0, 320, 200]);
  for await (const _ of client.stream(busyScene("left"), { width: 1500, height: 1000, samples: 8 })) break;
  await assert.rejects(async () => { for await (const _ of client.stream("{}")); }, problem("invalid-scene"));
});

test("variations, comparisons, several settings", async () => {
  const { scene_id: base } = await client.addScene(SCENE);
  const moved = await client.render({ base, patch: { camera: { pinhole: { eye: [2, 1, 4] } } } });
  assert.deepEqual(moved.bytes, (await client.render({ ...SCENE, camera: { pinhole: { eye: [2, 1, 4], look_at: [0, 0.5, 0] } } })).bytes);
  assert.deepEqual(JSON.parse(await client.source(base)), SCENE);
  const rough = { scene: SCENE, settings: { antialias: false } };
  const far = await client.compare(rough, (await client.render(SCENE)).imageId);
  assert(!far.same && far.rms_codes > 0 && (await client.compare({ scene: SCENE }, { scene: SCENE })).same);
  assert.equal((await client.difference(rough, { scene: SCENE }, { format: "flip" })).floats().channels, 1);
  const several = await client.explainEach(SCENE, [{ max_depth: 1 }, { max_depth: 2 }]);
  assert.deepEqual(several.estimates.map(({ settings }) => settings.max_depth), [1, 2]);
  assert((await client.me()).needs_keys === false && (await client.queue()).threads >= 1);
});

test("events of all jobs", async () => {
  const stop = new AbortController(), seen = [];
  const following = (async () => { for await (const { name, data } of client.jobs.events({ label: "watched", signal: stop.signal })) {
    seen.push([name, data.job]);
    if (name === "removed") return;
  } })();
  // Once it tells of one of these, the stream is open.
  const ids = [];
  while (!seen.length && ids.length < 600) {
    ids.push((await client.jobs.submit(SCENE, { labels: ["watched"], width: 76 })).id);
    await new Promise((done) => setTimeout(done, 100));
  }
  const job = await client.jobs.submit(SCENE, { labels: ["watched"], width: 77 });
  await client.jobs.submit(SCENE, { width: 78 });
  await job.wait({ timeout: 120 });
  await job.delete();
  await following;
  const names = seen.filter(([, of]) => of === job.id).map(([name]) => name);
  assert(["created", "succeeded", "removed"].every((name) => names.includes(name)), JSON.stringify(seen));
  assert(seen.every(([, of]) => [...ids, job.id].includes(of)), JSON.stringify(seen));
});

test("mistakes have pointers, lines and columns, and names cannot control a terminal", async () => {
  const text = JSON.stringify({ ...SCENE, objects: [{ sphere: { center: [0, 0, 0], radius: -1, material: "rde" } }] }, null, 1);
  for (const ask of [() => client.validate(text), () => client.render(text), () => client.explain(text), () => client.jobs.submit(text)]) {
    await assert.rejects(ask, problem("invalid-scene", ({ mistakes }) => {
      const pointers = mistakes.map(({ pointer }) => pointer).sort();
      return pointers.join() === "/objects/0/sphere/material,/objects/0/sphere/radius" && mistakes.every(({ line, column }) => line > 0 && column > 0);
    }));
  }
  const hostile = "\u001b]0;owned\u0007\u001b[2J\u202e<img src=x onerror=alert(1)>";
  await assert.rejects(client.render({ ...SCENE, objects: [{ sphere: { center: [0, 0, 0], radius: 1, material: hostile } }] }),
    (error) => !/[\u0000-\u0009\u000b-\u001f\u007f-\u009f\u202e]/.test(error.message));
  await assert.rejects(client.render(SCENE, { samples: 0 }), problem("invalid-parameter", ({ mistakes }) => mistakes[0].parameter === "samples"));
  await assert.rejects(client.render(SCENE, { width: 4096, height: 4096 }), problem("cost-limit", ({ limit }) => limit.name === "max_pixels"));
});

test("a job from its submission to its picture", async () => {
  const job = await client.jobs.submit(busyScene("job"), { width: 256, height: 192, samples: 64, labels: ["mine"], priority: 70, format: "pfm" });
  assert.equal((await job.prioritize(71)).view.priority, 71);
  const seen = [];
  for await (const progress of job.progress()) seen.push(progress);
  assert(seen.length > 3 && seen.at(-1).state === "succeeded" && seen.at(-1).fraction === 1);
  assert(seen.every(({ fraction }, i) => !i || fraction >= seen[i - 1].fraction));
  const picture = await job.wait();
  assert.equal(picture.floats().width, 256);
  assert(job.view.report.cost.rays.camera > 0);
  assert.equal((await job.preview()).mediaType, "image/png");
  assert.equal((await job.tile([0, 0, 16, 16])).mediaType, "image/png");
  const listed = [];
  for await (const one of client.jobs.list({ label: "mine" })) listed.push(one.id);
  assert.deepEqual(listed, [job.id]);
  await assert.rejects(job.cancel(), problem("conflict"));
  await job.delete();
  await assert.rejects(client.jobs.get(job.id), problem("not-found"));
});

test("jobs that end otherwise", async () => {
  const job = await client.jobs.submit(busyScene("never"), { width: 2000, height: 1500, samples: 256 });
  await assert.rejects(job.wait({ timeout: 0.5 }), { name: "TimeoutError" });
  const told = [], stop = new AbortController();
  const onProgress = (progress) => {
    told.push(progress);
    stop.abort();
  };
  await assert.rejects(job.wait({ onProgress, signal: stop.signal }), { name: "AbortError" });
  assert(told.length);
  await job.cancel();
  await assert.rejects(job.wait({ timeout: 120 }), problem("job-failed"));
  const names = [];
  for await (const { name } of job.events()) names.push(name);
  assert.equal(names.at(-1), "canceled");
  const [first, second] = [await client.jobs.submit(SCENE, { idempotencyKey: "same" }), await client.jobs.submit(SCENE, { idempotencyKey: "same" })];
  assert.equal(first.id, second.id);
  for (const wrong of ["../livez", "", "a b", "%2e"]) await assert.rejects(client.jobs.get(wrong), TypeError);
});

test("pointers lead to the values in the scene", async () => {
  const name = 'grün "a" \\ b', ball = { sphere: { center: [0, 0, 0], radius: 1, material: name } };
  await assert.rejects(client.validate({ ...SCENE, materials: { [name]: { ior: -1 } }, objects: [ball] }),
    problem("invalid-scene", ({ mistakes }) => mistakes[0].pointer === `/materials/${name}/ior`));
});

test("warnings are the same in pictures and streams", async () => {
  const name = 'say "so" \\ b', ball = { sphere: { center: [0, 1, 0], radius: 1, material: name } };
  const scene = { ...SCENE, materials: { [name]: { diffuse: [9, 0, 0] } }, objects: [ball] };
  const { warnings } = await client.render(scene);
  assert(warnings[0].startsWith(`/materials/${name}/diffuse: `) && warnings[0].includes('"#rrggbb"'), warnings[0]);
  for await (const { final, picture } of client.stream(scene)) if (final) assert.deepEqual(picture.warnings, warnings);
});

test("times may have fractions, and no end", async () => {
  assert.equal((await new Client(service.url, { timeout: 2.01 }).version()).name, "strahl");
  for (const timeout of [Infinity, 1e9]) {
    const patient = new Client(service.url, { timeout });
    assert((await (await patient.jobs.submit(SCENE)).wait({ timeout })).bytes.length);
    for await (const { final } of patient.stream(SCENE)) if (final) break;
  }
  const job = await client.jobs.submit(busyScene("fraction"), { width: 2000, height: 1500, samples: 256 });
  for (const timeout of [0.1001, 0, -1]) await assert.rejects(job.wait({ timeout }), { name: "TimeoutError" });
  await assert.rejects(job.wait({ timeout: NaN }), RangeError);
  for (const timeout of [0, -1, NaN, "60"]) assert.throws(() => new Client(service.url, { timeout }), /RangeError: timeout must be seconds/);
  const gone = { signal: AbortSignal.abort() };
  for (const ask of [() => job.cancel(gone), () => job.prioritize(1, gone), () => job.delete(gone)]) await assert.rejects(ask, { name: "AbortError" });
  assert(["queued", "running"].includes((await job.refresh()).state), "what was given up was not done");
  await job.cancel();
});

test("the README does what it says", async () => {
  const blocks = [...fs.readFileSync(path.join(ROOT, "clients/js/README.md"), "utf8").matchAll(/```js\n(.*?)```/gs)].map(([, code]) => code);
  assert(blocks.length >= 5);
  const file = path.join(ROOT, "target", `readme-${process.pid}.mjs`);
  const code = blocks.join("\n").replaceAll("http://127.0.0.1:8080", service.url).replace('from "strahl"', `from ${JSON.stringify(path.join(ROOT, "clients/js/src/index.js"))}`);
  fs.writeFileSync(file, code);
  const before = process.cwd(), folder = fs.mkdtempSync(path.join(ROOT, "target", "readme-"));
  fs.symlinkSync(path.join(ROOT, "scenes"), path.join(folder, "scenes"));
  process.chdir(folder);
  try {
    await import(file);
    assert(fs.statSync("whitted.png").size > 1_000);
  } finally {
    process.chdir(before);
    fs.rmSync(folder, { recursive: true });
    fs.rmSync(file);
  }
});
