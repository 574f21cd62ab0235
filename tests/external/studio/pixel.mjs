// The panel of a pixel: its rays add up to it, everywhere; outline, links, overlay, samples, the outside view; and what could go wrong.
import { caretAt, clean, end, figure, launch, open, pause, settled, state } from "./page.mjs";

const browser = await launch();
const scenes = ["whitted/whitted", "refraction/glass_of_water", "mirrors/hall", "effects/gloss", "effects/dispersion"];
/** Reproducible pixels. */
let seed = 1979;
const random = (below) => ((seed = (seed * 1103515245 + 12345) % 2147483648), seed % below);

/** A page with the modules of the panel as `pixels`. */
async function start(options) {
  const page = await open(browser, options);
  await page.evaluate(async () => {
    const folder = document.querySelector("script[type=module]").src.replace(/main\.js$/, "");
    window.pixels = { ...(await import(`${folder}panels/pixel-asked.js`)), ...(await import(`${folder}panels/pixel-objects.js`)), ...(await import(`${folder}panels/pixel-glow.js`)) };
    studio.openPanel("pixel");
  });
  return page;
}

const choose = (page, x, y) => page.evaluate((at) => studio.openPanel("pixel") ?? (studio.pixel.value = at), { x, y });
const answered = (page) => page.waitForFunction(() => pixels.answer.value !== null && !pixels.isStale.value && pixels.asking.value.state === "idle", { timeout: 30_000, polling: 10 });
const words = (page, selector) => page.$eval(selector, (element) => element.textContent.replace(/\s+/g, " ").trim());

// 50 pixels of each scene: as many rows as rays, and the sum is the value, bit by bit.
let [pixelCount, rayCount, most] = [0, 0, 0];
const off = [];
for (const example of scenes) {
  const page = await start({ fragment: `#e=${example}` });
  const { width, height } = await state(page, "size");
  for (let at = 0; at < 50; at += 1) {
    const [x, y] = [random(width), random(height)];
    await choose(page, x, y);
    await answered(page);
    const found = await page.evaluate(() => {
      const { grown, sum } = pixels.answer.value;
      let rows = 0;
      grown.roots.forEach((_, sample) => {
        pixels.chooseSample(sample);
        rows += pixels.rows.value.filter(({ stub }) => !stub).length;
      });
      return { rows, rays: grown.tree.rays.length, isEqual: sum.sum.every((value, c) => Object.is(value, grown.tree.value[c])) };
    });
    pixelCount += 1;
    rayCount += found.rays;
    most = Math.max(most, found.rays);
    const said = await words(page, ".verdict");
    if (found.rows !== found.rays || !found.isEqual || !said.startsWith("= the pixel, to the last bit")) off.push(`${example} ${x},${y}: ${JSON.stringify(found)} ${said}`);
  }
  await clean(page, example);
}
figure(`${pixelCount} pixels, ${rayCount} rays, at most ${most} in one`, off.length === 0 ? "rows = rays, sum = value" : off.slice(0, 5).join("; "), off.length === 0);

