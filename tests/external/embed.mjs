// Pages with <strahl-picture> in headless Chromium. Called by embed.py.
//
// Page, element and service have three addresses, as they would have in use. Between them is a proxy, which counts streams,
// cuts them, can be busy or away, and can have a gateway that answers instead.
import fs from "node:fs";
import http from "node:http";
import path from "node:path";
import { spawn, spawnSync } from "node:child_process";
import { createRequire } from "node:module";
import assert from "node:assert/strict";

const [modules, browserPath, strahl, folder, ...chosen] = process.argv.slice(2);
const require = createRequire(path.join(modules, "x.js"));
const puppeteer = require("puppeteer-core");
const axe = fs.readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");
const pause = (ms) => new Promise((over) => setTimeout(over, ms));
async function until(what, holds, ms = 120_000) {
  for (const started = Date.now(); !(await holds()); await pause(20)) assert(Date.now() - started < ms, `never: ${what}`);
}

// The services: one without keys, one with.
class Program {
  constructor(port, ...flags) { Object.assign(this, { port, flags: [...flags, "--listen", `127.0.0.1:${port}`] }); }
  async start() {
    this.process = spawn(strahl, ["serve", ...this.flags], { stdio: ["ignore", "ignore", "pipe"] });
    await new Promise((listens, fails) => {
      this.process.stderr.on("data", (data) => /listening on/.test(data) && listens());
      this.process.on("exit", (code) => fails(new Error(`the service ended with ${code}`)));
    });
    return this;
  }
  stop(signal = "SIGTERM") {
    const ended = new Promise((over) => this.process.on("exit", over));
    this.process.kill(signal);
    return ended;
  }
}
const [openPort, closedPort] = [8471, 8472];
const keys = path.join(folder, "keys.toml");
const key = spawnSync(strahl, ["key", "new", "--tenant", "acme", "--scopes", "render,jobs,read", "--file", keys], { encoding: "utf8" }).stdout.trim();
const open = await new Program(openPort).start();
const closed = await new Program(closedPort, "--keys", keys, "--data", path.join(folder, "data")).start();

// A service that tells of five thousand tiles at once, with addresses that lead elsewhere.
const small = Buffer.from(await (await fetch(`http://127.0.0.1:${openPort}/v1/render?width=64&height=64`, { method: "POST", body: fs.readFileSync("scenes/whitted/whitted.json") })).arrayBuffer());
function flood(rest, response, allow) {
  const png = () => response.writeHead(200, { ...allow, "content-type": "image/png" }).end(small);
  if (!rest.endsWith("/events")) {
    if (rest !== "/v1/jobs/flood") return png();
    return response.writeHead(200, { ...allow, "content-type": "application/json" }).end(JSON.stringify({ state: "succeeded", width: 1024, height: 1024, image_id: null }));
  }
  const event = (seq, name, data) => `id: ${seq}\nevent: ${name}\ndata: ${JSON.stringify({ job: "flood", seq, url: "https://elsewhere.example/", ...data })}\n\n`;
  const tiles = Array.from({ length: 5_000 }, (_, i) => event(i + 2, "tile", { x: 0, y: 0, w: 16, h: 16, tiles_done: i + 1 }));
  response.writeHead(200, { ...allow, "content-type": "text/event-stream" });
  response.write(event(1, "snapshot", { state: "running", width: 1024, height: 1024, tiles_total: 5_000, tiles_done: 0 }) + tiles.join(""));
  setTimeout(() => response.end(event(5_002, "succeeded", {})), 500);
}

// The proxy in front of them: /open/..., /closed/... and /flood/...
const proxy = { streams: 0, most: 0, asked: [], cutAfter: 0, busy: 0, away: false };
const proxied = http.createServer((request, response) => {
  if (proxy.away) {
    proxy.missed++;
    return response.destroy();
  }
  const [, name, rest] = request.url.match(/^\/(open|closed|flood)(\/.*)$/) ?? [];
  if (!name) return response.writeHead(404).end();
  if (rest === "/embed.js" && process.env.EMBED_FROM_DISK) {
    return response.writeHead(200, { "access-control-allow-origin": "*", "content-type": "text/javascript" }).end(fs.readFileSync("web/embed/strahl-picture.js"));
  }
  const isStream = rest.includes("/events");
  proxy.asked.push({ method: request.method, url: rest, last: request.headers["last-event-id"], origin: request.headers.origin });
  const allow = { "access-control-allow-origin": "*" };
  if (proxy.busy > 0 && request.method !== "OPTIONS" && (proxy.busyOn ?? /./).test(rest)) {
    proxy.busy--;
    proxy.busyAt.push(Date.now());
    return response.writeHead(503, { ...allow, "access-control-expose-headers": "Retry-After", "retry-after": "1", "content-type": "application/problem+json" })
      .end(JSON.stringify({ type: "/problems/saturated", title: "busy", status: 503, detail: "busy" }));
  }
  if (request.method !== "OPTIONS" && rest !== "/embed.js" && proxy.instead?.(rest, response, allow, request)) return;
  if (isStream) { proxy.streams++; proxy.most = Math.max(proxy.most, proxy.streams); response.on("close", () => proxy.streams--); }
  if (name === "flood") return flood(rest, response, allow);
  const port = name === "open" ? openPort : closedPort;
  const asked = http.request({ port, host: "127.0.0.1", method: request.method, path: rest, headers: { ...request.headers, host: `127.0.0.1:${port}` } }, (answer) => {
    response.writeHead(answer.statusCode, answer.headers);
    let sent = 0;
    answer.on("data", (part) => {
      response.write(part);
      sent += part.length;
      if (isStream && proxy.cutAfter && sent > proxy.cutAfter) { proxy.cut = (proxy.cut ?? 0) + 1; response.destroy(); asked.destroy(); }
    });
    answer.on("end", () => response.end());
    answer.on("error", () => response.destroy());
  });
  asked.on("error", () => response.destroy());
  response.on("close", () => asked.destroy());
  request.pipe(asked);
});
const listen = (server, port) => new Promise((done) => server.listen(port, "127.0.0.1", done));
await listen(proxied, 8473);
const through = "http://127.0.0.1:8473";

