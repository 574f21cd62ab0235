// The panel of the plan: by time, measured, with links, without an effect; and what could go wrong.
import { base, clean, end, figure, launch, open, pause, settled, state } from "./page.mjs";

const browser = await launch();
const words = (page, selector) => page.$eval(selector, (element) => element.textContent.replace(/\s+/g, " ").trim());
const rows = (page) => page.$$eval(".plan-row", (all) => all.map((row) => ({ name: row.querySelector(".fold").textContent, last: row.lastElementChild.textContent.trim() })));
const press = (page, label) => page.evaluate((of) => [...document.querySelectorAll(".panels button")].find((button) => button.textContent.trim().startsWith(of)).click(), label);
const planned = (page) => page.waitForFunction(() => document.querySelector(".plan-row"), { timeout: 20_000 });

const page = await open(browser, { fragment: "#e=whitted/whitted" });
await settled(page);
await page.evaluate(() => studio.openPanel("plan"));
await planned(page);
const requests = [];
page.on("request", (request) => request.url().includes("analyze=1") && requests.push(request.url()));
figure("in a sentence", await words(page, ".plan-body .lead"), /^\d+ effects are on\./.test(await words(page, ".plan-body .lead")));

/** Milliseconds of a cell. */
const ms = (text) => {
  const found = /^([\d.]+) (ms|s|min)$/.exec(text);
  return found ? Number(found[1]) * { ms: 1, s: 1000, min: 60000 }[found[2]] : null;
};
const isSorted = (list) => {
  const times = list.map(({ last }) => ms(last) ?? -1);
  return times.every((value, at) => at === 0 || value <= times[at - 1]);
};
const estimated = await rows(page);
figure("sorted by time", estimated.slice(0, 4).map(({ name, last }) => `${name} ${last}`).join(", "), isSorted(estimated) && ms(estimated[0].last) !== null && estimated.some(({ last }) => last === "no rays of its own"));

// A reason leads to its line.
const at = estimated.findIndex(({ name }) => name === "Refraction");
await page.evaluate((index) => document.querySelectorAll(".plan-row .fold")[index].click(), at);
await page.waitForSelector(".plan-because .pointer");
await page.click(".plan-because .pointer");
figure("a reason leads to its line", (await state(page, "revealed")).pointer, (await state(page, "revealed")).pointer === "/materials/glass/ior");

// Measured: what it took beside what was estimated.
await press(page, "Measure");
await page.waitForFunction(() => document.querySelector(".plan-totals thead th:nth-child(4)"), { timeout: 60_000 });
const truth = await page.evaluate(async () => {
  const folder = document.querySelector("script[type=module]").src.replace(/main\.js$/, "");
  const { measured } = await import(`${folder}panels/plan-measured.js`);
  return measured.value.plan;
});
const shadows = truth.effects.find(({ effect }) => effect === "shadows");
const list = await rows(page);
await page.evaluate((index) => document.querySelectorAll(".plan-row .fold")[index].click(), list.findIndex(({ name }) => name === "Shadows"));
await pause(50);
const details = await page.$$eval(".plan-details", (all) => all.map((of) => of.textContent).join(" "));
figure("measured", await words(page, ".plan-totals tbody"), isSorted(list) && details.includes("counted") && truth.actual.rays.shadow === shadows.act.rays);
await page.evaluate(() => studio.editAt("/objects/1/sphere/radius", 0.9));
await page.waitForFunction(() => !document.querySelector(".plan-totals thead th:nth-child(4)"));
figure("an edit", await words(page, ".plan-measure"), (await words(page, ".plan-measure")).startsWith("Measured before the last edit."));
requests.length = 0;
await press(page, "Measure again");
await page.waitForSelector(".plan-measure .spinner");
await press(page, "Stop");
await pause(300);
figure("stopped", await words(page, ".plan-measure"), (await page.$(".spinner")) === null && requests.length === 1);

// Without it: B is the scene without the effect, and nothing of the text changes.
const text = await state(page, "text");
await page.evaluate(() => [...document.querySelectorAll(".plan-row .fold")].forEach((of) => of.getAttribute("aria-expanded") === "false" && of.click()));
await page.evaluate(() => [...document.querySelectorAll(".plan-row")].find((row) => row.textContent.startsWith("Transmission")).nextElementSibling.querySelector(".plan-actions button").click());
await page.waitForFunction(() => studio.otherAsked.value !== null, { timeout: 10_000 });
const other = await state(page, "otherAsked");
const effects = await page.evaluate(async ({ text: own, settings }) => {
  const query = new URLSearchParams(settings);
  const answer = await fetch(`v1/explain?${query}`, { method: "POST", headers: { "content-type": "application/json" }, body: own ?? studio.text.value });
  return (await answer.json()).effects.find(({ effect }) => effect === "transmission").state;
}, other);
figure("without it", `${other.label}: ${effects}`, other.label === "without transmission" && effects !== "on" && (await state(page, "text")) === text);

// A text that is no scene: the last plan stays, and it is said.
await page.evaluate(() => studio.editAt("/objects/1/sphere/material", "glas"));
await page.waitForSelector(".panel-state.invalid");
figure("an unsound text", await words(page, ".panel-state.invalid"), (await page.$(".plan-row")) !== null);
await clean(page, "plan");

// A link to a row opens it.
const linked = await open(browser, { fragment: "#e=effects/gloss&plan=gloss" });
await planned(linked);
await linked.waitForSelector(".plan-row.linked");
figure("a link to a row", await words(linked, ".plan-row.linked .fold"), (await words(linked, ".plan-row.linked .fold")) === "Gloss" && (await linked.$(".plan-more.linked .plan-details")) !== null);
await linked.click(".plan-more.linked .plan-link");
await pause(200);
const copied = await linked.evaluate(() => navigator.clipboard.readText());
figure("the link is copied", copied.replace(base, "").slice(0, 60), /[#&]plan=gloss$/.test(copied));
await clean(linked, "a link to a row");
await end(browser);
