// The two pictures of a comparison: asks for B, keeps the numbers of both, and measures how far they are apart.
import { batch, computed, effect, signal, untracked } from "../../vendor/preact.js";
import { Problem, ask, patiently, pause, render } from "../api.js";
import { readPfm } from "./pfm.js";
import { bitmaps, connection, origin, other, otherAsked, panel, reference, settings, shown, text, version } from "../state.js";
import { difference, exposed, measure } from "./compare-metrics.js";

/** @typedef {import("../state.js").Shown} Shown */
/** @typedef {"wipe" | "side" | "flip" | "difference" | "flip map"} Mode */

/** Milliseconds without an edit before B is asked for again. */
const QUIET = 500;
/** Milliseconds after which another B is meant: arrow keys pass over many. */
const SETTLED = 120;

export const mode = signal(/** @type {Mode} */ ("wipe"));
/** Where the wipe is, from 0 to 1. */
export const wipe = signal(0.5);
/** Whether B is shown in place of A, while the space bar is held. */
export const flipped = signal(false);
/** The difference is shown that many times. */
export const gain = signal(16);
/** Stops of exposure. Other than 0 it takes the floats of both. */
export const exposure = signal(0);
/** What B is doing: "", "rendering", or why there is none. */
export const state = signal(/** @type {{ word: "" | "rendering" | "waiting" | "failed", detail: string }} */ ({ word: "", detail: "" }));
/** @type {import("../../vendor/preact.js").Signal<import("./compare-metrics.js").Metrics | null>} */
export const metrics = signal(null);

/** A: what it is held against. */
export const a = computed(() => reference.value ?? (shown.value && { ...shown.value, label: "the scene" }));
export const isOn = computed(() => other.value !== null && a.value !== null);
/** Whether B shows an older text than the editor. */
export const isStale = computed(() => other.value !== null && otherAsked.value?.text === null && other.value.version !== version.value);
/** Both pictures can be compared pixel by pixel. */
export const alike = computed(() => {
  const [one, two] = [a.value, other.value];
  return one !== null && two !== null && one.width === two.width && one.height === two.height;
});

/** Codes of pictures, four bytes for each pixel, as long as the pictures live. */
const codes = /** @type {WeakMap<ImageBitmap, Uint8ClampedArray>} */ (new WeakMap());

/** The codes of a picture. @param {Shown} of */
export function codesOf({ bitmap, width, height }) {
  const known = codes.get(bitmap);
  if (known || bitmap.width === 0) return known ?? null;
  const context = /** @type {OffscreenCanvasRenderingContext2D} */ (new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true }));
  context.drawImage(bitmap, 0, 0);
  const { data } = context.getImageData(0, 0, width, height);
  codes.set(bitmap, data);
  return data;
}

/** Starts a comparison. @param {{ label: string, settings: import("../state.js").Settings, text: string | null }} of @param {Mode} [how] */
export function compareWith(of, how) {
  batch(() => {
    otherAsked.value = of;
    if (how) mode.value = how;
  });
}

/** Ends the comparison. */
export function endComparison() {
  batch(() => ((otherAsked.value = null), (exposure.value = 0), (flipped.value = false)));
}

/** Closes a bitmap that nobody draws any more. @param {ImageBitmap | null | undefined} bitmap */
export function letGo(bitmap) {
  if (!bitmap) return;
  bitmap.close();
  bitmaps.closed += 1;
}

/** Takes A of the dial, or nothing. @param {(Shown & { label: string }) | null} next @param {AbortSignal} [ended] */
export function refer(next, ended) {
  if (next) bitmaps.made += 1;
  if (ended?.aborted) return letGo(next?.bitmap);
  const before = reference.peek();
  reference.value = next;
  letGo(before?.bitmap);
}

/** @param {(Shown & { label: string }) | null} next */
function put(next) {
  const before = other.peek();
  other.value = next;
  if (next) bitmaps.made += 1;
  letGo(before?.bitmap);
}

/** @param {NonNullable<typeof otherAsked.value>} asked @param {AbortSignal} signal */
async function load(asked, signal) {
  const is = { text: asked.text ?? text.peek(), version: version.peek(), settings: { ...settings.peek(), ...asked.settings }, type: origin.peek().type };
  state.value = { word: "rendering", detail: "" };
  try {
    const waiting = (/** @type {number} */ seconds) => (state.value = { word: "waiting", detail: `The service is busy and takes it in ${seconds} s.` });
    const picture = await patiently(() => render({ text: is.text, type: is.type, settings: is.settings, signal, priority: "low" }), signal, waiting);
    const { width, height } = picture.bitmap;
    batch(() => {
      put({ bitmap: picture.bitmap, width, height, rung: 2, version: is.version, text: is.text, settings: is.settings, report: picture.report, label: asked.label });
      state.value = { word: "", detail: "" };
    });
  } catch (error) {
    if (signal.aborted) return;
    state.value = { word: "failed", detail: error instanceof Error ? error.message : String(error) };
  }
}