// Pages, with a policy that forbids all that an element of somebody else should not need.
const example = path.join("examples", "embed");
const scene = JSON.parse(fs.readFileSync("scenes/whitted/whitted.json", "utf8"));
const policy = `default-src 'none'; script-src 'self' ${through}; connect-src 'self' ${through}; style-src 'self'; require-trusted-types-for 'script'; trusted-types 'none'`;
const watch = `window.seen = []; window.violations = [];
document.addEventListener("securitypolicyviolation", (event) => violations.push(event.violatedDirective + " " + event.blockedURI));
for (const name of ["progress", "done", "error"]) document.addEventListener("strahl-" + name, ({ target, detail }) =>
  seen.push({ name, id: target.id, at: performance.now(), detail: JSON.parse(JSON.stringify({ ...detail, message: detail.error?.message })) }));`;
const types = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".json": "application/json" };
let body = "";
const host = http.createServer((request, response) => {
  const { pathname } = new URL(request.url, "http://host");
  response.setHeader("content-security-policy", policy);
  response.setHeader("content-type", types[path.extname(pathname)] ?? "text/html");
  if (pathname === "/page") {
    return response.end(`<!doctype html><html lang="en"><title>page</title><script src="/watch.js"></script>
<script type="module" src="${through}/open/embed.js"></script><main><h1>Page</h1>${body}</main></html>`);
  }
  if (pathname === "/watch.js") return response.end(watch);
  if (pathname === "/hasty.js") return response.end("const real = setTimeout; window.setTimeout = (run, ms) => real(run, ms / 20);");
  if (pathname === "/early.js") return response.end(`document.getElementById("p").key = "${key}";`);
  if (pathname === "/scene.json") return response.end(JSON.stringify(scene));
  if (pathname === "/models/Box.glb" || pathname === "/models/cube.obj") {
    // As a plain file server has them, which knows neither.
    response.setHeader("content-type", "text/plain");
    return response.end(fs.readFileSync(path.join("tests/inputs/models", pathname.endsWith(".obj") ? "obj" : "", path.basename(pathname))));
  }
  if (pathname === "/fbx") return response.end("Kaydara FBX Binary");
  const file = pathname.startsWith("/client/") ? path.join("clients/js/src", path.basename(pathname)) : path.join(example, path.normalize(pathname));
  if (!fs.existsSync(file)) return response.writeHead(404).end();
  const text = fs.readFileSync(file, "utf8").replaceAll("http://127.0.0.1:8080", `${through}/open`);
  response.end(pathname === "/index.html" ? text.replace("<script", '<script src="/watch.js"></script><script') : text);
});
await listen(host, 8474);
const origin = "http://127.0.0.1:8474";

const flags = "--no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking --disable-component-update --disable-sync";
// Pages that one leaves are kept, as they are for people.
const browser = await puppeteer.launch({ executablePath: browserPath, headless: true, userDataDir: path.join(folder, "profile"), args: flags.split(" "), ignoreDefaultArgs: ["--disable-back-forward-cache"] });

let page;
const problems = [];
async function show(html, address = "/page", instead = undefined) {
  body = html;
  Object.assign(proxy, { most: 0, asked: [], cutAfter: 0, cut: 0, busy: 0, busyAt: [], busyOn: undefined, away: false, missed: 0, instead });
  page = await browser.newPage();
  await page.setCacheEnabled(false);
  await page.setViewport({ width: 1200, height: 800 });
  page.on("pageerror", (error) => problems.push(String(error)));
  await page.goto(origin + address);
  return page;
}
/** The same with timers that run 20 times as fast, and a page that nobody sees; `instead` answers from the start. */
async function hasten(html, { hidden = false, instead } = {}) {
  await show("");
  proxy.instead = instead;
  if (hidden) await page.evaluateOnNewDocument(() => Object.defineProperty(document, "hidden", { value: true }));
  body = `<script src="/hasty.js"></script>${html}`;
  await page.goto(`${origin}/page`);
}
async function leave() {
  problems.push(...await page.evaluate(() => window.violations));
  await page.close();
}
const seen = (name, id = "") => page.evaluate((name, id) => window.seen.filter((one) => one.name === name && one.id === id), name, id);
const last = async (name, id = "") => (await seen(name, id)).at(-1)?.detail;
const done = (id = "", ms) => until(`done ${id}`, async () => {
  const error = await last("error", id);
  assert(!error, `${id}: ${error?.message}`);
  return last("done", id);
}, ms);
const failed = async (id = "") => { await until(`error ${id}`, () => last("error", id)); return last("error", id); };
/** The canvas's pixels, or what differs from a picture of the same size: the mean of all bytes. */
const differs = async (selector, url, headers = {}) => page.evaluate(async (selector, bytes) => {
  const canvas = document.querySelector(selector).shadowRoot.querySelector("canvas");
  const other = new OffscreenCanvas(canvas.width, canvas.height), context = other.getContext("2d");
  context.drawImage(await createImageBitmap(new Blob([new Uint8Array(bytes)])), 0, 0, canvas.width, canvas.height);
  await new Promise((next) => requestAnimationFrame(() => requestAnimationFrame(next)));
  const [a, b] = [canvas.getContext("2d"), context].map((one) => one.getImageData(0, 0, canvas.width, canvas.height).data);
  return a.reduce((sum, value, i) => sum + Math.abs(value - b[i]), 0) / a.length;
}, selector, [...new Uint8Array(await (await fetch(url, { headers })).arrayBuffer())]);

