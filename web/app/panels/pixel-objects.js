// Which object each part of the picture shows, by /v1/map?of=object. Asked for once for each arrangement of camera and objects, and
// only when somebody points at something.
import { effect, signal, untracked } from "../../vendor/preact.js";
import { askJson, pause } from "../api.js";
import { escaped, objectOf, valueAt } from "../pointers.js";
import { caret, hover, scene, settings, size, text } from "../state.js";

/**
 * @typedef {object} Objects
 * @property {string} key of the arrangement
 * @property {number} columns
 * @property {number} rows
 * @property {number} step pixels of the picture in a cell, across and down
 * @property {Int32Array} ids places in `pointers`, or -1
 * @property {string[]} pointers of the objects that are seen
 * @property {(string | null)[]} copies pointer of the definition that an object is a copy of
 */
export const objects = signal(/** @type {Objects | null} */ (null));

/** Cells at most: enough for an outline, and few enough to be drawn while one points. */
const CELLS = 150_000;
/** Longer texts are not sent just for a glow. */
export const LONGEST = 256 << 10;
/** Milliseconds of quiet after an edit. */
const QUIET = 400;

/** What decides which object is seen where. @param {any} of */
const keyOf = (of) => JSON.stringify([of.camera, of.objects, of.definitions, size.value]);

/** The coarsest step that keeps a map below so many cells, at most 64. @param {number} cells */
export function stepFor(cells) {
  const { width, height } = size.peek();
  return Math.min(64, Math.max(1, Math.ceil(Math.sqrt((width * height) / cells))));
}

/** Parameters of a map: of all settings only the size decides what is seen. */
export function mapQuery() {
  const { width, height } = settings.peek();
  return { ...(width ? { width } : {}), ...(height ? { height } : {}) };
}

/** @param {AbortSignal} signal @param {string} key */
async function load(signal, key) {
  await pause(QUIET, signal);
  const query = { ...mapQuery(), of: "object", step: stepFor(CELLS) };
  const { columns, rows, step, objects: seen, runs } = await askJson("v1/map", { body: text.peek(), type: "application/json", query, signal, priority: "low" });
  const ids = new Int32Array(columns * rows);
  let at = 0;
  for (const [number, count] of runs) ids.fill(number - 1, at, (at += count));
  const pointers = seen.map((/** @type {any} */ { pointer }) => pointer);
  const copies = pointers.map((/** @type {string} */ pointer) => {
    const name = valueAt(scene.peek(), pointer)?.instance?.of;
    return typeof name === "string" ? `/definitions/${escaped(name)}` : null;
  });
  objects.value = { key, columns, rows, step, ids, pointers, copies };
}

/** Whether something is an object, or is held by it, as by a group. @param {string} holder @param {string} pointer */
const isWithin = (holder, pointer) => pointer === holder || pointer.startsWith(`${holder}/`);

/**
 * The outline of an object as lines between the cells, in pixels: marching squares, with their stairs smoothed.
 * @param {Omit<Objects, "key">} of @param {string} pointer @returns {[number, number][][]}
 */
export function outlineOf({ columns, rows, step, ids, pointers, copies }, pointer) {
  // A part of a definition is seen in each copy, of which the map knows no parts.
  const isOwn = (/** @type {string} */ at, /** @type {string | null} */ copy) => isWithin(pointer, at) || isWithin(at, pointer) || (copy !== null && (isWithin(pointer, copy) || isWithin(copy, pointer)));
  const own = new Set(pointers.flatMap((at, id) => (isOwn(at, copies[id]) ? [id] : [])));
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
  return loops.map((loop) => smooth(loop).map(([x, y]) => /** @type {[number, number]} */ ([x * step, y * step])));
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
