// A service that wants keys: the page asks, refuses a wrong one in the service's words, and forgets it with the page.
import { base, end, figure, launch, open, pause, settled } from "./page.mjs";

const key = process.argv[5];
const browser = await launch();
const context = await browser.createBrowserContext();
const page = await context.newPage();
const sent = [];
page.on("request", (request) => sent.push([request.url(), request.headers().authorization ?? ""]));
await page.goto(`${base}/studio`);
await page.waitForSelector("dialog input[type=password]");
figure("the page asks for a key", await page.$eval("dialog h2", (of) => of.textContent), true);
await page.type("dialog input[type=password]", "rk_wrong");
await page.keyboard.press("Enter");
await page.waitForFunction(() => document.querySelector(".wrong")?.textContent !== "");
figure("a wrong one is refused", await page.$eval(".wrong", (of) => of.textContent), true);
await page.$eval("dialog input[type=password]", (of) => (of.value = ""));
// The page may ask for other things meanwhile, such as whether the service is there.
const asked = () => sent.filter(([url]) => url.endsWith("/v1/me")).length;
const before = asked();
await page.type("dialog input[type=password]", "rk_abc\u2026\u20ac");
await page.keyboard.press("Enter");
await page.waitForFunction(() => document.querySelector(".wrong")?.textContent.includes("\u2026"), { timeout: 5_000 }).catch(() => {});
const words = await page.$eval(".wrong", (of) => of.textContent);
figure("one that no request can hold is refused at once", words, words.includes("No key has the character") && asked() === before);
await page.$eval("dialog input[type=password]", (of) => (of.value = ""));
await page.type("dialog input[type=password]", key);
await page.keyboard.press("Enter");
await page.evaluate(async () => {
  window.studio = await import(document.querySelector("script[type=module]").src.replace(/main\.js$/, "state.js"));
});
await settled(page);
figure("the right one is taken", "a picture", true);
await pause(700);
const kept = await page.evaluate(() => JSON.stringify({ ...localStorage, ...sessionStorage }));
const urls = sent.map(([url]) => url).join() + page.url();
figure("it is in no address and in no storage", kept, !kept.includes(key) && !urls.includes(key));
await page.reload();
await page.waitForSelector("dialog input[type=password]");
figure("a reload asks again", "it does", true);
await end(browser);