const authorization = { authorization: `Bearer ${key}` };
async function ask(url, method = "GET", json, headers = {}) {
  const answer = await fetch(url, { method, headers: { ...(json && { "content-type": "application/json" }), ...headers }, body: json && JSON.stringify(json) });
  assert(answer.ok, `${url}: ${answer.status} ${await answer.clone().text()}`);
  return answer.headers.get("content-type")?.includes("json") ? answer.json() : answer.arrayBuffer();
}
let count = 0;
/** A job that takes so many samples; no two are the same. */
async function submit(where, samples = 16, width = 512, headers = {}, output = {}) {
  const own = structuredClone(scene);
  own.name = `job ${++count} ${Date.now()}`;
  own.background = [0.1 + count / 1_000, 0.2, 0.3 + Math.random() / 100];
  return (await ask(`http://127.0.0.1:${where}/v1/jobs`, "POST", { scene: own, settings: { width, height: width * 3 / 4, samples, antialias: false }, output }, headers)).id;
}
const capability = async (what) => (await ask(`http://127.0.0.1:${closedPort}/v1/capabilities`, "POST", what, authorization)).prefix;
/** More samples than one answer may have. */
const long = { ...scene, render: { samples: 64, antialias: false } };
/** Widths and heights of an element, its status, and the text below it, and how far that is down the page. */
const boxes = (id = "p") => page.evaluate((id) => {
  const element = document.getElementById(id), status = element.shadowRoot.querySelector("[role=status]");
  const [own, text, after] = [element, status, document.getElementById("after")].map((of) => of?.getBoundingClientRect());
  const inside = text.left >= own.left - 1 && text.right <= own.right + 1 && text.top >= own.top - 1 && text.bottom <= own.bottom + 1;
  return { size: `${Math.round(own.width)}x${Math.round(own.height)}`, says: status.textContent, text: [text.width, text.height], inside, after: after?.top, over: after && own.bottom > after.top + 1 };
}, id);
const mine = (id, attributes) => `<strahl-picture id="${id}" src="${through}/${attributes}></strahl-picture>`;

