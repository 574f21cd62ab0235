// Jobs: an empty list, hostile labels, a submission, the viewport, priority, cancel with undo, links, filters, an address.
import { clean, end, figure, launch, open, pause, settled } from "./page.mjs";

const browser = await launch();
const page = await open(browser, { fragment: "#e=mirrors/hall" });
const button = (name) => page.click(`aria/${name}[role="button"]`);
const rows = () => page.$$eval(".job", (all) => all.map((row) => row.textContent.replace(/\s+/g, " ").trim()));
const api = (path, options = {}) => page.evaluate(async (to, of) => {
  const answer = await fetch(to, of);
  return { status: answer.status, body: (answer.headers.get("content-type") ?? "").includes("json") ? await answer.json() : null };
}, path, options);
const post = (body) => api("v1/jobs", { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(body) });
await settled(page);
await page.evaluate(() => studio.openPanel("jobs"));
await page.waitForSelector(".curl");
figure("empty", (await page.$eval(".curl", (of) => of.textContent)).slice(0, 60), true);

// Labels that strangers wrote are text.
const HOSTILE = ["<img src=x onerror=alert(1)>", "\u202Egnp.exe", "javascript:alert(1)", "'\"><script>alert(1)</script>", "a".repeat(64), "\u0000\u0007", "${alert(1)}", "🂡".repeat(20)];
const scene = await page.evaluate(() => JSON.parse(studio.text.value));
await post({ scene, settings: { width: 40, height: 25 }, labels: HOSTILE.filter((label) => label !== "\u0000\u0007") });
await page.waitForFunction(() => document.querySelector(".job")?.textContent.includes("onerror"), { timeout: 20_000 });
const injected = await page.evaluate(() => document.querySelectorAll(".jobs img, .jobs script, .jobs [onerror]").length);
const isInside = await page.evaluate(() => document.querySelector(".jobs").scrollWidth <= document.querySelector(".jobs").clientWidth);
figure("hostile labels", `${injected} elements made, ${isInside ? "nothing sticks out" : "STICKS OUT"}`, injected === 0 && isInside);

// A submission by the keyboard.
await page.focus("canvas.canvas");
await page.keyboard.press("n");
await page.waitForSelector(".job-form");
const fill = (name, value) => page.evaluate((label, words) => {
  const input = [...document.querySelectorAll(".job-form label")].find((of) => of.textContent.startsWith(label)).querySelector("input");
  input.value = words;
  input.dispatchEvent(new Event("input", { bubbles: true }));
}, name, value);
await fill("Width", "1920");
await fill("Height", "1200");
await fill("Samples", "128");
await fill("Labels", "night, studio");
await page.waitForFunction(() => /Should take/.test(document.querySelector(".job-estimate")?.textContent ?? ""), { timeout: 20_000 });
figure("prediction in the dialog", await page.$eval(".job-estimate", (of) => of.textContent.replace(/\s+/g, " ")), true);
await button("Render it");
await page.waitForSelector(".job-caption", { timeout: 20_000 });
await page.waitForFunction(() => studio.layers.value.some(({ id }) => id === "job"), { timeout: 60_000 });
figure("in the viewport", await page.$eval(".job-caption", (of) => of.textContent.replace(/\s+/g, " ")), true);

// What is under the pointer comes first.
const looked = [];
page.on("request", (request) => request.url().includes("/look") && looked.push(new URL(request.url()).searchParams.toString()));
const canvas = await (await page.$("canvas.canvas")).boundingBox();
await page.mouse.move(canvas.x + canvas.width * 0.3, canvas.y + canvas.height * 0.5);
await pause(700);
await page.mouse.move(canvas.x + canvas.width * 0.7, canvas.y + canvas.height * 0.5, { steps: 20 });
await pause(700);
figure("wishes for tiles", looked.join("; "), looked.length >= 2 && looked.length <= 5 && new Set(looked).size > 1, "2 to 5 for a sweep, the last one too");

