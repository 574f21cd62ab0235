// Opens pages with viewers in headless Chromium and looks whether all tiles come. Called by viewers.py.
// A page is served from another address than the tiles, as it would be in use.
import fs from "node:fs";
import http from "node:http";
import path from "node:path";
import { createRequire } from "node:module";

const [modules, browserPath, service, image] = process.argv.slice(2);
const puppeteer = createRequire(path.join(modules, "x.js"))("puppeteer-core");

const openseadragon = (source) => `<!doctype html><body style="margin:0"><div id="v" style="width:900px;height:600px"></div>
<script src="/openseadragon/build/openseadragon/openseadragon.min.js"></script><script>
window.seen = { loaded: 0, failed: [], done: false };
window.viewer = OpenSeadragon({ id: "v", tileSources: ${JSON.stringify(source)}, showNavigationControl: false,
  drawer: "canvas", crossOriginPolicy: "Anonymous", animationTime: 0.1, maxZoomPixelRatio: 1 });
viewer.addHandler("open-failed", (e) => seen.failed.push(String(e.message)));
viewer.addHandler("tile-load-failed", (e) => seen.failed.push(e.tile.getUrl() + ": " + e.message));
viewer.addHandler("tile-loaded", () => seen.loaded++);
viewer.addHandler("open", () => { const t = viewer.world.getItemAt(0);
  seen.done = t.getFullyLoaded(); t.addHandler("fully-loaded-change", (e) => { seen.done = e.fullyLoaded; }); });
window.move = (x, y, zoom) => { viewer.viewport.zoomTo(viewer.viewport.getHomeZoom() * zoom);
  viewer.viewport.panTo(new OpenSeadragon.Point(x, y * 0.5)); };
</script>`;

const leaflet = (about) => `<!doctype html><link rel="stylesheet" href="/leaflet/dist/leaflet.css">
<body style="margin:0"><div id="v" style="width:900px;height:600px"></div><script src="/leaflet/dist/leaflet.js"></script><script>
window.seen = { loaded: 0, failed: [], done: false };
const size = ${JSON.stringify([about.width, about.height])}, zoom = ${about.nativezoom};
window.map = L.map("v", { crs: L.CRS.Simple, minZoom: 0, maxZoom: zoom + 2, zoomAnimation: false, fadeAnimation: false });
const at = (x, y) => map.unproject([x, y], zoom);
const layer = L.tileLayer(${JSON.stringify(service)} + "${about.tiles[0]}", { tileSize: ${about.tileSize}, noWrap: true,
  bounds: L.latLngBounds(at(0, size[1]), at(size[0], 0)), crossOrigin: true });
layer.on("tileload", () => seen.loaded++);
layer.on("tileerror", (e) => seen.failed.push(e.tile.src));
layer.on("loading", () => { seen.done = false; });
layer.on("load", () => { seen.done = true; });
map.setView(at(size[0] / 2, size[1] / 2), 0);
layer.addTo(map);
window.move = (x, y, deeper) => map.setView(at(size[0] * x, size[1] * y), Math.min(zoom + 2, Math.log2(deeper)), { animate: false });
</script>`;

const about = await (await fetch(`${service}/xyz/${image}.json`)).json();
const pages = {
  "/iiif": openseadragon(`${service}/iiif/3/${image}/info.json`),
  "/dzi": openseadragon(`${service}/dzi/${image}.dzi`),
  "/xyz": leaflet(about),
};
const types = { ".js": "text/javascript", ".css": "text/css", ".png": "image/png" };
const host = http.createServer((request, response) => {
  const { pathname } = new URL(request.url, "http://host");
  if (pages[pathname]) return response.setHeader("content-type", "text/html").end(pages[pathname]);
  const file = path.join(modules, path.normalize(pathname));
  if (!file.startsWith(modules) || !fs.existsSync(file)) return response.writeHead(404).end();
  response.setHeader("content-type", types[path.extname(file)] ?? "application/octet-stream").end(fs.readFileSync(file));
});
await new Promise((listening) => host.listen(0, "127.0.0.1", listening));
const base = `http://127.0.0.1:${host.address().port}`;

const browser = await puppeteer.launch({ executablePath: browserPath, headless: true, args: ["--no-sandbox"] });
const pause = (ms) => new Promise((over) => setTimeout(over, ms));
let failures = 0;
for (const name of Object.keys(pages)) {
  const page = await browser.newPage();
  await page.setViewport({ width: 900, height: 600 });
  const errors = [];
  page.on("pageerror", (error) => errors.push(error.message));
  page.on("response", (answer) => { if (answer.status() >= 400 && !answer.url().endsWith("favicon.ico")) errors.push(`${answer.status()} ${answer.url()}`); });
  await page.goto(base + name);
  const settled = () => page.waitForFunction(() => window.seen.done, { timeout: 120_000 });
  await settled();
  const first = await page.evaluate(() => window.seen.loaded);
  // The storm: nobody waits for what is asked for.
  let state = 7;
  const random = () => (state = (state * 16807) % 2147483647) / 2147483647;
  for (let i = 0; i < 60; i++) {
    await page.evaluate((x, y, zoom) => window.move(x, y, zoom), random(), random(), 2 ** (random() * 5));
    await pause(40);
  }
  await page.evaluate(() => { window.seen.done = false; window.move(0.5, 0.5, 4); });
  await pause(1500);
  if (name !== "/xyz") await page.evaluate(() => { window.seen.done = window.viewer.world.getItemAt(0).getFullyLoaded(); });
  else await page.evaluate(() => { window.seen.done = [...document.querySelectorAll("img.leaflet-tile")].every((tile) => tile.complete); });
  await settled();
  const seen = await page.evaluate(() => window.seen);
  // What is on the screen is a picture, not an empty page: its center differs from white and from its surroundings.
  const shot = await page.screenshot({ type: "png" });
  const problems = [...seen.failed, ...errors];
  if (first < 1 || seen.loaded <= first) problems.push(`only ${first} and then ${seen.loaded} tiles came`);
  if (shot.length < 50_000) problems.push(`the screen is nearly empty: ${shot.length} bytes of PNG`);
  console.log(`${name}: ${first} tiles at first, ${seen.loaded} after the storm, ${problems.length} problems`);
  problems.slice(0, 10).forEach((problem) => console.log(`  ${problem}`));
  failures += problems.length;
  fs.writeFileSync(path.join(modules, "..", `${name.slice(1)}.png`), shot);
  await page.close();
}
await browser.close();
host.close();
process.exit(failures ? 1 : 0);
