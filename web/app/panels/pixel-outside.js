// The outside view: the same scene from a second camera that can be walked around, with the pixel's rays in it.
import { effect, html, signal, untracked, useEffect, useRef } from "../../vendor/preact.js";
import { Problem, askJson, pause, render } from "../api.js";
import { LARGE } from "../base.js";
import { cross, dot as times, length, minus, plus, unit } from "../camera.js";
import { sized } from "../framing.js";
import { bitmaps, scene, settings, text } from "../state.js";
import { Button } from "../ui.js";
import { answer, chosen, pointed, sample } from "./pixel-asked.js";
import { PAINT, dot, segmentsOf, stroke } from "./pixel-overlay.js";
import { cameraOf, pathOf } from "./pixel-projection.js";
import { KINDS } from "./pixel-rays.js";

/** @typedef {import("./pixel-projection.js").Vec} Vec */
/** @typedef {{ target: Vec, up: Vec, front: Vec, side: Vec, distance: number, yaw: number, pitch: number }} Orbit */

const isOpen = signal(false);
const orbit = signal(/** @type {Orbit | null} */ (null));
const picture = signal(/** @type {{ bitmap: ImageBitmap, seen: Orbit } | null} */ (null));
/** Which parts of each segment a body hides from the second camera, for the orbit it was asked for. */
const hidden = signal(/** @type {{ orbit: Orbit, parts: Map<number, boolean[]> } | null} */ (null));
const trouble = signal("");

const SIZE = { width: 480, height: 320 };
const FIELD = 40;
/** Rays that are asked at once which parts are hidden, and points of a segment. */
const [MOST, POINTS] = [1536, 24];

/** Where one sees all rays of the sample: aside of the eye's line of sight, and a little above. */
function firstOrbit() {
  const of = answer.peek();
  const camera = cameraOf(scene.peek(), SIZE);
  if (!of || !camera) return null;
  const all = segmentsOf(of.grown, sample.peek(), scene.peek()).filter(({ leaves, ray }) => !leaves && ray.kind !== "shadow");
  // What matters is in the middle; faint rays may go far.
  const known = all.filter(({ weight }) => weight >= 0.2 * (all.at(-1)?.weight ?? 0));
  const points = known.length > 0 ? known.flatMap(({ from, to }) => [from, to]) : [camera.eye];
  const [low, high] = [Math.min, Math.max].map((best) => /** @type {Vec} */ ([0, 1, 2].map((c) => best(...points.map((point) => point[c])))));
  const target = plus(low, minus(high, low), 0.5);
  const [, value] = /** @type {[string, any]} */ (Object.entries(scene.peek().camera)[0]);
  const up = unit(value.up ?? [0, 1, 0]);
  const view = minus(value.look_at, value.eye);
  const front = unit(minus(view, plus([0, 0, 0], up, times(view, up))));
  return { target, up, front, side: cross(front, up), distance: Math.max(1e-6, length(minus(high, low)) * 1.5, 1e-3 * length(view)), yaw: 65, pitch: 24 };
}

/** @param {Orbit} of */
function viewOf({ target, up, front, side, distance, yaw, pitch }) {
  const [a, b] = [(yaw * Math.PI) / 180, (pitch * Math.PI) / 180];
  const flat = plus(plus([0, 0, 0], front, -Math.cos(a)), side, Math.sin(a));
  const eye = plus(plus(target, flat, distance * Math.cos(b)), up, distance * Math.sin(b));
  return { pinhole: { eye, look_at: target, up, vfov_deg: FIELD } };
}

/** A large text that the service has, and the scene's id there: so a turn sends the second camera alone. */
let base = { text: "", id: "" };

/** The scene as the second camera sees it; a large one as a variation. @param {Orbit} of @param {AbortSignal} signal */
async function sceneFrom(of, signal) {
  const camera = viewOf(of);
  const now = text.peek();
  if (now.length < LARGE) return JSON.stringify({ ...scene.peek(), camera });
  if (base.text !== now) {
    const { scene_id: id } = await askJson("v1/scenes", { body: now, type: "application/json", signal });
    base = { text: now, id };
  }
  const kinds = Object.keys(scene.peek().camera).map((kind) => [kind, null]);
  return JSON.stringify({ base: base.id, patch: { camera: { ...Object.fromEntries(kinds), pinhole: { ...camera.pinhole, aperture: 0 } } } });
}

/** @param {Orbit} of @param {AbortSignal} signal */
async function load(of, signal) {
  const plain = sized(settings.peek(), SIZE);
  const show = async (/** @type {string} */ varied, /** @type {Record<string, string>} */ more) => {
    const { bitmap } = await render({ text: varied, settings: { ...plain, ...more }, signal });
    bitmaps.made += 1;
    const before = picture.peek();
    picture.value = { bitmap, seen: of };
    letGo(before);
    trouble.value = "";
  };
  try {
    const varied = await sceneFrom(of, signal);
    await show(varied, { accuracy: "time:40", antialias: "false", samples: "1" });
    await pause(250, signal);
    await Promise.all([show(varied, { accuracy: "time:500" }), loadHidden(of, varied, signal)]);
  } catch (error) {
    if (signal.aborted) return;
    // The service may have forgotten the scene.
    if (error instanceof Problem && error.status === 404) base = { text: "", id: "" };
    trouble.value = error instanceof Error ? error.message : String(error);
  }
}