const flows = {
  async "a job comes coarse to fine with a capability, and the stream is cut and goes on"() {
    const id = await submit(closedPort, 24, 512, authorization);
    await show(mine("p", `closed" job="${id}" capability="${await capability({ job_id: id })}" alt="A ball"`));
    proxy.cutAfter = 1_500;
    await until("a cut", () => proxy.cut >= 2);
    proxy.cutAfter = 0;
    await done("p");
    const states = (await seen("progress", "p")).map(({ detail }) => detail.state);
    for (const state of ["waiting", "preview", "tile", "succeeded"]) assert(states.includes(state), `no ${state}: ${[...new Set(states)]}`);
    const fractions = (await seen("progress", "p")).map(({ detail }) => detail.fraction).filter((one) => one !== undefined);
    assert(fractions.every((one, i) => !i || one >= fractions[i - 1]), "progress goes backwards");
    const again = proxy.asked.filter(({ url }) => url.includes("/events")).slice(1);
    assert(again.filter(({ method }) => method === "GET").every(({ last }) => /^\d+$/.test(last)), JSON.stringify(again));
    const told = await last("done", "p");
    assert.equal(told.width, 512);
    assert(told.report.cost.rays.camera > 0 && told.error.proved !== undefined && told.job.state === "succeeded", JSON.stringify(told));
    assert.equal(await differs("#p", `http://127.0.0.1:${closedPort}/v1/jobs/${id}/image`, authorization), 0);
    assert(!proxy.asked.some(({ url }) => !url.startsWith("/c/") && url !== "/embed.js"), "it asks without its capability");
    return `${proxy.cut} cuts, ${states.length} events`;
  },
  async "the service is killed in the middle and the picture comes"() {
    const id = await submit(closedPort, 24, 512, authorization);
    await show(mine("p", `closed" job="${id}" capability="${await capability({ job_id: id })}"`));
    // The secret of a capability ends with the process unless the key file has one, so this page has the key.
    await page.evaluate((key) => { const p = document.getElementById("p"); p.removeAttribute("capability"); p.key = key; }, key);
    await until("some tiles", async () => (await seen("progress", "p")).some(({ detail }) => detail.state === "tile"));
    await closed.stop("SIGKILL");
    await until("offline", async () => (await last("progress", "p")).state === "offline");
    const said = await page.evaluate(() => document.getElementById("p").shadowRoot.querySelector("[role=status]").textContent);
    assert.match(said, /Trying again/);
    await closed.start();
    await done("p");
    assert.equal(await differs("#p", `http://127.0.0.1:${closedPort}/v1/jobs/${id}/image`, authorization), 0);
  },
  async "jobs without capabilities share a stream, and a wrong one among them harms none"() {
    const ids = [];
    for (let i = 0; i < 5; i++) ids.push(await submit(openPort, 12, 256));
    const wrong = "00000000-0000-7000-8000-000000000000";
    await show([...ids, wrong].map((id, i) => mine(`p${i}`, `open" job="${id}" width="120"`)).join(""));
    const { status, message } = await failed("p5");
    assert.equal(status, 410, message);
    for (let i = 0; i < 5; i++) await done(`p${i}`);
    assert(proxy.most <= 2, `${proxy.most} streams at one time`);
    return `${proxy.asked.filter(({ url }) => url.includes("/events")).length} streams asked for`;
  },
  async "seven jobs with capabilities have three streams, and all come"() {
    const ids = [];
    for (let i = 0; i < 7; i++) ids.push(await submit(closedPort, 12, 256, authorization));
    const rights = await Promise.all(ids.map((id) => capability({ job_id: id })));
    await show(ids.map((id, i) => mine(`p${i}`, `closed" job="${id}" capability="${rights[i]}" width="100"`)).join(""));
    for (let i = 0; i < 7; i++) await done(`p${i}`);
    assert(proxy.most <= 3, `${proxy.most} streams at one time`);
    return `at most ${proxy.most} streams`;
  },
  async "a scene in the page, and deep zoom by wheel, keys, buttons and fingers"() {
    await show("", "/index.html");
    await done("scene");
    const told = await last("done", "scene");
    assert.equal(told.width, 640);
    assert(told.rays.camera > 0 && told.error.proved === 1 && told.image.startsWith("i_"), JSON.stringify(told));
    assert.match(await page.$eval("#told", (told) => told.textContent), /^[\d,]+ rays; at most 1 of 255 codes off$/);
    const states = (await seen("progress", "scene")).map(({ detail }) => detail.state);
    const renders = proxy.asked.filter(({ url, method }) => url.startsWith("/v1/render") && method === "POST").map(({ url }) => url);
    assert(renders.length === 2 && renders[0].includes("time:") && states.at(-1) === "succeeded", renders.join());
    assert.equal(await differs("#scene", `http://127.0.0.1:${openPort}/v1/images/${told.image}.png`), 0);
    const view = () => page.$eval("#scene", (one) => one.view);
    const box = await page.$eval("#scene", (one) => { const { left, top, width, height } = one.getBoundingClientRect(); return { left, top, width, height }; });
    await page.mouse.move(box.left + box.width / 4, box.top + box.height / 2);
    await page.mouse.wheel({ deltaY: -100 });
    assert.equal((await view()).scale, 1, "the wheel scrolls the page as long as the picture has no focus");
    await page.focus("#scene");
    await page.keyboard.press("Tab");
    await page.evaluate(() => document.getElementById("scene").shadowRoot.querySelector("canvas").focus());
    for (let i = 0; i < 8; i++) await page.mouse.wheel({ deltaY: -100 });
    const wheeled = await view();
    assert(Math.abs(wheeled.scale - 16) < 0.01 && wheeled.x < 0.5, JSON.stringify(wheeled));
    const tiles = () => proxy.asked.filter(({ url }) => /^\/xyz\/.*\/\d+\/\d+\/\d+\.png$/.test(url)).map(({ url }) => +url.split("/")[3]);
    await until("deep tiles", () => tiles().some((zoom) => zoom >= 5));
    await page.keyboard.press("ArrowRight");
    assert((await view()).x > wheeled.x);
    await page.keyboard.press("0");
    assert.equal((await view()).scale, 1);
    for (let i = 0; i < 3; i++) await page.keyboard.press("+");
    await page.keyboard.press("-");
    assert(Math.abs((await view()).scale - 2.25) < 0.01);
    await page.evaluate(() => document.getElementById("scene").shadowRoot.querySelectorAll("button").forEach((button, i) => i !== 1 && button.click()));
    assert.equal((await view()).scale, 1, "the third button shows the whole");
    const touch = await page.createCDPSession(), finger = (x, id) => ({ x: box.left + x, y: box.top + 150, id });
    await touch.send("Input.dispatchTouchEvent", { type: "touchStart", touchPoints: [finger(250, 1), finger(350, 2)] });
    for (let apart = 120; apart <= 400; apart += 20) {
      await touch.send("Input.dispatchTouchEvent", { type: "touchMove", touchPoints: [finger(300 - apart / 2, 1), finger(300 + apart / 2, 2)] });
    }
    await touch.send("Input.dispatchTouchEvent", { type: "touchEnd", touchPoints: [] });
    assert((await view()).scale > 3, JSON.stringify(await view()));
    // As deep as it goes, where the pixels of the screen are those of the tiles.
    for (let i = 0; i < 40; i++) await page.evaluate(() => document.getElementById("scene").zoomBy(2));
    const deepest = await view();
    assert(deepest.scale > 1_000, JSON.stringify(deepest));
    const { maxzoom } = await ask(`http://127.0.0.1:${openPort}/xyz/${told.image}.json`);
    await until("the deepest tiles", () => tiles().includes(maxzoom));
    return `to ${Math.round(deepest.scale)} times, ${tiles().length} tiles to zoom ${Math.max(...tiles())}`;
  },
  async "what is seen deep in a picture is what the service renders there"() {
    await show("", "/index.html");
    await done("scene");
    const { image } = await last("done", "scene");
    // Half of a picture of 640 x 360: 4 times larger, 160 x 90 of its pixels fill the element.
    await page.$eval("#scene", (one) => one.zoomTo(4, 0.5, 0.5));
    await until("tiles", async () => (await page.$eval("#scene", (one) => one.shadowRoot.querySelector("canvas").width)) === 640
      && proxy.asked.filter(({ url }) => /\/3\/\d+\/\d+\.png/.test(url)).length >= 3);
    const region = `http://127.0.0.1:${openPort}/iiif/3/${image}/240,135,160,90/^640,360/0/default.png`;
    await until("the same pixels", async () => (await differs("#scene", region)) < 0.05, 20_000);
    return `mean difference ${(await differs("#scene", region)).toFixed(4)} codes`;
  },
  async "a scene by its address, with a size of its own"() {
    await show(mine("p", `open" scene="/scene.json" width="320" height="240"`));
    await done("p");
    assert.equal((await last("done", "p")).width, 320);
  },
  async "a model by its address, and what is neither is refused in plain words"() {
    for (const name of ["Box.glb", "cube.obj"]) {
      await show(mine("p", `open" scene="/models/${name}" width="320" height="240"`));
      await done("p");
      const { width, height, image } = await last("done", "p");
      assert.deepEqual([width, height, typeof image], [320, 240, "string"]);
    }
    await show(mine("p", `open" scene="/fbx" width="320" height="240"`));
    assert.equal((await failed("p")).message, "this is FBX, which strahl does not read: convert it to glTF (.glb)");
    await show(mine("p", `open" scene="/watch.js" width="320" height="240"`));
    const { message } = await failed("p");
    // The words on the page; those of the service are for who wrote it.
    assert.equal((await boxes("p")).says, "no scene, no model");
    return message;
  },
  async "a scene that takes long becomes a job, which ends with its element"() {
    await show(mine("p", `open" width="1200" height="900"`).replace("></", `><script type="application/json">${JSON.stringify(long)}</script></`));
    await until("tiles", async () => (await seen("progress", "p")).some(({ detail }) => detail.state === "tile" || detail.state === "preview" && detail.job));
    let { job } = await last("progress", "p");
    await page.evaluate(() => { window.kept = document.getElementById("p"); window.kept.remove(); });
    await until("canceled", async () => (await ask(`http://127.0.0.1:${openPort}/v1/jobs/${job}`)).state === "canceled");
    await until("no streams", () => proxy.streams === 0, 5_000);
    // The same when the page is left.
    const first = job;
    await page.evaluate(() => document.body.append(window.kept));
    await until("another job", async () => ![first, undefined].includes(job = (await last("progress", "p")).job));
    await page.goto("about:blank");
    await until("canceled, too", async () => (await ask(`http://127.0.0.1:${openPort}/v1/jobs/${job}`)).state === "canceled");
    await show("");
  },
  async "an image by its id, with and without a key"() {
    const { image_id } = await ask(`http://127.0.0.1:${closedPort}/v1/scenes`, "POST", scene, authorization);
    const deep = await ask(`http://127.0.0.1:${closedPort}/v1/scenes?zoom=6`, "POST", scene, authorization);
    await show(mine("p", `closed" image="${image_id}" capability="${await capability({ image_id })}" zoom`)
      + mine("q", `closed" image="${deep.image_id}" capability="${await capability({ image_id: deep.image_id })}" width="300" zoom`)
      + mine("r", `closed" image="${image_id}"`));
    await done("p");
    await done("q");
    assert.equal((await failed("r")).status, 401);
    assert.equal(await differs("#p", `http://127.0.0.1:${closedPort}/v1/images/${image_id}.png`, authorization), 0);
    assert.equal((await last("done", "q")).width, deep.width);
  },
  async "a job in a format that no browser reads"() {
    const id = await submit(openPort, 4, 256, {}, { format: "exr" });
    await show(mine("p", `open" job="${id}"`));
    await done("p");
    assert((await differs("#p", `http://127.0.0.1:${openPort}/v1/jobs/${id}/preview`)) === 0);
  },
  async "a failed scene says why, as text"() {
    const hostile = `<img src=x onerror="window.ran = 1">`;
    const broken = { ...scene, objects: [{ sphere: { center: [0, 0, 0], radius: 1, material: hostile } }] };
    await show(mine("p", `open"`).replace("></", `><script type="application/json">${JSON.stringify(broken)}</script></`));
    const { status, problem } = await failed("p");
    assert.equal(status, 422);
    assert(problem.errors[0].pointer.startsWith("#/objects/0"), JSON.stringify(problem));
    const [text, elements, ran] = await page.evaluate(() => {
      const root = document.getElementById("p").shadowRoot;
      return [root.querySelector("[role=status]").textContent, root.querySelectorAll("img").length, window.ran];
    });
    assert(text.length > 10 && !elements && !ran, text);
  },
  async "both attributes are the size from the start, with an error or a picture of another shape"() {
    const after = `<p id="after">Below</p>`, missing = "00000000-0000-7000-8000-000000000000";
    await show(`<div>${mine("p", `open" job="${missing}" width="300" height="200" alt="A hall"`)}</div>${after}`);
    await failed("p");
    const early = await boxes();
    assert(early.size === "300x200" && early.inside && early.text[0] === 300 && !early.over, JSON.stringify(early));
    await leave();
    const id = await submit(openPort, 1, 320);
    // Before the service says anything.
    await show(`<div>${mine("q", `open" width="300" height="300"`)}</div>${after}`);
    proxy.away = true;
    await page.evaluate((id) => document.getElementById("q").setAttribute("job", id), id);
    await until("offline", async () => (await last("progress", "q")).state === "offline");
    const before = await boxes("q");
    assert.equal(before.size, "300x300");
    proxy.away = false;
    // The next try may be a while away.
    await page.evaluate((id) => document.getElementById("q").setAttribute("src", document.getElementById("q").getAttribute("src") + "/"), id);
    await until("done", () => last("done", "q"));
    const now = await boxes("q");
    assert.deepEqual([now.size, now.after], [before.size, before.after], "what is below it moves");
    // Of a page that is narrower both sides become smaller.
    await page.setViewport({ width: 216, height: 800 });
    assert.equal((await boxes("q")).size, "200x200");
  },
  async "without a size the text of an error has room of its own, and hides nothing"() {
    for (const attributes of ["", ` width="120"`, ` controls zoom`]) {
      await show(`<div>${mine("p", `open" job="00000000-0000-7000-8000-000000000000"${attributes}`)}</div><p id="after">Below</p>`);
      await failed("p");
      const is = await boxes();
      assert(await page.$eval("#p", (p) => { const { scrollWidth, clientWidth } = p.shadowRoot.querySelector("p"); return scrollWidth <= clientWidth; }), "words stick out");
      assert(is.says.length > 10 && is.text[0] >= 100 && is.text[1] >= 15 && is.inside && !is.over, `${attributes}: ${JSON.stringify(is)}`);
      await leave();
    }
    await show("");
  },
  async "a size that is changed or taken away later counts"() {
    const id = await submit(openPort, 1, 320);
    await show(mine("p", `open" job="${id}"`));
    await done("p");
    const sizes = [(await boxes()).size];
    for (const [name, value] of [["width", "200"], ["height", "60"], ["width", null], ["height", null]]) {
      const before = (await seen("done", "p")).length;
      await page.evaluate((name, value) => {
        const p = document.getElementById("p");
        if (value) p.setAttribute(name, value); else p.removeAttribute(name);
      }, name, value);
      await until("done again", async () => (await seen("done", "p")).length > before);
      sizes.push((await boxes()).size);
    }
    assert.deepEqual(sizes, ["320x240", "200x150", "200x60", "80x60", "320x240"]);
    await page.evaluate(() => { const p = document.getElementById("p"); p.setAttribute("job", "nope"); p.setAttribute("width", "90"); p.setAttribute("height", "40"); });
    await failed("p");
    const last = await boxes();
    assert(last.size === "90x40" && last.inside, JSON.stringify(last));
  },
  async "a page that one comes back to has its job again"() {
    await show(mine("p", `open" width="1200" height="900"`).replace("></", `><script type="application/json">${JSON.stringify(long)}</script></`));
    const job = async () => (await seen("progress", "p")).findLast(({ detail }) => detail.job)?.detail.job;
    const state = async (id) => (await ask(`http://127.0.0.1:${openPort}/v1/jobs/${id}`)).state;
    await until("a job", job);
    const first = await job();
    await page.evaluate(() => addEventListener("pageshow", ({ persisted }) => { window.persisted = persisted; }));
    await page.goto(`${origin}/scene.json`);
    await until("canceled", async () => (await state(first)) === "canceled");
    await page.goBack();
    assert(await page.evaluate(() => window.persisted), "the browser has not kept the page");
    await until("another job", async () => (await job()) !== first);
    assert(["queued", "running"].includes(await state(await job())), "it is not rendered again");
    assert.equal(await last("error", "p"), undefined);
    await page.evaluate(() => document.getElementById("p").remove());
  },
  async "images and scenes say that the service is away, and wait for as long as it is"() {
    const { image_id: image } = await ask(`http://127.0.0.1:${openPort}/v1/scenes`, "POST", scene);
    await hasten(mine("i", `open" width="300"`) + mine("s", `open" width="200" height="150"`));
    proxy.away = true;
    await page.evaluate((image) => {
      document.getElementById("i").setAttribute("image", image);
      document.getElementById("s").setAttribute("scene", "/scene.json");
    }, image);
    for (const id of ["i", "s"]) {
      await until(`${id} offline`, async () => (await last("progress", id)).state === "offline", 10_000);
      assert.match((await boxes(id)).says, /Trying again/);
    }
    // More often than a service that is busy.
    await until("tries", () => proxy.missed >= 16, 60_000);
    // One that has just come back is busy.
    Object.assign(proxy, { away: false, busy: 2, busyOn: /xyz|render/ });
    for (const id of ["i", "s"]) {
      await until(`${id} done`, () => last("done", id));
      const states = (await seen("progress", id)).map(({ detail }) => detail.state);
      assert(states.at(-1) === "succeeded" && states.indexOf("waiting", states.indexOf("offline")) > 0, states.join());
      assert.equal((await boxes(id)).says, "");
    }
    return `${proxy.missed} tries`;
  },
  async "a gateway that says 5xx in its own words is a service that is away"() {
    const { image_id: image } = await ask(`http://127.0.0.1:${openPort}/v1/scenes`, "POST", scene);
    const kinds = { j: /jobs/, i: /xyz|images/, s: /render/ }, statuses = [504, 500, 520, 502, 503];
    for (const hidden of [false, true]) {
      const missed = { j: 0, i: 0, s: 0 };
      const instead = (rest, response, allow) => {
        const kind = Object.keys(kinds).find((name) => kinds[name].test(rest));
        response.writeHead(statuses[missed[kind]++ % 5], { ...allow, "content-type": "text/html" }).end("<h1>Bad gateway</h1>");
        return true;
      };
      await hasten(mine("j", `open" job="${await submit(openPort, 4, 256)}"`) + mine("i", `open" image="${image}" width="300"`)
        + mine("s", `open" scene="/scene.json" width="200" height="150"`), { hidden, instead });
      // More often than a service that is busy.
      await until("tries", () => Object.values(missed).every((count) => count >= 8), 60_000);
      for (const id of Object.keys(kinds)) assert.equal((await last("progress", id)).state, "offline", id);
      proxy.instead = undefined;
      for (const id of Object.keys(kinds)) {
        await done(id);
        const states = (await seen("progress", id)).map(({ detail }) => detail.state);
        assert.equal(states.filter((state, i) => state === "waiting" && states[i + 1] === "offline").length, 1, `only the first try waits: ${states}`);
      }
      await leave();
    }
    await show("");
  },
  async "problem documents of the service mean what they say"() {
    const says = (status, left) => (rest, response, allow) => left-- > 0 && response.writeHead(status, { ...allow, "content-type": "application/problem+json" })
      .end(JSON.stringify({ title: "no", status, detail: `says ${status}` }));
    // Busy: asked some more times. Too long: not asked again.
    for (const [status, asked] of [[503, 6], [429, 6], [504, 1], [500, 1]]) {
      await hasten(mine("p", `open" image="i_x" width="300"`), { instead: says(status, 100) });
      const { message, problem } = await failed("p");
      assert.deepEqual([message, problem.status, proxy.asked.filter(({ url }) => url.startsWith("/xyz")).length], [`says ${status}`, status, asked]);
      await leave();
    }
    // A stream that is busy is asked for until there is room.
    await hasten(mine("p", `open" job="${await submit(openPort, 4, 256)}"`), { instead: says(503, 8) });
    await done("p");
  },
  async "what refuses a job is named"() {
    const instead = (rest, response, allow) => response.writeHead(403, { ...allow, "content-type": "text/html" }).end("<h1>No</h1>");
    for (const hidden of [false, true]) {
      await hasten(mine("p", `open" job="x" width="300"`), { hidden, instead });
      const { status, message, problem } = await failed("p");
      assert.deepEqual([status, message, (await boxes()).says, !problem], [403, "HTTP 403", "HTTP 403", true]);
      await leave();
    }
    await show("");
  },
  async "pages where the service should be are an error that says so"() {
    const instead = (rest, response, allow) => response.writeHead(200, { ...allow, "content-type": "text/html; charset=utf-8" }).end("<!doctype html><div id=app></div>");
    for (const hidden of [false, true]) {
      await hasten(["job", "image", "scene"].map((name) => mine(name, `open" ${name}="/scene.json" width="300"`)).join(""), { hidden, instead });
      for (const name of ["job", "image", "scene"]) assert.equal((await failed(name)).message, "no answer of the service: check src");
      await leave();
    }
    await show("");
  },
  async "a key of before the module counts"() {
    const id = await submit(closedPort, 1, 128, authorization);
    await show(`${mine("p", `closed" job="${id}"`)}<script src="/early.js"></script>`);
    await done("p");
    await page.evaluate(() => { document.getElementById("p").key = "another"; });
    assert.equal((await failed("p")).status, 401);
  },
  async "requests without an answer make room for others, and are asked again"() {
    const id = await submit(openPort, 4, 256);
    let hangs = 2;
    // Three pictures that never come, and the first streams of a job.
    await hasten([1, 2, 3].map((i) => mine(`never${i}`, `open" image="i_never${i}" width="100"`)).join("")
      + mine("p", `open" scene="/scene.json" width="200" height="150"`) + mine("j", `open" job="${id}"`),
    { instead: (rest) => /never/.test(rest) || /events/.test(rest) && hangs-- > 0 });
    await done("p", 30_000);
    await done("j", 60_000);
    assert((await seen("progress", "j")).some(({ detail }) => detail.state === "offline"), "a stream that never begins is away");
    const again = (i) => proxy.asked.filter(({ url }) => url.includes(`never${i}`)).length;
    await until("more tries", () => again(1) > 1 && again(2) > 1 && again(3) > 1, 30_000);
    for (const i of [1, 2, 3]) assert.equal((await last("progress", `never${i}`)).state, "offline");
  },
  async "a long download is not cut"() {
    let downloads = 0;
    // 5 s are 100 for the page.
    await hasten(mine("p", `flood" job="flood"`), { instead: (rest, response, allow) => {
      if (!rest.endsWith("/image")) return false;
      downloads++;
      response.writeHead(200, { ...allow, "content-type": "image/png" }).write(small.subarray(0, 100));
      return setTimeout(() => response.end(small.subarray(100)), 5_000);
    } });
    await done("p", 30_000);
    assert.equal(downloads, 1);
  },
  async "scenes that wait for each other are not scenes that take long"() {
    // Three at a time, 1.2 s each: the last have waited for longer than 4 s.
    await show([...Array(12).keys()].map((i) => mine(`p${i}`, `open" scene="/scene.json" width="${48 + i}" height="32"`)).join(""), "/page",
      (rest, response, allow) => rest.startsWith("/v1/render")
        && setTimeout(() => response.writeHead(200, { ...allow, "content-type": "image/png" }).end(small), rest.includes("time:") ? 100 : 1_200));
    for (let i = 0; i < 12; i++) await done(`p${i}`);
    assert.equal(proxy.asked.filter(({ method, url }) => method === "POST" && url.startsWith("/v1/render")).length, 24, "it is asked for as a job");
    await leave();
    // One that does take long.
    let jobs = 0;
    await hasten(mine("p", `open" scene="/scene.json" width="200" height="150"`), { instead: (rest, response, allow, { headers }) => {
      jobs += headers.prefer === "respond-async";
      return rest.startsWith("/v1/render") && !rest.includes("time:") && !headers.prefer;
    } });
    await done("p");
    assert.equal(jobs, 1);
  },
  async "scripts zoom no further than people"() {
    await show("", "/index.html");
    await done("scene");
    const zoom = (...to) => page.$eval("#scene", (one, to) => { one.zoomTo(...to.map(Number)); return one.view; }, to.map(String));
    for (const scale of [0, NaN, 0.1, -3]) assert.deepEqual(await zoom(scale, 0.2, 0.2), { scale: 1, x: 0.5, y: 0.5 }, `${scale}`);
    assert.deepEqual(await zoom(4, NaN, 7), { scale: 4, x: 0.5, y: 0.875 });
    const { scale } = await zoom(1e9, 0.3, 0.3);
    for (let i = 0; i < 3; i++) await page.$eval("#scene", (one) => one.zoomBy(2));
    assert(scale > 1_000 && (await page.$eval("#scene", (one) => one.view.scale)) === scale, `${scale}`);
    await leave();
    // Without tiles.
    await show(mine("p", `flood" job="flood"`));
    await done("p");
    assert.equal(await page.$eval("#p", (one) => { one.zoomTo(1e9); return one.view.scale; }), 16);
  },
  async "a scene whose address is wrong is not sent to the service"() {
    await show(mine("p", `open" scene="/nothere.json" width="300" height="200"`));
    const { message } = await failed("p");
    assert.equal(message, `HTTP 404: ${origin}/nothere.json`);
    assert(!proxy.asked.some(({ url }) => url.startsWith("/v1/render")), "it is sent");
  },
  async "a service that is busy is asked again when it says"() {
    await show(mine("p", `open" scene="/scene.json" width="200" height="150"`).replace("<strahl", "<strahl-later").replace("</strahl", "</strahl-later"));
    Object.assign(proxy, { busy: 2, busyOn: /render/ });
    await page.evaluate((through) => {
      const made = document.createElement("strahl-picture");
      for (const [name, value] of Object.entries({ id: "late", src: through + "/open", scene: "/scene.json", width: 200, height: 150 })) made.setAttribute(name, value);
      document.body.append(made);
    }, through);
    await done("late");
    assert.equal(proxy.busyAt.length, 2);
    assert(proxy.busyAt[1] - proxy.busyAt[0] >= 950, "it does not wait as it is told");
  },
  async "elements that go stop everything, and those that come back start again"() {
    const id = await submit(openPort, 16, 512);
    await show(mine("p", `open" job="${id}"`));
    await until("tiles", async () => (await seen("progress", "p")).some(({ detail }) => detail.state === "tile"));
    await page.evaluate(() => { window.kept = document.getElementById("p"); window.kept.remove(); });
    await until("no streams", () => proxy.streams === 0, 5_000);
    const asked = proxy.asked.length;
    await pause(1_000);
    assert.equal(proxy.asked.length, asked, "it asks after it is gone");
    await page.evaluate(() => document.body.append(window.kept));
    await done("p");
    await page.evaluate(() => { for (let i = 0; i < 200; i++) { window.kept.remove(); document.body.append(window.kept); } });
    const before = (await seen("done", "p")).length;
    await until("done once more", async () => (await seen("done", "p")).length > before);
    await pause(500);
    assert.equal((await seen("done", "p")).length, before + 1);
  },
  async "five thousand events are a few requests, and lead nowhere else"() {
    await show(mine("p", `flood" job="flood"`));
    await done("p");
    const asked = proxy.asked.length;
    assert(asked < 60, `${asked} requests`);
    assert.equal((await seen("progress", "p")).filter(({ detail }) => detail.state === "tile").length, 5_000);
    return `${asked} requests`;
  },
  async "a tab that nobody sees leaves its stream, and comes back to it"() {
    const id = await submit(openPort, 12, 512);
    await show(mine("p", `open" job="${id}"`));
    const hide = (hidden) => page.evaluate((hidden) => {
      Object.defineProperty(document, "hidden", { configurable: true, value: hidden });
      document.dispatchEvent(new Event("visibilitychange"));
    }, hidden);
    await until("tiles", async () => (await seen("progress", "p")).some(({ detail }) => detail.state === "tile"));
    await hide(true);
    await until("no stream", () => proxy.streams === 0, 5_000);
    await hide(false);
    await until("a stream again", () => proxy.streams === 1, 5_000);
    await done("p");
    assert(proxy.asked.filter(({ url, method }) => method === "GET" && url.includes("/events")).at(-1).last, "it goes on where it was");
  },
  async "a capability cannot lead to another host, nor a job out of its path"() {
    for (const [attributes, refused] of [
      [`closed" job="../../livez"`, 401], [`closed" job="x" capability="//127.0.0.1:8474/"`, 401], [`closed" job="x" capability="https://elsewhere.example/c/x"`, 401],
    ]) {
      await show(mine("p", attributes));
      const { status, message } = await failed("p");
      assert.equal(status, refused, `${attributes}: ${message}`);
      await leave();
    }
    await show("");
  },
  async "the client library works in a page, too"() {
    await show("");
    const said = await page.evaluate(async (url, scene) => {
      const { Client, Problem } = await import("/client/index.js");
      const client = new Client(url), picture = await client.render(scene, { format: "pfm", width: 64, height: 36 });
      const job = await client.jobs.submit(scene, { width: 128, height: 72 }), states = [];
      for await (const { state } of job.progress()) states.push(state);
      const refused = await client.validate("{}").catch((error) => error instanceof Problem && error.mistakes.length > 0);
      const bitmap = await createImageBitmap((await job.wait()).blob());
      return { width: picture.floats().width, proved: picture.error.proved, last: states.at(-1), refused, across: bitmap.width };
    }, `${through}/open`, scene);
    assert.deepEqual(said, { width: 64, proved: 1, last: "succeeded", refused: true, across: 128 });
  },
  async "axe finds nothing, in light and dark, narrow and wide"() {
    await show("", "/index.html");
    await done("scene");
    for (const [scheme, width] of [["light", 1280], ["dark", 390]]) {
      await page.setViewport({ width, height: 800 });
      await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: scheme }, { name: "prefers-reduced-motion", value: "reduce" }]);
      const session = await page.createCDPSession();
      await session.send("Runtime.evaluate", { expression: axe });
      const { result } = await session.send("Runtime.evaluate", { expression: "axe.run().then((found) => JSON.stringify(found.violations.map((one) => one.id + ': ' + one.nodes[0].html)))", awaitPromise: true, returnByValue: true });
      assert.equal(result.value, "[]");
      await page.screenshot({ path: path.join(modules, "..", `${scheme}.png`) });
    }
  },
};

let failures = 0;
for (const [name, flow] of Object.entries(flows)) {
  if (chosen.length && !chosen.some((word) => name.includes(word))) continue;
  const started = Date.now();
  try {
    const said = await flow();
    await leave();
    console.log(`ok: ${name}${said ? ` (${said})` : ""}, ${((Date.now() - started) / 1_000).toFixed(1)} s`);
  } catch (error) {
    failures++;
    console.log(`FAILED: ${name}\n${error.stack}\n${JSON.stringify(await page?.evaluate(() => window.seen?.slice(-2)).catch(() => {}))?.slice(0, 1_000)}`);
    await page?.close().catch(() => {});
  }
}
console.log(`${problems.length} violations of the policy and errors of pages`);
problems.slice(0, 10).forEach((problem) => console.log(`  ${problem}`));
await browser.close();
host.close();
proxied.closeAllConnections();
proxied.close();
await Promise.all([open.stop(), closed.stop()]);
process.exit(failures || problems.length ? 1 : 0);
