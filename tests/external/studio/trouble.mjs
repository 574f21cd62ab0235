// Bad connections: answers that break off, proxies without their service, limits, slow answers that come in another order. And
// files that are no scenes. Each flow is a line, and has a proxy of its own.
import { between, busy, gateway } from "./between.mjs";
import { base, clean, end, figure, launch, open, pause, ready, settled, state } from "./page.mjs";

const browser = await launch();
const only = process.argv.slice(5);
const becomes = (promise) => promise.then(() => true, () => false);
const edit = (page, radius = 0.8) => page.evaluate((of) => studio.editAt("/objects/0/sphere/radius", of), radius);
/** A rule for so many requests of a path. */
const first = (times, path, answer) => (request) => (request.url.startsWith(path) && (times -= 1) >= 0 ? answer : undefined);
const drop = (page, name, bytes) => page.evaluate((of, content) => {
  const data = new DataTransfer();
  data.items.add(new File([Uint8Array.from(content)], of));
  dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
}, name, [...Buffer.from(bytes)]);
const LONG = { samples: "30", width: "1920", height: "1080" };

/** No answer for a while. */
async function away(page, proxy) {
  proxy.rule = () => ({ refuse: true });
  await page.evaluate(async () => (await import(document.querySelector("script[type=module]").src.replace(/main\.js$/, "api.js"))).askJson("v1/queue").catch(() => {}));
  await page.waitForFunction(() => !studio.connection.value.online);
  proxy.rule = () => undefined;
  proxy.asked.length = 0;
  await page.waitForFunction(() => studio.connection.value.online);
  await pause(1500);
}