/** @param {typeof picture.value} of */
function letGo(of) {
  if (!of) return;
  of.bitmap.close();
  bitmaps.closed += 1;
}

/** Asks which points of the segments something hides. @param {Orbit} of @param {string} varied @param {AbortSignal} signal */
async function loadHidden(of, varied, signal) {
  const tree = answer.peek();
  if (!tree) return;
  const segments = segmentsOf(tree.grown, sample.peek(), scene.peek()).slice(-Math.floor(MOST / POINTS));
  const { eye } = viewOf(of).pinhole;
  const rays = segments.flatMap(({ from, to }) => Array.from({ length: POINTS }, (_, at) => {
    const point = plus(from, minus(to, from), (at + 0.5) / POINTS);
    // It counts in the direction's own length: 1 is the point itself.
    return { origin: eye, direction: minus(point, eye), t_max: 0.999 };
  }));
  const { answers } = await askJson("v1/rays", { body: `{"scene":${varied},"rays":${JSON.stringify(rays)}}`, type: "application/json", signal });
  const parts = new Map(segments.map(({ id }, at) => [id, answers.slice(at * POINTS, (at + 1) * POINTS).map((/** @type {any} */ one) => one.hit)]));
  hidden.value = { orbit: of, parts };
}

/** @param {HTMLCanvasElement} canvas */
function draw(canvas) {
  const context = canvas.getContext("2d");
  const [of, shown, tree] = [orbit.value, picture.value, answer.value];
  const marked = Number.parseInt(pointed.value || chosen.value, 10);
  const which = sample.value;
  const parts = hidden.value;
  if (!context || !of) return;
  const ratio = Math.min(2, window.devicePixelRatio || 1);
  const [width, height] = [canvas.clientWidth, (canvas.clientWidth * SIZE.height) / SIZE.width];
  if (canvas.width !== Math.round(width * ratio)) [canvas.width, canvas.height] = [width, height].map((side) => Math.round(side * ratio));
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  if (shown) context.drawImage(shown.bitmap, 0, 0, width, height);
  context.fillStyle = "rgb(0 0 0 / 22%)";
  context.fillRect(0, 0, width, height);
  const camera = cameraOf({ camera: viewOf(shown?.seen ?? of) }, { width, height });
  if (!tree || !camera) return;
  const known = parts && shown && parts.orbit === shown.seen ? parts.parts : null;
  const segments = segmentsOf(tree.grown, which, scene.value);
  for (const { id, ray, from, to, weight } of [...segments.filter(({ id }) => id !== marked), ...segments.filter(({ id }) => id === marked)]) {
    const how = { color: PAINT[ray.kind], width: (1.2 + 1.6 * Math.sqrt(Math.min(1, weight))) * (id === marked ? 1.5 : 1), dash: "", faint: pointed.value !== "" && id !== marked };
    const own = known?.get(id);
    for (const { from: start, to: end, isHidden } of runsOf(own)) {
      const [a, b] = [start, end].map((at) => plus(from, minus(to, from), at));
      for (const path of pathOf(camera, a, b, width)) stroke(context, path, isHidden ? { ...how, dash: "3 4", width: how.width * 0.75, faint: how.faint } : how);
    }
    const end = ray.hit && camera.project(to);
    if (end) dot(context, end, how.color, id === marked ? 4 : 2.5, how.faint);
    if (ray.kind === "camera") {
      const eye = camera.project(from);
      if (eye) label(context, eye, "eye");
    } else if (id === marked) {
      const middle = camera.project(plus(from, minus(to, from), 0.5));
      if (middle) label(context, middle, `${KINDS[ray.kind].letter}${id}`);
    }
  }
}

/** Runs of a segment that are seen or hidden. @param {boolean[] | undefined} parts */
export function runsOf(parts) {
  if (!parts) return [{ from: 0, to: 1, isHidden: false }];
  /** @type {{ from: number, to: number, isHidden: boolean }[]} */
  const runs = [];
  parts.forEach((isHidden, at) => {
    const last = runs.at(-1);
    const to = (at + 1) / parts.length;
    if (last?.isHidden === isHidden) last.to = to;
    else runs.push({ from: at / parts.length, to, isHidden });
  });
  return runs;
}

/** @param {CanvasRenderingContext2D} context @param {[number, number]} at @param {string} words */
function label(context, [x, y], words) {
  context.font = "600 11px system-ui, sans-serif";
  context.lineWidth = 3;
  context.strokeStyle = "rgb(0 0 0 / 75%)";
  context.strokeText(words, x + 7, y - 6);
  context.fillStyle = "#ffffff";
  context.fillText(words, x + 7, y - 6);
}

