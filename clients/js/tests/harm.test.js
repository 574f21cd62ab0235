// Cut connections, a service that is killed, wrong keys, busy services, thousands of events.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import { test } from "node:test";
import { Client, ConnectionError, DamagedError, Problem } from "../src/index.js";
import { events } from "../src/sse.js";
import { BINARY, SCENE, between, busyScene, start } from "./service.js";

const temporary = (about) => {
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), "strahl-js-"));
  about.after(() => fs.rmSync(folder, { recursive: true }));
  return folder;
};

test("a stream that is cut goes on without gaps, and so does a picture", async (about) => {
  const service = await start(), proxy = await between(service.port);
  about.after(() => { proxy.close(); return service.stop(); });
  const client = new Client(proxy.url);
  const job = await client.jobs.submit(busyScene("cut"), { width: 320, height: 240, samples: 96 });
  Object.assign(proxy, { cutAfter: 1_200, cuts: 3 });
  const numbers = [];
  let last;
  for await (last of job.events()) numbers.push(last.data.seq);
  assert.equal(proxy.cuts, 0, "nothing was cut");
  assert.deepEqual(numbers, numbers.map((_, i) => numbers[0] + i));
  assert.equal(last.name, "succeeded");
  const asked = proxy.asked.filter(({ url }) => url.includes("/events"));
  assert(asked.length >= 4 && asked.slice(1).every((one) => one.last));
  for await (const _ of job.events({ since: last.id })) assert.fail("nothing comes after the last");
  const whole = (await job.result()).bytes;
  Object.assign(proxy, { cutAfter: 1_000, cuts: 2 });
  assert.deepEqual((await job.result()).bytes, whole);
  Object.assign(proxy, { cutAfter: 3_000, cuts: 1 });
  const scales = [];
  for await (const { scale } of client.stream(SCENE, { width: 400, height: 300 })) scales.push(scale);
  assert(proxy.cuts === 0 && scales.at(-1) === 1 && scales.every((scale, i) => !i || scale < scales[i - 1]), scales.join());
  Object.assign(proxy, { cutAfter: 100, cuts: 100 });
  await assert.rejects(new Client(proxy.url, { retries: 1 }).render(SCENE), ConnectionError);
});

test("a job outlives the service", async (about) => {
  const data = path.join(temporary(about), "data");
  let service = await start("--data", data);
  const client = new Client(service.url, { retries: 8 });
  const job = await client.jobs.submit(busyScene("killed"), { width: 320, height: 240, samples: 64 });
  const seen = [];
  const following = (async () => { for await (const progress of job.progress()) seen.push(progress); })();
  while ((await job.refresh()).view.progress.tiles_done < 2) await new Promise((done) => setTimeout(done, 50));
  await service.stop("SIGKILL");
  await new Promise((done) => setTimeout(done, 500));
  service = await start("--data", data, "--listen", `127.0.0.1:${service.port}`);
  about.after(() => service.stop());
  await following;
  assert.equal(seen.at(-1).state, "succeeded");
  assert(seen.every(({ fraction }, i) => !i || fraction >= seen[i - 1].fraction));
  await job.wait({ timeout: 120 });
  assert(job.view.stats.tiles_recovered >= 1);
});

test("keys", async (about) => {
  const file = path.join(temporary(about), "keys.toml");
  const key = (scopes) => spawnSync(BINARY, ["key", "new", "--tenant", "acme", "--scopes", scopes, "--file", file], { encoding: "utf8" }).stdout.trim();
  const [all, read] = [key("render,jobs,read"), key("read")];
  const service = await start("--keys", file);
  about.after(() => service.stop());
  const client = new Client(service.url, { key: all });
  const job = await client.jobs.submit(SCENE);
  await job.wait({ timeout: 120 });
  const { prefix } = await client.capability({ job_id: job.id, ttl: 60 });
  assert.equal((await (await fetch(`${service.url}${prefix}/v1/jobs/${job.id}`)).json()).state, "succeeded");
  for (const wrong of [undefined, "rk_wrong", "x".repeat(5_000)]) {
    await assert.rejects(new Client(service.url, { key: wrong }).render(SCENE), (error) => error instanceof Problem && error.status === 401);
  }
  await assert.rejects(new Client(service.url, { key: read }).render(SCENE), (error) => error.document.scope === "render");
});

