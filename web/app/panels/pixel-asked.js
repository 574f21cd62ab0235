// Asks for the tree of the pixel that is chosen, one answer for each text, settings and pixel; and what of it is looked at.
import { batch, computed, effect, signal, untracked } from "../../vendor/preact.js";
import { Problem, Unreachable, ask, askJson, patiently, pause } from "../api.js";
import { pointer } from "../looking.js";
import { connection, deep, draft, hover, openPanel, origin, panel, panelsOpen, pixel, settings, size, text, version, view } from "../state.js";
import { levelOf } from "../tiles.js";
import { KINDS, addUp, grow, nameOf, rowsOf } from "./pixel-rays.js";

/** @typedef {import("./pixel-rays.js").Grown} Grown */
/** @typedef {ReturnType<typeof addUp>} Sum */
/** @typedef {{ zoom: number, x: number, y: number }} Spot a pixel of the picture at 2^zoom times its size */
/** @typedef {{ grown: Grown, sum: Sum, version: number, text: string, question: string, spot: Spot | null }} Answer `question`: what it answers */

/** The last tree. It stays while another one is on its way, or none comes. */
export const answer = signal(/** @type {Answer | null} */ (null));
/** What goes on: nothing, a request, or why there is no new answer. */
export const asking = signal(/** @type {{ state: "idle" | "loading" | "failed" | "invalid" | "offline" | "large" | "outside", detail: string }} */ ({ state: "idle", detail: "" }));
/** Where in the pixel one has looked closer, if one has; else the whole pixel is meant. */
export const spot = signal(/** @type {Spot | null} */ (null));
const again = signal(0);
const question = computed(() => JSON.stringify([version.value, settings.value, size.value, pixel.value, spot.value]));
/** Whether what is shown is about another text, other settings or another pixel than those of now. */
export const isStale = computed(() => answer.value !== null && (draft.value !== null || answer.value.question !== question.value));
/** The sample whose rays are listed. */
export const sample = signal(0);
/** Rays whose branches are folded. */
export const closed = signal(/** @type {ReadonlySet<number>} */ (new Set()));
/** The row of the outline that is chosen, and the one under the pointer: names of rows. */
export const chosen = signal("0");
export const pointed = signal("");
/** Whether the rays are drawn over the picture. */
export const isDrawn = signal(true);
/** The rows of the outline. */
export const rows = computed(() => {
  const of = answer.value;
  return of ? rowsOf(of.grown, of.grown.roots[sample.value] ?? 0, closed.value) : [];
});
/** Where each row is, by its name. */
export const places = computed(() => new Map(rows.value.map((row, at) => [nameOf(row), at])));

/** Milliseconds of quiet after an edit. A pixel is asked for at once. */
const QUIET = 150;
/** Bytes of an answer that is taken without a question: about 40,000 rays. */
const LARGE = 24 << 20;
let allowed = "";

/** Takes also an answer that is large. */
export function askAnyway() {
  allowed = question.peek();
  again.value += 1;
}

/** Asks again, after a failure. */
export const askAgain = () => void (again.value += 1);

/** The ray of a row's name. @param {string} name */
export const rayOf = (name) => answer.value?.grown.tree.rays[Number.parseInt(name, 10)] ?? null;

/** Chooses a sample, and its camera ray. @param {number} number */
export function chooseSample(number) {
  const roots = answer.peek()?.grown.roots ?? [0];
  const next = (number + roots.length) % roots.length;
  batch(() => {
    sample.value = next;
    chosen.value = String(roots[next]);
    pointed.value = "";
  });
}

/** Reads an answer, as long as it is no larger than what may be read. @param {Response} from @param {number} most */
async function read(from, most) {
  const parts = [];
  let bytes = 0;
  const reader = /** @type {ReadableStream<Uint8Array<ArrayBuffer>>} */ (from.body).getReader();
  for (let next = await reader.read(); !next.done; next = await reader.read()) {
    bytes += next.value.length;
    if (bytes > most) {
      await reader.cancel();
      return null;
    }
    parts.push(next.value);
  }
  try {
    return JSON.parse(await new Blob(parts).text());
  } catch {
    return undefined;
  }
}

/** Whether an answer has what this page reads: it may come from another version, or from a proxy. @param {any} of */
function isTree(of) {
  const isTriple = (/** @type {any} */ triple) => Array.isArray(triple) && triple.length === 3;
  const isRay = (/** @type {any} */ ray, /** @type {number} */ id) => ray?.id === id && (ray.parent === null || (ray.parent >= 0 && ray.parent < id)) && ray.kind in KINDS && [ray.weight, ray.contribution, ray.origin, ray.direction].every(isTriple) && Array.isArray(ray.media);
  return Array.isArray(of?.pixel) && [of.value, of.codes, of.raised, of.lacking].every(isTriple) && Array.isArray(of.rays) && of.rays.every(isRay);
}

/** The request of a pixel of the scene's own size. @param {AbortSignal} signal */
function whole(signal) {
  const { x, y } = /** @type {{ x: number, y: number }} */ (pixel.peek());
  const options = { body: text.peek(), type: origin.peek().type, query: { ...settings.peek(), x, y }, signal, accept: "application/json" };
  return () => ask("v1/tree", options);
}

