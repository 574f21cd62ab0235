// The viewport: draws the picture, its tiles when one looks closer, and the layers over it. gestures.js moves it.
import { effect, html, untracked, useEffect, useRef } from "../vendor/preact.js";
import { fitted, placed } from "./framing.js";
import { gestures } from "./gestures.js";
import { isFitted, pointer } from "./looking.js";
import { deep, hover, layers, pixel, report, scene, shown, size, status, title, view } from "./state.js";
import { arrived, tiles } from "./tiles.js";

/** CSS pixels of a pixel from which on lines separate them. */
const GRID = 20;

/** @param {HTMLCanvasElement} canvas */
function draw(canvas) {
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  const ratio = devicePixelRatio;
  const at = view.peek();
  const of = size.peek();
  const picture = shown.peek();
  const [across, down] = [Math.round(at.width * ratio), Math.round(at.height * ratio)];
  if (canvas.width !== across || canvas.height !== down) Object.assign(canvas, { width: across, height: down });
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, at.width, at.height);
  if (picture) drawPicture(context, picture, at, of, ratio);
  if (picture && deep.peek()) {
    context.imageSmoothingEnabled = false;
    for (const { bitmap, x, y, side } of tiles(at, ratio, pointer)) {
      // Edges meet on device pixels, so that no seam shows.
      const [left, top] = [Math.round(x * ratio) / ratio, Math.round(y * ratio) / ratio];
      const [right, bottom] = [Math.round((x + bitmap.width * side) * ratio) / ratio, Math.round((y + bitmap.height * side) * ratio) / ratio];
      cropped(context, bitmap, left, top, right - left, bottom - top, at);
    }
  }
  for (const layer of layers.peek()) {
    context.save();
    context.globalAlpha = layer.opacity ?? 1;
    layer.draw(context, at);
    context.restore();
  }
  if (at.scale >= GRID && !deep.peek()) drawGrid(context, at, of);
  if (isRefused()) drawFrame(context, at, of);
  const cursor = pixel.peek();
  if (cursor) drawCursor(context, at, cursor);
}

/** @param {CanvasRenderingContext2D} context @param {import("./state.js").Shown} picture @param {import("./state.js").View} at @param {{ width: number, height: number }} of @param {number} ratio */
function drawPicture(context, picture, at, of, ratio) {
  // Where detail is on its way the picture stands in for it, and is smooth; else its pixels are squares.
  context.imageSmoothingEnabled = deep.peek() || picture.width < of.width || at.scale * ratio < 2;
  context.imageSmoothingQuality = at.scale < 1 ? "high" : "low";
  cropped(context, picture.bitmap, at.left, at.top, of.width * at.scale, of.height * at.scale, at);
}

/**
 * Draws a bitmap into a rectangle, and of it only what is in sight: canvases compute in single precision, and a picture that is
 * 60 million pixels wide would tremble.
 * @param {CanvasRenderingContext2D} context @param {ImageBitmap} bitmap @param {number} left @param {number} top @param {number} width @param {number} height @param {import("./state.js").View} at
 */
function cropped(context, bitmap, left, top, width, height, at) {
  const [sx, sy] = [bitmap.width / width, bitmap.height / height];
  const x0 = Math.max(0, Math.floor(-left * sx));
  const y0 = Math.max(0, Math.floor(-top * sy));
  const x1 = Math.min(bitmap.width, Math.ceil((at.width - left) * sx));
  const y1 = Math.min(bitmap.height, Math.ceil((at.height - top) * sy));
  if (x1 <= x0 || y1 <= y0) return;
  context.drawImage(bitmap, x0, y0, x1 - x0, y1 - y0, left + x0 / sx, top + y0 / sy, (x1 - x0) / sx, (y1 - y0) / sy);
}

/** @param {CanvasRenderingContext2D} context @param {import("./state.js").View} at @param {{ width: number, height: number }} of */
function drawGrid(context, at, of) {
  context.beginPath();
  const first = (/** @type {number} */ from) => Math.max(0, Math.floor(-from / at.scale));
  for (let x = first(at.left); x <= Math.min(of.width, (at.width - at.left) / at.scale); x += 1) {
    const place = Math.round(at.left + x * at.scale) + 0.5;
    context.moveTo(place, Math.max(0, at.top));
    context.lineTo(place, Math.min(at.height, at.top + of.height * at.scale));
  }
  for (let y = first(at.top); y <= Math.min(of.height, (at.height - at.top) / at.scale); y += 1) {
    const place = Math.round(at.top + y * at.scale) + 0.5;
    context.moveTo(Math.max(0, at.left), place);
    context.lineTo(Math.min(at.width, at.left + of.width * at.scale), place);
  }
  context.strokeStyle = "rgb(128 128 128 / 45%)";
  context.stroke();
}

