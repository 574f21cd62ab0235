// The map over the picture: asks for it, coarse first, and draws it. What it shows stays on while other panels are open.
import { batch, computed, effect, signal, untracked } from "../../vendor/preact.js";
import { ask, patiently, pause } from "../api.js";
import { loadObjects, painted } from "./maps-objects.js";
import { readPfm } from "./pfm.js";
import { colored, histogram, scaleOf } from "../ramps.js";
import { bitmaps, connection, hover, origin, panel, pixel, predicted, problems, putLayer, removeLayer, settings, size, text, version } from "../state.js";

/**
 * What a map shows. @typedef {object} Kind
 * @property {string} title
 * @property {string} words
 * @property {boolean} isLogarithmic where one begins
 * @property {(value: number) => string} shown
 */
const plainly = (/** @type {string} */ unit) => (/** @type {number} */ value) => `${value.toLocaleString("en", { maximumFractionDigits: 1 })} ${unit}${value === 1 ? "" : "s"}`;
const time = (/** @type {number} */ ns) => (ns < 999.5 ? `${Math.round(ns)} ns` : ns < 999_500 ? `${(ns / 1e3).toPrecision(3)} µs` : `${(ns / 1e6).toPrecision(3)} ms`);
/** @type {Record<string, Kind>} */
export const KINDS = {
  proved: { title: "Proved", words: "Most codes of 255 that each pixel is proved to be off; 255 where nothing bounds it.", isLogarithmic: false, shown: plainly("code") },
  rays: { title: "Rays", words: "Rays of all kinds that each pixel took.", isLogarithmic: true, shown: plainly("ray") },
  time: { title: "Time", words: "Processor time of each pixel; up to 16 that are traced together share it by their rays.", isLogarithmic: true, shown: time },
  depth: { title: "Depth", words: "Rays in the longest chain of each pixel; the camera ray counts 1.", isLogarithmic: false, shown: plainly("ray") },
  samples: { title: "Samples", words: "Samples that each pixel got.", isLogarithmic: true, shown: plainly("sample") },
  object: { title: "Objects", words: "What each pixel shows, straight ahead: each object has a color.", isLogarithmic: false, shown: (value) => (value === 0 ? "nothing" : (found.peek()?.objects?.[value - 1]?.name ?? `object ${value}`)) },
  distance: { title: "Distance", words: "How far away what each pixel shows is.", isLogarithmic: true, shown: (value) => value.toPrecision(4) },
};

/** Blocks of the coarse map. */
const STEP = 8;
/** Pixels above which a coarse map comes first. */
const LARGE = 40_000;
/** Predicted milliseconds above which the whole map waits to be asked for. */
const LONG = 3000;
const QUIET = 700;

export const kind = signal("");
export const opacity = signal(0.85);
export const isLogarithmic = signal(false);
export const isClipped = signal(false);
export const onlyPositive = signal(false);
export const rampName = signal(/** @type {import("../ramps.js").RampName} */ ("cividis"));
/** @typedef {{ kind: string, version: number, step: number, floats: import("./pfm.js").Floats, key: string, objects?: import("./maps-objects.js").Named[] }} Found */
export const found = signal(/** @type {Found | null} */ (null));
export const progress = signal(/** @type {{ word: "" | "coarse" | "whole" | "waiting" | "held" | "failed", detail: string }} */ ({ word: "", detail: "" }));
/** Raised to ask for the whole map although it takes long, or again. */
const asked = signal(0);

export const isStale = computed(() => found.value !== null && found.value.version !== version.value);
export const scale = computed(() => found.value && scaleOf(found.value.floats.values, { isLogarithmic: isLogarithmic.value, isClipped: isClipped.value }));
export const bins = computed(() => (found.value && scale.value ? histogram(found.value.floats.values, scale.value, 56) : []));
/** The pixel under the pointer, else the pixel cursor, and its number. */
export const read = computed(() => {
  const at = hover.value ?? pixel.value;
  const of = found.value;
  if (!at || !of) return null;
  const [x, y] = [Math.floor((at.x * of.floats.width) / size.value.width), Math.floor((at.y * of.floats.height) / size.value.height)];
  const value = of.floats.values[y * of.floats.width + x];
  return value === undefined ? null : { at, value };
});
/** Sum, mean, and where the most is. */
export const sums = computed(() => {
  const of = found.value?.floats;
  if (!of) return null;
  let [sum, most, counted] = [0, 0, 0];
  for (let i = 0; i < of.values.length; i += 1) {
    if (!Number.isFinite(of.values[i])) continue;
    sum += of.values[i];
    counted += 1;
    if (of.values[i] > of.values[most]) most = i;
  }
  const place = { x: Math.floor(((most % of.width) * size.value.width) / of.width), y: Math.floor((Math.floor(most / of.width) * size.value.height) / of.height) };
  return { sum, mean: sum / Math.max(1, counted), most: of.values[most], place };
});

