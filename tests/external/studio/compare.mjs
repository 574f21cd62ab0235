// Compare: wipe by pointer and keys, flip, side by side, difference, exposure, numbers, an earlier text.
import { clean, end, figure, launch, open, pause, settled, state } from "./page.mjs";

const browser = await launch();
const page = await open(browser, { fragment: "#e=mirrors/hall" });
await settled(page);
const words = (selector) => page.$eval(selector, (element) => element.textContent.replace(/\s+/g, " ").trim());
const button = (name) => page.click(`aria/${name}[role="button"]`);
/** Codes on screen at a share of the picture's width and height. */
const codes = (x, y) => page.evaluate(async (sx, sy) => {
  await new Promise((frame) => requestAnimationFrame(() => requestAnimationFrame(frame)));
  const canvas = document.querySelector("canvas.canvas");
  const { left, top, scale } = studio.view.value;
  const { width, height } = studio.size.value;
  const ratio = devicePixelRatio;
  return [...canvas.getContext("2d").getImageData((left + sx * width * scale) * ratio, (top + sy * height * scale) * ratio, 1, 1).data].slice(0, 3);
}, x, y);
const isNear = (a, b) => a.every((value, i) => Math.abs(value - b[i]) <= 3);

await page.evaluate(() => studio.openPanel("compare"));
const plain = await codes(0.9, 0.3);
await button("depth 3");
await page.waitForSelector(".wipe", { timeout: 30_000 });
await page.waitForSelector(".facts", { timeout: 30_000 });
const facts = await words(".facts");
figure("depth 3 against 100", facts, /Largest difference\s*1\d\d codes/.test(facts) && /Identical pixels\s*4\d/.test(facts));
const [leftOf, rightOf] = [await codes(0.2, 0.3), await codes(0.9, 0.3)];
figure("wipe at the middle", `right of it ${rightOf} for ${plain}`, !isNear(rightOf, plain));

// The handle: by the pointer, then by keys.
const box = await (await page.$(".wipe")).boundingBox();
await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
await page.mouse.down();
await page.mouse.move(box.x + 160, box.y + box.height / 2, { steps: 5 });
await page.mouse.up();
const dragged = Number(await page.$eval(".wipe", (of) => of.getAttribute("aria-valuenow")));
await page.focus(".wipe");
await page.keyboard.press("Home");
const home = Number(await page.$eval(".wipe", (of) => of.getAttribute("aria-valuenow")));
await page.keyboard.press("End");
const ended = await codes(0.9, 0.3);
figure("wipe by pointer and keys", `${dragged} %, Home ${home} %, End shows A`, dragged > 70 && home === 0 && isNear(ended, plain));

// Flip while the space bar is held.
await page.focus("canvas.canvas");
await page.keyboard.down("Space");
const held = await codes(0.9, 0.3);
await page.keyboard.up("Space");
const released = await codes(0.9, 0.3);
figure("space bar held", "B, and A again", isNear(held, rightOf) && isNear(released, plain));

// Side by side the cursor is in both.
await page.click('input[name="compare-mode"][value="side"]');
const canvas = await (await page.$("canvas.canvas")).boundingBox();
await page.mouse.move(canvas.x + canvas.width * 0.75, canvas.y + canvas.height / 2);
await page.waitForSelector(".pixel-pair");
const pair = await page.$$eval(".pixel-pair tbody tr", (rows) => rows.map((row) => [...row.querySelectorAll("td")].map((of) => Number(of.textContent))));
figure("values of a pixel in both", JSON.stringify(pair), pair.length === 3 && pair[2].every((value, i) => value === pair[1][i] - pair[0][i]));

// The difference: where both are equal it is black; the gain makes it brighter.
await page.click('input[name="compare-mode"][value="difference"]');
await pause(300);
const difference = await codes(0.9, 0.3);
figure("difference times 16", difference.join(", "), difference.some((value) => value > 100));

