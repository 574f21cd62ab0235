// How fast: the first picture, keystrokes, orbits; how much is wasted; whether old pictures ever win; what memory grows.
import { caretAt, clean, end, figure, launch, open, pause, percentile, settled, state } from "./page.mjs";

const browser = await launch();

/** Times of the frames that show a newer text, in the page. */
const watch = () => {
  window.seen = [];
  window.tasks = [];
  new PerformanceObserver((list) => window.tasks.push(...list.getEntries().map((of) => of.duration))).observe({ type: "longtask" });
  studio.shown.subscribe((picture) => picture && requestAnimationFrame(() => window.seen.push({ version: picture.version, rung: picture.rung, at: performance.now() })));
};

async function cold() {
  const times = [];
  let paints = {};
  for (let round = 0; round < 5; round += 1) {
    const page = await open(browser, {
      before: (of) => of.evaluateOnNewDocument(() => {
        window.paints = { lcp: 0, cls: 0, blocked: 0 };
        new PerformanceObserver((list) => list.getEntries().forEach((entry) => (window.paints.lcp = entry.startTime))).observe({ type: "largest-contentful-paint", buffered: true });
        new PerformanceObserver((list) => list.getEntries().forEach((entry) => (window.paints.cls += entry.value))).observe({ type: "layout-shift", buffered: true });
        new PerformanceObserver((list) => list.getEntries().forEach((entry) => (window.paints.blocked += Math.max(0, entry.duration - 50)))).observe({ type: "longtask", buffered: true });
      }),
    });
    await settled(page);
    // The picture is there when the ladder has shown it: the entry of its request ends just before.
    const first = await page.evaluate(() => performance.getEntriesByType("resource").find((of) => of.name.includes("v1/render"))?.responseEnd ?? 1e9);
    times.push(first);
    paints = await page.evaluate(() => window.paints);
    await clean(page, "cold open");
  }
  figure("first picture after a cold open", `${Math.round(percentile(times, 0.5))} ms`, percentile(times, 0.5) <= 1000, "<= 1000 ms");
  figure("largest contentful paint", `${Math.round(paints.lcp)} ms`, paints.lcp <= 1000, "<= 1000 ms");
  figure("layout shift", paints.cls.toFixed(4), paints.cls <= 0.02, "<= 0.02");
  figure("total blocking time", `${Math.round(paints.blocked)} ms`, paints.blocked <= 100, "<= 100 ms");
}

/** 100 edits by the keyboard, 100 ms apart: from the key to the frame that shows its text. */
async function keystrokes(example, pointer) {
  const page = await open(browser, { fragment: `#e=${example}` });
  await settled(page);
  await caretAt(page, pointer);
  await page.evaluate(watch);
  await page.evaluate(() => {
    window.keys = [];
    addEventListener("keydown", (event) => window.keys.push({ at: performance.now(), version: studio.version.value + 1, key: event.key }), { capture: true });
  });
  for (let edit = 0; edit < 100; edit += 1) {
    const started = Date.now();
    // A digit comes and goes: each time the text is another one, and sound.
    await page.keyboard.press(edit % 2 === 0 ? String((edit / 2) % 10) : "Backspace");
    await pause(Math.max(0, 100 - (Date.now() - started)));
  }
  await pause(600);
  const delays = await page.evaluate(() => window.keys.flatMap(({ at, version }) => {
    const frame = window.seen.find((of) => of.version >= version && of.at > at);
    return frame ? [frame.at - at] : [];
  }));
  const long = await page.evaluate(() => window.tasks.length);
  const name = example.split("/")[1];
  const [p50, p95] = [percentile(delays, 0.5), percentile(delays, 0.95)];
  figure(`keystroke to pixels, ${name}`, `p50 ${p50?.toFixed(0)} ms, p95 ${p95?.toFixed(0)} ms of ${delays.length}; ${long} long tasks`, delays.length >= 95 && p50 <= 50 && p95 <= 100, "p50 <= 50, p95 <= 100");
  await clean(page, name);
}

