// Pointer, wheel and keys on the picture: pan and zoom, the pixel cursor, or the camera.
import { batch } from "../vendor/preact.js";
import { LARGE, remember } from "./base.js";
import { cameraOf, dollied, orbited, trucked, written } from "./camera.js";
import { panned, pixelAt } from "./framing.js";
import { fit, isFitted, moveCursor, pointer, zoomBy } from "./looking.js";
import { editOf } from "./pointers.js";
import { draft, hover, moved, openPanel, origin, pixel, rendered, scene, setText, size, syntax, text, tool, view } from "./state.js";

/** @typedef {import("./camera.js").Camera} Camera */

/** CSS pixels that a press may move and still be a click. */
const STILL = 4;
/** Milliseconds of rest after which moves by wheel or keys become one edit. */
const REST = 350;

/** The camera as it is dragged, or that of the scene. */
let moving = /** @type {Camera | null} */ (null);
let resting = 0;

/** Moves the camera in a draft of the text, or of a large one in a patch. @param {(camera: Camera) => Camera} change */
export function moveCamera(change) {
  const from = moving ?? cameraOf(scene.peek());
  if (!from) return;
  moving = change(from);
  clearTimeout(resting);
  if (text.peek().length >= LARGE && origin.peek().type === "application/json") moved.value = { camera: { [moving.kind]: written(moving) } };
  else draft.value = textWith(moving);
}

/** The text with a camera. @param {Camera} camera */
function textWith(camera) {
  const { eye, look_at } = written(camera);
  // From the end to the beginning, so that the places stay.
  const changes = Object.entries({ eye, look_at }).flatMap(([key, value]) => editOf(text.peek(), syntax.peek(), `/camera/${camera.kind}/${key}`, value) ?? []);
  return changes.sort((a, b) => b.from - a.from).reduce((next, of) => next.slice(0, of.from) + of.insert + next.slice(of.to), text.peek());
}

/** Makes the draft an edit: one step of undo. */
export function letGo() {
  clearTimeout(resting);
  const camera = moving;
  moving = null;
  if (!camera || (draft.peek() === null && moved.peek() === null)) return;
  const next = textWith(camera);
  if (moved.peek()) remember(text.peek(), moved.peek() ?? { camera: {} }, next);
  batch(() => (setText(next), (draft.value = null), (moved.value = null)));
}

/** The same after a rest, for wheel and keys. */
const letGoSoon = () => (clearTimeout(resting), (resting = window.setTimeout(letGo, REST)));

