// All state of the page, as signals. The text of the scene is the only truth: whatever changes the scene changes the text.
// README.md says what each signal means, so it is not said here again. Modules and panels share state only through this file.
import { batch, computed, effect, signal } from "../vendor/preact.js";
import { sizeOf } from "./framing.js";
import { editOf, scan, valueOf } from "./pointers.js";

/** @typedef {import("./pointers.js").Syntax} Syntax */
/** @typedef {import("./report.js").Report} Report */
/** @typedef {Record<string, string>} Settings parameters of the query that override the scene, as `{ accuracy: "proved:1" }` */
/** @typedef {{ pointer?: string, parameter?: string, code: string, detail: string, line?: number, column?: number }} SceneProblem `pointer`: where it is in the text; `parameter`: the setting that it is about */
/**
 * @typedef {object} Shown
 * @property {ImageBitmap} bitmap
 * @property {number} width of the bitmap
 * @property {number} height
 * @property {0 | 1 | 2} rung 0: the quick answer; 1: full size without antialiasing; 2: as the scene says
 * @property {number} version of the text that it shows
 * @property {string} text
 * @property {Settings} settings those of the request, with what the rung has added
 * @property {Report} report
 */
/** @typedef {{ x: number, y: number }} Pixel in pixels of the scene's own size, whole numbers */
/** @typedef {{ ms: number, low: number, high: number, rays: number, raysLow: number, raysHigh: number }} Predicted */
/**
 * A thing drawn over the picture. `draw` gets the canvas, whose unit is a CSS pixel, and the view.
 * @typedef {{ id: string, order: number, opacity?: number, draw: (context: CanvasRenderingContext2D, view: View) => void }} Layer
 */
/**
 * How the picture lies in the viewport.
 * @typedef {object} View
 * @property {number} scale CSS pixels for one pixel of the scene
 * @property {number} left CSS pixels from the left edge of the viewport to that of the picture
 * @property {number} top
 * @property {number} width of the viewport in CSS pixels
 * @property {number} height
 * @property {number} [foot] CSS pixels below a fitted picture, unless those that the tools take
 */
/** @typedef {"starting" | "live" | "tracing" | "paused" | "invalid" | "waiting" | "offline" | "failed"} Status */

// The scene.
export const text = signal("");
export const version = signal(0);
export const draft = signal(/** @type {string | null} */ (null));
export const moved = signal(/** @type {import("./base.js").Patch | null} */ (null));
/** @typedef {{ name: string, type: string }} Origin */
export const origin = signal({ name: "", type: "application/json" });
export const rendered = computed(() => draft.value ?? text.value);
/** Characters of a text that are read. */
const READ = 1 << 20;
const HEAD = 1 << 16;
/** Where each pointer is in the text. NFF has no nodes, a text above 1 MB those of its first 64 KB. */
export const syntax = computed(() => {
  if (origin.value.type !== "application/json") return /** @type {Syntax} */ ({ nodes: new Map(), root: null, error: null });
  return text.value.length <= READ ? scan(text.value) : { ...scan(text.value.slice(0, HEAD)), error: null };
});
/** The scene as a value, or null while the text is not JSON. Of a text above 1 MB it has what stands before its first list of objects. */
export const scene = computed(() => {
  if (origin.value.type !== "application/json" || syntax.value.error) return null;
  return text.value.length > READ ? headOf(text.value, syntax.value) : valueOf(text.value);
});
export const title = signal("");
effect(() => {
  if (scene.value || title.peek() === "") title.value = typeof scene.value?.name === "string" ? scene.value.name : origin.value.name;
});
export const settings = signal(/** @type {Settings} */ ({}));
export const size = signal({ width: 960, height: 540 });
/** What the last scene that was JSON says of it. */
let image = {};
effect(() => {
  if (scene.value) image = scene.value.image ?? {};
  const { width, height } = sizeOf(settings.value, image);
  const isSound = (/** @type {number} */ side) => Number.isInteger(side) && side >= 1 && side <= 16384;
  if (isSound(width) && isSound(height) && (width !== size.peek().width || height !== size.peek().height)) size.value = { width, height };
});

// The picture.
export const shown = signal(/** @type {Shown | null} */ (null));
export const report = computed(() => shown.value?.report ?? null);
export const plan = signal(/** @type {any} */ (null));
export const predicted = computed(() => {
  const of = plan.value?.estimate ?? plan.value?.est;
  return of ? /** @type {Predicted} */ ({ ms: of.ms, low: of.ms_ci[0], high: of.ms_ci[1], rays: of.rays, raysLow: of.rays_ci[0], raysHigh: of.rays_ci[1] }) : null;
});
/** `job`: only a job may be it. */
export const status = signal(/** @type {{ word: Status, detail: string, job?: boolean }} */ ({ word: "starting", detail: "" }));
export const problems = signal(/** @type {SceneProblem[]} */ ([]));
export const live = signal(true);
export const offer = signal(/** @type {number | null} */ (null));