/** A client of a service that gives these answers, and the requests it got. */
function answers(...responses) {
  const got = [], retries = responses.length - 1;
  const fetch = async (url, options) => { got.push({ url, ...options }); const [status, headers, body] = responses.shift(); return new Response(body, { status, headers }); };
  return [new Client("http://strahl.test", { fetch, retries }), got];
}
const BUSY = [503, { "retry-after": "0" }, '{"type":"/problems/saturated","detail":"busy"}'];
const VERSION = [200, {}, '{"name":"strahl"}'];

test("a busy service is asked again as often as allowed, with the same key for a job", async () => {
  let [client, got] = answers(BUSY, [429, { "retry-after": "0" }, "{}"], BUSY, VERSION);
  assert.equal((await client.version()).name, "strahl");
  assert.equal(got.length, 4);
  [client, got] = answers(BUSY, BUSY, BUSY, BUSY);
  await assert.rejects(client.version(), (error) => error.isBusy && error.retryAfter === 0);
  assert.equal(got.length, 4);
  [client, got] = answers([503, { "retry-after": "1" }, ""], VERSION);
  const started = performance.now();
  await client.version();
  assert(performance.now() - started >= 990);
  [client, got] = answers(BUSY, [202, {}, '{"id":"a","state":"queued"}']);
  await client.jobs.submit(SCENE);
  assert.equal(new Set(got.map(({ headers }) => headers["idempotency-key"])).size, 1);
  // Who gives up while it waits is not asked again.
  [client, got] = answers([503, { "retry-after": "60" }, ""], VERSION);
  await assert.rejects(client.version({ signal: AbortSignal.timeout(100) }), { name: "TimeoutError" });
  assert.equal(got.length, 1);
});

test("a service that is silent is waited for as long as the client says", async () => {
  let asked = 0;
  const fetch = (_, { signal }) => { asked++; return new Promise((_, stop) => signal.addEventListener("abort", () => stop(signal.reason))); };
  // A real request keeps the process alive.
  const alive = setInterval(() => {}, 1_000);
  await assert.rejects(new Client("http://strahl.test", { fetch, timeout: 0.1 }).version(), { name: "TimeoutError" });
  clearInterval(alive);
  assert.equal(asked, 1);
});

test("what is no answer of the service is said as it is", async () => {
  await assert.rejects(answers([404, {}, "<h1>nginx</h1>"])[0].version(), (error) => error instanceof Problem && /404/.test(error.message));
  await assert.rejects(answers(...Array(2).fill([200, {}, "<html>"]))[0].version(), DamagedError);
  await assert.rejects(answers(...Array(2).fill([200, { "repr-digest": "sha-256=:AAAA:" }, "picture"]))[0].render(SCENE), /SHA-256/);
  const [client, got] = answers([504, {}, '{"type":"/problems/render-deadline"}'], VERSION);
  await assert.rejects(client.render(SCENE), Problem);
  assert.equal(got.length, 1, "what is too slow is not asked for again");
  const hostile = { errors: [null, { pointer: 7, detail: null }, { line: "x" }], type: null, detail: ["x"], more: "many" };
  await assert.rejects(answers([422, {}, JSON.stringify(hostile)])[0].version(), (error) => error instanceof Problem && error.mistakes.length === 2);
});

test("thousands of events come in any pieces", async () => {
  const lines = Array.from({ length: 5_000 }, (_, n) => `id: ${n}\nevent: tile\ndata: ${JSON.stringify({ seq: n, name: "ü".repeat(n % 7) })}\n\n: beat\n\n`).join("");
  const bytes = new TextEncoder().encode(`retry: 2000\n\n${lines}`);
  const inPieces = (size, of = bytes) => new ReadableStream({
    pull(control) { const part = of.subarray(this.at ?? 0, this.at = (this.at ?? 0) + size); if (part.length) control.enqueue(part); else control.close(); },
  });
  for (const size of [7, 4_096, bytes.length]) {
    const seen = [];
    for await (const { data } of events(inPieces(size), () => {})) seen.push(data.seq);
    assert.deepEqual(seen, Array.from({ length: 5_000 }, (_, n) => n), `pieces of ${size}`);
  }
  for (const broken of ["x".repeat(2 << 20), "event: tile\ndata: {\n\n"]) {
    await assert.rejects(async () => { for await (const _ of events(inPieces(65_536, new TextEncoder().encode(broken)), () => {})); }, DamagedError);
  }
});