/** The floats of a picture, as linear light. @param {Shown} of @param {AbortSignal} signal */
async function floatsOf(of, signal) {
  const answer = await patiently(() => ask("v1/render", { body: of.text, type: origin.peek().type, query: { ...of.settings, format: "pfm" }, signal }), signal);
  return readPfm(await answer.arrayBuffer());
}

/** What is drawn in place of the pictures: at an exposure, or their difference. */
export const drawn = signal(/** @type {{ a: ImageBitmap | null, b: ImageBitmap | null, difference: ImageBitmap | null }} */ ({ a: null, b: null, difference: null }));

/** @param {Partial<typeof drawn.value>} next */
function draw(next) {
  const before = drawn.peek();
  drawn.value = { ...before, ...next };
  for (const key of /** @type {("a" | "b" | "difference")[]} */ (Object.keys(next))) {
    if (next[key]) bitmaps.made += 1;
    if (before[key] !== next[key]) letGo(before[key]);
  }
}

/** Takes a map that is shown as the difference is. @param {ImageBitmap} map */
export const putMap = (map) => draw({ difference: map });

/** @param {Uint8ClampedArray<ArrayBuffer>} pixels @param {number} width @param {number} height */
export const bitmapOf = (pixels, width, height) => createImageBitmap(new ImageData(pixels, width, height));

/** @type {{ of: string, a: import("./pfm.js").Floats, b: import("./pfm.js").Floats } | null} */
let floats = null;

/** @param {number} stops @param {Shown} one @param {Shown} two @param {AbortSignal} signal */
async function expose(stops, one, two, signal) {
  const of = [one, two].map((picture) => `${picture.version} ${JSON.stringify(picture.settings)}`).join(" | ");
  if (floats?.of !== of) floats = { of, a: await floatsOf(one, signal), b: await floatsOf(two, signal) };
  const known = floats;
  const [left, right] = await Promise.all([known.a, known.b].map((part) => bitmapOf(exposed(part, stops), part.width, part.height)));
  if (signal.aborted) return left.close(), right.close();
  draw({ a: left, b: right });
}

/** Runs a task again when what it reads changes, and aborts the run before. @param {(signal: AbortSignal) => (() => Promise<any>) | null} read */
function task(read) {
  effect(() => {
    const control = new AbortController();
    const run = read(control.signal);
    if (run) untracked(run).catch((/** @type {unknown} */ error) => control.signal.aborted || (state.value = { word: "failed", detail: error instanceof Problem ? error.message : String(error) }));
    return () => control.abort();
  });
}

/** Begins to watch what is asked for. */
export function start() {
  let before = /** @type {typeof otherAsked.value} */ (null);
  task((signal) => {
    const asked = otherAsked.value;
    const isOnline = connection.value.online;
    // B of the scene's own text follows each edit; a kept text does not change.
    if (asked?.text === null) void [version.value, settings.value];
    if (!asked) return () => (before = null, put(null), (state.value = { word: "", detail: "" }), Promise.resolve());
    const isNew = asked !== before;
    before = asked;
    return isOnline ? () => pause(isNew ? SETTLED : QUIET, signal).then(() => load(asked, signal)) : null;
  });
  task((signal) => {
    const [one, two] = [a.value, other.value];
    const isWanted = panel.value === "compare" || panel.value === "accuracy";
    if (!one || !two || !alike.value || one.rung < 2 || !isWanted) return () => ((metrics.value = null), Promise.resolve());
    return async () => {
      const [left, right] = [codesOf(one), codesOf(two)];
      if (!left || !right) return;
      for (const run = measure(left, right, one.width); ; await pause(0, signal)) {
        const { done, value } = run.next();
        if (done) return (metrics.value = value);
      }
    };
  });
  effect(() => {
    void [a.value, other.value];
    // The map of FLIP is of two pictures: others end it.
    untracked(() => mode.peek() === "flip map" && (mode.value = "wipe"));
  });
  task((signal) => {
    const [one, two, times] = [a.value, other.value, gain.value];
    if (mode.value === "flip map") return null;
    if (mode.value !== "difference" || !one || !two || !alike.value) return () => (draw({ difference: null }), Promise.resolve());
    return async () => {
      const [left, right] = [codesOf(one), codesOf(two)];
      const next = left && right && (await bitmapOf(difference(left, right, times), one.width, one.height));
      if (signal.aborted) next?.close();
      else draw({ difference: next || null });
    };
  });
  task((signal) => {
    const [one, two, stops] = [a.value, other.value, exposure.value];
    if (stops === 0 || !one || !two) return () => (draw({ a: null, b: null }), Promise.resolve());
    return () => pause(120, signal).then(() => expose(stops, one, two, signal));
  });
}