/** Bitmaps made and closed: the difference is what the page holds. */
export const bitmaps = { made: 0, closed: 0 };

// What one looks at.
export const view = signal(/** @type {View} */ ({ scale: 1, left: 0, top: 0, width: 1, height: 1 }));
/** By their order: 0 to 9 pictures (maps, B), 10 to 19 outlines, 20 and more marks. */
export const layers = signal(/** @type {Layer[]} */ ([]));
export const pixel = signal(/** @type {Pixel | null} */ (null));
export const hover = signal(/** @type {Pixel | null} */ (null));
export const caret = signal("");
export const lit = signal(/** @type {string[]} */ ([]));
/** The pointer that the editor should show, with a number so that the same one can be asked for twice. */
export const revealed = signal(/** @type {{ pointer: string, count: number } | null} */ (null));
export const panels = signal(/** @type {import("./panels/registry.js").Panel[]} */ ([]));
export const panel = signal("plan");
export const panelsOpen = signal(true);
/** What the pane on a phone shows: "edit" or a panel. */
export const pane = signal("edit");
/** Whether looking closer traces more detail; else pixels become squares. */
export const deep = signal(true);
export const tool = signal(/** @type {"look" | "orbit"} */ ("look"));

export const other = signal(/** @type {(Shown & { label: string }) | null} */ (null));
/** @type {import("../vendor/preact.js").Signal<{ label: string, settings: Settings, text: string | null } | null>} */
export const otherAsked = signal(null);

export const reference = signal(/** @type {(Shown & { label: string }) | null} */ (null));

// The service.
export const key = signal("");
export const connection = signal(/** @type {{ online: boolean, upgraded: boolean }} */ ({ online: true, upgraded: false }));
export const limits = signal(/** @type {any} */ (null));
/** Steps of undo and redo, which the editor keeps; null until it is there. */
export const steps = signal(/** @type {{ undo: (() => void) | null, redo: (() => void) | null }} */ ({ undo: null, redo: null }));
/** The open dialog: "examples", "share", "help", "commands", "key", or "". */
export const dialog = signal("");
/** A sentence for the live region, and at the foot for a while: until the next edit if it offers nothing. */
export const notice = signal(/** @type {{ text: string, version: number, action?: { label: string, run: () => void } } | null} */ (null));

/** Values of the first keys of a long text. @param {string} long @param {Syntax} places */
function headOf(long, places) {
  const top = [...places.nodes.values()].filter(({ parent, key }) => parent !== null && parent === places.root && key !== null);
  const whole = top.slice(0, Math.max(0, top.findIndex(({ pointer }) => pointer === "/objects" || pointer === "/definitions")));
  return /** @type {any} */ (Object.fromEntries(whole.map(({ pointer, from, to }) => [pointer.slice(1), JSON.parse(long.slice(from, to))])));
}

/** JSON begins with a brace, NFF with its camera, background or light; others are what they were. @param {string} of @param {string} before */
export function typeOf(of, before) {
  if (/^\s*\{/.test(of)) return "application/json";
  return /^(?:\s*#[^\n]*\n)*\s*(?:v\s*\n|[bl]\s+[-+.\d]+\s+[-+.\d])/.test(of) ? "text/x-nff" : before;
}

/** @param {string} next @param {Origin} [about] */
export function setText(next, about) {
  batch(() => {
    const { name, type: before } = about ?? origin.peek();
    const type = typeOf(next, before);
    if (about || type !== before) origin.value = { name, type };
    if (next === text.peek()) return;
    text.value = next;
    version.value += 1;
  });
}

/** Gives a pointer of the scene a value, as one step of undo. @param {string} pointer @param {any} value */
export function editAt(pointer, value) {
  const change = editOf(text.peek(), syntax.peek(), pointer, value);
  if (change) setText(text.peek().slice(0, change.from) + change.insert + text.peek().slice(change.to));
}

/** @param {string} pointer */
export function reveal(pointer) {
  batch(() => {
    revealed.value = { pointer, count: (revealed.peek()?.count ?? 0) + 1 };
    pane.value = "edit";
  });
}

/** @param {string} id */
export function openPanel(id) {
  batch(() => {
    panel.value = id;
    pane.value = id;
    panelsOpen.value = true;
  });
}

/** @param {Layer} layer */
export function putLayer(layer) {
  layers.value = [...layers.peek().filter(({ id }) => id !== layer.id), layer].sort((a, b) => a.order - b.order);
}

/** @param {string} id */
export function removeLayer(id) {
  if (layers.peek().some((layer) => layer.id === id)) layers.value = layers.peek().filter((layer) => layer.id !== id);
}

/** Says that a module did not come: another version has other files. */
export const missing = () => say("A part of this page did not come; your text is safe.", { label: "Reload", run: () => location.reload() });

/** Says something to everybody, also to screen readers. @param {string} words @param {{ label: string, run: () => void }} [action] */
export function say(words, action) {
  notice.value = { text: words, version: version.peek(), action };
}
