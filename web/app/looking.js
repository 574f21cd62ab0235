// What one looks at: fitting, zooming, and the pixel cursor, for gestures, buttons and commands alike.
import { batch, effect, signal } from "../vendor/preact.js";
import { fitted, framed, pixelAt, placed, showing, zoomed } from "./framing.js";
import { pixel, size, view } from "./state.js";

/** Whether the picture stays fitted when the viewport changes its size. */
export const isFitted = signal(true);
/** Where the pointer is, in CSS pixels of the viewport: tiles near it come first. */
export const pointer = { x: 0, y: 0 };

export function fit() {
  batch(() => ((isFitted.value = true), (view.value = fitted(view.peek(), size.peek()))));
}

/** Puts a place of the picture, in shares of its size, into the middle; as soon as there is a viewport. @param {{ x: number, y: number, scale: number }} frame */
export function lookAt(frame) {
  const stop = effect(() => {
    const room = view.value;
    if (room.width <= 1) return;
    queueMicrotask(() => {
      stop();
      batch(() => ((isFitted.value = false), (view.value = framed(room, size.peek(), frame))));
    });
  });
}

/** One pixel of the scene to one of the screen, about the middle. */
export function actualSize() {
  const room = view.peek();
  const scale = 1 / devicePixelRatio;
  const of = size.peek();
  batch(() => {
    isFitted.value = false;
    view.value = placed({ ...room, scale, left: (room.width - of.width * scale) / 2, top: (room.height - of.height * scale) / 2 }, of);
  });
}

/** @param {number} factor @param {number} [x] @param {number} [y] */
export function zoomBy(factor, x = view.peek().width / 2, y = view.peek().height / 2) {
  batch(() => ((isFitted.value = false), (view.value = zoomed(view.peek(), size.peek(), factor, x, y))));
}

/** Moves the pixel cursor. @param {number} dx @param {number} dy */
export function moveCursor(dx, dy) {
  const { width, height } = size.peek();
  const from = pixel.peek() ?? pixelAt(view.peek(), size.peek(), view.peek().width / 2, view.peek().height / 2) ?? { x: width >> 1, y: height >> 1 };
  const to = { x: Math.max(0, Math.min(width - 1, from.x + dx)), y: Math.max(0, Math.min(height - 1, from.y + dy)) };
  batch(() => {
    pixel.value = to;
    const next = showing(view.peek(), size.peek(), to);
    if (next !== view.peek()) (isFitted.value = false), (view.value = next);
  });
}
