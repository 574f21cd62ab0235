/**
 * Client of strahl, a render service: a JSON scene in, a ray-traced picture and what it cost out. For Node 20 and browsers.
 * @module
 */

export { Assets } from "./assets.js";
export { Client } from "./client.js";
export { Job, Jobs } from "./jobs.js";
export { Picture } from "./picture.js";
export { ConnectionError, DamagedError, Problem, StrahlError } from "./problems.js";

/** @typedef {import("./client.js").Scene} Scene */
/** @typedef {import("./client.js").Settings} Settings */
/** @typedef {import("./client.js").Output} Output */
/** @typedef {import("./client.js").Layers} Layers */
/** @typedef {import("./client.js").Given} Given */
/** @typedef {import("./client.js").ImageLike} ImageLike */
/** @typedef {import("./parts.js").Pass} Pass */
/** @typedef {import("./problems.js").Mistake} Mistake */
/** @typedef {import("./picture.js").PictureError} PictureError */
/** @typedef {import("./jobs.js").JobEvent} JobEvent */
/** @typedef {import("./jobs.js").Progress} Progress */