/** Chooses a map; "" takes it away. @param {string} next */
export function choose(next) {
  batch(() => {
    if (next !== "" && next !== kind.peek()) isLogarithmic.value = KINDS[next].isLogarithmic;
    kind.value = next;
  });
}
/** Asks for the whole map, or again after it failed. */
export const askAgain = () => (asked.value += 1);

/** @param {string} of @param {number} step @param {AbortSignal} signal @returns {Promise<Found>} */
async function load(of, step, signal) {
  const about = { kind: of, version: version.peek(), step, key: keyOf(of) };
  const query = { ...settings.peek(), of, format: "pfm", step };
  const waiting = (/** @type {number} */ seconds) => (progress.value = { word: "waiting", detail: `The service is busy and takes it in ${seconds} s.` });
  const request = { body: text.peek(), type: origin.peek().type, query, signal, priority: /** @type {const} */ ("low") };
  if (of === "object") {
    const { objects, ...map } = await patiently(() => loadObjects(request), signal, waiting);
    return { ...about, floats: { ...map, channels: 1 }, objects };
  }
  const answer = await patiently(() => ask("v1/map", request), signal, waiting);
  return { ...about, floats: readPfm(await answer.arrayBuffer()) };
}

const keyOf = (/** @type {string} */ of) => `${of} ${version.peek()} ${JSON.stringify(settings.peek())}`;

/** Coarse, then whole. @param {string} of @param {boolean} force @param {AbortSignal} signal */
async function run(of, force, signal) {
  const known = found.peek();
  if (known?.key === keyOf(of) && known.step === 1) return (progress.value = { word: "", detail: "" });
  if (known) await pause(known.kind === of && !force ? QUIET : 0, signal);
  const isLarge = size.peek().width * size.peek().height > LARGE;
  try {
    if (isLarge && !(known?.key === keyOf(of))) {
      progress.value = { word: "coarse", detail: "" };
      found.value = await load(of, STEP, signal);
    }
    if (isLarge && !force && (predicted.peek()?.ms ?? 0) > LONG) return (progress.value = { word: "held", detail: "" });
    progress.value = { word: "whole", detail: "" };
    const whole = await load(of, 1, signal);
    batch(() => ((found.value = whole), (progress.value = { word: "", detail: "" })));
  } catch (error) {
    if (!signal.aborted) progress.value = { word: "failed", detail: /** @type {Error} */ (error).message };
  }
}

let bitmap = /** @type {ImageBitmap | null} */ (null);

/** @param {ImageBitmap | null} next */
function put(next) {
  if (bitmap) {
    bitmap.close();
    bitmaps.closed += 1;
  }
  if (next) bitmaps.made += 1;
  bitmap = next;
  if (next) putLayer({ id: "map", order: 5, opacity: opacity.peek(), draw });
  else removeLayer("map");
}

/** @param {CanvasRenderingContext2D} context @param {import("../state.js").View} view */
function draw(context, view) {
  if (!bitmap) return;
  context.imageSmoothingEnabled = view.scale < 1;
  context.drawImage(bitmap, view.left, view.top, size.peek().width * view.scale, size.peek().height * view.scale);
}

export function start() {
  let wanted = 0;
  effect(() => {
    const of = kind.value;
    const isOpen = panel.value === "maps";
    const force = asked.value > wanted;
    const isReady = connection.value.online && problems.value.length === 0;
    void [version.value, settings.value];
    const control = new AbortController();
    untracked(() => {
      if (of === "") batch(() => ((found.value = null), (progress.value = { word: "", detail: "" })));
      else if (isOpen && isReady) {
        wanted = asked.peek();
        run(of, force, control.signal).catch(() => {});
      } else if (isStale.peek()) found.value = null;
    });
    return () => control.abort();
  });
  effect(() => {
    const [of, along, name, positive] = [found.value, scale.value, rampName.value, onlyPositive.value];
    if (!of || !along) return untracked(() => put(null));
    let isOver = false;
    const { width, height, values } = of.floats;
    const pixels = of.objects ? painted(values) : colored(values, along, name, positive);
    createImageBitmap(new ImageData(pixels, width, height)).then((next) => (isOver ? next.close() : put(next)));
    return () => void (isOver = true);
  });
  effect(() => {
    const next = opacity.value;
    untracked(() => bitmap && putLayer({ id: "map", order: 5, opacity: next, draw }));
  });
}
