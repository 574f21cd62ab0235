// Deep zoom: tiles of /xyz for what is in sight, nearest to the pointer first, three at a time. What is out of sight is aborted,
// which stops the work in the service, too. Each tile comes twice, with one ray a pixel and then as the scene says; coarser ones
// stand in for those that are not there yet.
import { signal } from "../vendor/preact.js";
import { Problem, Unreachable, ask, askJson, pause } from "./api.js";
import { bitmaps, connection, origin, settings, size, text } from "./state.js";

/** @typedef {import("./state.js").View} View */
/** @typedef {{ level: number, column: number, row: number, name: string }} Place */
/** @typedef {"quick" | "full"} Tier */
/** @typedef {Place & { tier: Tier, key: string }} Wanted `key`: name with tier */
/** @typedef {{ image: string, offset: number, template: string }} Source `offset`: level of /xyz at the scene's own size */

const TILE = 512;
const IN_FLIGHT = 3;
const KEPT = 120;
/** Levels beyond the scene's size that single precision tells apart; below that rays are traced in double. */
const SINGLE = 8;
const DEEPEST = 16;

/** Rises whenever a tile has come. */
export const arrived = signal(0);
/** Whether a tile is here. @param {string} name */
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
const PLAIN = { accuracy: "fixed", antialias: "false", samples: "1" };

/** The level that a view needs: 0 is the scene's own size. @param {number} scale device pixels for a pixel of the scene */
export const levelOf = (scale) => Math.min(DEEPEST, Math.ceil(Math.log2(scale) - 0.01));

/** Tiles of a level that a view shows, the nearest to a point first. @param {View} view @param {{ width: number, height: number }} of @param {number} level @param {{ x: number, y: number }} near */
export function inSight(view, of, level, near) {
  const side = (TILE / 2 ** level) * view.scale;
  const last = (/** @type {number} */ length) => Math.ceil((length * 2 ** level) / TILE) - 1;
  const range = (/** @type {number} */ from, /** @type {number} */ room, /** @type {number} */ end) => [Math.max(0, Math.floor(-from / side)), Math.min(end, Math.floor((room - from) / side))];
  const [left, right] = range(view.left, view.width, last(of.width));
  const [top, bottom] = range(view.top, view.height, last(of.height));
  const places = [];
  for (let row = top; row <= bottom; row += 1) {
    for (let column = left; column <= right; column += 1) {
      const distance = Math.hypot(view.left + (column + 0.5) * side - near.x, view.top + (row + 0.5) * side - near.y);
      places.push({ level, column, row, name: `${level}/${column}/${row}`, distance });
    }
  }
  return places.sort((a, b) => a.distance - b.distance);
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
}

/** The image whose tiles a level is of. @param {number} level @param {Tier} tier @returns {Promise<Source | null>} */
function source(level, tier) {
  const isFar = level > SINGLE;
  const name = `${tier} ${isFar}`;
  let known = sources.get(name);
  if (!known) {
    const query = { ...settings.peek(), ...(tier === "quick" ? PLAIN : {}), ...(isFar ? { precision: "double" } : {}) };
    known = open(query, isFar ? DEEPEST : SINGLE);
    sources.set(name, known);
    known.catch(() => sources.delete(name));
  }
  return known;
}

/** @param {Record<string, string>} query @param {number} zoom @returns {Promise<Source | null>} */
async function open(query, zoom) {
  try {
    const known = await askJson("v1/scenes", { method: "POST", body: text.peek(), type: origin.peek().type, query: { ...query, zoom } });
    const tiles = await askJson(known.links.xyz);
    // With many samples tiles are smaller ones, and other places have their names: the quick ones stay.
    if (tiles.tileSize !== TILE) return null;
    return { image: known.image_id, offset: tiles.nativezoom - zoom, template: tiles.tiles[0] };
  } catch (error) {
    if (error instanceof Problem && query.precision !== "double" && error.status === 400) return open({ ...query, precision: "double" }, zoom);
    if (error instanceof Unreachable) throw error;
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
  const places = inSight(view, of, level, near);
  const missing = (/** @type {Tier} */ tier) => places.map((place) => ({ ...place, tier, key: `${tier}/${place.name}` })).filter(({ key, name }) => !loaded.has(key) && !refused.has(key) && !has(name));
  wanted = [...missing("quick"), ...missing("full")];
  for (const [key, controller] of flying) if (!wanted.some((of) => of.key === key)) cancel(key, controller);
  pump();
  const drawn = /** @type {Map<string, { level: number, x: number, y: number, side: number, bitmap: ImageBitmap }>} */ (new Map());
  for (const { level: at, column, row } of places) {
    for (let up = 0; up <= at; up += 1) {
      const [coarse, left, top] = [at - up, column >> up, row >> up];
      const name = `${coarse}/${left}/${top}`;
      const key = has(name) ? `full/${name}` : `quick/${name}`;
      const bitmap = loaded.get(key);
      if (!bitmap) continue;
      // The last used is the last to be dropped.
      loaded.delete(key);
      loaded.set(key, bitmap);
      const side = (TILE / 2 ** coarse) * view.scale;
      drawn.set(name, { level: coarse, bitmap, x: view.left + left * side, y: view.top + top * side, side: side / TILE });
      break;
    }
  }
  return [...drawn.values()].sort((a, b) => a.level - b.level);
}

/** @param {string} key @param {AbortController} controller */
function cancel(key, controller) {
  counts.aborted += 1;
  flying.delete(key);
  controller.abort();
}

/** Starts what there is room for. */
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
async function load({ level, column, row, tier, key, name }) {
  const controller = new AbortController();
  const { signal: aborted } = controller;
  flying.set(key, controller);
  counts.flying = flying.size;
  counts.most = Math.max(counts.most, flying.size);
  try {
    const from = await source(level, tier);
    if (!from) throw new Error("no tiles");
    const path = from.template.replace("{z}", String(level + from.offset)).replace("{x}", String(column)).replace("{y}", String(row));
    aborted.throwIfAborted();
    const answer = await ask(path, { signal: aborted, accept: "image/png" });
    const bitmap = await createImageBitmap(await answer.blob());
    bitmaps.made += 1;
    if (aborted.aborted) return void (bitmap.close(), (bitmaps.closed += 1));
    loaded.set(key, bitmap);
    if (tier === "full") letGo(`quick/${name}`);
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
  for (const key of loaded.keys()) {
    if (loaded.size <= KEPT) return;
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
