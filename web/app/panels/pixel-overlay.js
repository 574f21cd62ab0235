// The rays of the chosen sample over the picture: projected once for each tree, drawn with the view.
import { computed, effect, untracked } from "../../vendor/preact.js";
import { panel, panelsOpen, pixel, putLayer, removeLayer, scene, size } from "../state.js";
import { answer, chosen, isDrawn, isStale, pointed, sample } from "./pixel-asked.js";
import { length, minus, plus } from "../camera.js";
import { cameraOf, pathOf } from "./pixel-projection.js";
import { KINDS, isBlocked, largest } from "./pixel-rays.js";

/** @typedef {import("./pixel-rays.js").Ray} Ray */
/** @typedef {import("./pixel-projection.js").Vec} Vec */
/** @typedef {{ id: number, ray: Ray, from: Vec, to: Vec, leaves: boolean, weight: number, total: boolean }} Segment */

/** Segments that are drawn: the heaviest. More could not be told apart. */
const MOST = 300;

/** Rays as segments of the scene, the heaviest last. @param {import("./pixel-rays.js").Grown} grown @param {number} which @param {any} of the scene @returns {Segment[]} */
export function segmentsOf({ tree, sample: sampleOf }, which, of) {
  const own = tree.rays.filter(({ id, direction }) => sampleOf[id] === which && (direction[0] !== 0 || direction[1] !== 0 || direction[2] !== 0));
  const points = own.flatMap(({ origin, hit }) => (hit ? [origin, hit.point] : [origin]));
  const middle = plus([0, 0, 0], points.reduce((sum, point) => plus(sum, point), /** @type {Vec} */ ([0, 0, 0])), 1 / (points.length || 1));
  // As far as the rays have spread; what leaves the scene is drawn that far.
  const far = Math.max(1e-9, ...points.slice(0, 4096).map((point) => length(minus(point, middle)))) * 2;
  return own
    .map((ray) => {
      const position = ray.light === undefined || ray.light === null ? null : lightAt(of, ray.light);
      const end = ray.hit?.point ?? (position ? plus(ray.origin, ray.direction, length(minus(position, ray.origin))) : null);
      const total = ray.kind === "reflected" && ray.parent !== null && tree.rays[ray.parent].snell?.tir === true;
      return { id: ray.id, ray, from: ray.origin, to: end ?? plus(ray.origin, ray.direction, far), leaves: !end, weight: largest(ray.weight) * tree.samples, total };
    })
    .sort((a, b) => a.weight - b.weight)
    .slice(-MOST);
}

/** @param {any} of @param {number} light @returns {Vec | null} */
function lightAt(of, light) {
  const [value] = /** @type {any[]} */ (Object.values(of?.lights?.[light] ?? {}));
  const at = value?.position;
  return Array.isArray(at) && at.length === 3 && at.every(Number.isFinite) ? /** @type {Vec} */ (at) : null;
}

/** Colors of the kinds over a picture: light on a dark edge, the same in both schemes. */
export const PAINT = /** @type {Record<string, string>} */ ({ camera: "#f0f0f0", reflected: "#ff8a3d", transmitted: "#3ed6a6", shadow: "#ffd23d", gathered: "#e79cc8" });

/**
 * Draws a line of the picture so that it can be seen on any ground.
 * @param {CanvasRenderingContext2D} context @param {[number, number][]} line in CSS pixels @param {{ color: string, width: number, dash: string, faint: boolean }} how
 */
