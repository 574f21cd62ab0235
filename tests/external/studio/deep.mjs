// Deep zoom: storms of zooming and panning to 65,536 times; at most three requests; stale ones stop; refused ones come again.
import { clean, end, figure, launch, open, pause, settled } from "./page.mjs";

const browser = await launch();

/** Waits until all tiles of the view are there. */
const complete = (page, timeout = 90_000) =>
  page.waitForFunction(() => {
    const at = studio.view.value;
    const level = studio.levelOf(at.scale * devicePixelRatio);
    if (level <= 0 || at.scale <= 1) return true;
    return studio.counts.flying === 0 && studio.inSight(at, studio.size.value, level, { x: 0, y: 0 }).every(({ name }) => studio.has(name));
  }, { timeout, polling: 50 });

async function storms() {
  const page = await open(browser);
  await settled(page);
  const box = await (await page.$("canvas.canvas")).boundingBox();
  let seed = 11;
  const random = (below) => (seed = (seed * 48271) % 2147483647) % below;
  for (let storm = 0; storm < 20; storm += 1) {
    await page.keyboard.press("0");
    await page.evaluate(() => document.activeElement.blur());
    const [x, y] = [box.x + box.width * (0.3 + random(40) / 100), box.y + box.height * (0.35 + random(25) / 100)];
    await page.mouse.move(x, y);
    for (let step = 0; step < 18; step += 1) await page.mouse.wheel({ deltaY: -240 });
    if (storm % 3 === 0) {
      await page.mouse.down();
      await page.mouse.move(x + 90, y + 60, { steps: 4 });
      await page.mouse.up();
    }
  }
  const scale = await page.evaluate(() => studio.view.value.scale);
  await complete(page);
  const { most, aborted, loaded } = await page.evaluate(() => ({ ...studio.counts }));
  figure("deep zoom, 20 storms", `to ${Math.round(scale).toLocaleString("en")} times; ${loaded} tiles came, ${aborted} were aborted, ${most} in flight at most`, scale === 65_536 && most <= 3 && aborted > 0, "65,536, <= 3");
  await pause(400);
  const running = await page.evaluate(async () => (await (await fetch("readyz")).json()).running);
  figure("work after the storms", running, running === 0, "0");
  await clean(page, "storms");
}

async function refusals() {
  const page = await open(browser, {
    before: (of) => of.evaluateOnNewDocument(() => {
      const real = window.fetch;
      window.refusals = 0;
      window.fetch = async (...args) => {
        if (!String(args[0]).includes("/xyz/") || String(args[0]).endsWith(".json") || window.refusals >= 12 || Math.random() < 0.5) return real(...args);
        window.refusals += 1;
        return new Response(JSON.stringify({ type: "/problems/overloaded", title: "busy", detail: "the queue is full" }), { status: 503, headers: { "retry-after": "1", "content-type": "application/problem+json" } });
      };
    }),
  });
  await settled(page);
  const box = await (await page.$("canvas.canvas")).boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  for (let step = 0; step < 4; step += 1) await page.mouse.wheel({ deltaY: -240 });
  await pause(500);
  await complete(page);
  const { refusals, retried } = await page.evaluate(() => ({ refusals: window.refusals, retried: studio.counts.retried }));
  figure("tiles after refusals", `${refusals} refused, ${retried} asked for again, none missing`, refusals > 0 && retried === refusals);
  await clean(page, "refusals");
}

const BALL = '{ "version": 1, "image": { "width": 64, "height": 36 }, "camera": { "pinhole": { "eye": [0, 1, 5], "look_at": [0, 0, 0] } }, "render": { "antialias": false }, "objects": [{ "sphere": { "center": [0, 0, 0], "radius": 1 } }] }';

/** A picture of so many samples that its tiles are smaller than the quick ones, until both are at their places. */
async function samples() {
  const page = await open(browser);
  await page.evaluate((of) => (studio.setText(of), (studio.settings.value = { samples: "300" })), BALL);
  await page.waitForFunction(() => studio.size.value.width === 64);
  await settled(page);
  await page.evaluate(() => studio.fit());
  const box = await (await page.$("canvas.canvas")).boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.wheel({ deltaY: -240 });
  await pause(500);
  await complete(page);
  const seen = await page.evaluate(() => studio.tiles(studio.view.value, devicePixelRatio, { x: 0, y: 0 }).map(({ bitmap, side }) => [bitmap.width, side]));
  const edges = [...new Set(seen.map(([width]) => width))];
  figure("tiles of 300 samples", `${seen.length} of ${edges} pixels`, seen.length > 2 && edges.join() === "256" && new Set(seen.map(([, side]) => side)).size === 1, "256");
  await clean(page, "samples");
}

await storms();
await refusals();
await samples();
await end(browser);
