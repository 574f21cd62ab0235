// Cut connections, a service that is killed, wrong keys, busy services, thousands of events.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import fs from "node:fs";
import net from "node:net";
import os from "node:os";
import path from "node:path";
import { test } from "node:test";
import { inspect } from "node:util";
import vm from "node:vm";
import { Client, ConnectionError, DamagedError, Job, Problem } from "../src/index.js";
import { Connection } from "../src/connection.js";
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

/** Options of a client of a service that gives these answers, and the requests it got. */
function serviceOf(responses) {
  const got = [], retries = responses.length - 1;
  const fetch = async (url, options) => { got.push({ url, ...options }); const [status, headers, body] = responses.shift(); return new Response(body, { status, headers }); };
  return [{ fetch, retries, timeout: 60 }, got];
}
function answers(...responses) {
  const [options, got] = serviceOf(responses);
  return [new Client("http://strahl.test", options), got];
}
function jobOf(state, ...responses) {
  const [options, got] = serviceOf(responses);
  return [new Job(new Connection("http://strahl.test", options), { id: "a", state }), got];
}
const BUSY = [503, { "retry-after": "0" }, '{"type":"/problems/saturated","detail":"busy"}'];
const VERSION = [200, {}, '{"name":"strahl"}'];

test("a key that is still being accepted is sent again, and no other conflict", async () => {
  const pending = [409, { "retry-after": "0" }, '{"type":"/problems/conflict","detail":"still being accepted"}'];
  let [client, got] = answers(pending, pending, [202, {}, '{"id":"a","state":"queued"}']);
  assert.equal((await client.jobs.submit(SCENE)).id, "a");
  assert.equal(got.length, 3);
  for (const other of [[409, {}, '{"type":"/problems/conflict"}'], [409, { "retry-after": "0" }, '{"type":"/problems/job-not-finished"}']]) {
    [client, got] = answers(other);
    await assert.rejects(client.version(), (error) => error.status === 409);
    assert.equal(got.length, 1);
  }
});

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

/** A service that sends one of these on each connection, and then nothing. */
async function silentAfter(about, ...beginnings) {
  const service = { asked: 0 }, held = new Set();
  const server = net.createServer((socket) => {
    held.add(socket);
    socket.once("data", () => socket.write(beginnings[service.asked++] ?? ""));
    socket.on("error", () => {});
  });
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  about.after(() => { held.forEach((socket) => socket.destroy()); server.close(); });
  return Object.assign(service, { url: `http://127.0.0.1:${server.address().port}` });
}
const part = (type, body) => `--b\r\nContent-Type: ${type}\r\nContent-Length: ${body.length}\r\n\r\n${body}\r\n`;
const chunked = (type, body) => `HTTP/1.1 200 OK\r\nContent-Type: ${type}\r\nTransfer-Encoding: chunked\r\n\r\n${body && `${body.length.toString(16)}\r\n${body}\r\n`}`;

test("a stream that is silent is waited for as long as the client says", { timeout: 60_000 }, async (about) => {
  const options = { timeout: 2, retries: 1 };
  const silent = await silentAfter(about);
  await assert.rejects(new Client(silent.url, options).stream(SCENE).next(), { name: "TimeoutError" });
  assert.equal(silent.asked, 1, "who gives a time wants to wait no longer for an answer");
  const coarse = part("application/json", '{"scale":8,"x":0,"y":0,"w":8,"h":8,"final":false}') + part("image/png", "coarse");
  const fine = ['{"scale":1,"final":true}', "fine", '{"report":null}'].map((body) => part(body[0] === "{" ? "application/json" : "image/png", body)).join("");
  const torn = await silentAfter(about, chunked("multipart/mixed", coarse), chunked("multipart/mixed", fine)), seen = [];
  for await (const { picture } of new Client(torn.url, options).stream(SCENE)) {
    seen.push(new TextDecoder().decode(picture.bytes));
    // Who takes long over a picture does not make the service silent.
    await new Promise((done) => setTimeout(done, 2_500));
  }
  assert.deepEqual([seen, torn.asked], [["coarse", "fine"], 2], "an answer that falls silent is asked for again");
  const never = await silentAfter(about, ...Array(2).fill(chunked("multipart/mixed", coarse)));
  await assert.rejects(async () => { for await (const _ of new Client(never.url, options).stream(SCENE)); }, (error) => error instanceof ConnectionError && /silent for 2/.test(error.message));
  const stop = new AbortController(), stopped = new Client((await silentAfter(about)).url).stream(SCENE, {}, { signal: stop.signal }).next();
  setTimeout(() => stop.abort(), 100);
  await assert.rejects(stopped, { name: "AbortError" });
});