/** @param {number} yaw @param {number} pitch @param {number} [zoom] */
function turn(yaw, pitch, zoom = 1) {
  const of = orbit.peek();
  if (of) orbit.value = { ...of, yaw: of.yaw + yaw, pitch: Math.min(88, Math.max(-88, of.pitch + pitch)), distance: of.distance * zoom };
}

const STEPS = /** @type {Record<string, [number, number, number]>} */ ({ ArrowLeft: [-10, 0, 1], ArrowRight: [10, 0, 1], ArrowUp: [0, 10, 1], ArrowDown: [0, -10, 1], "+": [0, 0, 0.8], "-": [0, 0, 1.25] });

function Canvas() {
  const canvas = useRef(/** @type {HTMLCanvasElement | null} */ (null));
  useEffect(() => {
    let from = /** @type {{ text: any, of: any, which: number } | null} */ (null);
    let loading = new AbortController();
    let next = /** @type {Orbit | null} */ (null);
    let busy = false;
    // One picture on its way, the newest waits: so one sees something while one turns.
    const go = async () => {
      if (busy || !next) return;
      busy = true;
      const of = next;
      next = null;
      loading = new AbortController();
      await load(of, loading.signal);
      busy = false;
      go();
    };
    const stopAsking = effect(() => {
      const about = { text: scene.value, of: answer.value, which: sample.value };
      if (from === null || from.of?.grown.tree.pixel.join() !== about.of?.grown.tree.pixel.join() || !orbit.peek()) untracked(() => (orbit.value = firstOrbit()));
      const isTurn = from !== null && from.text === about.text && from.of === about.of && from.which === about.which;
      from = about;
      next = orbit.value;
      untracked(() => {
        // The quick picture of a turn is seen; what follows it at rest is not waited for.
        if (busy && (!isTurn || picture.peek()?.seen !== null)) loading.abort();
        go();
      });
    });
    const stopDrawing = effect(() => void (canvas.current && draw(canvas.current)));
    const resized = new ResizeObserver(() => canvas.current && draw(canvas.current));
    if (canvas.current) resized.observe(canvas.current);
    return () => {
      stopAsking(), stopDrawing(), resized.disconnect(), loading.abort();
      letGo(picture.peek());
      picture.value = hidden.value = null;
    };
  }, []);
  const drag = (/** @type {PointerEvent} */ event) => {
    if (event.buttons & 1) turn(-event.movementX * 0.5, event.movementY * 0.5);
  };
  const onKey = (/** @type {KeyboardEvent} */ event) => {
    const step = STEPS[event.key === "=" ? "+" : event.key];
    if (!step || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    event.stopPropagation();
    turn(...step);
  };
  const wheel = (/** @type {WheelEvent} */ event) => {
    if (!event.ctrlKey) return;
    event.preventDefault();
    turn(0, 0, Math.exp(event.deltaY * 0.004));
  };
  return html`<div class="outside-view">
    <canvas ref=${canvas} tabindex="0" role="img" aria-label="The scene and the rays of the pixel from outside. Arrows turn, plus and minus zoom." onKeyDown=${onKey} onWheel=${wheel}
      onPointerDown=${(/** @type {PointerEvent} */ event) => /** @type {HTMLElement} */ (event.currentTarget).setPointerCapture(event.pointerId)} onPointerMove=${drag}></canvas>
    ${trouble.value !== "" && html`<p class="outside-trouble" role="status">${trouble.value}</p>`}
    <div class="outside-buttons" role="group" aria-label="Second camera">
      <${Button} label="Turn left" kind="quiet" press=${() => turn(-15, 0)}>←<//><${Button} label="Turn right" kind="quiet" press=${() => turn(15, 0)}>→<//>
      <${Button} label="Higher" kind="quiet" press=${() => turn(0, 12)}>↑<//><${Button} label="Lower" kind="quiet" press=${() => turn(0, -12)}>↓<//>
      <${Button} label="Nearer" icon="plus" kind="quiet" press=${() => turn(0, 0, 0.8)} /><${Button} label="Farther" icon="minus" kind="quiet" press=${() => turn(0, 0, 1.25)} />
      <${Button} label="Show all rays" icon="fit" kind="quiet" press=${() => (orbit.value = firstOrbit())} />
    </div>
  </div>`;
}

export function OutsideView() {
  if (!scene.value || !cameraOf(scene.value, SIZE)) return null;
  return html`<section class="outside" aria-label="From outside">
    <h3><button type="button" class="fold" aria-expanded=${String(isOpen.value)} onClick=${() => (isOpen.value = !isOpen.value)}>From outside</button></h3>
    ${isOpen.value ? html`<${Canvas} /><p class="quiet">Drag to walk around. Dashed: behind a body, from there.</p>` : html`<p class="quiet">Walk around the scene with these rays in it.</p>`}
  </section>`;
}
