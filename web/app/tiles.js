// Deep zoom: tiles of /xyz for what is in sight, nearest to the pointer first, three at a time. What is out of sight is aborted,
// which stops the work in the service, too. Each place comes twice, with one ray a pixel and then as the scene says, in smaller
// tiles if it has many samples; coarser ones stand in for those that are not there yet.
import { signal } from "../vendor/preact.js";
import { Problem, Unreachable, askBlob, askJson, pause } from "./api.js";
import { bitmaps, connection, origin, settings, size, text } from "./state.js";

/** @typedef {import("./state.js").View} View */
/** @typedef {{ level: number, column: number, row: number, name: string }} Place */
/** @typedef {"quick" | "full"} Tier */
/** @typedef {Place & { tier: Tier, key: string, edge: number }} Wanted `key`: name with tier; `edge`: of its tier then */
/** @typedef {{ image: string, offset: number, template: string }} Source `offset`: level of /xyz at the scene's own size */

/** Edge of a tile, unless its description says another. */
const TILE = 512;
const IN_FLIGHT = 3;
/** Pixels of tiles that are kept. */
const KEPT = 120 * TILE * TILE;
/** Levels beyond the scene's size that single precision tells apart; below that rays are traced in double. */
const SINGLE = 8;
const DEEPEST = 16;

/** Rises whenever a tile has come. */
export const arrived = signal(0);
/** @param {string} name */
export const has = (name) => loaded.has(`full/${name}`);
/** What has happened, for tests. */
export const counts = { flying: 0, most: 0, aborted: 0, retried: 0, loaded: 0 };

let about = "";
const sources = /** @type {Map<string, Promise<Source | null>>} */ (new Map());
const loaded = /** @type {Map<string, ImageBitmap>} */ (new Map());
const flying = /** @type {Map<string, AbortController>} */ (new Map());
/** Tiles that the service refuses, so that they are not asked for again. */
const refused = /** @type {Set<string>} */ (new Set());
let wanted = /** @type {Wanted[]} */ ([]);
/** Edges of tiles, a power of two each: with more samples than one answer may have they are smaller. */
let edges = { quick: TILE, full: TILE };
const PLAIN = { accuracy: "fixed", antialias: "false", samples: "1" };

/** The level that a view needs: 0 is the scene's own size. @param {number} scale device pixels for a pixel of the scene */
export const levelOf = (scale) => Math.min(DEEPEST, Math.ceil(Math.log2(scale) - 0.01));

/** The last tile of a level, across or down. @param {number} length @param {number} level @param {number} edge */
const lastOf = (length, level, edge) => Math.ceil((length * 2 ** level) / edge) - 1;

/** Tiles of a level that a view shows, the nearest to a point first. @param {View} view @param {{ width: number, height: number }} of @param {number} level @param {{ x: number, y: number }} near @param {number} [edge] */
export function inSight(view, of, level, near, edge = edges.full) {
  const side = (edge / 2 ** level) * view.scale;
  const range = (/** @type {number} */ from, /** @type {number} */ room, /** @type {number} */ end) => [Math.max(0, Math.floor(-from / side)), Math.min(end, Math.floor((room - from) / side))];
  const [left, right] = range(view.left, view.width, lastOf(of.width, level, edge));
  const [top, bottom] = range(view.top, view.height, lastOf(of.height, level, edge));
  const places = [];
  for (let row = top; row <= bottom; row += 1) {
    for (let column = left; column <= right; column += 1) {
      const distance = Math.hypot(view.left + (column + 0.5) * side - near.x, view.top + (row + 0.5) * side - near.y);
      places.push({ level, column, row, name: `${level}/${column}/${row}`, distance });
    }
  }
  return places.sort((a, b) => a.distance - b.distance);
}

/** The names of the smaller tiles that lie where a larger one does. @param {Place} place @param {number} large @param {number} small @param {{ width: number, height: number }} of */
export function within({ level, column, row }, large, small, of) {
  const times = large / small;
  const range = (/** @type {number} */ at, /** @type {number} */ length) => {
    const [first, last] = [at * times, Math.min((at + 1) * times - 1, lastOf(length, level, small))];
    return Array.from({ length: Math.max(0, last - first + 1) }, (_, i) => first + i);
  };
  return range(row, of.height).flatMap((y) => range(column, of.width).map((x) => `${level}/${x}/${y}`));
}

/** Forgets everything if the scene is another one. */
function settle() {
  const now = `${JSON.stringify(settings.peek())}\n${text.peek()}`;
  if (now === about) return;
  about = now;
  for (const [, controller] of flying) controller.abort();
  for (const key of [...loaded.keys()]) letGo(key);
  sources.clear();
  refused.clear();
  edges = { quick: TILE, full: TILE };
}

/** The image whose tiles a level is of. @param {number} level @param {Tier} tier @returns {Promise<Source | null>} */
function source(level, tier) {
  const isFar = level > SINGLE;
  const name = `${tier} ${isFar}`;
  let known = sources.get(name);
  if (!known) {
    const query = { ...settings.peek(), ...(tier === "quick" ? PLAIN : {}), ...(isFar ? { precision: "double" } : {}) };
    const made = open(query, isFar ? DEEPEST : SINGLE, tier);
    known = made;
    sources.set(name, made);
    made.catch(() => sources.get(name) === made && sources.delete(name));
  }
  return known;
}