test("an idle stream that is cut is opened again and again", async (about) => {
  // The clock is not waited for.
  const pauses = [], real = globalThis.setTimeout;
  about.mock.method(globalThis, "setTimeout", (done, ms) => { if (ms < 45_000) pauses.push(ms / 1_000); return real(done, ms < 45_000 ? 0 : ms); });
  const stream = (text) => [200, { "content-type": "text/event-stream" }, text], idle = stream(": ok\n\n");
  const ends = async (retries, ...responses) => {
    pauses.length = 0;
    const client = new Client("http://strahl.test", { retries, fetch: async () => { const [status, headers, body] = responses.shift(); return new Response(body, { status, headers }); } });
    return client.jobs.events().next().then(() => assert.fail("there is no event"), (error) => error);
  };
  assert.equal((await ends(2, ...Array(9).fill(idle), [403, {}, "{}"])).status, 403);
  assert(pauses.length === 9 && pauses.every((pause) => pause >= 1 && pause < 2), pauses.join());
  for (const [said, least] of [["2500", 2.5], ["0", 0.5], ["soon", 1]]) {
    await ends(2, stream(`retry: ${said}\n\n`), [403, {}, "{}"]);
    assert(pauses[0] >= least && pauses[0] < least + 0.5, `${said}: ${pauses}`);
  }
  assert.equal((await ends(2, idle, BUSY, BUSY)).status, 503);
  assert.equal(pauses.length, 2, "what does not answer is asked as often as allowed");
  assert(await ends(2, ...Array(3).fill(stream("data: {\n\n"))) instanceof DamagedError);
  assert.equal(pauses.length, 2, "what is damaged each time is asked for as often as allowed");
});

test("no error shows a secret, and what cannot be sent is said at once", async () => {
  for (const key of ["se\ncret", "sec\u20acret", "sec\0ret", "s\u00e9cret"]) {
    assert.throws(() => new Client("http://strahl.test", { key }), (error) => error instanceof TypeError && /the key/.test(error.message) && !/cret/.test(inspect(error)));
  }
  let got;
  const fetch = async (_, { headers }) => { got = headers.authorization; return new Response(VERSION[2]); };
  await new Client("http://strahl.test", { fetch, key: " secret\n" }).version();
  assert.equal(got, "Bearer secret");
  for (const url of ["http://me:secret@127.0.0.1:1", "http://me:secret@[::1", "127.0.0.1:8080", "localhost:8080", "ftp://secret", ""]) {
    assert.throws(() => new Client(url), (error) => error instanceof TypeError && !/secret/.test(inspect(error)));
  }
  await assert.rejects(new Client("http://127.0.0.1:1/c/secret", { retries: 0 }).version(), (error) => error instanceof ConnectionError && !/secret/.test(inspect(error)));
  const client = new Client("http://127.0.0.1:1");
  await assert.rejects(client.jobs.submit(SCENE, { idempotencyKey: "a\nb" }), /TypeError: the idempotency key/);
  await assert.rejects(new Job({}, { id: "a" }).events({ since: "1\n2" }).next(), /TypeError: the id of an event/);
});

test("what only renders have is refused before it is sent, and options that are none are left out", async () => {
  const [client, got] = answers(VERSION);
  await assert.rejects(client.jobs.submit(SCENE, { layers: "normal", format: "exr" }), /TypeError: a job has no layers/);
  await assert.rejects(client.stream(SCENE, { layers: "normal" }).next(), /TypeError: a stream has no layers/);
  assert.equal(got.length, 0);
  await client.explain(SCENE, null);
  assert.equal(got[0].url, "http://strahl.test/v1/explain");
});