const flows = {
  async "a picture that breaks off is asked for again"(page, proxy) {
    proxy.rule = first(2, "/v1/render", { cut: 300 });
    await edit(page);
    const holds = await becomes(settled(page, 8000));
    return [holds, JSON.stringify(await state(page, "status"))];
  },
  async "a proxy without its service is a service that is away"(page, proxy) {
    proxy.rule = () => gateway();
    await edit(page);
    const told = await becomes(page.waitForFunction(() => document.querySelector(".state").innerText.startsWith("offline"), { timeout: 3000 }));
    // Its own page is a 502, too.
    await pause(1500);
    const stays = !(await state(page, "connection")).online;
    proxy.rule = () => undefined;
    return [(await becomes(settled(page, 8000))) && told && stays, `told ${told}, stays ${stays}`];
  },
  async "a service that is busy is waited for"(page, proxy) {
    proxy.rule = first(4, "/v1/", busy(429, 1));
    await edit(page);
    await page.waitForFunction(() => document.querySelector(".state").innerText.startsWith("waiting"), { timeout: 3000 });
    return [await becomes(settled(page, 15_000)), JSON.stringify(await state(page, "status"))];
  },
  async "without its plan a long picture is not started"(page, proxy) {
    proxy.rule = first(1, "/v1/explain", busy(429, 1));
    await page.evaluate((of) => (studio.settings.value = of), LONG);
    const offered = await becomes(page.waitForFunction(() => studio.offer.value !== null, { timeout: 8000 }));
    const started = proxy.asked.filter((of) => of.startsWith("POST /v1/render?samples=30")).length;
    return [offered && started === 0, `offered ${offered}, started ${started} times`];
  },
  async "what was only offered, or waits, is not started by a service that comes back"(page, proxy) {
    await page.evaluate((of) => (studio.settings.value = of), LONG);
    await page.waitForFunction(() => studio.offer.value !== null, { timeout: 20_000 });
    await away(page, proxy);
    const offered = proxy.asked.filter((of) => of.startsWith("POST /v1/render")).length;
    const still = (await state(page, "offer")) !== null;
    await page.keyboard.press("p");
    await page.evaluate(() => (studio.settings.value = {}));
    await edit(page, 0.7);
    await away(page, proxy);
    const paused = proxy.asked.filter((of) => of.startsWith("POST /v1/render")).length;
    return [offered === 0 && still && paused === 0, `${offered} and ${paused} renders; ${JSON.stringify(await state(page, "status"))}`];
  },
  async "tiles come also if their picture is refused at first"(page, proxy) {
    proxy.rule = first(2, "/v1/scenes", busy(429, 1));
    await page.evaluate(() => studio.fit());
    const box = await (await page.$("canvas.canvas")).boundingBox();
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    for (let step = 0; step < 3; step += 1) await page.mouse.wheel({ deltaY: -240 });
    const holds = await becomes(page.waitForFunction(() => {
      const at = studio.view.value;
      const places = studio.inSight(at, studio.size.value, studio.levelOf(at.scale * devicePixelRatio), { x: 0, y: 0 });
      return studio.counts.flying === 0 && places.every(({ name }) => studio.has(name));
    }, { timeout: 20_000 }));
    return [holds, JSON.stringify(await page.evaluate(() => studio.counts))];
  },
  async "of two scenes the one that was asked for last is open"(page, proxy) {
    await pause(600);
    proxy.rule = (request) => (request.url.startsWith("/v1/examples/") ? { wait: 1500 } : undefined);
    const link = await page.evaluate(async () => {
      const { packed } = await import(document.querySelector("script[type=module]").src.replace(/main\.js$/, "link.js"));
      return `#z=${await packed(JSON.stringify({ ...studio.scene.value, name: "the last" }))}`;
    });
    await page.evaluate(() => (location.hash = "#e=mirrors/hall&q.samples=2"));
    await pause(100);
    await page.evaluate((of) => (location.hash = of), link);
    await pause(3000);
    const [title, settings] = [await state(page, "title"), await state(page, "settings")];
    return [title === "the last" && Object.keys(settings).length === 0, `${title} ${JSON.stringify(settings)}`];
  },
  async "a job in the viewport stays while the service is busy, and a sequence has its own shape"(page, proxy) {
    const id = await page.evaluate(async () => {
      const body = JSON.stringify({ scene: studio.scene.value, settings: { width: 160, height: 40 }, frames: { count: 9, turntable: {} } });
      return (await (await fetch("v1/jobs", { method: "POST", headers: { "content-type": "application/json" }, body })).json()).id;
    });
    await page.evaluate(() => studio.openPanel("jobs"));
    await page.waitForFunction((of) => document.querySelector(`[data-job="${of}"]`)?.classList.contains("is-succeeded"), { timeout: 60_000 }, id);
    await page.waitForFunction((of) => document.querySelector(`[data-job="${of}"] .job-picture`)?.disabled === false, {}, id);
    await pause(1000);
    proxy.rule = first(2, `/v1/jobs/${id}/`, busy(429, 1));
    await page.evaluate((of) => document.querySelector(`[data-job="${of}"] .job-picture`).click(), id);
    const comes = await becomes(page.waitForFunction(() => studio.layers.value.some((of) => of.id === "job"), { timeout: 10_000 }));
    // Drawn into a canvas of its own: the contact sheet has another shape than a frame.
    const box = comes && await page.evaluate(() => {
      const seen = [];
      const context = { drawImage: (picture, x, y, w, h) => seen.push([picture.width / picture.height, w / h]), setLineDash() {}, strokeRect() {}, clearRect() {} };
      studio.layers.value.find((of) => of.id === "job").draw(context, studio.view.value);
      return seen[0];
    });
    return [comes && Math.abs(box[0] / box[1] - 1) < 0.01, `${comes} ${box}`];
  },
  async "who asks by hand does not wait for an hour"(page, proxy) {
    proxy.rule = first(1, "/v1/render", busy(429, 3600));
    await edit(page);
    await page.waitForFunction(() => document.querySelector(".state").innerText.startsWith("waiting"), { timeout: 3000 });
    await page.keyboard.down("Control");
    await page.keyboard.press("Enter");
    await page.keyboard.up("Control");
    return [await becomes(settled(page, 5000)), JSON.stringify(await state(page, "status"))];
  },
  async "a job is canceled also while the service is busy"(page, proxy) {
    const id = await page.evaluate(async () => {
      const body = JSON.stringify({ scene: studio.scene.value, settings: { width: 1920, height: 1080, samples: 512 } });
      return (await (await fetch("v1/jobs", { method: "POST", headers: { "content-type": "application/json" }, body })).json()).id;
    });
    await page.evaluate(() => studio.openPanel("jobs"));
    await page.waitForSelector(`[data-job="${id}"] .job-actions button`);
    proxy.rule = first(1, `/v1/jobs/${id}/cancel`, busy(429, 1));
    await page.evaluate((of) => [...document.querySelectorAll(`[data-job="${of}"] .job-actions button`)].find((it) => it.textContent.trim() === "Cancel").click(), id);
    await pause(7500);
    const { state: now } = await (await fetch(`${base}/v1/jobs/${id}`)).json();
    if (now !== "canceled") await fetch(`${base}/v1/jobs/${id}/cancel`, { method: "POST" });
    return [now === "canceled", now];
  },
  async "a link that is opened while the service is away stays, and opens when it is back"(page, proxy) {
    proxy.rule = (request) => (request.url.startsWith("/v1/") ? gateway() : undefined);
    await page.goto("about:blank");
    await page.goto(`${proxy.address}/studio#e=mirrors/hall&q.samples=2`, { waitUntil: "load" });
    await pause(1500);
    const kept = page.url().includes("#e=mirrors/hall&q.samples=2");
    proxy.rule = () => undefined;
    await ready(page);
    return [kept && (await state(page, "settings")).samples === "2", `${page.url().split("#")[1]}, ${await state(page, "title")}`];
  },
  async "panels that do not come are asked for again"(page, proxy) {
    proxy.rule = (request) => (request.url.endsWith("/panels/registry.js") ? gateway() : undefined);
    // The browser keeps what the service's own page has loaded.
    await page.setCacheEnabled(false);
    await page.goto("about:blank");
    await page.goto(`${proxy.address}/studio`, { waitUntil: "load" });
    await ready(page);
    await pause(1500);
    const told = await page.evaluate(() => studio.notice.value?.text);
    proxy.rule = () => undefined;
    await edit(page);
    const holds = await becomes(page.waitForFunction(() => document.querySelectorAll("[role=tab]").length > 3, { timeout: 5000 }));
    await page.setCacheEnabled(true);
    return [holds && /did not come/.test(told), `${(await page.$$("[role=tab]")).length} panels; ${told}`];
  },
  async "a file with the ends of lines of Windows has its marks at their places"(page) {
    const text = await page.evaluate(() => JSON.stringify(studio.scene.value, null, 2).replace('"radius": 1', '"radius": -1').replaceAll("\n", "\r\n"));
    await drop(page, "windows.json", text);
    await page.waitForSelector(".trouble-link");
    await page.click(".trouble-link");
    await pause(400);
    const marked = await page.evaluate(() => document.querySelector(".editor-host").shadowRoot.querySelector(".cm-lintRange-error")?.textContent);
    return [marked === "-1", marked];
  },
  async "a file that is no scene and no model is not opened"(page) {
    const before = await state(page, "text");
    await drop(page, "model.glb", "glTF\u0002\0\0\0\0\u0001");
    await page.waitForFunction(() => studio.notice.value?.text.includes("cannot"));
    const told = await page.evaluate(() => studio.notice.value?.text);
    return [/^model.glb cannot be opened: /.test(told) && (await state(page, "text")) === before, told];
  },
};

for (const [name, flow] of Object.entries(flows)) {
  if (only.length > 0 && !only.some((of) => name.includes(of))) continue;
  const proxy = await between(base);
  const page = await open(browser, { at: proxy.address });
  try {
    await settled(page);
    const [holds, value] = await flow(page, proxy);
    figure(name, value, holds);
  } catch (error) {
    figure(name, error.message, false);
  }
  await clean(page, name);
  proxy.close();
}
await end(browser);