export function stroke(context, line, { color, width, dash, faint }) {
  context.globalAlpha = faint ? 0.28 : 1;
  context.lineJoin = context.lineCap = "round";
  context.beginPath();
  line.forEach(([x, y], at) => (at === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
  context.setLineDash([]);
  context.strokeStyle = "rgb(0 0 0 / 42%)";
  context.lineWidth = width + 1.6;
  context.stroke();
  context.setLineDash(dash === "" ? [] : dash.split(" ").map((part) => Number(part) * Math.max(1, width / 2)));
  context.strokeStyle = color;
  context.lineWidth = width;
  context.stroke();
  context.setLineDash([]);
  context.globalAlpha = 1;
}

/** What of the tree is to be drawn now. */
const drawing = computed(() => {
  const of = answer.value;
  if (!of || !isDrawn.value || panel.value !== "pixel" || !panelsOpen.value || !pixel.value || isStale.value) return null;
  const camera = cameraOf(scene.value, size.value);
  if (!camera) return null;
  const lines = segmentsOf(of.grown, sample.value, scene.value).map((segment) => ({
    segment,
    // The camera ray is seen as a point: that is the cursor.
    paths: segment.ray.kind === "camera" ? [] : pathOf(camera, segment.from, segment.to, size.value.width),
  }));
  const at = of.spot;
  return { lines, spot: at && [(at.x + 0.5) / 2 ** at.zoom, (at.y + 0.5) / 2 ** at.zoom] };
});

/** @param {CanvasRenderingContext2D} context @param {import("../state.js").View} view */
function draw(context, view) {
  const of = drawing.peek();
  if (!of) return;
  const place = (/** @type {[number, number]} */ [x, y]) => /** @type {[number, number]} */ ([view.left + x * view.scale, view.top + y * view.scale]);
  const marked = Number.parseInt(pointed.peek() || chosen.peek(), 10);
  // While one is pointed at, the others step back.
  const faint = pointed.peek() !== "";
  context.save();
  context.beginPath();
  context.rect(view.left, view.top, size.peek().width * view.scale, size.peek().height * view.scale);
  context.clip();
  for (const { segment, paths } of [...of.lines.filter(({ segment }) => segment.id !== marked), ...of.lines.filter(({ segment }) => segment.id === marked)]) {
    const isMarked = segment.id === marked;
    const width = (1 + 1.4 * Math.sqrt(Math.min(1, segment.weight))) * (isMarked ? 1.5 : 1);
    const how = { color: PAINT[segment.ray.kind], width, dash: KINDS[segment.ray.kind].dash, faint: (faint && !isMarked) || (isBlocked(segment.ray) && !isMarked) };
    for (const path of paths) stroke(context, path.map(place), how);
    const end = paths.at(-1)?.at(-1);
    if (end && segment.ray.hit) dot(context, place(end), how.color, isMarked ? 4 : 2.5, how.faint);
  }
  // The cursor is around the whole pixel; the spot in it is marked here.
  if (of.spot) dot(context, place(/** @type {[number, number]} */ (of.spot)), "#ffffff", 4, false);
  context.restore();
}

/** @param {CanvasRenderingContext2D} context @param {[number, number]} at @param {string} color @param {number} radius @param {boolean} faint */
export function dot(context, [x, y], color, radius, faint) {
  context.globalAlpha = faint ? 0.3 : 1;
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  context.fillStyle = color;
  context.strokeStyle = "rgb(0 0 0 / 75%)";
  context.lineWidth = 1.2;
  context.fill();
  context.stroke();
  context.globalAlpha = 1;
}

/**
 * The ray that a place of the picture lies on, or null. @param {{ x: number, y: number }} at @param {number} reach in pixels of the scene
 */
export function overlayHit({ x, y }, reach) {
  let best = { id: /** @type {number | null} */ (null), off: reach };
  for (const { segment, paths } of drawing.peek()?.lines ?? []) {
    for (const path of paths) {
      for (let at = 1; at < path.length; at += 1) {
        const off = distance([x + 0.5, y + 0.5], path[at - 1], path[at]);
        if (off < best.off) best = { id: segment.id, off };
      }
    }
  }
  return best.id;
}

/** From a point to a segment. @param {[number, number]} p @param {[number, number]} a @param {[number, number]} b */
function distance([px, py], [ax, ay], [bx, by]) {
  const [dx, dy] = [bx - ax, by - ay];
  const t = Math.min(1, Math.max(0, ((px - ax) * dx + (py - ay) * dy) / (dx * dx + dy * dy || 1)));
  return Math.hypot(ax + t * dx - px, ay + t * dy - py);
}

/** Puts the rays over the picture as long as there are some. */
export function start() {
  effect(() => {
    const of = drawing.value;
    void chosen.value, pointed.value;
    untracked(() => (of ? putLayer({ id: "pixel-rays", order: 20, draw: (context, view) => draw(context, view) }) : removeLayer("pixel-rays")));
  });
}