test("what is no scene is refused before it is sent", async () => {
  const [client, got] = answers(VERSION);
  const streams = [new Blob(["{}"]).stream(), fs.createReadStream(os.devNull)];
  for (const scene of [Promise.resolve(SCENE), ...streams, null, undefined, 5, [], new Map()]) {
    for (const ask of [() => client.render(scene), () => client.jobs.submit(scene), () => client.compare({ scene }, { scene })]) {
      await assert.rejects(ask, /TypeError: a scene is an object, its JSON text, its bytes or a Blob, not \w/);
    }
  }
  assert.equal(got.length, 0);
  await client.explain(vm.runInNewContext("({ version: 1 })"));
  assert.equal(got[0].body, '{"version":1}', "an object of another window is one, too");
});

test("a page of plain http submits jobs, and is told what it cannot do", async (about) => {
  const { crypto } = globalThis;
  about.mock.getter(globalThis, "crypto", () => ({ getRandomValues: (bytes) => crypto.getRandomValues(bytes) }));
  const submitted = [202, {}, '{"id":"a","state":"queued"}'], [client, got] = answers(submitted, submitted);
  for (let count = 0; count < 2; count++) await client.jobs.submit(SCENE);
  const keys = got.map(({ headers }) => headers["idempotency-key"]);
  assert(keys[0] !== keys[1] && keys.every((key) => /^[\da-f]{32}$/.test(key)), keys.join());
  await assert.rejects(client.assets.add(new Uint8Array(1)), /TypeError: assets.add needs https or localhost/);
});

test("JSON of something else is damaged, and a wait that is no number is none", async () => {
  const all = async (some) => { for await (const _ of some); };
  for (const [bodies, ask] of [[[], (c) => c.version()], [[], (c) => c.jobs.get("a")], [["{}"], (c) => all(c.jobs.list())], [["{}"], (c) => c.validate(SCENE)], [["{}"], (c) => c.rays(SCENE, [])]]) {
    for (const body of ["[]", "null", "5", ...bodies]) await assert.rejects(ask(answers([200, {}, body])[0]), DamagedError, body);
  }
  for (const head of ["5", "null", "[]"]) {
    await assert.rejects(all(answers([200, { "content-type": "multipart/mixed" }, part("application/json", head)])[0].stream(SCENE)), DamagedError);
    await assert.rejects(all(answers([200, { "content-type": "text/event-stream" }, `event: tile\ndata: ${head}\n\n`])[0].jobs.events()), DamagedError);
  }
  for (const after of ["", "Wed, 21 Oct 2026 07:28:00 GMT", "-1"]) {
    await assert.rejects(answers([503, { "retry-after": after }, ""])[0].version(), (error) => error.retryAfter === undefined);
  }
});

test("a page is no answer of the service", async () => {
  const all = async (some) => { for await (const _ of some); };
  for (const ask of [(c) => c.version(), (c) => c.render(SCENE), (c) => all(c.stream(SCENE)), (c) => c.jobs.get("a"), (c) => all(c.jobs.list()),
    (c) => all(c.jobs.events()), (c) => c.source("a"), (c) => c.jobs.submit(SCENE)]) {
    const [client] = answers([200, { "content-type": "text/html; charset=utf-8" }, "<html>"]);
    await assert.rejects(ask(client), (error) => error instanceof DamagedError && /text\/html.* check that the URL is that of the service/.test(error.message));
  }
  for (const ask of [(c) => all(c.stream(SCENE)), (c) => all(c.jobs.events()), (c) => c.jobs.get("a"), (c) => all(c.jobs.list())]) {
    const [client, got] = answers(...Array(2).fill([200, { "content-type": "text/plain" }, "OK"]));
    await assert.rejects(ask(client), (error) => error instanceof DamagedError && /text\/plain/.test(error.message));
    assert.equal(got.length, 2);
  }
});