async function orbit(example, least) {
  const page = await open(browser, { fragment: `#e=${example}` });
  await settled(page);
  await page.evaluate(watch);
  await page.evaluate(() => (studio.tool.value = "orbit"));
  const box = await (await page.$("canvas.canvas")).boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  const frames = await page.evaluate(async () => {
    const canvas = document.querySelector("canvas.canvas");
    const rect = canvas.getBoundingClientRect();
    let count = 0;
    const stop = studio.shown.subscribe(() => (count += 1));
    const started = performance.now();
    for (let step = 0; performance.now() - started < 5000; step += 1) {
      await new Promise((frame) => requestAnimationFrame(frame));
      const angle = step / 40;
      canvas.dispatchEvent(new PointerEvent("pointermove", { pointerId: 1, clientX: rect.x + rect.width / 2 + 60 * Math.sin(angle), clientY: rect.y + rect.height / 2 + 20 * Math.sin(angle / 2), buttons: 1, bubbles: true }));
    }
    stop();
    return count;
  });
  await page.mouse.up();
  await settled(page);
  await page.evaluate(() => studio.offer.value !== null && studio.renderNow());
  await page.waitForFunction(() => studio.shown.value.rung === 2 && studio.shown.value.text === studio.text.value, { timeout: 60_000 });
  const digest = await page.evaluate(() => studio.report.value.digest);
  const text = await state(page, "text");
  const again = await page.evaluate(async (scene) => {
    const answer = await fetch("v1/render", { method: "POST", body: scene, headers: { "content-type": "application/json", accept: "image/png" } });
    return studio.reportOf(answer.headers).digest;
  }, text);
  figure(`orbit, ${example.split("/")[1]}`, `${(frames / 5).toFixed(0)} pictures a second; the last is ${digest === again ? "" : "NOT "}the render of the text`, frames / 5 >= least && digest === again, `>= ${least}`);
  await clean(page, "orbit");
}

/** A mesh of a million triangles: its text goes to the service once, then only cameras do. */
async function orbitMesh() {
  const page = await open(browser);
  await settled(page);
  const triangles = await page.evaluate(() => {
    const side = 708;
    const vertices = [];
    const faces = [];
    for (let z = 0; z < side; z += 1) {
      for (let x = 0; x < side; x += 1) {
        vertices.push(`[${x / 100},${(Math.sin(x / 25) * Math.cos(z / 30) * 0.6).toFixed(4)},${z / 100}]`);
        if (x === 0 || z === 0) continue;
        const at = z * side + x;
        faces.push(`[${at},${at - 1},${at - side}]`, `[${at - 1},${at - side - 1},${at - side}]`);
      }
    }
    const camera = '{ "pinhole": { "eye": [3.5, 4, 11], "look_at": [3.5, 0, 3.5] } }';
    const mesh = `{ "mesh": { "vertices": [${vertices}], "faces": [${faces}] } }`;
    studio.open(`{ "version": 1, "image": { "width": 960, "height": 540 }, "camera": ${camera}, "objects": [${mesh}] }`, "a mesh");
    return faces.length;
  });
  await page.waitForFunction(() => studio.shown.value.text === studio.text.value && studio.shown.value.rung > 0, { timeout: 90_000 });
  const box = await (await page.$("canvas.canvas")).boundingBox();
  await page.evaluate(() => (studio.tool.value = "orbit"));
  await page.mouse.move(box.x + 200, box.y + 250);
  await page.mouse.down();
  await page.mouse.move(box.x + 230, box.y + 255, { steps: 3 });
  // The scene is sent now; what is measured comes after it.
  await page.waitForFunction(() => studio.shown.value.rung === 0, { timeout: 90_000 });
  await pause(3000);
  const count = await page.evaluate(async () => {
    const rect = document.querySelector("canvas.canvas").getBoundingClientRect();
    let pictures = 0;
    const stop = studio.shown.subscribe(() => (pictures += 1));
    const started = performance.now();
    for (let step = 0; performance.now() - started < 4000; step += 1) {
      await new Promise((frame) => requestAnimationFrame(frame));
      document.querySelector("canvas.canvas").dispatchEvent(new PointerEvent("pointermove", { pointerId: 1, clientX: rect.x + 230 + 60 * Math.sin(step / 40), clientY: rect.y + 255, buttons: 1, bubbles: true }));
    }
    stop();
    return pictures;
  });
  await page.mouse.up();
  await page.waitForFunction(() => studio.shown.value.text === studio.text.value && studio.shown.value.rung > 0, { timeout: 90_000 });
  const { eye } = await page.evaluate(() => studio.scene.value.camera.pinhole);
  figure(`orbit, ${triangles.toLocaleString("en")} triangles`, `${(count / 4).toFixed(0)} pictures a second, ${Math.round(4000 / count)} ms each; the text has eye ${eye}`, 4000 / count <= 60 && String(eye) !== "3.5,4,11", "<= 60 ms");
  await clean(page, "mesh");
}

