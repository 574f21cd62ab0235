// The panels in the order of their tabs.
import * as pixel from "./pixel.js";
import * as plan from "./plan.js";

/**
 * @typedef {object} Panel
 * @property {string} id
 * @property {string} title
 * @property {() => import("../../vendor/preact.js").ComponentChild} Panel
 * @property {() => void} [start] called once at the start, for effects that go on while the panel is closed
 */
/** @type {Panel[]} */
export const panels = [plan, pixel];
