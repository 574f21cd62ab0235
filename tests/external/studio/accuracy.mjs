// Accuracy: the dial with predictions and receipts, the trade-off, the stamp of equal bytes.
import { clean, end, figure, launch, open, pause, settled, state } from "./page.mjs";

const browser = await launch();
const page = await open(browser, { fragment: "#e=mirrors/hall&q.width=320&q.height=200" });
const inFlight = { now: 0, most: 0 };
page.on("request", (request) => request.url().includes("/v1/explain") && (inFlight.most = Math.max(inFlight.most, (inFlight.now += 1))));
for (const over of ["requestfinished", "requestfailed"]) page.on(over, (request) => request.url().includes("/v1/explain") && (inFlight.now -= 1));
const words = (selector) => page.$eval(selector, (element) => element.textContent.replace(/\s+/g, " ").trim());
await settled(page);

await page.evaluate(() => studio.openPanel("accuracy"));
await page.waitForFunction(() => [...document.querySelectorAll(".stop-time")].every((of) => of.textContent !== ""), { timeout: 30_000 });
figure("stops of the dial with a prediction", await page.$$eval(".stop", (all) => all.length), (await page.$$eval(".stop", (all) => all.length)) === 12, "12");
figure("predictions at once", inFlight.most, inFlight.most <= 4, "<= 3, and the plan");

// By the keyboard: arrows go from stop to stop.
await page.focus('input[value="depth-3"]');
await page.keyboard.press("Space");
await page.waitForFunction(() => studio.other.value?.label === "depth 3" && document.querySelector(".stop.is-chosen .stop-receipt"), { timeout: 30_000 });
const receipt = await words(".stop.is-chosen .stop-receipt");
figure("receipt of depth 3", receipt, /rays · proved ≤ \d+ · [\d.]+ % identical/.test(receipt));
const against = await page.waitForFunction(() => /at most (\d+) codes? off/.exec(document.querySelector(".chosen")?.textContent ?? "")?.[1]).then((found) => found.jsonValue());
figure("depth 3 against the scene", `${against} codes`, Number(against) > 50);
for (let step = 0; step < 2; step += 1) await page.keyboard.press("ArrowDown");
await page.waitForFunction(() => studio.other.value?.label === "depth 100", { timeout: 30_000 });
const same = await page.waitForFunction(() => /The same picture/.test(document.querySelector(".chosen")?.textContent ?? "")).then(() => true, () => false);
figure("depth 100, which the scene says", same ? "the same picture in each pixel" : "another picture", same);

// A is the finest that was seen.
await page.click('input[name="against"][value="finest"]');
await page.waitForFunction(() => studio.reference.value?.label === "depth 100", { timeout: 30_000 });
await page.click('input[value="depth-5"]');
await page.waitForFunction(() => studio.other.value?.label === "depth 5" && studio.reference.value?.label === "depth 100", { timeout: 30_000 });
await page.click('input[value="proved-0"]');
await page.waitForFunction(() => studio.reference.value?.label === "proved 0", { timeout: 30_000 });
figure("finest seen", await page.evaluate(() => studio.reference.value.label), true);

// Into the scene, and back by one step of undo.
const before = await state(page, "text");
await page.click("aria/Put it into the scene[role=\"button\"]");
const written = await page.evaluate(() => studio.scene.value.render.accuracy);
await page.waitForFunction(() => studio.steps.value.undo);
await page.evaluate(() => studio.steps.value.undo());
figure("put into the scene", JSON.stringify(written), written?.proved?.max_codes === 0 && (await state(page, "text")) === before, "one step of undo");
await settled(page);

// All measured: points are buttons, the arrows go along them.
// By its element: the panel may still move while predictions come.
await page.waitForSelector("aria/Measure all (10 s)[role=\"button\"]").then((button) => button.evaluate((of) => of.click()));
await page.waitForSelector(".plot .point", { timeout: 60_000 });
await page.waitForSelector(".advice", { timeout: 60_000 });
const points = await page.$$eval(".plot .point", (all) => all.length);
const advice = await words(".advice");
figure("trade-off", `${points} points; “${advice.slice(0, 60)}…”`, points >= 8 && advice.startsWith("Take "));
await page.$eval('.plot .point[tabindex="0"]', (of) => of.focus());
await page.keyboard.press("Home");
await page.keyboard.press("Enter");
const label = await page.evaluate(() => studio.otherAsked.value?.label);
await page.waitForFunction((name) => studio.other.value?.label === name, { timeout: 30_000 }, label);
figure("a point by the keyboard is B", label, (await page.$$eval('.plot .point[aria-pressed="true"]', (all) => all.length)) === 1);
await page.click(".points-table summary");
figure("the same as a table", `${await page.$$eval(".points-table tbody tr", (all) => all.length)} rows`, (await page.$$eval(".points-table tbody tr", (all) => all.length)) === points);

// Equal bytes, whatever the pieces.
for (const [name, expected] of [["Again", /all [\d,]+ bytes of its pixels are the same/], ["By tiles", /all [\d,]+ bytes of its pixels are the same \(\d+ tiles/], ["Double", /pixels differ, by at most \d+ code|are the same/]]) {
  await page.click(`aria/${name}[role="button"]`);
  await page.waitForFunction((of) => [...document.querySelectorAll(".stamp-results li")].some((li) => li.textContent.includes(of) && !li.classList.contains("is-running")), { timeout: 60_000 }, name);
  const said = await page.$$eval(".stamp-results li", (all, of) => all.find((li) => li.textContent.includes(of)).textContent.replace(/\s+/g, " "), name);
  figure("stamp", said, expected.test(said));
}

// An edit makes everything about the old text go away.
await page.evaluate(() => studio.editAt("/ambient", 0.3));
await page.waitForSelector(".stale-note");
figure("after an edit", "the trade-off says that it is old, receipts are gone", (await page.$$eval(".stop-receipt", (all) => all.length)) === 0);
await pause(200);
await clean(page, "accuracy");
await end(browser);
