// The panels in the order of their tabs.
import * as accuracy from "./accuracy.js";
import * as compare from "./compare.js";
import * as farm from "./farm.js";
import * as jobs from "./jobs.js";
import * as maps from "./maps.js";
import * as pixel from "./pixel.js";
import * as plan from "./plan.js";

/**
 * @typedef {object} Panel
 * @property {string} id
 * @property {string} title
 * @property {() => import("../../vendor/preact.js").ComponentChild} Panel
 * @property {() => void} [start] called once at the start, for effects that go on while the panel is closed
 * @property {() => import("../../vendor/preact.js").ComponentChild} [Overlay] over the viewport, in its coordinates
 */
/** @type {Panel[]} */
export const panels = [plan, pixel, accuracy, compare, maps, jobs];
/** Panels that add themselves when there is something for them. @type {Panel[]} */
export const later = [farm];
