// A scene without one of its effects: the keys that ask for it get the value that asks for nothing. Pure.
// Where the service can leave an effect out itself, it does so more exactly; this is for the others.
import { fromHex } from "../values.js";

/** What is done to a copy of the scene; false if there was nothing to do. @typedef {(scene: any) => boolean} Change */

/** A pattern's mean color, as far as two colors tell it. @param {any} pattern */
function plainOf(pattern) {
  const [of] = /** @type {any[]} */ (Object.values(pattern));
  const triple = (/** @type {any} */ color) => (Array.isArray(color) ? color : typeof color === "string" ? fromHex(color) : [color ?? 0.5, color ?? 0.5, color ?? 0.5]);
  const [a, b] = [triple(of?.a), triple(of?.b)];
  return a.map((/** @type {number} */ value, /** @type {number} */ c) => (value + b[c]) / 2);
}

/** @param {string} name @param {any} value `undefined` takes the key away @param {any} [only] where it has this value @returns {Change} */
const material = (name, value, only) => (scene) => {
  let changed = false;
  for (const of of Object.values(scene.materials ?? {})) {
    if (of === null || typeof of !== "object" || (!(name in of) && value === undefined)) continue;
    if (only !== undefined && of[name] !== only) continue;
    changed = true;
    if (value === undefined) delete of[name];
    else of[name] = value;
  }
  return changed;
};

/** @param {string} kind @returns {Change} */
const pattern = (kind) => (scene) => {
  let changed = false;
  for (const of of /** @type {any[]} */ (Object.values(scene.materials ?? {}))) {
    for (const key of ["diffuse", "ambient"]) {
      if (!of?.[key] || typeof of[key] !== "object" || !(kind in of[key])) continue;
      of[key] = plainOf(of[key]);
      changed = true;
    }
  }
  return changed;
};

/** @param {string} part @param {string} name @param {any} value @returns {Change} */
const setting = (part, name, value) => (scene) => {
  scene[part] = { ...scene[part] };
  if (value === undefined) delete scene[part][name];
  else scene[part][name] = value;
  return true;
};

/** @param {string} name @param {any} [value] @returns {Change} */
const whole = (name, value) => (scene) => {
  const had = name in scene;
  if (value === undefined) delete scene[name];
  else scene[name] = value;
  return had || value !== undefined;
};

/** Takes a key away from lights, the camera, or objects however deep they stand. @param {string} part @param {string} name @returns {Change} */
const anywhere = (part, name) => (scene) => {
  let changed = false;
  const open = [scene[part], part === "objects" ? scene.definitions : null];
  while (open.length > 0) {
    const of = open.pop();
    if (of === null || typeof of !== "object") continue;
    if (!Array.isArray(of) && name in of) {
      delete of[name];
      changed = true;
    }
    // Numbers of meshes hold no keys.
    for (const inner of Object.values(of)) if (inner !== null && typeof inner === "object" && !(Array.isArray(inner) && typeof inner[0] === "number")) open.push(inner);
  }
  return changed;
};

const black = [0, 0, 0];
/** @type {Record<string, Change[]>} */
const CHANGES = {
  ambient_light: [whole("ambient", black)],
  diffuse_reflection: [material("diffuse", 0)],
  highlights: [material("specular", undefined)],
  shadows: [setting("render", "shadows", "none")],
  transmissive_shadows: [setting("render", "shadows", "opaque")],
  colored_shadows: [setting("render", "shadows", "opaque")],
  // Metals mirror by their Fresnel terms alone.
  reflection: [material("reflection", undefined), material("fresnel", undefined, "conductor")],
  transmission: [material("transmission", undefined)],
  absorption: [material("absorption", undefined)],
  emission: [material("emission", undefined)],
  fog: [whole("fog")],
  fresnel: [material("fresnel", undefined)],
  refraction: [material("ior", 1)],
  checker_texture: [pattern("checker")],
  gradient_texture: [pattern("gradient")],
  noise_texture: [pattern("noise")],
  bump_mapping: [material("bump", undefined)],
  normal_mapping: [material("normal_map", undefined)],
  environment_map: [whole("environment")],
  light_falloff: [anywhere("lights", "falloff")],
  soft_shadows: [anywhere("lights", "area")],
  gloss: [material("roughness", undefined)],
  dispersion: [material("dispersion", undefined)],
  depth_of_field: [anywhere("camera", "aperture")],
  motion_blur: [anywhere("objects", "motion")],
  color_bleeding: [setting("render", "color_bleeding", false)],
  alpha_channel: [setting("film", "background", "scene")],
  tone_mapping: [setting("film", "exposure", undefined), setting("film", "tone", undefined)],
  antialiasing: [setting("render", "antialias", false)],
  double_precision: [setting("render", "precision", "single")],
};

/** Settings of a request that ask for an effect, too. */
const OVERRIDES = /** @type {Record<string, string>} */ ({ antialiasing: "antialias", double_precision: "precision" });

/** Whether an effect can be left out in this way. @param {string} effect */
export const canLeaveOut = (effect) => effect in CHANGES;

/**
 * The scene and the settings without an effect; null if they cannot be without it.
 * @param {any} scene @param {Record<string, string>} settings @param {string} effect
 */
export function without(scene, settings, effect) {
  if (!canLeaveOut(effect) || scene === null) return null;
  const copy = structuredClone(scene);
  const changed = CHANGES[effect].map((change) => change(copy)).some(Boolean);
  const rest = { ...settings };
  delete rest[OVERRIDES[effect] ?? ""];
  return changed ? { text: JSON.stringify(copy), settings: rest } : null;
}