// Priority: somebody else was first.
const id = await page.evaluate(() => document.querySelector(".job.is-running, .job.is-queued").dataset.job);
await page.evaluate((of) => document.querySelector(`[data-job="${of}"] [aria-label="Higher priority"]`).click(), id);
await page.waitForFunction((of) => document.querySelector(`[data-job="${of}"] .priority`)?.textContent === "60", { timeout: 10_000 }, id);
await pause(800);
await api(`v1/jobs/${id}`, { method: "PATCH", headers: { "content-type": "application/merge-patch+json" }, body: '{"priority": 7}' });
await page.evaluate((of) => document.querySelector(`[data-job="${of}"] [aria-label="Higher priority"]`).click(), id);
await page.waitForFunction(() => /Somebody else|somebody else/.test(studio.notice.value?.text ?? ""), { timeout: 10_000 });
const notice = await page.evaluate(() => studio.notice.value.text);
const priority = (await api(`v1/jobs/${id}`)).body.priority;
figure("priority that somebody else has changed", notice, priority === 7 && notice.includes("7"));

// Cancel, taken back; then for good.
const press = (word) => page.evaluate((of, name) => [...document.querySelectorAll(`[data-job="${of}"] .job-actions button`)].find((it) => it.textContent.trim() === name).click(), id, word);
await press("Cancel");
await pause(500);
await press("Keep it");
await pause(5500);
const stillThere = (await api(`v1/jobs/${id}`)).body.state;
figure("cancel taken back", stillThere, stillThere === "running" || stillThere === "queued");
await press("Cancel");
await page.waitForFunction((of) => document.querySelector(`[data-job="${of}"]`)?.classList.contains("is-canceled"), { timeout: 15_000 }, id);
figure("canceled", (await api(`v1/jobs/${id}`)).body.state, true);

// The whole of a small one: its bytes by a link without a key, its scene in the editor.
const small = (await post({ scene, settings: { width: 80, height: 50 }, labels: ["small"] })).body;
await page.waitForFunction((of) => document.querySelector(`[data-job="${of}"]`)?.classList.contains("is-succeeded"), { timeout: 30_000 }, small.id);
await page.evaluate((of) => [...document.querySelectorAll(`[data-job="${of}"] .job-actions button`)].find((it) => it.textContent.trim() === "Share").click(), small.id);
await button("an hour");
const link = await page.waitForSelector(".job-share input").then((input) => input.evaluate((of) => of.value));
const answer = await fetch(link);
figure("link without a key", `${answer.status} ${answer.headers.get("content-type")}`, answer.status === 200 && answer.headers.get("content-type") === "image/png");
await page.evaluate((of) => [...document.querySelectorAll(`[data-job="${of}"] .job-actions button`)].find((it) => it.textContent.trim() === "Open").click(), small.id);
await page.waitForFunction(() => studio.scene.value?.image?.width === 80, { timeout: 10_000 });
figure("opened in the studio", await page.evaluate(() => JSON.stringify(studio.scene.value.image)), true);

// Somebody else deletes the job that is shown, which may be on another page of the list.
for (const isListed of [true, false]) {
  const { id: other } = (await post({ scene, settings: { width: 1600, height: 900, samples: 1024 }, labels: ["shown"] })).body;
  const row = `[data-job="${other}"]`;
  await page.waitForFunction((of) => document.querySelector(`${of} .job-picture`)?.disabled === false, { timeout: 60_000 }, row);
  await page.evaluate((of) => document.querySelector(`${of} .job-picture`).click(), row);
  await page.waitForFunction(() => document.querySelector(".job-caption")?.textContent.includes("shown"));
  if (!isListed) {
    await page.select("#jobs-state", "succeeded");
    await page.waitForFunction((of) => !document.querySelector(of), { timeout: 10_000 }, row);
  }
  await api(`v1/jobs/${other}`, { method: "DELETE" });
  const isGone = await page.waitForFunction(() => !document.querySelector(".job-over"), { timeout: 15_000 }).then(() => true, () => false);
  const told = await page.evaluate(() => studio.notice.value?.text ?? "");
  figure(`deleted by somebody else, ${isListed ? "in" : "not in"} the list`, told, isGone && told.includes("deleted"));
}
await button("All");
await page.waitForFunction(() => document.querySelectorAll(".job").length === 3, { timeout: 10_000 });

// Filters are in the address.
await page.select("#jobs-state", "canceled");
await page.waitForFunction(() => [...document.querySelectorAll(".job")].every((row) => row.classList.contains("is-canceled")) && document.querySelectorAll(".job").length === 1, { timeout: 10_000 });
const address = await page.evaluate(() => location.search);
figure("filter in the address", address, address === "?state=canceled");
await button("All");
await page.waitForFunction(() => document.querySelectorAll(".job").length === 3, { timeout: 10_000 });
figure("all again", (await rows()).length, (await page.evaluate(() => location.search)) === "");
await pause(300);
await clean(page, "jobs");
await end(browser);