// Exposure takes floats.
await page.click('input[name="compare-mode"][value="wipe"]');
await page.focus("canvas.canvas");
for (let press = 0; press < 2; press += 1) await page.keyboard.press("[");
await page.waitForFunction(() => document.querySelector(".compare-name")?.textContent.includes("-1 EV"));
await page.waitForFunction(async (before) => {
  const canvas = document.querySelector("canvas.canvas");
  const { left, top, scale } = studio.view.value;
  const { width, height } = studio.size.value;
  return canvas.getContext("2d").getImageData(left + 0.9 * width * scale, top + 0.3 * height * scale, 1, 1).data[0] < before - 20;
}, { timeout: 30_000 }, plain[0]);
figure("one stop darker", `${await codes(0.9, 0.3)} for ${plain}`, true);

// An earlier text stays while A follows the edits.
await button("Reset");
await button("Keep this text as B");
await page.waitForFunction(() => studio.other.value?.label === "the text as it was", { timeout: 30_000 });
await page.evaluate(() => studio.editAt("/ambient", 0.9));
await settled(page);
await page.waitForFunction(() => /Largest difference\s*\d+/.test(document.querySelector(".facts")?.textContent ?? ""), { timeout: 30_000 });
const kept = await page.evaluate(() => studio.other.value.text !== studio.text.value);
await button("Go back to B's text");
await settled(page);
figure("an earlier text", "B stays, and comes back", kept && (await page.evaluate(() => studio.scene.value.ambient)) === 0.25);
figure("after the end", `layers: ${(await state(page, "layers")).map(({ id }) => id)}`, !(await state(page, "layers")).some(({ id }) => id === "compare"));

// Many comparisons leave nothing behind.
const count = () => page.evaluate(async () => {
  const { otherAsked, other } = studio;
  for (let depth = 2; depth < 12; depth += 1) {
    otherAsked.value = { label: `depth ${depth}`, settings: { accuracy: "fixed", max_depth: String(depth), width: "160", height: "100" }, text: null };
    await new Promise((over) => { const stop = other.subscribe((of) => of?.label === `depth ${depth}` && (setTimeout(() => stop()), over())); });
  }
  otherAsked.value = null;
  return studio.bitmaps.made - studio.bitmaps.closed;
});
await count();
const [first, second] = [await count(), await count()];
figure("bitmaps that stay after ten more comparisons", second - first, second === first, "0");

// A busy service: B waits as long as it says, and says so; a refusal has its words and a way on.
await page.setRequestInterception(true);
let refusals = [503, 429];
page.on("request", (request) => {
  const status = request.url().includes("max_depth=4&") || request.url().endsWith("max_depth=4") ? refusals.shift() : undefined;
  if (!status) return request.continue();
  const document = { type: "/problems/overloaded", title: "busy", status, detail: status === 400 ? "this is refused" : "busy" };
  request.respond({ status, contentType: "application/problem+json", headers: status === 400 ? {} : { "retry-after": "1" }, body: JSON.stringify(document) });
});
const ask = () => page.evaluate(() => (studio.otherAsked.value = { label: "depth 4", settings: { accuracy: "fixed", max_depth: "4" }, text: null }));
await ask();
await page.waitForFunction(() => /busy and takes it in 1 s/.test(document.querySelector(".compare-state")?.textContent ?? ""), { timeout: 10_000 });
await page.waitForFunction(() => studio.other.value?.label === "depth 4", { timeout: 30_000 });
figure("a busy service", `B came after ${2 - refusals.length} refusals`, refusals.length === 0);
await page.evaluate(() => (studio.otherAsked.value = null));
refusals = [400];
await ask();
await page.waitForFunction(() => /this is refused/.test(document.querySelector(".compare-state")?.textContent ?? ""), { timeout: 10_000 });
await button("Try again");
await page.waitForFunction(() => studio.other.value?.label === "depth 4", { timeout: 30_000 });
figure("a refusal", "its words, and a second try", true);
await clean(page, "compare");
await end(browser);