/** @param {Record<string, string>} query @param {number} zoom @param {Tier} tier @returns {Promise<Source | null>} */
async function open(query, zoom, tier) {
  const of = about;
  try {
    const known = await askJson("v1/scenes", { method: "POST", body: text.peek(), type: origin.peek().type, query: { ...query, zoom } });
    const tiles = await askJson(known.links.xyz);
    if (of === about) edges = { ...edges, [tier]: tiles.tileSize };
    return { image: known.image_id, offset: tiles.nativezoom - zoom, template: known.links.xyz.replace(".json", "/{z}/{x}/{y}.png") };
  } catch (error) {
    if (error instanceof Problem && query.precision !== "double" && error.status === 400) return open({ ...query, precision: "double" }, zoom, tier);
    if (error instanceof Unreachable || (error instanceof Problem && error.retryAfter > 0)) throw error;
    return null;
  }
}

/**
 * Asks for the tiles of a view, and gives those to draw, the coarsest first.
 * @param {View} view @param {number} ratio device pixels for a CSS pixel @param {{ x: number, y: number }} near
 * @returns {{ bitmap: ImageBitmap, x: number, y: number, side: number }[]}
 */
export function tiles(view, ratio, near) {
  settle();
  const level = levelOf(view.scale * ratio);
  const of = size.peek();
  // At the size of the scene and below the picture itself is enough, also on screens with finer pixels.
  if (level <= 0 || view.scale <= 1) {
    wanted = [];
    pump();
    return [];
  }
  const places = { quick: inSight(view, of, level, near, edges.quick), full: inSight(view, of, level, near, edges.full) };
  const missing = (/** @type {Tier} */ tier) => places[tier].map((place) => ({ ...place, tier, key: `${tier}/${place.name}`, edge: edges[tier] })).filter(({ key }) => !loaded.has(key) && !refused.has(key));
  const isBare = (/** @type {Place} */ place) => !within(place, edges.quick, edges.full, of).every(has);
  wanted = [...missing("quick").filter(isBare), ...missing("full")];
  for (const [key, controller] of flying) if (!wanted.some((of) => of.key === key)) cancel(key, controller);
  pump();
  const drawn = /** @type {Map<string, { level: number, x: number, y: number, side: number, bitmap: ImageBitmap }>} */ (new Map());
  const draw = (/** @type {Tier} */ tier, /** @type {Place} */ { level: at, column, row }) => {
    for (let up = 0; up <= at; up += 1) {
      const [coarse, left, top] = [at - up, column >> up, row >> up];
      const key = `${tier}/${coarse}/${left}/${top}`;
      const bitmap = loaded.get(key);
      if (!bitmap) continue;
      // The last used is the last to be dropped.
      loaded.delete(key);
      loaded.set(key, bitmap);
      const side = (edges[tier] / 2 ** coarse) * view.scale;
      drawn.set(key, { level: coarse, bitmap, x: view.left + left * side, y: view.top + top * side, side: side / edges[tier] });
      return;
    }
  };
  for (const place of places.quick) if (isBare(place)) draw("quick", place);
  for (const place of places.full) draw("full", place);
  // Of one level, what is as the scene says lies over what is quick.
  return [...drawn.values()].sort((a, b) => a.level - b.level);
}

/** @param {string} key @param {AbortController} controller */
function cancel(key, controller) {
  counts.aborted += 1;
  flying.delete(key);
  controller.abort();
}

function pump() {
  if (!connection.value.online) return;
  // What one sees first does not wait for what refines it.
  if (wanted.some(({ tier, key }) => tier === "quick" && !flying.has(key))) {
    for (const [key, controller] of flying) if (key.startsWith("full/") && flying.size >= IN_FLIGHT) cancel(key, controller);
  }
  for (const of of wanted) {
    if (flying.size >= IN_FLIGHT) return;
    if (!flying.has(of.key)) load(of);
  }
}

/** @param {Wanted} of */
async function load({ level, column, row, tier, key, name, edge }) {
  const controller = new AbortController();
  const { signal: aborted } = controller;
  flying.set(key, controller);
  counts.flying = flying.size;
  counts.most = Math.max(counts.most, flying.size);
  try {
    const from = await source(level, tier);
    if (!from) throw new Error("no tiles");
    // Its place was that of a tile of another size: there are others now.
    if (edge !== edges[tier]) return;
    const path = from.template.replace("{z}", String(level + from.offset)).replace("{x}", String(column)).replace("{y}", String(row));
    aborted.throwIfAborted();
    const bitmap = await createImageBitmap(await askBlob(path, { signal: aborted, accept: "image/png" }));
    bitmaps.made += 1;
    if (aborted.aborted) return void (bitmap.close(), (bitmaps.closed += 1));
    loaded.set(key, bitmap);
    if (tier === "full" && edge === edges.quick) letGo(`quick/${name}`);
    counts.loaded += 1;
    drop();
  } catch (error) {
    if (aborted.aborted) return;
    if (error instanceof Problem && error.retryAfter > 0) {
      counts.retried += 1;
      await pause(error.retryAfter * 1000, aborted).catch(() => {});
    } else if (!(error instanceof Unreachable)) refused.add(key);
  } finally {
    if (flying.get(key) === controller) flying.delete(key);
    counts.flying = flying.size;
    arrived.value += 1;
  }
}

/** Drops the tiles that were not used for the longest time. */
function drop() {
  let pixels = 0;
  for (const { width, height } of loaded.values()) pixels += width * height;
  for (const [key, { width, height }] of loaded) {
    if (pixels <= KEPT) return;
    pixels -= width * height;
    letGo(key);
  }
}

/** @param {string} key */
function letGo(key) {
  const bitmap = loaded.get(key);
  if (!bitmap) return;
  loaded.delete(key);
  bitmap.close();
  bitmaps.closed += 1;
}
