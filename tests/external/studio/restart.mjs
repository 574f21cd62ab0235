// The service is killed under an open page and starts again: it says so, the text is safe, the job goes on. studio.py kills and
// starts it when this program says so.
import readline from "node:readline";
import { clean, end, figure, launch, open, settled } from "./page.mjs";

const input = readline.createInterface({ input: process.stdin })[Symbol.asyncIterator]();
const order = async (word) => {
  console.log(word);
  await input.next();
};
const browser = await launch();
const page = await open(browser);
await settled(page);
await page.evaluate(() => studio.editAt("/objects/0/sphere/radius", 1.0625));
await settled(page);
const before = await page.evaluate(() => ({ text: studio.text.value, digest: studio.report.value.digest }));

const job = await page.evaluate(async () => {
  const body = JSON.stringify({ scene: JSON.parse(studio.text.value), settings: { samples: 64, width: 1280, height: 720 } });
  return (await fetch("v1/jobs", { method: "POST", body, headers: { "content-type": "application/json", "idempotency-key": "restart" } })).json();
});
await page.waitForFunction(async (id) => (await (await fetch(`v1/jobs/${id}`)).json()).progress?.fraction > 0.05, { polling: 200, timeout: 60_000 }, job.id).catch(() => {});
await order("kill");
let started = Date.now();
await page.evaluate(() => studio.editAt("/objects/0/sphere/radius", 1.25));
await page.waitForFunction(() => document.querySelector(".state").innerText.startsWith("offline"), { polling: 20, timeout: 20_000 });
figure("offline is said after", `${Date.now() - started} ms`, Date.now() - started <= 3000, "<= 3000 ms");
const during = await page.evaluate(() => studio.shown.value !== null && studio.text.value.includes("1.25"));
figure("text and picture stay", during, during);
await order("start");
started = Date.now();
await page.waitForFunction(() => studio.connection.value.online, { polling: 20, timeout: 20_000 });
figure("back after the port answers", `${Date.now() - started} ms`, Date.now() - started <= 5000, "<= 5000 ms");
await settled(page);
const after = await page.evaluate(() => studio.report.value.text ?? studio.shown.value.text);
figure("the edit made meanwhile is rendered", after.includes("1.25"), after.includes("1.25"));
await page.evaluate(() => studio.editAt("/objects/0/sphere/radius", 1.0625));
await settled(page);
const digest = await page.evaluate(() => studio.report.value.digest);
figure("the same scene has the same bytes", digest.slice(0, 8), digest === before.digest);
const known = await page.evaluate(async (id) => (await fetch(`v1/jobs/${id}`)).json(), job.id);
figure("the job goes on", known.state, ["queued", "running", "succeeded"].includes(known.state));
await clean(page, "restart");
await end(browser);
