// What each stop of the dial should take, before, and what it took, after. Kept for the text that it is about.
import { batch, computed, effect, signal, untracked } from "../../vendor/preact.js";
import { askJson, patiently, pause, render } from "../api.js";
import { connection, origin, other, otherAsked, panel, problems, reference, settings, text, version } from "../state.js";
import { refer } from "./compare-pictures.js";
import { STOPS, finest, settingsOf, typed } from "./accuracy-stops.js";

/** @typedef {import("./accuracy-stops.js").Stop} Stop */
/** @typedef {{ ms: number, low: number, high: number, rays: number }} Prediction */
/** @typedef {{ ms: number | null, rays: number, proved: number | null, identical: number | null, estimated: number | null, digest: string }} Receipt `ms` is null if the service had the picture already */

/** Milliseconds without an edit before predictions are asked for. */
const QUIET = 700;
/** Requests on their way at once. */
const AT_ONCE = 3;

export const precision = signal(/** @type {import("./accuracy-stops.js").Precision} */ (""));
/** What A is: the picture of the scene, or the finest stop that has been seen. */
export const against = signal(/** @type {"scene" | "finest"} */ ("scene"));
export const predictions = signal(/** @type {Map<string, Prediction>} */ (new Map()));
export const receipts = signal(/** @type {Map<string, Receipt>} */ (new Map()));
/** Why there are no predictions, or "". */
export const trouble = signal("");
/** The stop that is B, or null. */
export const chosen = computed(() => STOPS.find(({ id }) => otherAsked.value?.label === labelOf(id)) ?? null);

/** The name of a stop as B. @param {string} id */
export const labelOf = (id) => /** @type {Stop} */ (STOPS.find((stop) => stop.id === id)).label;

/** Makes a stop B. @param {Stop} stop */
export function choose(stop) {
  otherAsked.value = { label: stop.label, settings: settingsOf(stop, {}, precision.peek()), text: null };
}

/** @param {any} estimate @param {Stop} stop @returns {Prediction} */
const prediction = ({ ms, ms_ci: [low, high], rays }, { budget }) => (budget === undefined ? { ms, low, high, rays } : { ms: Math.min(ms, budget), low: Math.min(low, budget), high: Math.min(high, budget), rays });

/** One request for all stops. @param {string} scene @param {AbortSignal} signal @param {(stop: Stop, found: Prediction) => void} take */
async function askMany(scene, signal, take) {
  const all = STOPS.map((stop) => typed(settingsOf(stop, settings.peek(), precision.peek())));
  const body = `{"settings":${JSON.stringify(all)},"scene":${scene}}`;
  const answer = await patiently(() => askJson("v1/explain", { body, type: "application/json", signal }), signal);
  answer.estimates.forEach((/** @type {any} */ { estimate }, /** @type {number} */ i) => estimate && take(STOPS[i], prediction(estimate, STOPS[i])));
}

/** A request for each stop: a scene that is no JSON goes into no other. @param {string} scene @param {AbortSignal} signal @param {(stop: Stop, found: Prediction) => void} take */
async function askEach(scene, signal, take) {
  const left = [...STOPS];
  const work = async () => {
    for (let stop = left.shift(); stop; stop = left.shift()) {
      const of = stop;
      const query = settingsOf(of, settings.peek(), precision.peek());
      const { estimate } = await patiently(() => askJson("v1/explain", { body: scene, type: origin.peek().type, query, signal, priority: "low" }), signal);
      take(of, prediction(estimate, of));
    }
  };
  await Promise.all(Array.from({ length: AT_ONCE }, work));
}

/** @param {AbortSignal} signal */
async function load(signal) {
  await pause(QUIET, signal);
  const scene = text.peek();
  const take = (/** @type {Stop} */ stop, /** @type {Prediction} */ found) => !signal.aborted && (predictions.value = new Map(predictions.peek()).set(stop.id, found));
  await (origin.peek().type === "application/json" ? askMany : askEach)(scene, signal, take);
}

/** Keeps what a picture of a stop took. */
function receive() {
  const picture = other.peek();
  const stop = chosen.peek();
  if (!picture || !stop || picture.label !== stop.label || picture.version !== version.peek()) return;
  const { ms, totalRays: rays, proved, identical, estimated, digest, hit } = picture.report;
  const before = receipts.peek().get(stop.id);
  const receipt = { ms: hit ? (before?.ms ?? null) : ms, rays, proved, identical, estimated, digest };
  receipts.value = new Map(receipts.peek()).set(stop.id, receipt);
}

let holding = new AbortController();
/** Makes A the finest stop that has been seen: a copy of B, or the picture that the service still has. */
async function hold() {
  const best = against.peek() === "finest" ? finest(receipts.peek().keys()) : null;
  if (best?.label === reference.peek()?.label) return;
  holding.abort();
  holding = new AbortController();
  const { signal: ended } = holding;
  if (!best) return refer(null);
  const picture = other.peek();
  if (picture?.label === best.label) return refer({ ...picture, bitmap: await createImageBitmap(picture.bitmap) }, ended);
  const of = { text: text.peek(), version: version.peek(), settings: settingsOf(best, settings.peek(), precision.peek()) };
  const { bitmap, report } = await patiently(() => render({ text: of.text, type: origin.peek().type, settings: of.settings, signal: ended, priority: "low" }), ended);
  refer({ ...of, bitmap, report, width: bitmap.width, height: bitmap.height, rung: 2, label: best.label }, ended);
}

/** Forgets what is about another text. */
function forget() {
  batch(() => (refer(null), (predictions.value = new Map()), (receipts.value = new Map()), (trouble.value = "")));
}

export function start() {
  let about = "";
  effect(() => {
    const now = `${version.value} ${precision.value} ${JSON.stringify(settings.value)}`;
    const isWanted = panel.value === "accuracy" && connection.value.online && problems.value.length === 0 && text.value !== "";
    const control = new AbortController();
    untracked(() => {
      if (now !== about) forget();
      about = now;
      if (!isWanted || predictions.peek().size === STOPS.length) return;
      load(control.signal).catch((error) => control.signal.aborted || (trouble.value = error.message));
    });
    return () => control.abort();
  });
  effect(() => {
    void other.value;
    untracked(receive);
  });
  effect(() => {
    void [receipts.value, against.value];
    untracked(() => hold().catch(() => {}));
  });
  let before = precision.peek();
  effect(() => {
    const next = precision.value;
    untracked(() => next !== before && chosen.peek() && choose(/** @type {Stop} */ (chosen.peek())));
    before = next;
  });
}
