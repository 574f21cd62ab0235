// What a comparison draws over the picture. A is the viewport's own picture, unless something else is to be A.
import { computed, effect } from "../../vendor/preact.js";
import { hover, other, putLayer, reference, removeLayer, size, view } from "../state.js";
import { a, alike, codesOf, drawn, flipped, isOn, mode, wipe } from "./compare-pictures.js";

/** @typedef {import("../state.js").View} View */
/** CSS pixels of a pixel from which on its numbers fit into it. */
const LEGIBLE = 24;

/** Side by side each picture has half of the width, and all of it at half the scale. */
const half = (/** @type {View} */ { left, top, scale, width, height }, /** @type {0 | 1} */ side) => ({ left: left / 2 + (side * width) / 2, top: top / 2 + height / 4, scale: scale / 2, width, height });

/** The pixel under the pointer in A and in B: side by side it is another one than that of the viewport. */
export const probe = computed(() => {
  const at = hover.value;
  if (!at || !isOn.value || mode.value !== "side") return at;
  const { left, top, scale, width, height } = view.value;
  const [x, y] = [left + (at.x + 0.5) * scale, top + (at.y + 0.5) * scale];
  const inside = half(view.value, x < width / 2 ? 0 : 1);
  const pixel = { x: Math.floor((x - inside.left) / inside.scale), y: Math.floor((y - inside.top) / inside.scale) };
  const isInside = pixel.x >= 0 && pixel.y >= 0 && pixel.x < size.value.width && pixel.y < size.value.height && height > 0;
  return isInside ? pixel : null;
});

/** @param {CanvasRenderingContext2D} context @param {ImageBitmap | null | undefined} bitmap @param {View} at */
function image(context, bitmap, at) {
  if (!bitmap || bitmap.width === 0) return;
  const { width, height } = size.peek();
  context.imageSmoothingEnabled = at.scale * (width / bitmap.width) < 1;
  context.imageSmoothingQuality = "high";
  context.drawImage(bitmap, at.left, at.top, width * at.scale, height * at.scale);
}

/** Draws within a part of the viewport. @param {CanvasRenderingContext2D} context @param {[number, number, number, number]} part @param {() => void} run */
function within(context, part, run) {
  context.save();
  context.beginPath();
  context.rect(...part);
  context.clip();
  run();
  context.restore();
}

/** @param {CanvasRenderingContext2D} context @param {View} at */
function draw(context, at) {
  const one = drawn.peek().a ?? reference.peek()?.bitmap;
  const two = drawn.peek().b ?? other.peek()?.bitmap;
  const { width, height } = at;
  const edge = at.left + wipe.peek() * size.peek().width * at.scale;
  if (mode.peek() === "side") {
    context.clearRect(0, 0, width, height);
    within(context, [0, 0, width / 2, height], () => image(context, one ?? a.peek()?.bitmap, half(at, 0)));
    within(context, [width / 2, 0, width / 2, height], () => image(context, two, half(at, 1)));
    return mark(context, at);
  }
  if ((mode.peek() === "difference" || mode.peek() === "flip map") && !flipped.peek()) image(context, drawn.peek().difference, at);
  else if (flipped.peek()) image(context, two, at);
  else {
    image(context, one, at);
    if (mode.peek() === "wipe") within(context, [edge, 0, width, height], () => image(context, two, at));
  }
  if (at.scale >= LEGIBLE) numbers(context, at, edge);
}

/** The pixel under the pointer, in both. @param {CanvasRenderingContext2D} context @param {View} at */
function mark(context, at) {
  const pixel = probe.peek();
  if (!pixel) return;
  for (const side of /** @type {(0 | 1)[]} */ ([0, 1])) {
    const { left, top, scale } = half(at, side);
    const edge = Math.max(7, scale);
    const [x, y] = [left + (pixel.x + 0.5) * scale - edge / 2, top + (pixel.y + 0.5) * scale - edge / 2];
    for (const [color, line] of /** @type {[string, number][]} */ ([["#000", 3], ["#fff", 1]])) {
      context.strokeStyle = color;
      context.lineWidth = line;
      context.strokeRect(x, y, edge, edge);
    }
  }
}

/** The codes of each pixel, in it. @param {CanvasRenderingContext2D} context @param {View} at @param {number} edge */
function numbers(context, { left, top, scale, width, height }, edge) {
  const [one, two] = [a.peek(), other.peek()];
  if (!one || !two || !alike.peek() || one.width !== size.peek().width) return;
  const [first, second] = [codesOf(one), codesOf(two)];
  if (!first || !second) return;
  const line = Math.min(14, scale / 3.4);
  context.font = `${line}px ui-monospace, monospace`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  const until = [Math.min(one.width, Math.ceil((width - left) / scale)), Math.min(one.height, Math.ceil((height - top) / scale))];
  for (let y = Math.max(0, Math.floor(-top / scale)); y < until[1]; y += 1) {
    for (let x = Math.max(0, Math.floor(-left / scale)); x < until[0]; x += 1) {
      const i = 4 * (y * one.width + x);
      const isB = flipped.peek() || (mode.peek() === "wipe" && left + (x + 0.5) * scale > edge);
      const of = isB ? second : first;
      const isDifference = mode.peek() === "difference" && !flipped.peek();
      const bright = isDifference ? 0 : 0.3 * of[i] + 0.6 * of[i + 1] + 0.1 * of[i + 2];
      context.fillStyle = bright > 128 ? "#000" : "#fff";
      for (let c = 0; c < 3; c += 1) {
        const value = isDifference ? second[i + c] - first[i + c] : of[i + c];
        context.fillText(isDifference && value > 0 ? `+${value}` : String(value), left + (x + 0.5) * scale, top + (y + 0.5) * scale + (c - 1) * line * 1.05);
      }
    }
  }
}

/** Begins to draw whatever is compared. */
export function start() {
  effect(() => {
    void [wipe.value, flipped.value, drawn.value, mode.value === "side" && probe.value, other.value, reference.value];
    if (isOn.value) putLayer({ id: "compare", order: 8, draw });
    else removeLayer("compare");
  });
}