/** Zoom beyond which single precision cannot tell rays apart, as tiles have it. */
const SINGLE = 8;

/** The request of a pixel of the picture that one looks into: the service has to know that picture. @param {Spot} at @param {AbortSignal} signal */
async function inside({ zoom, x, y }, signal) {
  const query = { ...settings.peek(), ...(zoom > SINGLE ? { precision: "double" } : {}), zoom };
  const { image_id: image } = await askJson("v1/scenes", { method: "POST", body: text.peek(), type: origin.peek().type, query, signal });
  return () => ask(`v1/images/${image}/tree`, { query: { x, y }, signal, accept: "application/json" });
}

/** The spot under the pointer, if one looks closer than at pixels and has pressed into the one that is chosen. @returns {Spot | null} */
function spotUnderPointer() {
  const [at, of] = [pixel.peek(), view.peek()];
  const zoom = levelOf(of.scale * devicePixelRatio);
  if (!at || !deep.peek() || zoom < 1 || of.scale <= 1 || hover.peek() === null) return null;
  const [x, y] = [(pointer.x - of.left) / of.scale, (pointer.y - of.top) / of.scale];
  if (Math.floor(x) !== at.x || Math.floor(y) !== at.y) return null;
  return { zoom, x: Math.floor(x * 2 ** zoom), y: Math.floor(y * 2 ** zoom) };
}

/** @param {AbortSignal} signal @param {boolean} isEdit */
async function load(signal, isEdit) {
  const of = { version: version.peek(), text: text.peek(), question: question.peek(), spot: spot.peek() };
  try {
    if (isEdit) await pause(QUIET, signal);
    // A quick answer needs no word about waiting.
    const slow = setTimeout(() => !signal.aborted && (asking.value = { state: "loading", detail: "" }), 120);
    signal.addEventListener("abort", () => clearTimeout(slow));
    const request = of.spot ? await inside(of.spot, signal) : whole(signal);
    const tree = await patiently(request, signal, (seconds) => (asking.value = { state: "loading", detail: `the service is busy; again in ${seconds} s` }))
      .then((from) => read(from, allowed === of.question ? Infinity : LARGE))
      .finally(() => clearTimeout(slow));
    if (signal.aborted) return;
    if (tree === null) return void (asking.value = { state: "large", detail: "" });
    if (!isTree(tree)) throw new Error("the answer is no tree of rays");
    show(tree, of);
  } catch (error) {
    if (signal.aborted) return;
    if (error instanceof Unreachable) asking.value = { state: "offline", detail: "" };
    else if (error instanceof Problem && error.status === 422) asking.value = { state: "invalid", detail: error.errors[0]?.detail ?? error.message };
    else asking.value = { state: "failed", detail: error instanceof Error ? error.message : String(error) };
  }
}

/** @param {import("./pixel-rays.js").Tree} tree @param {Omit<Answer, "grown" | "sum">} about */
function show(tree, about) {
  const grown = grow(tree);
  const before = answer.peek()?.grown.tree.pixel;
  const isSame = before !== undefined && before[0] === tree.pixel[0] && before[1] === tree.pixel[1];
  batch(() => {
    answer.value = { grown, sum: addUp(grown), ...about };
    asking.value = { state: "idle", detail: "" };
    // The same pixel after an edit: what was looked at stays, if it is still there.
    if (isSame && sample.peek() < grown.roots.length) {
      const ray = grown.tree.rays[Number.parseInt(chosen.peek(), 10)];
      if (!ray || grown.sample[ray.id] !== sample.peek()) chosen.value = String(grown.roots[sample.peek()]);
      return;
    }
    sample.value = 0;
    closed.value = new Set();
    chosen.value = String(grown.roots[0] ?? 0);
    pointed.value = "";
  });
}

/** Watches the pixel, the text and the settings. Nothing is asked while nobody looks. */
export function start() {
  let [lastText, lastAgain] = [-1, 0];
  effect(() => {
    void pixel.value;
    untracked(() => (spot.value = spotUnderPointer()));
  });
  // A service that is back is asked for what it could not answer.
  effect(() => {
    const { online } = connection.value;
    untracked(() => online && asking.peek().state === "offline" && askAgain());
  });
  let loading = new AbortController();
  effect(() => {
    const at = pixel.value;
    const isWatched = panel.value === "pixel" && panelsOpen.value;
    const number = version.value;
    const turn = again.value;
    void question.value;
    untracked(() => {
      loading.abort();
      if (!at) return batch(() => ((answer.value = null), (asking.value = { state: "idle", detail: "" })));
      if (!isWatched || text.peek() === "") return;
      if (answer.peek() && !isStale.peek() && turn === lastAgain) return void (asking.value = { state: "idle", detail: "" });
      lastAgain = turn;
      const isEdit = number !== lastText && answer.peek() !== null;
      lastText = number;
      const { width, height } = size.peek();
      if (at.x >= width || at.y >= height) return void (asking.value = { state: "outside", detail: `${width} x ${height}` });
      loading = new AbortController();
      load(loading.signal, isEdit);
    });
  });
}

/** Opens the panel with a pixel. @param {{ x: number, y: number }} at */
export function inspect(at) {
  batch(() => {
    pixel.value = at;
    openPanel("pixel");
  });
}