/** Listens to a canvas until the function that it gives is called. @param {HTMLCanvasElement} canvas @returns {() => void} */
export function gestures(canvas) {
  const stop = new AbortController();
  const fingers = /** @type {Map<number, { x: number, y: number }>} */ (new Map());
  let travelled = 0;
  /** @param {MouseEvent} event */
  const place = (event) => {
    const box = canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  };
  const pinch = () => {
    const [a, b] = [...fingers.values()];
    return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, distance: Math.hypot(a.x - b.x, a.y - b.y) || 1 };
  };
  const listen = /** @type {HTMLCanvasElement["addEventListener"]} */ ((/** @type {string} */ type, /** @type {any} */ heard) => canvas.addEventListener(type, heard, { signal: stop.signal, passive: false }));

  listen("pointerdown", (event) => {
    if (event.button > 1) return;
    canvas.setPointerCapture(event.pointerId);
    if (fingers.size === 0) travelled = 0;
    fingers.set(event.pointerId, place(event));
  });
  listen("pointermove", (event) => {
    const at = place(event);
    Object.assign(pointer, at);
    const before = fingers.get(event.pointerId);
    if (!before) return void (hover.value = pixelAt(view.peek(), size.peek(), at.x, at.y));
    const [dx, dy] = [at.x - before.x, at.y - before.y];
    travelled += Math.abs(dx) + Math.abs(dy);
    if (fingers.size === 2) {
      const from = pinch();
      fingers.set(event.pointerId, at);
      const to = pinch();
      if (tool.peek() === "orbit") {
        moveCamera((camera) => dollied(trucked(camera, (to.x - from.x) / view.peek().height, (to.y - from.y) / view.peek().height), from.distance / to.distance));
      } else {
        zoomBy(to.distance / from.distance, from.x, from.y);
        view.value = panned(view.peek(), size.peek(), to.x - from.x, to.y - from.y);
      }
      return;
    }
    fingers.set(event.pointerId, at);
    if (travelled < STILL) return;
    if (tool.peek() === "orbit" || event.altKey) {
      const { height } = view.peek();
      if (event.shiftKey || event.buttons === 4) moveCamera((camera) => trucked(camera, dx / height, dy / height));
      else moveCamera((camera) => orbited(camera, (dx / height) * Math.PI, (dy / height) * Math.PI));
    } else batch(() => ((isFitted.value = false), (view.value = panned(view.peek(), size.peek(), dx, dy))));
  });
  const up = (/** @type {PointerEvent} */ event) => {
    if (!fingers.delete(event.pointerId)) return;
    if (fingers.size > 0) return;
    if (moving) return letGo();
    if (travelled >= STILL || event.type !== "pointerup") return;
    const at = place(event);
    const chosen = pixelAt(view.peek(), size.peek(), at.x, at.y);
    const before = pixel.peek();
    // With a finger the first tap chooses, the second inspects.
    const isSecond = chosen && before && Math.hypot(chosen.x - before.x, chosen.y - before.y) * view.peek().scale < 24;
    batch(() => {
      pixel.value = chosen;
      if (chosen && (event.pointerType !== "touch" || isSecond)) openPanel("pixel");
    });
  };
  listen("pointerup", up);
  listen("pointercancel", up);
  listen("pointerleave", () => (hover.value = null));
  listen("wheel", (event) => {
    event.preventDefault();
    const at = place(event);
    Object.assign(pointer, at);
    const amount = event.deltaY * (event.deltaMode === 1 ? 16 : 1) * (event.ctrlKey ? 4 : 1);
    const factor = 2 ** (-Math.max(-240, Math.min(240, amount)) / 240);
    if (tool.peek() !== "orbit") return zoomBy(factor, at.x, at.y);
    moveCamera((camera) => dollied(camera, 1 / factor));
    letGoSoon();
  });
  listen("dblclick", (event) => {
    const at = place(event);
    if (tool.peek() !== "orbit") zoomBy(2, at.x, at.y);
  });
  listen("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const step = event.shiftKey ? 10 : 1;
    const arrow = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (arrow && tool.peek() === "orbit") {
      const [dx, dy] = arrow;
      if (event.shiftKey) moveCamera((camera) => trucked(camera, -dx * 0.05, -dy * 0.05));
      else moveCamera((camera) => orbited(camera, dx * 0.05, dy * 0.05));
      letGoSoon();
    } else if (arrow) moveCursor(arrow[0] * step, arrow[1] * step);
    else if (event.key === "+" || event.key === "=") tool.peek() === "orbit" ? (moveCamera((camera) => dollied(camera, 0.9)), letGoSoon()) : zoomBy(1.5);
    else if (event.key === "-") tool.peek() === "orbit" ? (moveCamera((camera) => dollied(camera, 1 / 0.9)), letGoSoon()) : zoomBy(1 / 1.5);
    else if (event.key === "0") fit();
    else if (event.key === "Enter" && pixel.peek()) openPanel("pixel");
    else if (event.key === "Escape") pixel.value = null;
    else return;
    event.preventDefault();
    event.stopPropagation();
  });
  return () => stop.abort();
}

/** Whether the camera of what is rendered can be moved. */
export const isMovable = () => rendered.value !== "" && cameraOf(scene.value) !== null;