/** Whether the picture is not that of the text. */
const isRefused = () => ["invalid", "failed", "offline"].includes(status.value.word);

/** @param {CanvasRenderingContext2D} context @param {import("./state.js").View} at @param {{ width: number, height: number }} of */
function drawFrame(context, at, of) {
  context.strokeStyle = getComputedStyle(document.documentElement).getPropertyValue("--error-mark");
  context.lineWidth = 2;
  context.setLineDash([6, 5]);
  context.strokeRect(at.left - 4, at.top - 4, of.width * at.scale + 8, of.height * at.scale + 8);
  context.setLineDash([]);
}

/** The cursor: a box around its pixel, black and white so that it shows on anything. @param {CanvasRenderingContext2D} context @param {import("./state.js").View} at @param {import("./state.js").Pixel} cursor */
function drawCursor(context, at, cursor) {
  const side = Math.max(at.scale, 7);
  const x = at.left + (cursor.x + 0.5) * at.scale - side / 2;
  const y = at.top + (cursor.y + 0.5) * at.scale - side / 2;
  for (const [color, out] of /** @type {[string, number][]} */ ([["#000", 1.5], ["#fff", 0.5]])) {
    context.strokeStyle = color;
    context.lineWidth = 1;
    context.strokeRect(x - out, y - out, side + 2 * out, side + 2 * out);
  }
}

/** What the picture shows, in a sentence for those who do not see it. */
export function sentence() {
  const { width, height } = size.value;
  const name = title.value || "a scene";
  const objects = scene.value?.objects?.length ?? 0;
  const plan = report.value?.plan ?? [];
  const effects = plan.length > 0 ? `; simulated are ${plan.slice(0, 8).map((of) => of.replaceAll("_", " ")).join(", ")}` : "";
  return `Picture of ${name}, ${width} by ${height} pixels, ${objects} objects${effects}`;
}

/** Tells of another density of pixels, on another screen. @param {() => void} tell */
function watchScreen(tell) {
  const control = new AbortController();
  const watch = () => matchMedia(`(resolution: ${devicePixelRatio}dppx)`).addEventListener("change", () => (tell(), watch()), { once: true, signal: control.signal });
  watch();
  return () => control.abort();
}

export function Viewport() {
  const canvas = useRef(/** @type {HTMLCanvasElement | null} */ (null));
  useEffect(() => {
    const element = /** @type {HTMLCanvasElement} */ (canvas.current);
    let frame = 0;
    const redraw = () => (frame ||= requestAnimationFrame(() => ((frame = 0), draw(element))));
    const resized = new ResizeObserver(() => {
      const { clientWidth: width, clientHeight: height } = element;
      if (width === 0 || height === 0) return;
      // On low screens the tools stand beside it.
      const foot = element.parentElement?.clientWidth === width ? undefined : 0;
      const room = { ...view.peek(), width, height, foot };
      view.value = isFitted.peek() ? fitted(room, size.peek()) : placed(room, size.peek());
      // At once: a canvas that has a new size is empty.
      draw(element);
    });
    resized.observe(element);
    const stops = [
      watchScreen(redraw),
      effect(() => {
        void [shown.value, view.value, layers.value, pixel.value, arrived.value, deep.value, isRefused()];
        redraw();
      }),
      effect(() => {
        const of = size.value;
        untracked(() => (view.value = isFitted.peek() ? fitted(view.peek(), of) : placed(view.peek(), of)));
      }),
      gestures(element),
    ];
    return () => {
      resized.disconnect();
      cancelAnimationFrame(frame);
      for (const stop of stops) stop();
    };
  }, []);
  return html`<canvas ref=${canvas} class="canvas" tabindex="0" role="application" aria-roledescription="picture"
    aria-label=${sentence()} aria-describedby="picture-keys" data-hover=${hover.value ? `${hover.value.x},${hover.value.y}` : undefined}></canvas>
    <p id="picture-keys" class="hidden-visually">Arrow keys move the pixel cursor, Enter inspects its pixel, plus and minus zoom, 0 fits, C switches to moving the camera.</p>`;
}
