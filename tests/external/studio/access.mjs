// Accessibility: axe-core in 13 states, light and dark, wide and narrow, under the real policy; and everything by keyboard alone.
import fs from "node:fs";
import { axePath, clean, end, figure, launch, open, pause, settled } from "./page.mjs";

const browser = await launch();
const axe = fs.readFileSync(axePath, "utf8");
const TAGS = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"];

const set = (name, value) => (page) => page.evaluate((of, to) => (studio[of].value = to), name, value);
const STATES = {
  "at first": async () => {},
  "a pixel": (page) => page.evaluate(() => ((studio.pixel.value = { x: 480, y: 300 }), studio.openPanel("pixel"))),
  "a problem": (page) => page.evaluate(() => studio.editAt("/objects/1/sphere/material", "glas")),
  "a wrong setting": set("settings", { samples: "99999" }),
  paused: set("live", false),
  camera: set("tool", "orbit"),
  examples: set("dialog", "examples"),
  share: set("dialog", "share"),
  commands: set("dialog", "commands"),
  key: set("dialog", "key"),
  help: set("dialog", "help"),
  notice: (page) => page.evaluate(() => studio.say("A sentence for everybody.", { label: "Back", run: () => {} })),
  panels: (page) => page.evaluate(async () => {
    for (const tab of document.querySelectorAll("[role=tab]")) {
      tab.click();
      await new Promise((over) => setTimeout(over, 150));
    }
  }),
};

async function states() {
  let count = 0;
  const found = [];
  for (const scheme of ["light", "dark"]) {
    for (const width of [1280, 390]) {
      for (const [name, reach] of Object.entries(STATES)) {
        const page = await open(browser, { scheme, width, height: width === 390 ? 844 : 800, touch: width === 390 });
        await settled(page);
        await reach(page);
        await pause(700);
        // Through the debugger, which the policy of the page does not bind.
        await page.evaluate(axe);
        const { violations } = await page.evaluate((tags) => axe.run(document, { runOnly: tags }), TAGS);
        count += 1;
        for (const { id, nodes } of violations) found.push(`${name}, ${scheme}, ${width}: ${id} at ${nodes.slice(0, 3).map((of) => `${of.target.join(" ")} (${of.any[0]?.message ?? of.all[0]?.message ?? ""})`).join(", ")}`);
        await page.browserContext().close();
      }
    }
  }
  figure(`axe-core in ${count} states`, found.length === 0 ? "no violation" : `\n     ${[...new Set(found)].join("\n     ")}`, found.length === 0);
}

/** The element with the focus, also inside of the editor, and whether one sees that it has it. */
const focused = (page) =>
  page.evaluate(() => {
    let at = document.activeElement;
    while (at?.shadowRoot?.activeElement) at = at.shadowRoot.activeElement;
    const style = getComputedStyle(at);
    const box = at.getBoundingClientRect();
    const seen = (style.outlineStyle !== "none" && parseFloat(style.outlineWidth) > 0) || at.classList.contains("cm-content") || at.matches("input, textarea");
    return { name: at.getAttribute("aria-label") || at.textContent.trim().slice(0, 30) || at.tagName, seen, small: at.matches("button, a, input, [role=tab]") && (box.width < 24 || box.height < 24) ? `${box.width}x${box.height}` : "", body: at === document.body };
  });

async function keyboard() {
  const page = await open(browser);
  await settled(page);
  await pause(500);
  const unseen = [];
  const small = [];
  const names = new Set();
  let rounds = 0;
  for (; rounds < 120; rounds += 1) {
    await page.keyboard.press("Tab");
    const { name, seen, small: size, body } = await focused(page);
    if (body && rounds > 5) break;
    if (names.has(name) && rounds > 60) break;
    names.add(name);
    if (!seen) unseen.push(name);
    if (size) small.push(`${name} ${size}`);
  }
  figure("Tab goes around", `${names.size} stops; unseen: ${unseen.join(", ") || "none"}; below 24 px: ${small.join(", ") || "none"}`, names.size > 15 && unseen.length === 0 && small.length === 0);

  // A scene is edited, looked at, inspected and shared without a pointer.
  await page.keyboard.press("F6");
  await page.evaluate(() => studio.reveal("/objects/0/sphere/radius"));
  await pause(100);
  await page.keyboard.down("Alt");
  for (let step = 0; step < 3; step += 1) await page.keyboard.press("ArrowUp");
  await page.keyboard.up("Alt");
  const radius = await page.evaluate(() => studio.scene.value.objects[0].sphere.radius);
  figure("a number is stepped by Alt and arrows", radius, radius === 1.3);
  await page.keyboard.press("Escape");
  await page.keyboard.press("F6");
  await page.evaluate(() => document.querySelector("canvas.canvas").focus());
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("Enter");
  const pixel = await page.evaluate(() => studio.pixel.value);
  figure("arrows move the cursor", JSON.stringify(pixel), pixel !== null);
  await page.keyboard.press("c");
  const before = await page.evaluate(() => studio.scene.value.camera.pinhole.eye);
  await page.keyboard.press("ArrowLeft");
  await pause(700);
  const after = await page.evaluate(() => studio.scene.value.camera.pinhole.eye);
  figure("arrows orbit", `${before} -> ${after}`, String(before) !== String(after));
  await page.keyboard.press("c");
  for (const [keys, dialog] of [[["Control", "k"], "commands"], [["?"], "help"], [["o"], "examples"], [["s"], "share"]]) {
    for (const key of keys) await page.keyboard.down(key);
    for (const key of keys.toReversed()) await page.keyboard.up(key);
    // Escape is for a dialog that is open already.
    await page.waitForFunction((of) => studio.dialog.value === of && document.querySelector("dialog")?.open, {}, dialog);
    await page.keyboard.press("Escape");
    await page.waitForFunction(() => studio.dialog.value === "");
  }
  figure("dialogs open and close by keys", "4", true);
  await clean(page, "keyboard");
}

await keyboard();
await states();
await end(browser);