const page = await start();
await settled(page);
const requests = [];
page.on("request", (request) => request.url().includes("/v1/") && requests.push(request.url().replace(/.*\/v1\//, "")));

// A click: the rays, the line, the drawing.
const canvas = await (await page.$("canvas.canvas")).boundingBox();
const place = await page.evaluate(() => ({ left: studio.view.value.left, top: studio.view.value.top, scale: studio.view.value.scale }));
const point = (x, y) => [canvas.x + place.left + (x + 0.5) * place.scale, canvas.y + place.top + (y + 0.5) * place.scale];
await page.mouse.move(...point(400, 300));
await page.mouse.down();
await page.mouse.up();
await answered(page);
await pause(100);
const isDrawn = async () => (await state(page, "layers")).some(({ id }) => id === "pixel-rays");
figure("a click", `${await words(page, ".rays-head h3")}, line of ${(await state(page, "revealed"))?.pointer}`, (await state(page, "revealed"))?.pointer === "/objects/1" && (await isDrawn()));
const focus = await page.evaluate(() => document.activeElement.className);
figure("the focus stays in the picture", focus, focus.startsWith("canvas"));
await page.click(".rays-head button");
figure("drawing off", String(await isDrawn()), !(await isDrawn()));
await page.click(".rays-head button");

// The outline by keys alone.
await page.focus(".ray-tree");
const chosen = () => page.evaluate(() => [pixels.chosen.value, pixels.rows.value.length, document.getElementById(document.activeElement.getAttribute("aria-activedescendant"))?.textContent.replace(/\s+/g, " ").trim()]);
const trail = [];
for (const key of ["ArrowDown", "ArrowDown", "ArrowLeft", "ArrowLeft", "ArrowLeft", "ArrowLeft", "ArrowRight", "ArrowRight", "End", "Home", "s", "r"]) {
  await page.keyboard.press(key);
  trail.push((await chosen()).slice(0, 2).join("/"));
}
const [, , label] = await chosen();
figure("outline by keys", trail.join(" "), new Set(trail).size >= 8 && typeof label === "string" && label.length > 10, label);
await page.keyboard.press("Home");
await page.keyboard.press("ArrowDown");
await page.keyboard.press("Enter");
figure("Enter goes to the line", (await state(page, "revealed")).pointer, (await state(page, "revealed")).pointer === "/objects/2");

// Links: row to text and picture, picture to row, caret to picture.
await page.hover(".ray-row:nth-of-type(2)");
await pause(50);
const lit = await state(page, "lit");
figure("a row lights its object", lit.join(), lit.length === 1 && lit[0].startsWith("/objects/"));
await page.mouse.move(...point(480, 240));
await page.waitForFunction(() => pixels.objects.value !== null, { timeout: 10_000 });
await pause(400);
figure("the pointer lights the object under it", (await state(page, "lit")).join(), (await state(page, "lit"))[0]?.startsWith("/objects/") && (await state(page, "layers")).some(({ id }) => id === "object"));
await page.mouse.move(10, 10);
await caretAt(page, "/objects/0/sphere/radius");
await pause(200);
figure("the caret lights its object", await state(page, "caret"), (await state(page, "layers")).some(({ id }) => id === "object"));
// The floor in the mirror ball: a part of its pixels, none of the sky's.
await caretAt(page, "/objects/3/quad/material");
await page.waitForFunction(() => pixels.glow.value?.pointer === "/objects/3", { timeout: 20_000 });
const shares = await page.evaluate(() => {
  const { canvas, step } = pixels.glow.value;
  return [[350, 375], [480, 20], [200, 500]].map(([x, y]) => canvas.getContext("2d").getImageData(Math.floor(x / step), Math.floor(y / step), 1, 1).data[3]);
});
figure("it glows in mirrors, too", `in the mirror ball ${shares[0]}, in the sky ${shares[1]}, on the floor ${shares[2]} of 130`, shares[0] > 20 && shares[0] < shares[2] && shares[1] === 0);

// Samples: at an edge there are several, and the odd one is found.
await choose(page, 400, 300);
await answered(page);
const edge = await page.evaluate(async () => {
  for (let x = 300; x < 600; x += 3) {
    studio.pixel.value = { x, y: 320 };
    while (pixels.isStale.value) await new Promise((over) => setTimeout(over, 5));
    if (pixels.answer.value.grown.roots.length > 1) return x;
  }
  return null;
});
await page.waitForSelector(".samples");
await page.click('.samples button[aria-label="Next sample"]');
const second = await words(page, ".samples-at");
await page.click(".samples > .button:last-child");
figure("samples", `pixel ${edge}, 320: ${second}, then ${await words(page, ".samples-at")}`, second.startsWith("Sample 2 of"));

// The outside view turns, and asks what is hidden once it rests.
await page.click(".outside .fold");
await page.waitForFunction(() => document.querySelector(".outside-view canvas")?.width > 100);
const settledOutside = async () => {
  const count = requests.length;
  await pause(1500);
  return requests.slice(count).filter((of) => of.startsWith("rays")).length;
};
await settledOutside();
const drawn = () => page.$eval(".outside-view canvas", (of) => [...of.getContext("2d").getImageData(0, 0, of.width, of.height).data].reduce((sum, value, at) => (sum * 31 + value * (at % 7)) % 1000003, 7));
const before = await drawn();
requests.length = 0;
await page.focus(".outside-view canvas");
for (let turn = 0; turn < 6; turn += 1) await page.keyboard.press("ArrowRight");
await page.waitForFunction(() => true);
await pause(2000);
const asked = { renders: requests.filter((of) => of.startsWith("render")).length, rays: requests.filter((of) => of.startsWith("rays")).length };
figure("the outside view", `6 turns: ${asked.renders} renders, ${asked.rays} questions what is hidden`, (await drawn()) !== before && asked.renders <= 8 && asked.rays >= 1 && asked.rays <= 2);
await page.click(".outside .fold");

// Deep zoom: the rays of a place far inside a pixel.
await page.evaluate(() => studio.zoomBy(4096, ...[studio.view.value.left + 400.4 * studio.view.value.scale, studio.view.value.top + 300.6 * studio.view.value.scale]));
await pause(300);
const inside = await page.evaluate(() => [studio.view.value.left + 400.4003 * studio.view.value.scale, studio.view.value.top + 300.6002 * studio.view.value.scale]);
await page.mouse.move(canvas.x + inside[0], canvas.y + inside[1]);
await page.mouse.down();
await page.mouse.up();
await answered(page);
const deep = await page.evaluate(() => ({ ...pixels.answer.value.spot, pixel: pixels.answer.value.grown.tree.pixel.join(), verdict: pixels.answer.value.sum.verdict, precision: pixels.answer.value.grown.tree.precision }));
figure("inside of a pixel", JSON.stringify(deep), deep.zoom >= 11 && deep.pixel === `${deep.x},${deep.y}` && Math.abs(deep.x / 2 ** deep.zoom - 400.4003) < 1e-3 && deep.verdict === "exact" && deep.precision === "double");
await page.evaluate(() => studio.fit());
await page.evaluate(() => [...document.querySelectorAll(".pixel-where button")].find((of) => of.textContent === "Whole pixel").click());
await answered(page);
figure("the whole pixel again", (await page.evaluate(() => pixels.answer.value.grown.tree.pixel)).join(", "), (await page.evaluate(() => pixels.answer.value.grown.tree.pixel.join())) === "400,300");

// Twenty edits while answers are late: one tree at the end, of the last text.
await page.setRequestInterception(true);
let flying = 0;
let together = 0;
const late = async (request) => {
  if (!request.url().includes("/v1/tree") || request.url().includes("max_depth=1")) return request.continue();
  flying += 1;
  together = Math.max(together, flying);
  await pause(random(300));
  await request.continue().catch(() => {});
};
const landed = (request) => request.url().includes("/v1/tree") && !request.url().includes("max_depth=1") && (flying -= 1);
page.on("request", late);
page.on("requestfinished", landed);
page.on("requestfailed", landed);
requests.length = 0;
for (let edit = 0; edit < 20; edit += 1) {
  await page.evaluate((radius) => studio.editAt("/objects/1/sphere/radius", radius), 1 + edit / 100);
  await pause(60);
}
await answered(page);
const trees = requests.filter((of) => of.startsWith("tree") && !of.includes("max_depth=1")).length;
const isLast = await page.evaluate(() => pixels.answer.value.version === studio.version.value && pixels.answer.value.text === studio.text.value);
figure("20 quick edits", `${trees} trees asked for, at most ${together} at a time`, isLast && trees <= 4, "<= 4");
requests.length = 0;
for (let move = 0; move < 30; move += 1) await choose(page, 300 + move, 280);
await answered(page);
figure("30 quick moves", `pixel ${(await page.evaluate(() => pixels.answer.value.grown.tree.pixel)).join(", ")}`, (await page.evaluate(() => pixels.answer.value.grown.tree.pixel[0])) === 329);
page.off("request", late);
await page.setRequestInterception(false);

// A text that is no scene, and a service that is away: the last rays stay, and it is said why.
await page.evaluate(() => studio.editAt("/objects/1/sphere/material", "glas"));
await page.waitForSelector(".panel-state.invalid");
figure("an unsound text", await words(page, ".panel-state.invalid"), (await page.$(".ray-tree")) !== null);
await page.evaluate(() => studio.editAt("/objects/1/sphere/material", "glass"));
await answered(page);
await page.setOfflineMode(true);
await choose(page, 500, 290);
await page.waitForSelector(".panel-state.offline");
figure("the service is away", await words(page, ".panel-state.offline span"), (await page.$(".ray-tree")) !== null);
await page.setOfflineMode(false);
await answered(page);
figure("the service is back", (await page.evaluate(() => pixels.answer.value.grown.tree.pixel)).join(", "), (await page.$(".panel-state.offline")) === null);
await page.evaluate(() => studio.editAt("/image", { width: 320, height: 180 }));
await page.waitForSelector(".panel-state.outside");
await page.click(".panel-state.outside button");
await answered(page);
figure("a smaller picture", JSON.stringify(await state(page, "pixel")), (await state(page, "pixel")).x === 319);
await clean(page, "pixel");

// Very many rays: few of them are in the page, and they still add up.
const large = await start();
await large.evaluate(() => {
  studio.live.value = false;
  const scene = JSON.parse(studio.text.value);
  scene.image = { width: 8, height: 8 };
  scene.materials.glass.reflection = 0.5;
  scene.camera.pinhole.vfov_deg = 20;
  scene.camera.pinhole.look_at = scene.objects[1].sphere.center;
  scene.render = { accuracy: { fixed: {} }, max_depth: 18, min_weight: 0, antialias: false };
  studio.setText(JSON.stringify(scene));
});
await choose(large, 4, 3);
await large.waitForFunction(() => document.querySelector(".panel-state.large") || (pixels.answer.value && !pixels.isStale.value), { timeout: 60_000 });
if (await large.$(".panel-state.large")) await large.click(".panel-state.large button");
await answered(large);
await large.focus(".ray-tree");
await large.keyboard.press("End");
await pause(200);
const many = await large.evaluate(() => ({ rays: pixels.answer.value.grown.tree.rays.length, elements: document.querySelectorAll(".ray-row").length, verdict: pixels.answer.value.sum.verdict, isTruncated: pixels.answer.value.grown.tree.truncated, seen: document.getElementById(document.activeElement.getAttribute("aria-activedescendant")) !== null }));
figure("very many rays", JSON.stringify(many), many.rays > 5000 && many.elements < 60 && many.seen && many.verdict === (many.isTruncated ? "truncated" : "exact"));
await clean(large, "very many rays");

// Names that want to run.
const hostile = await start();
const names = ['<img src=x onerror="window.ran=1">', '"><script>window.ran=1</script>', "\u202Eeman", "a".repeat(256), "${window.ran=1}", "javascript\u003awindow.ran=1"];
await hostile.evaluate((all) => {
  const materials = Object.fromEntries(all.map((name, at) => [name.slice(0, 200) + at, { diffuse: 0.1, transmission: 0.8, ior: 1.4 }]));
  const objects = all.map((name, at) => ({ sphere: { center: [at * 2 - 5, 0, 0], radius: 0.95, material: name.slice(0, 200) + at, name } }));
  studio.setText(JSON.stringify({ version: 1, image: { width: 360, height: 120 }, camera: { orthographic: { eye: [0, 0, 9], look_at: [0, 0, 0], height: 4 } }, materials, objects }));
}, names);
const shown = [];
for (let at = 0; at < names.length; at += 1) {
  await choose(hostile, 180 + (at * 2 - 5) * 30, 60);
  await answered(hostile);
  await pause(50);
  shown.push(await hostile.$eval(".ray-name", (of) => of.textContent));
}
const ran = await hostile.evaluate(() => window.ran ?? document.querySelectorAll(".panels img, .panels script, .panels iframe").length);
figure("hostile names", shown.map((name) => name.slice(0, 12)).join(" "), ran === 0 && shown.join() === names.join());
const wide = await hostile.$eval(".tab-panel", (of) => of.scrollWidth - of.clientWidth);
figure("nothing is wider than the panel", `${wide} px`, wide <= 0);
await clean(hostile, "hostile names");
await end(browser);
