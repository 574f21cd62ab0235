// From a point of the scene to the point of the picture that shows it, and back to a ray: as src/camera does, for all cameras. Pure.
import { cross, dot, isVector, length, minus, plus, unit } from "../camera.js";

/** @typedef {import("../camera.js").Vector} Vec */
/** @typedef {[number, number]} Point in pixels from the picture's upper left corner */
/**
 * @typedef {object} Camera
 * @property {string} kind the key of the scene: "pinhole", "fisheye" ...
 * @property {boolean} bends whether straight lines become curves
 * @property {Vec} eye
 * @property {(point: Vec) => Point | null} project
 * @property {(at: Point) => { origin: Vec, direction: Vec } | null} ray through a point of the picture
 * @property {(a: Vec, b: Vec) => [Vec, Vec] | null} clip the part of a segment that can be seen
 */

const radians = (/** @type {number} */ degrees) => (degrees * Math.PI) / 180;

/**
 * The camera of a scene; null if it has none that is sound.
 * @param {any} scene @param {{ width: number, height: number }} size @returns {Camera | null}
 */
export function cameraOf(scene, { width, height }) {
  const [kind, of] = /** @type {[string, any]} */ (Object.entries(scene?.camera ?? {})[0] ?? ["", null]);
  const up = of?.up ?? [0, 1, 0];
  if (!of || !isVector(of.eye) || !isVector(of.look_at) || !isVector(up)) return null;
  const eye = /** @type {Vec} */ (of.eye);
  const forward = unit(minus(of.look_at, eye));
  const across = cross(forward, unit(up));
  if (!(length(across) > 1e-9)) return null;
  const right = unit(across);
  const above = cross(right, forward);
  const local = (/** @type {Vec} */ point) => {
    const to = minus(point, eye);
    return { x: dot(to, right), y: dot(to, above), z: dot(to, forward) };
  };
  const world = (/** @type {number} */ x, /** @type {number} */ y, /** @type {number} */ z) => plus(plus(plus([0, 0, 0], right, x), above, y), forward, z);

  if (kind === "pinhole" || kind === "orthographic") {
    const parallel = kind === "orthographic";
    // Half the height of the image plane, at the eye or at distance 1.
    const half = parallel ? 0.5 * of.height : Math.tan(radians(of.vfov_deg ?? 45) / 2);
    const perUnit = height / (2 * half);
    return {
      kind, bends: false, eye,
      project(point) {
        const { x, y, z } = local(point);
        const scale = parallel ? perUnit : perUnit / z;
        return (parallel ? z >= 0 : z > 0) ? [width / 2 + x * scale, height / 2 - y * scale] : null;
      },
      ray([px, py]) {
        const [x, y] = [(px - width / 2) / perUnit, (height / 2 - py) / perUnit];
        return parallel ? { origin: plus(eye, world(x, y, 0)), direction: forward } : { origin: eye, direction: unit(world(x, y, 1)) };
      },
      clip(a, b) {
        const [za, zb] = [local(a).z, local(b).z];
        const least = parallel ? 0 : 1e-6 * Math.max(za, zb);
        if (Math.max(za, zb) < 0 || (!parallel && Math.max(za, zb) <= 0)) return null;
        const cut = (/** @type {Vec} */ from, /** @type {Vec} */ to, /** @type {number} */ near, /** @type {number} */ far) =>
          near >= least ? from : plus(from, minus(to, from), (least - near) / (far - near));
        return [cut(a, b, za, zb), cut(b, a, zb, za)];
      },
    };
  }
  const angular = anglesOf(kind, of, width, height);
  if (!angular) return null;
  return {
    kind, bends: true, eye,
    project: (point) => {
      const { x, y, z } = local(point);
      return angular.project(x, y, z);
    },
    ray: (at) => {
      const direction = angular.direction(at);
      return direction && { origin: eye, direction: unit(world(...direction)) };
    },
    clip: (a, b) => [a, b],
  };
}

/**
 * Projections whose coordinates are angles, in the camera's own axes: right, up, forward.
 * @param {string} kind @param {any} of @param {number} width @param {number} height
 * @returns {{ project: (x: number, y: number, z: number) => Point | null, direction: (at: Point) => Vec | null } | null}
 */
function anglesOf(kind, of, width, height) {
  if (kind === "fisheye" || kind === "omnimax") {
    const half = radians(of.fov_deg ?? 180) / 2;
    const radius = (kind === "omnimax" ? width : Math.min(width, height)) / 2;
    const center = [width / 2, kind === "omnimax" ? width / 2 : height / 2];
    return {
      project(x, y, z) {
        const across = Math.hypot(x, y);
        const r = Math.atan2(across, z) / half;
        const scale = across > 0 ? (radius * r) / across : 0;
        return r > 1 ? null : [center[0] + x * scale, center[1] - y * scale];
      },
      direction([px, py]) {
        const [x, y] = [(px - center[0]) / radius, (center[1] - py) / radius];
        const r = Math.hypot(x, y);
        const scale = r > 0 ? Math.sin(r * half) / r : half;
        return r > 1 ? null : [x * scale, y * scale, Math.cos(r * half)];
      },
    };
  }
  const hfov = radians(of.hfov_deg ?? (kind === "panorama" ? 360 : 180));
  if (kind === "panorama") {
    const vfov = radians(of.vfov_deg ?? 180);
    return {
      project: (x, y, z) => [(Math.atan2(x, z) / hfov + 0.5) * width, (0.5 - Math.atan2(y, Math.hypot(x, z)) / vfov) * height],
      direction: ([px, py]) => {
        const [lon, lat] = [(px / width - 0.5) * hfov, (0.5 - py / height) * vfov];
        return [Math.sin(lon) * Math.cos(lat), Math.sin(lat), Math.cos(lon) * Math.cos(lat)];
      },
    };
  }
  if (kind === "cylinder") {
    const half = Math.tan(radians(of.vfov_deg ?? 60) / 2);
    return {
      project(x, y, z) {
        const flat = Math.hypot(x, z);
        return flat === 0 && y !== 0 ? null : [(Math.atan2(x, z) / hfov + 0.5) * width, (height / 2) * (1 - (flat > 0 ? y / flat : 0) / half)];
      },
      direction: ([px, py]) => {
        const lon = (px / width - 0.5) * hfov;
        return [Math.sin(lon), (1 - (2 * py) / height) * half, Math.cos(lon)];
      },
    };
  }
  return null;
}

/** Pieces of a line that becomes a curve. */
const PIECES = 48;

/**
 * A segment of the scene as lines of the picture: one, or several where a panorama's ends meet.
 * @param {Camera} camera @param {Vec} from @param {Vec} to @param {number} width @returns {Point[][]}
 */
export function pathOf(camera, from, to, width) {
  const seen = camera.clip(from, to);
  if (!seen) return [];
  const pieces = camera.bends ? PIECES : 1;
  /** @type {Point[][]} */
  const lines = [];
  /** @type {Point | null} */
  let last = null;
  for (let piece = 0; piece <= pieces; piece += 1) {
    const point = camera.project(plus(seen[0], minus(seen[1], seen[0]), piece / pieces));
    const goesOn = point && last && !(camera.bends && Math.abs(point[0] - last[0]) > width / 2);
    if (goesOn) lines[lines.length - 1].push(point);
    else if (point) lines.push([point]);
    last = point;
  }
  return lines.filter((line) => line.length > 1);
}
