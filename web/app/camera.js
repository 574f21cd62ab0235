// The camera: orbit, pan, dolly. No effects.
import { rounded } from "./pointers.js";

/** @typedef {[number, number, number]} Vector */
/** @typedef {{ kind: string, eye: Vector, look_at: Vector, up: Vector, vfov_deg: number, height: number }} Camera */

/** @param {Vector} a @param {Vector} b @returns {Vector} */
export const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
/** @param {Vector} a @param {Vector} b @param {number} by @returns {Vector} */
export const plus = (a, b, by = 1) => [a[0] + b[0] * by, a[1] + b[1] * by, a[2] + b[2] * by];
/** @param {Vector} a @param {Vector} b */
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
/** @param {Vector} a @param {Vector} b @returns {Vector} */
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
/** @param {Vector} a */
export const length = (a) => Math.hypot(...a);
/** @param {Vector} a @returns {Vector} */
export const unit = (a) => {
  const size = length(a) || 1;
  return [a[0] / size, a[1] / size, a[2] / size];
};
/** Turns a vector about a unit axis (Rodrigues). @param {Vector} v @param {Vector} axis @param {number} angle @returns {Vector} */
const turned = (v, axis, angle) => {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return plus(plus([v[0] * c, v[1] * c, v[2] * c], cross(axis, v), s), axis, dot(axis, v) * (1 - c));
};

/** @param {any} value @returns {value is Vector} */
export const isVector = (value) => Array.isArray(value) && value.length === 3 && value.every((of) => Number.isFinite(of));

/** The camera of a scene, or null if it has none that can be moved. @param {any} scene @returns {Camera | null} */
export function cameraOf(scene) {
  const kind = Object.keys(scene?.camera ?? {})[0];
  const of = scene?.camera?.[kind];
  if (!of || !isVector(of.eye) || !isVector(of.look_at)) return null;
  const up = isVector(of.up) ? of.up : /** @type {Vector} */ ([0, 1, 0]);
  return { kind, eye: of.eye, look_at: of.look_at, up, vfov_deg: of.vfov_deg ?? 45, height: of.height ?? 1 };
}

/** Right, up and forward. @param {Camera} camera */
function axes({ eye, look_at, up }) {
  const forward = unit(minus(look_at, eye));
  const right = unit(cross(forward, unit(up)));
  return { right, up: cross(right, forward), forward };
}

/** Moves the eye about `look_at`; it stops short of the poles. @param {Camera} camera @param {number} yaw @param {number} pitch radians @returns {Camera} */
export function orbited(camera, yaw, pitch) {
  const pole = unit(camera.up);
  const arm = turned(minus(camera.eye, camera.look_at), pole, -yaw);
  const height = Math.asin(Math.max(-1, Math.min(1, dot(unit(arm), pole))));
  const limit = 1.54;
  const by = Math.max(-limit, Math.min(limit, height + pitch)) - height;
  const axis = unit(cross(arm, pole));
  return { ...camera, eye: plus(camera.look_at, turned(arm, axis, by)) };
}

/** Moves eye and target sideways, in shares of the picture's height. @param {Camera} camera @param {number} dx @param {number} dy @returns {Camera} */
export function trucked(camera, dx, dy) {
  const { right, up } = axes(camera);
  const distance = length(minus(camera.look_at, camera.eye));
  const height = camera.kind === "orthographic" ? camera.height : 2 * distance * Math.tan((camera.vfov_deg * Math.PI) / 360);
  const by = plus(plus([0, 0, 0], right, -dx * height), up, dy * height);
  return { ...camera, eye: plus(camera.eye, by), look_at: plus(camera.look_at, by) };
}

/** Moves the eye towards the target. @param {Camera} camera @param {number} factor of the distance @returns {Camera} */
export const dollied = (camera, factor) => ({ ...camera, eye: plus(camera.look_at, minus(camera.eye, camera.look_at), factor) });

/** The scene with a camera, as eye and target with five digits. @param {Camera} camera @returns {{ eye: number[], look_at: number[] }} */
export const written = ({ eye, look_at }) => ({ eye: eye.map(rounded), look_at: look_at.map(rounded) });