test("what is no picture is damaged", async () => {
  const damaged = (error) => error instanceof DamagedError && /picture.* check that the URL is that of the service/.test(error.message);
  const said = (type, body) => [200, { "content-type": type }, body];
  for (const answer of [said("text/plain", "OK"), said("application/json", "{}"), said("application/xml", "<a/>"), said("image/png", ""), [204, {}, null]]) {
    for (const ask of [(c) => c.render(SCENE), (c) => c.tile(SCENE, [0, 0, 1, 1]), (c) => c.turntable(SCENE), (c) => c.image("i_a")]) {
      await assert.rejects(ask(answers(answer)[0]), damaged, String(answer));
    }
    await assert.rejects(jobOf("succeeded", answer)[0].wait(), damaged, String(answer));
  }
  for (const type of ["image/x-exr", "Image/PNG; a=b"]) assert.equal((await answers(said(type, "x"))[0].render(SCENE)).bytes.length, 1);
});

test("a job is followed although a gateway cannot reach the service", async (about) => {
  // The clock is not waited for.
  const real = globalThis.setTimeout;
  about.mock.method(globalThis, "setTimeout", (done, ms) => real(done, ms < 45_000 ? 0 : ms));
  const stream = (text) => [200, { "content-type": "text/event-stream" }, text];
  const view = (state) => [200, { "content-type": "application/json" }, JSON.stringify({ id: "a", state, progress: {} })];
  const began = stream('id: 1\nevent: snapshot\ndata: {"state":"running","tiles_total":2}\n\n');
  const ended = stream("id: 2\nevent: succeeded\ndata: {}\n\n");
  const states = async (job) => { const seen = []; for await (const { state } of job.progress()) seen.push(state); return seen; };
  for (const status of [500, 502, 504, 522]) {
    const gateway = [status, { "content-type": "text/html" }, "<h1>gateway</h1>"];
    let [job, got] = jobOf("running", began, gateway, gateway, ended);
    assert.deepEqual(await states(job), ["running", "succeeded"]);
    assert.deepEqual(got.map(({ headers }) => headers["last-event-id"]), [undefined, "1", "1", "1"]);
    [job, got] = jobOf("running", gateway, view("running"), gateway, view("succeeded"), gateway, [200, { "content-type": "image/png" }, "x"]);
    assert.equal((await job.wait()).bytes.length, 1);
    for (const ask of [states, (job) => job.wait()]) {
      [job, got] = jobOf("running", ...Array(4).fill(gateway));
      await assert.rejects(ask(job), (error) => error instanceof Problem && error.status === status);
      assert.equal(got.length, 4, "it is asked as often as allowed");
      if (status === 502) continue;
      [job, got] = jobOf("running", [status, { "content-type": "application/problem+json" }, '{"type":"/problems/internal"}'], gateway);
      await assert.rejects(ask(job), Problem);
      assert.equal(got.length, 1, "what the service says is so");
    }
  }
});

test("pointers are decoded as far as they can be", async () => {
  for (const [said, pointer] of [["#/a%20b/%C3%BC~1", "/a b/\u00fc~1"], ["/a%20b", "/a%20b"], ["#/a%zz%C", "/a%zz%C"], ["#/%FF%C3", "/\ufffd\ufffd"], ["#", ""]]) {
    await assert.rejects(answers([422, {}, JSON.stringify({ errors: [{ pointer: said }] })])[0].version(), ({ mistakes }) => mistakes[0].pointer === pointer);
  }
});

test("what is no answer of the service is said as it is", async () => {
  await assert.rejects(answers([404, {}, "<h1>nginx</h1>"])[0].version(), (error) => error instanceof Problem && /404/.test(error.message));
  await assert.rejects(answers(...Array(2).fill([200, {}, "<html>"]))[0].version(), DamagedError);
  await assert.rejects(answers(...Array(2).fill([200, { "content-type": "image/png", "repr-digest": "sha-256=:AAAA:" }, "picture"]))[0].render(SCENE), /SHA-256/);
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
    for await (const { data } of events(inPieces(size))) seen.push(data.seq);
    assert.deepEqual(seen, Array.from({ length: 5_000 }, (_, n) => n), `pieces of ${size}`);
  }
  for (const broken of ["x".repeat(2 << 20), "event: tile\ndata: {\n\n"]) {
    await assert.rejects(async () => { for await (const _ of events(inPieces(65_536, new TextEncoder().encode(broken)))); }, DamagedError);
  }
});
