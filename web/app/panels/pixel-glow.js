// How much of each pixel comes from the object that the caret is in, directly, in mirrors and through glass: /v1/map?of=share.
import { computed, effect, signal, untracked } from "../../vendor/preact.js";
import { ask, pause } from "../api.js";
import { readPfm } from "./pfm.js";
import { caret, draft, problems, scene, size, text, version } from "../state.js";
import { LONGEST, mapQuery, stepFor } from "./pixel-objects.js";

/** @typedef {{ pointer: string, step: number, canvas: HTMLCanvasElement }} Glow a pixel of `canvas` stands for a block of the picture */

export const glow = signal(/** @type {Glow | null} */ (null));

/** Blocks at most, and milliseconds of rest before they are asked for: each takes a whole tree of rays. */
const [BLOCKS, REST] = [24_000, 600];
/** One sample of each, as deep as pictures are by default. */
const PLAIN = { accuracy: "fixed", antialias: "false", samples: "1" };
/** The glow's color, sky blue of Okabe and Ito, and its alpha where all comes from the object. Small shares show by their root. */
const [RED, GREEN, BLUE, MOST] = [86, 180, 233, 130];

/** The object of the scene itself that a pointer is in, or null: parts of definitions have none. @param {string} pointer */
export const topOf = (pointer) => /^\/objects\/\d+/.exec(pointer)?.[0] ?? null;

/** @param {string} pointer @param {AbortSignal} signal */
async function load(pointer, signal) {
  await pause(REST, signal);
  const step = stepFor(BLOCKS);
  const { width: w, height: h } = size.peek();
  const query = { ...PLAIN, ...mapQuery(), of: "share", pointer, format: "pfm", step, x: 0, y: 0, w, h };
  const answer = await ask("v1/map", { method: "POST", body: text.peek(), type: "application/json", query, signal, priority: "low" });
  const { width, height, values } = readPfm(await answer.arrayBuffer());
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [width, height];
  const data = new ImageData(width, height);
  values.forEach((share, at) => data.data.set([RED, GREEN, BLUE, Math.round(MOST * Math.sqrt(Math.min(1, share)))], 4 * at));
  canvas.getContext("2d")?.putImageData(data, 0, 0);
  if (!signal.aborted) glow.value = { pointer, step, canvas };
}

/** What there should be a glow of: the object of the caret, and the number of a sound text. */
const wanted = computed(() => {
  const pointer = topOf(caret.value);
  const isSound = scene.value !== null && problems.value.length === 0 && draft.value === null && text.value.length <= LONGEST;
  return pointer !== null && isSound ? `${pointer} ${version.value}` : "";
});

/** Asks for the object of the caret, once caret and text rest. */
export function start() {
  let loading = new AbortController();
  effect(() => {
    const [pointer] = wanted.value.split(" ");
    untracked(() => {
      loading.abort();
      glow.value = null;
      if (pointer === "") return;
      loading = new AbortController();
      // A glow that does not come is nothing that anybody has to be told.
      load(pointer, loading.signal).catch(() => {});
    });
  });
}
