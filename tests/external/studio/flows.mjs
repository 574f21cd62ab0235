// What a user does, from the first run to a link in another browser. Each flow is a line.
import { readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { base, caretAt, clean, end, figure, launch, open, pause, ready, settled, state } from "./page.mjs";

const browser = await launch();
const only = process.argv.slice(5);
const text = (page, selector) => page.$eval(selector, (of) => of.innerText.replace(/\s+/g, " ").trim());
const press = (page, name) => page.locator(`::-p-aria([name="${name}"])`).click();
const digest = (page) => page.evaluate(() => studio.report.value.digest);
const render = (page, query = "") =>
  page.evaluate(async (more) => {
    const answer = await fetch(`v1/render${more}`, { method: "POST", body: studio.text.value, headers: { "content-type": "application/json", accept: "image/png" } });
    return studio.reportOf(answer.headers).digest;
  }, query);

const drop = (page, name, body, packed = false) => page.evaluate(async (of, content, zip) => {
  let blob = new Blob([content]);
  if (zip) blob = await new Response(blob.stream().pipeThrough(new CompressionStream("gzip"))).blob();
  const data = new DataTransfer();
  data.items.add(new File([blob], of));
  dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
}, name, body, packed);
const NFF = "v\nfrom 0 0 5\nat 0 0 0\nup 0 1 0\nangle 45\nhither 1\nresolution 64 64\nl 3 3 3\nf 1 0.5 0.2 0.8 0.2 10 0 1\ns 0 0 0 1\n";

const modelPath = (name) => fileURLToPath(new URL(`../../inputs/models/${name}`, import.meta.url));
const model = (name) => readFileSync(modelPath(name));
/** Drops files of any bytes together. */
const dropAll = (page, files) => page.evaluate((all) => {
  const data = new DataTransfer();
  for (const [of, bytes] of all) data.items.add(new File([Uint8Array.from(atob(bytes), (char) => char.charCodeAt(0))], of));
  dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
}, Object.entries(files).map(([name, bytes]) => [name, bytes.toString("base64")]));
const opened = async (page, name) => {
  await page.waitForFunction((of) => studio.origin.value.name === of || studio.notice.value?.text.includes("cannot"), {}, name);
  await settled(page);
};
/** The color in the middle of the picture, and how much of it is opaque. */
const middle = (page) => page.evaluate(() => {
  const { bitmap } = studio.shown.value;
  const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
  context.drawImage(bitmap, 0, 0);
  return [...context.getImageData(bitmap.width >> 1, bitmap.height >> 1, 1, 1).data];
});
const eye = async (page) => (await state(page, "scene")).camera.pinhole.eye.join();

const flows = {
  async "the first run shows a scene that is live"(page) {
    const root = await page.evaluate(async () => (await fetch("/", { headers: { accept: "text/html" } })).url);
    const strip = await text(page, ".strip");
    return [root.endsWith("/studio") && /^live/.test(strip) && (await digest(page)) === (await render(page)), strip.slice(0, 60)];
  },
  async "typing changes the picture"(page) {
    const before = await digest(page);
    await caretAt(page, "/objects/0/sphere/radius");
    await page.keyboard.type(".25");
    await settled(page);
    const scene = await state(page, "scene");
    return [scene.objects[0].sphere.radius === 1.25 && (await digest(page)) !== before && (await digest(page)) === (await render(page)), scene.objects[0].sphere.radius];
  },
  async "undo is at once, and redo"(page) {
    const before = await digest(page);
    await page.evaluate(() => studio.editAt("/objects/0/sphere/radius", 0.5));
    await settled(page);
    await pause(100);
    const at = Date.now();
    await press(page, "Undo");
    await page.waitForFunction((of) => studio.report.value.digest === of, { polling: 5 }, before);
    const ms = Date.now() - at;
    await press(page, "Redo");
    await settled(page);
    return [ms < 1000 && (await digest(page)) !== before, `${ms} ms`];
  },
  async "a problem is told in the service's words, with its line, and mended by a button"(page) {
    const before = await digest(page);
    await page.evaluate(() => studio.editAt("/objects/1/sphere/material", "glas"));
    await page.waitForSelector(".problems");
    const words = await text(page, ".problems");
    const still = (await digest(page)) === before;
    await press(page, 'Write "glass"');
    await settled(page);
    return [still && words.includes('no material "glas"; did you mean "glass"?') && (await digest(page)) === before, words];
  },
  async "a mistake of syntax is underlined, the picture stays"(page) {
    await caretAt(page, "/objects/0/sphere/radius");
    await page.keyboard.type(",,");
    await page.waitForSelector(".trouble");
    const marked = await page.evaluate(() => document.querySelector(".editor-host").shadowRoot.querySelectorAll(".cm-lintRange-error").length);
    return [marked > 0 && (await state(page, "shown")) !== null, await text(page, ".trouble")];
  },
  async "many problems are walked by F8"(page) {
    await page.evaluate(() => (studio.editAt("/objects/0/sphere/radius", -1), studio.editAt("/objects/1/sphere/material", "x")));
    await page.waitForSelector(".problems");
    const places = [];
    for (let step = 0; step < 2; step += 1) {
      await page.keyboard.press("F8");
      await pause(150);
      places.push(await state(page, "caret"));
    }
    return [places.join() === "/objects/0/sphere/radius,/objects/1/sphere/material", places.join(" ")];
  },
  async "completion offers the keys of the place"(page) {
    await caretAt(page, "/objects/0/sphere/material");
    await page.keyboard.type(', "');
    const list = await page.waitForFunction(() => {
      const found = [...document.querySelector(".editor-host").shadowRoot.querySelectorAll(".cm-tooltip-autocomplete li")].map((of) => of.textContent);
      return found.length > 0 && found;
    });
    const keys = await list.jsonValue();
    return [keys.join() === "hollow", keys.join(" ")];
  },
  async "completion knows the materials of the scene"(page) {
    await page.evaluate(() => studio.editAt("/objects/0/sphere/material", ""));
    await caretAt(page, "/objects/0/sphere/material");
    await page.keyboard.press("ArrowLeft");
    await page.keyboard.type("m");
    const list = await page.waitForFunction(() => {
      const found = [...document.querySelector(".editor-host").shadowRoot.querySelectorAll(".cm-tooltip-autocomplete li")].map((of) => of.textContent);
      return found.some((of) => of.startsWith("metal")) && found;
    });
    await pause(150);
    await page.keyboard.press("Enter");
    await settled(page);
    const { material } = (await state(page, "scene")).objects[0].sphere;
    return [material === "metal", `${(await list.jsonValue()).join(" ")} -> ${material}`];
  },
  async "hover tells what a key means"(page) {
    await page.waitForFunction(() => document.querySelector(".editor-host").shadowRoot?.querySelector(".cm-content"));
    const [x, y] = await page.evaluate(() => {
      const walker = document.createTreeWalker(document.querySelector(".editor-host").shadowRoot, NodeFilter.SHOW_TEXT);
      for (let line; (line = walker.nextNode()); ) {
        if (!line.data.includes("vfov_deg")) continue;
        const range = document.createRange();
        range.selectNode(line);
        const box = range.getBoundingClientRect();
        return [box.x + 20, box.y + box.height / 2];
      }
    });
    await page.mouse.move(x, y);
    const words = await page.waitForFunction(() => document.querySelector(".editor-host").shadowRoot.querySelector(".meaning")?.textContent);
    return [(await words.jsonValue()).includes("vertical angle"), await words.jsonValue()];
  },
  async "a number is dragged"(page) {
    await page.waitForFunction(() => document.querySelector(".editor-host").shadowRoot?.querySelector(".tok-number"));
    const box = await page.evaluate(() => {
      const number = [...document.querySelector(".editor-host").shadowRoot.querySelectorAll(".tok-number")].find((of) => of.textContent === "60");
      const { x, y, width, height } = number.getBoundingClientRect();
      return { x: x + width / 2, y: y + height / 2 };
    });
    await page.keyboard.down("Alt");
    await page.mouse.move(box.x, box.y);
    await page.mouse.down();
    await page.mouse.move(box.x - 80, box.y, { steps: 10 });
    await page.mouse.up();
    await page.keyboard.up("Alt");
    await settled(page);
    const angle = (await state(page, "scene")).camera.pinhole.vfov_deg;
    await press(page, "Undo");
    const back = (await state(page, "scene")).camera.pinhole.vfov_deg;
    return [angle === 40 && back === 60, `60 -> ${angle}, one undo -> ${back}`];
  },
  async "a color is picked"(page) {
    await page.waitForFunction(() => document.querySelector(".editor-host").shadowRoot?.querySelector(".swatch"));
    await page.evaluate(() => {
      const swatch = document.querySelector(".editor-host").shadowRoot.querySelector(".swatch");
      swatch.value = "#ff8000";
      swatch.dispatchEvent(new Event("input", { bubbles: true }));
    });
    await settled(page);
    const { background } = await state(page, "scene");
    return [String(background) === "1,0.216,0", String(background)];
  },
  async "the camera orbits by drag, as one step of undo"(page) {
    await page.evaluate(() => (studio.tool.value = "orbit"));
    const box = await (await page.$("canvas.canvas")).boundingBox();
    await page.mouse.move(box.x + 200, box.y + 300);
    await page.mouse.down();
    await page.mouse.move(box.x + 320, box.y + 330, { steps: 20 });
    const during = await text(page, ".readout");
    await page.mouse.up();
    await settled(page);
    const same = (await digest(page)) === (await render(page));
    await press(page, "Undo");
    await pause(100);
    const { eye } = (await state(page, "scene")).camera.pinhole;
    return [during.startsWith("eye") && same && String(eye) === "8,2,-4", during];
  },
  async "hovering lights the lines of the object"(page) {
    const box = await (await page.$("canvas.canvas")).boundingBox();
    const at = await state(page, "view");
    await page.mouse.move(box.x + at.left + 480 * at.scale, box.y + at.top + 500 * at.scale);
    await page.waitForFunction(() => studio.lit.value.length > 0);
    const lit = await state(page, "lit");
    const lines = await page.evaluate(() => document.querySelector(".editor-host").shadowRoot.querySelectorAll(".cm-lit").length);
    return [lit[0] === "/objects/3" && lines >= 1, `${lit}, ${lines} lines`];
  },
  async "a click puts the pixel cursor"(page) {
    const box = await (await page.$("canvas.canvas")).boundingBox();
    const at = await state(page, "view");
    await page.mouse.click(box.x + at.left + 480.5 * at.scale, box.y + at.top + 270.5 * at.scale);
    const pixel = await state(page, "pixel");
    return [Math.abs(pixel.x - 480) <= 1 && Math.abs(pixel.y - 270) <= 1, JSON.stringify(pixel)];
  },
  async "the wheel zooms about the pointer, 0 fits"(page) {
    const box = await (await page.$("canvas.canvas")).boundingBox();
    await page.mouse.move(box.x + 100, box.y + 300);
    const before = await state(page, "hover");
    for (let step = 0; step < 3; step += 1) await page.mouse.wheel({ deltaY: -240 });
    await page.mouse.move(box.x + 100.2, box.y + 300);
    const after = await state(page, "hover");
    const zoom = await text(page, ".zoom");
    await page.keyboard.press("0");
    return [before === null ? after === null : Math.abs(before.x - after.x) <= 2, zoom];
  },
  async "a window that goes to a finer screen shows the whole picture there"(page) {
    const { width, height } = page.viewport();
    const seen = [];
    for (const ratio of [2, 1]) {
      await page.setViewport({ width, height, deviceScaleFactor: ratio });
      // What a browser tells of another screen the emulation does not tell.
      await page.keyboard.press("+");
      const isSo = page.waitForFunction((of) => document.querySelector("canvas.canvas").width === document.querySelector("canvas.canvas").clientWidth * of, { timeout: 3000 }, ratio);
      seen.push(await isSo.then(() => true, () => false));
    }
    return [seen.every(Boolean), seen.join()];
  },
  async "examples open, and one can go back"(page) {
    const before = await state(page, "text");
    await page.keyboard.press("o");
    await page.waitForSelector(".example");
    const count = (await page.$$(".example")).length;
    await page.evaluate(() => [...document.querySelectorAll(".example")].find((of) => of.textContent.includes("Lute")).click());
    await page.waitForFunction((old) => studio.text.value !== old, {}, before);
    await settled(page);
    await press(page, "Back");
    await settled(page);
    return [count >= 6 && (await state(page, "text")) === before, `${count} examples`];
  },
  async "a file is dropped: JSON, NFF and gzip"(page) {
    const seen = [];
    for (const [name, packed] of [["ball.nff", false], ["ball.nff.gz", true]]) {
      await drop(page, name, NFF, packed);
      await page.waitForFunction(() => studio.origin.value.type === "text/x-nff");
      await settled(page);
      seen.push((await state(page, "shown")).width);
      await drop(page, "scene.json", '{ "version": 1, "image": { "width": 32, "height": 32 }, "camera": { "pinhole": { "eye": [0, 1, 5], "look_at": [0, 0, 0] } }, "objects": [ { "sphere": { "center": [0, 0, 0], "radius": 1 } } ] }');
      await page.waitForFunction(() => studio.size.value.width === 32);
      await settled(page);
    }
    return [seen.join() === "64,64", seen.join()];
  },
  async "a model is dropped: its scene is a text, its camera orbits by pointer and keys, undo brings back what was before"(page) {
    await page.waitForFunction(() => document.querySelector(".editor-host")?.shadowRoot?.querySelector(".cm-content"));
    const before = await state(page, "text");
    await dropAll(page, { "Box.glb": model("Box.glb") });
    await opened(page, "Box.glb");
    const { objects, environment, film, lights } = await state(page, "scene");
    const [red, green, , alpha] = await middle(page);
    const isShown = red > 60 && red > 2 * green && alpha === 255 && (await digest(page)) === (await render(page));
    const isWritten = /^sha256:[0-9a-f]{64}$/.test(objects[0].model.asset) && objects[1].mesh.name === "floor" && environment.studio && film.tone === "khronos_pbr_neutral" && lights.length === 1;
    const eyes = [await eye(page)];
    await page.keyboard.press("c");
    const box = await (await page.$("canvas.canvas")).boundingBox();
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width / 2 + 80, box.y + box.height / 2, { steps: 8 });
    await page.mouse.up();
    await settled(page);
    eyes.push(await eye(page));
    await page.focus("canvas.canvas");
    for (let step = 0; step < 3; step += 1) await page.keyboard.press("ArrowUp");
    const old = await state(page, "text");
    await page.waitForFunction((of) => studio.text.value !== of, { timeout: 5_000 }, old).catch(() => {});
    await settled(page);
    eyes.push(await eye(page));
    const isTurned = (await digest(page)) === (await render(page));
    for (let step = 0; step < 2; step += 1) {
      await press(page, "Undo");
      await settled(page);
      eyes.push(await eye(page));
    }
    await press(page, "Undo");
    await settled(page);
    const isBack = (await state(page, "text")) === before;
    return [isShown && isWritten && isTurned && isBack && new Set(eyes.slice(0, 3)).size === 3 && eyes[3] === eyes[1] && eyes[4] === eyes[0], `${isShown} ${isWritten} ${isTurned} ${isBack} ${eyes.map((of) => of.slice(0, 12)).join(" | ")}`];
  },
  async "models of all kinds are opened, from the dialog, too: by name or content, packed, and several files together"(page) {
    const glb = model("Box.glb");
    const end = 20 + glb.readUInt32LE(12);
    const json = JSON.parse(glb.toString("utf8", 20, end));
    const bin = glb.subarray(end + 8);
    const gltf = (uri) => Buffer.from(JSON.stringify({ ...json, buffers: [{ byteLength: json.buffers[0].byteLength, uri }] }));
    const whole = gltf(`data:application/octet-stream;base64,${bin.toString("base64")}`);
    const seen = [];
    for (const [name, files] of [
      ["cube.obj", { "cube.mtl": model("obj/cube.mtl"), "cube.obj": model("obj/cube.obj") }], ["20mm-xyz-cube.stl", { "20mm-xyz-cube.stl": model("stl/20mm-xyz-cube.stl") }],
      ["cube.ply", { "cube.ply": model("ply/cube.ply") }], ["Box.gltf", { "Box.gltf": whole }], ["download", { download: glb }], ["scene.json", { "scene.json": whole }],
      ["parts.gltf", { "box.bin": bin, "parts.gltf": gltf("box.bin") }],
    ]) {
      await dropAll(page, files);
      await opened(page, name);
      const scene = await state(page, "scene");
      const isParts = Object.keys(files).length > 1;
      seen.push([name, (await state(page, "origin")).name === name && (isParts ? "mesh" in scene.objects[0] : "model" in scene.objects[0]) && (await digest(page)) === (await render(page)) && (await middle(page))[3] === 255]);
    }
    await page.keyboard.press("o");
    await page.waitForSelector("dialog");
    const chooser = page.waitForFileChooser();
    await press(page, "Open a file");
    await (await chooser).accept([modelPath("RiggedFigure.glb")]);
    await opened(page, "RiggedFigure.glb");
    seen.push(["RiggedFigure.glb", "model" in (await state(page, "scene")).objects[0] && (await page.$("dialog")) === null]);
    return [seen.every(([, holds]) => holds), seen.map(([name, holds]) => `${name} ${holds ? "" : "NOT"}`).join(" ")];
  },
  async "a model that is refused says why, in plain words"(page) {
    const before = await state(page, "text");
    const told = [];
    for (const [files, words] of [
      [{ "out.glb": model("assimp_IndexOutOfRange.glb") }, "out.glb cannot be opened: element 0 is 255, and there are 24 vertices, at meshes › 0 › primitives › 0 › indices."],
      [{ "part.gltf": model("bad/buffer/not_found.gltf") }, 'part.gltf cannot be opened: it needs "not_found.bin". Open both together, or make one .glb of them.'],
      [{ "a.stl": model("stl/empty.stl") }, "a.stl cannot be opened: there is nothing to see: the model has no triangles that have an area."],
      [{ "a.fbx": Buffer.from("Kaydara FBX Binary  \0") }, "a.fbx cannot be opened: this is FBX, which strahl does not read: convert it to glTF (.glb)."],
      [{ "a.bin": Buffer.from([128, 0, 1]) }, "a.bin cannot be opened: it is no scene and no model."],
      [{ "a.gz": Buffer.from("x") }, "a cannot be opened: it cannot be read."],
      [null, "big.glb cannot be opened: it has 71,303,168 bytes, and the service takes 67,108,864."],
    ]) {
      if (files) await dropAll(page, files);
      else await drop(page, "big.glb", "glTF".repeat(17 << 20));
      const holds = await page.waitForFunction((of) => studio.notice.value?.text === of, { timeout: 10_000 }, words).catch(() => null);
      if (!holds) told.push(await page.evaluate(() => studio.notice.value?.text));
    }
    return [told.length === 0 && (await state(page, "text")) === before, told.join(" | ") || "7 of them"];
  },
  async "a phone held sideways has the picture as high as it can be, and the tools beside it"() {
    const seen = [];
    for (const [width, height] of [[740, 360], [844, 390], [667, 375], [568, 320]]) {
      const page = await open(browser, { width, height, touch: true });
      await settled(page);
      const [canvas, tools, edit] = await page.evaluate(() => ["canvas.canvas", ".tools", ".edit"].map((of) => document.querySelector(of).getBoundingClientRect().toJSON()));
      const { scale, top } = await state(page, "view");
      const { size } = await page.evaluate(() => ({ size: studio.size.value }));
      const isFull = scale * size.height >= 0.9 * canvas.height || scale * size.width >= 0.85 * canvas.width;
      await page.evaluate(() => [...document.querySelectorAll(".phone-tab")].find((of) => of.textContent === "Plan").click());
      await pause(200);
      const [panels, isEdit, across, down] = await page.evaluate(() => [document.querySelector(".panels").checkVisibility(), document.querySelector(".edit").checkVisibility(), document.documentElement.scrollWidth, document.documentElement.scrollHeight]);
      const small = await page.$$eval("button", (all) => all.filter((of) => of.checkVisibility()).map((of) => of.getBoundingClientRect()).filter((of) => of.width < 24 || of.height < 24).length);
      seen.push([canvas.height >= height - 80 && canvas.right <= tools.left && edit.right <= canvas.left && isFull && top >= 0 && panels && !isEdit && across <= width && down <= height && small === 0, `${width}x${height}: ${Math.round(canvas.width)}x${Math.round(canvas.height)}`]);
      await clean(page, "sideways");
    }
    return [seen.every(([holds]) => holds), seen.map(([, words]) => words).join(", ")];
  },
  async "undo and redo of another kind of file bring its kind, too"(page) {
    await page.waitForFunction(() => document.querySelector(".editor-host")?.shadowRoot?.querySelector(".cm-content"));
    const before = await state(page, "text");
    await drop(page, "ball.nff", NFF);
    await page.waitForFunction(() => studio.origin.value.type === "text/x-nff");
    await settled(page);
    const kinds = [];
    for (const step of ["Undo", "Redo", "Undo"]) {
      await press(page, step);
      await settled(page);
      kinds.push(await page.evaluate((old) => `${studio.origin.value.type} ${studio.text.value === old} ${studio.scene.value !== null}`, before));
    }
    await page.keyboard.press("s");
    await page.waitForSelector(".copied");
    const line = await page.$$eval(".copied textarea", (all) => all[1].value);
    return [kinds.join() === "application/json true true,text/x-nff false false,application/json true true" && !line.includes("nff"), kinds.join()];
  },
  async "a setting that is wrong is told, and left out by a button"(page) {
    const found = [];
    for (const [fragment, words] of [["q.samples=99999", "samples: expected a whole number"], ["q.width=99999", "width: expected a whole number"]]) {
      await page.evaluate((of) => (location.hash = `#e=whitted/whitted&${of}`), fragment);
      await page.waitForFunction((of) => document.querySelector(".trouble")?.textContent.includes(of) && document.querySelector(".problems")?.textContent.includes(of), { timeout: 20_000 }, words);
      found.push(await text(page, ".problems"));
      // The keys and buttons that go to a problem find none in the text.
      await page.keyboard.press("F8");
      await page.click(".state");
      await press(page, "Leave it out");
      await settled(page);
    }
    return [(await page.$(".problems")) === null && Object.keys(await state(page, "settings")).length === 0, found.join(" | ")];
  },
  async "a size by its name is that of the picture"(page) {
    await page.evaluate(() => (location.hash = "#e=whitted/whitted&q.size=og&q.accuracy=fixed"));
    await page.waitForFunction(() => studio.settings.value.size === "og" && studio.shown.value.settings.size === "og", { timeout: 10_000 }).catch(() => {});
    const { width, height } = await state(page, "size");
    const shown = await state(page, "shown");
    return [`${width}x${height} ${shown.width}x${shown.height}` === "1200x630 1200x630", `${shown.width}x${shown.height}`];
  },
  async "nonsense in an address leaves the picture in sight"(page) {
    const scales = [];
    for (const frame of ["0,0,0", "0.5,0.5,-3", "1e308,1e308,1e308", "0.5,0.5,1e-300"]) {
      await page.evaluate((of) => (location.hash = `#e=whitted/whitted&v=${of}`), frame);
      await pause(700);
      const { scale, left, top } = await state(page, "view");
      scales.push([scale > 0.01 && scale <= 65_536 && Number.isFinite(left) && Number.isFinite(top), scale]);
    }
    return [scales.every(([holds]) => holds), scales.map(([, scale]) => scale).join()];
  },
  async "long scenes have an address each: Back and a reload bring the right one, or none"(page) {
    const long = (name, count) => page.evaluate((of, many) => {
      const objects = Array.from({ length: many }, (_, i) => ({ sphere: { center: [Math.sin(i * 12.9898) * 4, Math.sin(i * 78.233), Math.sin(i * 37.719) * 4], radius: 0.02 + (i % 97) / 9700 } }));
      return JSON.stringify({ ...studio.scene.value, name: of, objects });
    }, name, count);
    const named = (name) => page.waitForFunction((of) => studio.title.value === of && location.hash.startsWith("#k="), { timeout: 60_000 }, name);
    // The first scene has an address by then.
    await pause(700);
    const plain = await page.evaluate(() => history.length);
    const seen = [];
    for (const [name, count] of [["long A", 2000], ["long B", 2000], ["too long", 80_000]]) {
      const before = page.url();
      await drop(page, `${name}.json`, await long(name, count));
      await named(name);
      await page.waitForFunction((of) => location.href !== of, { timeout: 10_000 }, before);
      seen.push(page.url().split("#")[1]);
    }
    const steps = (await page.evaluate(() => history.length)) - plain;
    await page.evaluate(() => (studio.dialog.value = "share"));
    await page.waitForSelector(".dialog .row");
    const shared = await text(page, "dialog");
    await page.evaluate(() => (studio.dialog.value = ""));
    await page.reload();
    await ready(page);
    const anew = await state(page, "title");
    const told = await page.evaluate(() => studio.notice.value?.text ?? "");
    await page.goBack();
    await named("long B");
    await page.goBack();
    await named("long A");
    await pause(700);
    await page.reload();
    await ready(page);
    const last = await state(page, "title");
    return [new Set(seen.map((of) => of.split("&")[0])).size === 3 && steps === 3 && anew.includes("Whitted 1980") && told.includes("too long for an address") && last === "long A" && shared.includes("too long for a link"), `${steps} steps; ${anew}: ${told}; ${last}`];
  },
  async "paused, edits wait for Ctrl-Enter"(page) {
    await page.keyboard.press("p");
    const before = await digest(page);
    await page.evaluate(() => studio.editAt("/objects/0/sphere/radius", 0.7));
    await pause(500);
    const waited = (await digest(page)) === before && (await text(page, ".state")).startsWith("as you left it");
    await page.keyboard.down("Control");
    await page.keyboard.press("Enter");
    await page.keyboard.up("Control");
    await page.waitForFunction(() => studio.shown.value.rung === 2 && studio.shown.value.text === studio.text.value);
    return [waited && (await digest(page)) !== before, "waited"];
  },
  async "a link restores scene, settings, pixel and zoom in another browser"(page) {
    await page.evaluate(() => {
      studio.editAt("/objects/0/sphere/radius", 1.125);
      // Cheap: on a busy machine a dear picture is offered instead of rendered, here or there.
      studio.settings.value = { accuracy: "fixed" };
      studio.pixel.value = { x: 400, y: 310 };
      studio.zoomBy(3);
    });
    await settled(page);
    const before = { digest: await digest(page), view: await state(page, "view") };
    await page.keyboard.press("s");
    await page.waitForFunction(() => document.querySelector(".copied textarea")?.value.length > 40);
    const link = await page.$eval(".copied textarea", (of) => of.value);
    const other = await open(browser, { fragment: new URL(link).hash });
    await settled(other);
    const after = { digest: await digest(other), view: await state(other, "view"), pixel: await state(other, "pixel"), settings: await state(other, "settings") };
    await clean(other, "link");
    const same = after.digest === before.digest && Math.abs(after.view.scale - before.view.scale) < 1e-3 && Math.abs(after.view.left - before.view.left) < 1 && after.pixel.x === 400 && after.settings.accuracy === "fixed";
    return [same, `${link.length} characters`];
  },
  async "the curl line gives the bytes on screen"(page) {
    await page.keyboard.press("s");
    await page.waitForSelector(".copied");
    const line = await page.$$eval(".copied textarea", (all) => all[1].value);
    const url = /'([^']+)'/.exec(line)[1];
    const scene = await state(page, "text");
    const answer = await fetch(url, { method: "POST", body: scene, headers: { "content-type": "application/x-www-form-urlencoded" } });
    const bytes = new Uint8Array(await crypto.subtle.digest("SHA-256", await answer.arrayBuffer()));
    const hex = [...bytes].map((of) => of.toString(16).padStart(2, "0")).join("");
    return [hex === (await digest(page)), line.slice(0, 80)];
  },
  async "the address follows, and a reload restores"(page) {
    await page.evaluate(() => studio.editAt("/objects/0/sphere/radius", 0.875));
    await settled(page);
    await pause(700);
    const before = await digest(page);
    await page.reload();
    await ready(page);
    await settled(page);
    return [(await digest(page)) === before, page.url().slice(0, 60)];
  },
  async "the palette finds and runs a command"(page) {
    await page.keyboard.down("Control");
    await page.keyboard.press("k");
    await page.keyboard.up("Control");
    await page.waitForSelector(".command");
    await page.waitForFunction(() => document.activeElement?.tagName === "INPUT");
    await page.keyboard.type("theme");
    await page.waitForFunction(() => document.querySelector('.command[aria-selected="true"]')?.textContent?.startsWith("Theme"));
    await page.keyboard.press("Enter");
    await page.waitForFunction(() => document.documentElement.dataset.theme === "dark");
    return [true, "dark"];
  },
  async "hostile names stay text"(page) {
    const names = ["<img src=x onerror=alert(1)>", "<script>alert(1)</script>", "javascript:alert(1)", "\"><svg onload=alert(1)>", "{{constructor.constructor('alert(1)')()}}", "${alert(1)}", "\u202etxt.exe", "'-alert(1)-'"];
    let dialogs = 0;
    page.on("dialog", (of) => ((dialogs += 1), of.dismiss()));
    // As names, as references in problems, as keys, and as what a notice says.
    for (const name of names) {
      await page.evaluate((of) => {
        studio.editAt("/name", of);
        studio.editAt("/objects/0/sphere/name", of);
        studio.editAt("/objects/1/sphere/material", of);
        studio.say(of);
      }, name);
      await pause(200);
      await page.evaluate((of) => {
        studio.editAt("/objects/1/sphere/material", "glass");
        studio.setText(studio.text.value.replace('"hollow": true', `${JSON.stringify(of)}: true`));
      }, name);
      await pause(200);
      await page.evaluate((of) => studio.setText(studio.text.value.replace(`${JSON.stringify(of)}: true`, '"hollow": true')), name);
    }
    await settled(page);
    const elements = await page.evaluate(() => document.querySelectorAll("img, svg[onload], script:not([src])").length);
    return [dialogs === 0 && elements === 0, `${names.length} names in 5 places`];
  },
  async "Back goes to the scene before"(page) {
    const before = await state(page, "title");
    await pause(600);
    await page.keyboard.press("o");
    await page.waitForSelector(".example");
    await page.evaluate(() => [...document.querySelectorAll(".example")].find((of) => of.textContent.includes("Lute")).click());
    await page.waitForFunction((old) => studio.title.value !== old, {}, before);
    await pause(900);
    await page.goBack();
    await page.waitForFunction((old) => studio.title.value === old, {}, before);
    return [true, before.slice(0, 40)];
  },
  async "a newer version of the page is offered, the old one goes on"(page) {
    const isEmbedded = await page.evaluate(() => /studio\/[0-9a-f]{16}\//.test(document.querySelector("script[type=module]").src));
    if (!isEmbedded) return [true, "not with files from a folder"];
    await page.evaluate(() => {
      const real = window.fetch;
      window.fetch = async (...args) => (args[1]?.method === "HEAD" ? new Response(null, { headers: { etag: '"0123456789abcdef"' } }) : real(...args));
      document.dispatchEvent(new Event("visibilitychange"));
    });
    await page.waitForFunction(() => document.querySelector(".strip").innerText.includes("new version"));
    await page.evaluate(() => studio.editAt("/objects/0/sphere/radius", 0.9));
    await settled(page);
    return [true, await text(page, ".strip").then((of) => of.slice(-60))];
  },
  async "a phone: panes, taps, no sideways scrolling"() {
    const page = await open(browser, { width: 390, height: 844, touch: true });
    await settled(page);
    const box = await (await page.$("canvas.canvas")).boundingBox();
    await page.touchscreen.tap(box.x + 195, box.y + 120);
    const pixel = await state(page, "pixel");
    await page.evaluate(() => [...document.querySelectorAll(".phone-tab")].find((of) => of.textContent === "Plan").click());
    await pause(200);
    const shown = await page.evaluate(() => [document.querySelector(".panels").checkVisibility(), document.querySelector(".edit").checkVisibility(), document.documentElement.scrollWidth, document.documentElement.scrollHeight]);
    await clean(page, "phone");
    return [pixel !== null && shown[0] && !shown[1] && shown[2] <= 390 && shown[3] <= 844, `${JSON.stringify(pixel)} ${shown.join(" ")}`];
  },
  async "dialogs at 320 pixels scroll downwards only"() {
    const page = await open(browser, { width: 320, height: 568 });
    await settled(page);
    const wide = [];
    for (const name of ["help", "share", "commands", "examples", "key"]) {
      await page.evaluate((of) => (studio.dialog.value = of), name);
      await page.waitForSelector("dialog");
      await pause(300);
      if (await page.$eval("dialog", (of) => [of, ...of.querySelectorAll("*")].some((it) => it.scrollWidth > it.clientWidth + 1 && /auto|scroll/.test(getComputedStyle(it).overflowX) && it.tagName !== "TEXTAREA"))) wide.push(name);
      await page.evaluate(() => (studio.dialog.value = ""));
    }
    await clean(page, "320 pixels");
    return [wide.length === 0, wide.join(", ") || "none"];
  },
  async "text at 200 % loses nothing"(page) {
    await page.evaluate(() => (document.documentElement.style.fontSize = "200%"));
    await pause(300);
    const lost = await page.evaluate(() => [...document.querySelectorAll("button, [role=tab], input")].filter((of) => of.checkVisibility() && !of.closest(".strip, .tab-list, .hidden-visually") && of.scrollWidth > of.clientWidth + 2 && of.clientWidth > 0 && of.tagName !== "INPUT").map((of) => of.textContent.trim()));
    return [lost.length === 0, lost.join(", ") || "nothing"];
  },
};

for (const [name, flow] of Object.entries(flows)) {
  if (only.length > 0 && !only.some((word) => name.includes(word))) continue;
  const page = await open(browser);
  try {
    await settled(page);
    const [holds, told] = await flow(page);
    figure(name, told, holds);
  } catch (error) {
    figure(name, error.message.split("\n")[0], false);
  }
  await clean(page, name);
}
await end(browser);
