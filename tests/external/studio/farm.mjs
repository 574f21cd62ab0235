// The page of the farm: only where there is one; nodes come and go, work waits, tiles are counted.
import { base, clean, end, figure, launch, open } from "./page.mjs";

const browser = await launch();
const page = await open(browser);
await page.waitForFunction(() => studio.panels.value.some(({ id }) => id === "farm"), { timeout: 20_000 });
await page.evaluate(() => studio.openPanel("farm"));
const words = () => page.$eval(".farm", (of) => of.textContent.replace(/\s+/g, " "));
const says = (part) => page.waitForFunction((words) => document.querySelector(".farm")?.textContent.includes(words), { timeout: 60_000 }, part);
await says("No node takes work.");
figure("without nodes", (await words()).slice(0, 60), true);
const isQuiet = (await page.$$(".farm-alarms")).length === 0;
figure("no alarm without work", isQuiet ? "none" : await words(), isQuiet);

// Work that waits, and nobody who takes it.
const body = JSON.stringify({ scene: await page.evaluate(() => JSON.parse(studio.text.value)), settings: { width: 1200, height: 800 } });
const submitted = await page.evaluate(async (text) => (await fetch("v1/jobs", { method: "POST", headers: { "content-type": "application/json" }, body: text })).status, body);
figure("a job", submitted, submitted === 202);
await says("Work waits, and no node takes it.");
figure("alarm", (await words()).slice(0, 90), true);

// Whoever runs this suite starts a node now.
console.log("node");
await says("on 1 node.");
await page.waitForFunction(() => /Tiles[1-9]/.test(document.querySelector(".farm")?.textContent ?? ""), { timeout: 60_000 });
figure("with a node", (await words()).slice(0, 60), true);
const row = await page.$eval(".farm .table tbody", (of) => of.textContent.replace(/\s+/g, " "));
figure("its row", row, row.includes("flow-node") && row.includes("ready"));
await page.setViewport({ width: 390, height: 800 });
const isInside = await page.evaluate(() => document.querySelector(".farm").scrollWidth <= document.querySelector(".farm").clientWidth);
figure("on a phone", isInside ? "nothing sticks out" : "STICKS OUT", isInside);
await clean(page, base);
await end(browser);
