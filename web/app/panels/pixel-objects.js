// Which object each part of the picture shows, as a coarse grid of the objects that camera rays hit. Asked for once for each
// arrangement of camera and objects, and only when somebody points at something.
import { effect, signal, untracked } from "../../vendor/preact.js";
import { askJson, pause } from "../api.js";
import { caret, hover, scene, size, text } from "../state.js";
import { objectOf } from "../pointers.js";
import { cameraOf } from "./pixel-projection.js";

/** @typedef {{ key: string, columns: number, rows: number, ids: Int32Array, hits: { object: string, body: string }[] }} Objects `ids` are places in `hits`, or -1 */

export const objects = signal(/** @type {Objects | null} */ (null));

/** Cells across, and the most there are. */
const [ACROSS, CELLS] = [96, 5000];
/** Longer texts are not sent just for a glow. */
const LONGEST = 256 << 10;
/** Milliseconds of quiet after an edit. */
const QUIET = 400;

/** What decides which object is seen where. @param {any} of */
const keyOf = (of) => JSON.stringify([of.camera, of.objects, of.definitions, size.value]);

/** @param {AbortSignal} signal @param {string} key */
async function load(signal, key) {
  await pause(QUIET, signal);
  const { width, height } = size.peek();
  const camera = cameraOf(scene.peek(), { width, height });
  if (!camera) return;
  const columns = Math.max(1, Math.min(ACROSS, width, Math.floor(Math.sqrt((CELLS * width) / height))));
  const rows = Math.max(1, Math.min(height, Math.floor(CELLS / columns), Math.round((columns * height) / width)));
  const cells = Array.from({ length: rows * columns }, (_, cell) => camera.ray([(((cell % columns) + 0.5) * width) / columns, ((Math.floor(cell / columns) + 0.5) * height) / rows]));
  const rays = cells.flatMap((ray, cell) => (ray ? [{ ray, cell }] : []));
  const digits = (/** @type {number[]} */ of) => `[${of.map((value) => Number(value.toPrecision(8))).join()}]`;
  const asked = rays.map(({ ray }) => `{"origin":${digits(ray.origin)},"direction":${digits(ray.direction)}}`).join();
  const { answers } = await askJson("v1/rays", { body: `{"scene":${text.peek()},"rays":[${asked}]}`, type: "application/json", signal, priority: "low" });
  const ids = new Int32Array(rows * columns).fill(-1);
  /** @type {Map<string, number>} */
  const places = new Map();
  /** @type {Objects["hits"]} */
  const hits = [];
  rays.forEach(({ cell }, at) => {
    const { hit, object, body } = answers[at];
    if (!hit) return;
    // A body of a definition stands in the picture once for each copy.
    const name = `${object} ${body ?? object}`;
    if (!places.has(name)) places.set(name, hits.push({ object, body: body ?? object }) - 1);
    ids[cell] = /** @type {number} */ (places.get(name));
  });
  objects.value = { key, columns, rows, ids, hits };
}

/** Whether something is an object, or is held by it, as by a group or a definition. @param {string} holder @param {string} pointer */
const isWithin = (holder, pointer) => pointer === holder || pointer.startsWith(`${holder}/`);

/**
 * The outline of an object as lines between the cells, in pixels: marching squares, with their stairs smoothed.
 * @param {Objects} of @param {string} pointer @param {{ width: number, height: number }} size @returns {[number, number][][]}
 */
export function outlineOf({ columns, rows, ids, hits }, pointer, { width, height }) {
  const own = new Set(hits.flatMap(({ object, body }, id) => (isWithin(pointer, object) || isWithin(pointer, body) ? [id] : [])));
  if (own.size === 0) return [];
  const isIn = (/** @type {number} */ x, /** @type {number} */ y) => x >= 0 && y >= 0 && x < columns && y < rows && own.has(ids[y * columns + x]);
  /** Where each edge between two cells leads, by the corner it begins at. @type {Map<string, [number, number][]>} */
  const edges = new Map();
  const add = (/** @type {number} */ x, /** @type {number} */ y, /** @type {[number, number]} */ to) => {
    const key = `${x},${y}`;
    edges.set(key, [...(edges.get(key) ?? []), to]);
  };
  // Around each cell clockwise, where its neighbour is not of the object.
  for (let y = 0; y < rows; y += 1) {
    for (let x = 0; x < columns; x += 1) {
      if (!isIn(x, y)) continue;
      if (!isIn(x, y - 1)) add(x, y, [x + 1, y]);
      if (!isIn(x + 1, y)) add(x + 1, y, [x + 1, y + 1]);
      if (!isIn(x, y + 1)) add(x + 1, y + 1, [x, y + 1]);
      if (!isIn(x - 1, y)) add(x, y + 1, [x, y]);
    }
  }
  /** @type {[number, number][][]} */
  const loops = [];
  for (const [begin] of edges) {
    for (let to = edges.get(begin)?.pop(); to; to = edges.get(begin)?.pop()) {
      const loop = [to];
      for (let next = edges.get(to.join())?.pop(); next; next = edges.get(/** @type {[number, number]} */ (loop.at(-1)).join())?.pop()) loop.push(next);
      loops.push(loop);
    }
  }
  const [sx, sy] = [width / columns, height / rows];
  return loops.map((loop) => smooth(loop).map(([x, y]) => /** @type {[number, number]} */ ([x * sx, y * sy])));
}

/** Smooths the stairs of a loop: each step takes the middles of its edges. @param {[number, number][]} loop */
function smooth(loop) {
  let line = loop;
  for (let step = 0; step < 5; step += 1) {
    line = line.map(([x, y], at) => {
      const [nx, ny] = line[(at + 1) % line.length];
      return [(x + nx) / 2, (y + ny) / 2];
    });
  }
  return line;
}

/** Asks for the grid when the pointer is over the picture or the caret in an object. */
export function start() {
  let loading = new AbortController();
  let asked = "";
  effect(() => {
    const of = scene.value;
    const isWanted = hover.value !== null || objectOf(caret.value) !== null;
    const isShort = text.value.length <= LONGEST;
    const key = of && isWanted && isShort ? keyOf(of) : "";
    untracked(() => {
      if (objects.peek() && objects.peek()?.key !== key && key !== "") objects.value = null;
      if (key === "" || key === asked) return;
      loading.abort();
      loading = new AbortController();
      asked = key;
      const { signal } = loading;
      // A glow that does not come is nothing that anybody has to be told.
      load(signal, key).catch(() => asked === key && (asked = ""));
    });
  });
}