/** Answers come 0 to 300 ms late, at random: whatever the order, the end is the newest text and nothing older replaces it. */
async function disorder() {
  const page = await open(browser, {
    before: (of) => of.evaluateOnNewDocument(() => {
      const real = window.fetch;
      window.late = false;
      window.fetch = async (...args) => {
        const answer = await real(...args);
        if (window.late && String(args[0]).includes("v1/render")) await new Promise((over) => setTimeout(over, Math.random() * 300));
        return answer;
      };
    }),
  });
  await settled(page);
  await page.evaluate(watch);
  await page.evaluate(() => (window.late = true));
  await page.evaluate(async () => {
    for (let edit = 0; edit < 200; edit += 1) {
      studio.editAt("/objects/0/sphere/radius", 1 + edit / 1000);
      await new Promise((over) => setTimeout(over, 15));
    }
  });
  await settled(page);
  const older = await page.evaluate(() => window.seen.filter((of, index) => index > 0 && of.version < window.seen[index - 1].version).length);
  const isNewest = await page.evaluate(() => studio.shown.value.text === studio.text.value);
  figure("answers out of order", `${older} older pictures replaced newer ones; the last is ${isNewest ? "the newest" : "OLD"}`, older === 0 && isNewest);
  await clean(page, "disorder");
}

/** 50 quick edits: rays that nobody saw, and work that goes on after the end. */
async function waste() {
  const page = await open(browser);
  await settled(page);
  await page.evaluate(watch);
  const sent = [];
  page.on("request", (request) => request.url().includes("v1/render") && sent.push(request));
  await page.evaluate(async () => {
    for (let edit = 0; edit < 50; edit += 1) {
      studio.editAt("/objects/0/sphere/radius", 1 + edit / 500);
      await new Promise((over) => setTimeout(over, 100));
    }
  });
  await settled(page);
  await pause(200);
  const full = sent.filter((request) => !request.url().includes("samples=1")).length;
  const running = await page.evaluate(async () => (await (await fetch("readyz")).json()).running);
  figure("waste of 50 edits", `${sent.length} renders, ${full} of them as the scene says; ${running} run 200 ms after the end`, sent.length <= 60 && full <= 2 && running === 0, "<= 60 renders, as the scene says <= 2, running 0");
  await clean(page, "waste");
}

async function memory() {
  const page = await open(browser);
  await settled(page);
  const session = await page.createCDPSession();
  const measure = async () => {
    await session.send("HeapProfiler.collectGarbage");
    const { usedSize } = await session.send("Runtime.getHeapUsage");
    const { nodes } = await session.send("Memory.getDOMCounters");
    return { heap: usedSize / 1e6, nodes };
  };
  const edits = (from, to) => page.evaluate(async (a, b) => {
    for (let edit = a; edit < b; edit += 1) {
      studio.editAt("/objects/0/sphere/radius", 1 + edit / 1000);
      await new Promise((over) => setTimeout(over, 25));
    }
  }, from, to);
  await edits(0, 20);
  await settled(page);
  const before = await measure();
  await edits(20, 220);
  await settled(page);
  const after = await measure();
  const { made, closed } = await page.evaluate(() => studio.bitmaps);
  const grown = after.heap - before.heap;
  figure("memory after 200 edits", `+${grown.toFixed(1)} MB, ${before.nodes} -> ${after.nodes} nodes, ${made - closed} bitmaps of ${made} open`, grown <= 10 && after.nodes <= before.nodes * 1.05 && made - closed <= 20, "<= 10 MB, <= +5 %, <= 20 open");
  await clean(page, "memory");
}

const suites = {
  cold,
  whitted: () => keystrokes("whitted/whitted", "/objects/0/sphere/center/1"),
  hall: () => keystrokes("mirrors/hall", "/camera/pinhole/eye/1"),
  gloss: () => keystrokes("effects/gloss", "/camera/pinhole/eye/1"),
  orbit: () => orbit("whitted/whitted", 50),
  "orbit-hall": () => orbit("mirrors/hall", 25),
  "orbit-gloss": () => orbit("effects/gloss", 25),
  mesh: orbitMesh,
  disorder,
  waste,
  memory,
};
const only = process.argv.slice(5);
for (const [name, suite] of Object.entries(suites)) {
  if (only.length > 0 && !only.includes(name)) continue;
  await suite().catch((error) => figure(name, error.message.split("\n")[0], false));
}
await end(browser);
