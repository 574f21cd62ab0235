// One picture by model-viewer in Chromium: MODULES CHROMIUM MODEL PICTURE SIDE [THETA PHI RADIUS TARGET ANGLE], with its defaults.

import { readFile, writeFile, mkdtemp, rm } from "node:fs/promises";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { basename, dirname, join } from "node:path";

const [modules, chromium, model, picture, side, ...camera] = process.argv.slice(2);
const { default: puppeteer } = await import(join(modules, "puppeteer-core/lib/puppeteer/puppeteer-core.js"));
const [theta, phi, radius, x, y, z, angle] = camera;
const seen = camera.length
  ? `camera-orbit="${theta}deg ${phi}deg ${radius}m" camera-target="${x}m ${y}m ${z}m" field-of-view="${angle}deg"
     min-camera-orbit="auto auto 0m" max-camera-orbit="Infinity 180deg Infinity" min-field-of-view="1deg" max-field-of-view="180deg"`
  : "";
const page = `<!doctype html><script type="module" src="/model-viewer.js"></script>
<model-viewer src="/model/${encodeURIComponent(basename(model))}" ${seen}
  interaction-prompt="none" style="width:${side}px;height:${side}px"></model-viewer>`;
const files = {
  "/": async () => ["text/html", page],
  "/model-viewer.js": async () => ["text/javascript", await readFile(join(modules, "@google/model-viewer/dist/model-viewer.min.js"))],
};
const server = createServer(async (request, response) => {
  const path = decodeURIComponent(request.url);
  try {
    const beside = async () => ["application/octet-stream", await readFile(join(dirname(model), basename(path)))];
    const [type, body] = await (files[path] ?? beside)();
    response.writeHead(200, { "Content-Type": type }).end(body);
  } catch {
    response.writeHead(404).end();
  }
});
await new Promise((listening) => server.listen(0, "127.0.0.1", listening));

const profile = await mkdtemp(join(tmpdir(), "model-viewer-"));
const quiet = ["quic", "background-networking", "component-update", "sync", "domain-reliability", "extensions"];
const browser = await puppeteer.launch({
  executablePath: chromium,
  userDataDir: profile,
  args: ["--no-sandbox", "--no-first-run", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist", ...quiet.map((what) => `--disable-${what}`)],
});
let status = 0;
try {
  const tab = await browser.newPage();
  await tab.setViewport({ width: Number(side), height: Number(side) });
  await tab.goto(`http://127.0.0.1:${server.address().port}/`);
  const shown = await tab.evaluate(
    () =>
      new Promise((done, failed) => {
        const viewer = document.querySelector("model-viewer");
        const take = () => requestAnimationFrame(() => requestAnimationFrame(() => done(viewer.toDataURL("image/png"))));
        viewer.addEventListener("error", (event) => failed(new Error(event.detail?.sourceError?.message ?? "no model")));
        viewer.loaded ? take() : viewer.addEventListener("load", take);
        setTimeout(() => failed(new Error("no picture after 60 s")), 60_000);
      }),
  );
  await writeFile(picture, Buffer.from(shown.split(",")[1], "base64"));
} catch (error) {
  console.error(`model-viewer: ${error.message.split("\n")[0]}`);
  status = 1;
}
await browser.close();
server.close();
await rm(profile, { recursive: true, force: true });
process.exit(status);
