// What the suites of the studio share: a browser, a page of the studio, its state, and a list of figures with their bars.
import path from "node:path";
import { createRequire } from "node:module";

export const [modules, browserPath, base] = process.argv.slice(2);
const require = createRequire(path.join(modules, "x.js"));
const puppeteer = require("puppeteer-core");
export const axePath = require.resolve("axe-core/axe.min.js");

const FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"];
export const pause = (ms) => new Promise((over) => setTimeout(over, ms));

let failures = 0;
/** Prints a figure and whether it holds. */
export function figure(name, value, holds, bar = "") {
  if (!holds) failures += 1;
  console.log(`${holds ? "ok  " : "FAIL"} ${name}: ${value}${bar && ` (${bar})`}`);
}
export const end = async (browser) => {
  await browser.close();
  process.exit(failures === 0 ? 0 : 1);
};
export const percentile = (values, share) => values.toSorted((a, b) => a - b)[Math.min(values.length - 1, Math.floor(values.length * share))];

export const launch = () => puppeteer.launch({ executablePath: browserPath, headless: true, args: FLAGS });

/** A page of its own profile at an address, which notes errors, violations of the policy, and requests to others. */
export async function open(browser, { fragment = "", width = 1280, height = 800, scheme = "light", touch = false, at = base, before } = {}) {
  const context = await browser.createBrowserContext();
  await context.overridePermissions(at, ["clipboard-read", "clipboard-write", "clipboard-sanitized-write"]);
  const page = await context.newPage();
  page.wrong = [];
  page.on("pageerror", (error) => page.wrong.push(`error: ${error.message}`));
  page.on("request", (request) => {
    const url = request.url();
    if (!url.startsWith(at) && !/^(blob|data|about):/.test(url)) page.wrong.push(`request to ${url}`);
  });
  await page.evaluateOnNewDocument(() => {
    window.violations = [];
    document.addEventListener("securitypolicyviolation", (event) => window.violations.push(`${event.violatedDirective} ${event.blockedURI} ${event.sample}`));
  });
  await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: scheme }]);
  await page.setViewport({ width, height, hasTouch: touch, isMobile: touch });
  await before?.(page);
  await page.goto(`${at}/studio${fragment}`, { waitUntil: "load" });
  await ready(page);
  return page;
}

/** Waits for the first picture, and gives the page its modules as `studio`. */
export async function ready(page) {
  await page.evaluate(async () => {
    const folder = document.querySelector("script[type=module]").src.replace(/main\.js$/, "");
    const names = ["state", "scenes", "tiles", "picture", "looking", "report"];
    const found = await Promise.all(names.map((name) => import(`${folder}${name}.js`)));
    window.studio = Object.assign({}, ...found);
  });
  await page.waitForFunction(() => studio.shown.value !== null, { timeout: 20_000 });
}

/** Waits until the newest text is shown as the scene says, or that is offered since it takes long. */
export const settled = (page, timeout = 60_000) =>
  page.waitForFunction(
    () => studio.status.value.word === "live" && studio.shown.value?.text === studio.text.value && (studio.shown.value.rung === 2 || studio.offer.value !== null),
    { timeout, polling: 20 },
  );

export const state = (page, name) => page.evaluate((of) => studio[of].value, name);

/** Puts the caret of the editor behind the value of a pointer. */
export async function caretAt(page, pointer) {
  await page.waitForFunction(() => document.querySelector(".editor-host")?.shadowRoot?.querySelector(".cm-content"), { timeout: 20_000 });
  await pause(100);
  await page.evaluate((to) => studio.reveal(to), pointer);
  await page.waitForFunction(() => document.querySelector(".editor-host").shadowRoot.activeElement?.classList.contains("cm-content"));
  await page.keyboard.press("ArrowRight");
}

/** A check of a page at the end: no errors, no violations, no requests to others. */
export async function clean(page, name) {
  const violations = await page.evaluate(() => window.violations);
  const wrong = [...page.wrong, ...violations];
  if (wrong.length > 0) figure(`${name}: errors`, wrong.join("; "), false);
  await page.browserContext().close();
}
