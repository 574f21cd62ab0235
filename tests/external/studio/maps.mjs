// Maps: coarse first, whole later; the numbers are those of the service; looks; cancel; an edit.
import { clean, end, figure, launch, open, pause, settled, state } from "./page.mjs";

const browser = await launch();
const page = await open(browser);
const asked = [];
page.on("request", (request) => request.url().includes("/v1/map") && asked.push(new URL(request.url()).searchParams));
await settled(page);
await page.evaluate(() => studio.openPanel("maps"));
await page.waitForSelector(".map-kind");
const words = (selector) => page.$eval(selector, (element) => element.textContent.replace(/\s+/g, " ").trim());
const layer = async () => (await state(page, "layers")).some(({ id }) => id === "map");
const whole = () => page.waitForFunction(() => document.querySelector(".legend") && !document.querySelector(".map-progress progress"), { timeout: 60_000 });

for (const kind of await page.$$eval('input[name="map"]', (all) => all.map(({ value }) => value).filter(Boolean))) {
  await page.click(`input[name="map"][value="${kind}"]`);
  // Objects have a table of colors in place of a scale.
  const legend = kind === "object" ? ".maps .table" : ".legend-ticks";
  await page.waitForSelector(legend, { timeout: 60_000 });
  await page.waitForFunction(() => !document.querySelector(".map-progress progress"), { timeout: 60_000 });
  figure(`map of ${kind}`, (await words(legend)).slice(0, 60), await layer());
}
const steps = asked.filter((of) => of.get("of") === "rays").map((of) => of.get("step"));
figure("coarse first", steps.join(", then "), steps.join() === "8,1");

// The number under the pointer is the one of the service.
// The coarse map has others, and the legend may be that of the map before.
const all = page.waitForResponse((of) => /[?&]of=rays&.*step=1(&|$)/.test(of.url()));
await page.click('input[name="map"][value="rays"]');
await all;
await whole();
await pause(200);
const canvas = await (await page.$("canvas.canvas")).boundingBox();
await page.mouse.move(canvas.x + canvas.width * 0.45, canvas.y + canvas.height * 0.5);
await page.waitForFunction(() => /^Pixel/.test(document.querySelector(".facts .fact dt")?.textContent ?? ""));
const shown = await page.$eval(".facts .fact", (of) => of.textContent.replace(/\s+/g, " "));
const truth = await page.evaluate(async () => {
  const { x, y } = studio.hover.value;
  const answer = await fetch("v1/map?of=rays&format=pfm", { method: "POST", body: studio.text.value, headers: { "content-type": "application/json" } });
  const buffer = await answer.arrayBuffer();
  const head = new TextDecoder("latin1").decode(buffer.slice(0, 64)).split("\n");
  const [width, height] = head[1].split(" ").map(Number);
  const channels = head[0] === "PF" ? 3 : 1;
  const from = head.slice(0, 3).join("\n").length + 1;
  return { x, y, value: new DataView(buffer).getFloat32(from + 4 * channels * ((height - 1 - y) * width + x), true) };
});
figure("the number under the pointer", shown, shown.includes(`Pixel ${truth.x}, ${truth.y}`) && shown.includes(`${truth.value.toLocaleString("en")} ray`), `${truth.value} by the service`);

// Looks change what is drawn.
const drawn = () => page.evaluate(async () => {
  await new Promise((over) => setTimeout(over, 150));
  const of = document.querySelector("canvas.canvas");
  const { left, top, scale } = studio.view.value;
  return [...of.getContext("2d").getImageData(left + 0.45 * 960 * scale, top + 0.2 * 540 * scale, 1, 1).data].join();
});
const looks = new Set([await drawn()]);
await page.click('input[name="map-ramp"][value="viridis"]');
looks.add(await drawn());
await page.click('input[name="map-scale"][value="linear"]');
await page.focus('.slider input[type="range"]');
await page.keyboard.press("Home");
looks.add(await drawn());
figure("looks", `${looks.size} different colors`, looks.size === 3);

// An edit: a new map, and only one request more for each step however many keys.
await page.click('input[name="map"][value="depth"]');
await whole();
asked.length = 0;
await page.evaluate(async () => {
  for (let edit = 0; edit < 10; edit += 1) {
    studio.editAt("/objects/0/sphere/radius", 1 + edit / 50);
    await new Promise((over) => setTimeout(over, 60));
  }
});
await pause(300);
await settled(page);
await whole();
await page.waitForFunction(() => !document.querySelector(".stale-note"));
figure("requests after ten quick edits", asked.length, asked.length <= 4, "<= 4");

// Stop: the service has nothing more to do.
await page.evaluate(() => studio.editAt("/objects/0/sphere/radius", 1.33));
// In one step, since a map may be whole before a click arrives.
const stop = () => {
  const button = document.querySelector(".map-progress progress") && [...document.querySelectorAll("button")].find((of) => of.textContent.trim() === "Stop");
  button?.click();
  return Boolean(button);
};
await page.waitForFunction(stop, { timeout: 20_000 });
await pause(300);
figure("stopped", `${await layer()}`, !(await layer()));
await clean(page, "maps");
await end(browser);
