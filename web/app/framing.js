// How the picture lies in the viewport: fitting, zooming about a point, panning. No effects.

/** @typedef {import("./state.js").View} View */
/** @typedef {import("./state.js").Settings} Settings */
/** @typedef {{ width: number, height: number }} Size */

/** A pixel of the scene may become this wide on the screen. */
export const LARGEST = 65_536;
/** CSS pixels around a fitted picture. */
const MARGIN = 16;
/** CSS pixels below a fitted picture, for the tools. */
const FOOT = 64;
/** CSS pixels of the picture that stay in sight. */
const HELD = 48;

/** Pixels of a scene that names none, and of `size=og`. */
const USUAL = { width: 960, height: 540 };
const PREVIEW = { width: 1200, height: 630 };

/** The size of the picture that settings make of a scene: `size` stands for width and height, `dpr` multiplies them. @param {Settings} settings @param {Partial<Size>} image @returns {Size} */
export function sizeOf({ width, height, size, dpr = "1" }, image) {
  const own = { ...USUAL, ...image, ...(size === "og" ? PREVIEW : {}) };
  return { width: Math.round(Number(width ?? own.width) * Number(dpr)), height: Math.round(Number(height ?? own.height) * Number(dpr)) };
}

/** Settings for a picture of another size: the service takes one size only. @param {Settings} settings @param {{ width: number | string, height: number | string }} size @returns {Settings} */
export const sized = ({ size: _, dpr: __, ...rest }, { width, height }) => ({ ...rest, width: String(width), height: String(height) });

/** The whole picture in the middle. @param {Size & { foot?: number }} room @param {Size} size @returns {View} */
export function fitted(room, size) {
  const margin = Math.min(MARGIN, room.width / 20);
  const high = Math.max(room.height - (room.foot ?? FOOT) - margin, room.height / 2);
  const scale = Math.max(1e-3, Math.min((room.width - 2 * margin) / size.width, high / size.height));
  const top = Math.min((room.height - size.height * scale) / 2, margin + (high - size.height * scale));
  return placed({ ...room, scale, left: (room.width - size.width * scale) / 2, top }, size);
}

/** The smallest scale that one can zoom to. @param {Size} room @param {Size} size */
const smallest = (room, size) => fitted(room, size).scale / 4;

/** A place of the picture in the middle, in shares of its size, as near as one can zoom. @param {View} room @param {Size} size @param {{ x: number, y: number, scale: number }} frame @returns {View} */
export function framed(room, size, { x, y, scale: wanted }) {
  const scale = Math.min(LARGEST, Math.max(smallest(room, size), wanted));
  return placed({ ...room, scale, left: room.width / 2 - x * size.width * scale, top: room.height / 2 - y * size.height * scale }, size);
}

/** Zooms about a point that stays where it is. @param {View} view @param {Size} size @param {number} factor @param {number} x @param {number} y @returns {View} */
export function zoomed(view, size, factor, x, y) {
  const scale = Math.min(LARGEST, Math.max(smallest(view, size), view.scale * factor));
  const by = scale / view.scale;
  return placed({ ...view, scale, left: x - (x - view.left) * by, top: y - (y - view.top) * by }, size);
}

/** @param {View} view @param {Size} size @param {number} dx @param {number} dy @returns {View} */
export const panned = (view, size, dx, dy) => placed({ ...view, left: view.left + dx, top: view.top + dy }, size);

/** Keeps some of the picture in sight. @param {View} view @param {Size} size @returns {View} */
export function placed(view, size) {
  const hold = (/** @type {number} */ at, /** @type {number} */ length, /** @type {number} */ room) => Math.min(room - HELD, Math.max(HELD - length, at));
  return { ...view, left: hold(view.left, size.width * view.scale, view.width), top: hold(view.top, size.height * view.scale, view.height) };
}

/** The pixel of the scene at a point of the viewport, or null outside. @param {View} view @param {Size} size @param {number} x @param {number} y */
export function pixelAt(view, size, x, y) {
  const at = { x: Math.floor((x - view.left) / view.scale), y: Math.floor((y - view.top) / view.scale) };
  return at.x >= 0 && at.y >= 0 && at.x < size.width && at.y < size.height ? at : null;
}

/** The view that shows a pixel, moved no more than it takes. @param {View} view @param {Size} size @param {{ x: number, y: number }} pixel @returns {View} */
export function showing(view, size, pixel) {
  const shift = (/** @type {number} */ from, /** @type {number} */ room) => {
    const margin = Math.min(24, room / 4);
    return from < margin ? margin - from : from + view.scale > room - margin ? Math.min(0, room - margin - view.scale - from) : 0;
  };
  const dx = shift(view.left + pixel.x * view.scale, view.width);
  const dy = shift(view.top + pixel.y * view.scale, view.height);
  return dx === 0 && dy === 0 ? view : { ...view, left: view.left + dx, top: view.top + dy };
}

/** Zoom for people: 50 %, 100 %, × 4,096. @param {number} scale device pixels for one of the scene */
export function zoomWords(scale) {
  if (scale < 9.995) return `${Math.round(scale * 100)} %`;
  return `× ${Math.round(scale).toLocaleString("en")}`;
}
