// Large scenes are sent once. While the camera of one moves, requests hold a variation of it: a patch on the scene that the
// service has, which does not build its geometry again. Small scenes go along as they are, which takes one request less.
import { Problem, askJson } from "./api.js";

/** @typedef {{ body: string, type: string }} Sent */
/** @typedef {{ camera: Record<string, { eye: number[], look_at: number[] }> }} Patch */

/** Characters from which on a text is large. */
export const LARGE = 100_000;
/** Texts of one base that are known as patches on it. */
const KNOWN = 16;

/** The scene that the service has, and texts that are this scene with a patch. */
let base = /** @type {{ text: string, id: Promise<string> } | null} */ (null);
let known = /** @type {{ text: string, patch: Patch | {} }[]} */ ([]);

/** The patch with which a text is the base, or null. @param {string} text */
const patchOf = (text) => known.find((of) => of.text === text)?.patch ?? null;

/** Posts a scene, to be varied. @param {string} text @param {AbortSignal} [signal] */
function post(text, signal) {
  const id = askJson("v1/scenes", { method: "POST", body: text, type: "application/json", signal }).then(({ scene_id }) => /** @type {string} */ (scene_id));
  base = { text, id };
  known = [{ text, patch: {} }];
  id.catch(() => (base = null));
  return id;
}

/** Remembers that a text is another one with a patch. @param {string} before @param {Patch} patch @param {string} after */
export function remember(before, patch, after) {
  if (!base || patchOf(before) === null) return;
  known = [...known.slice(-KNOWN + 1), { text: after, patch: { ...patchOf(before), ...patch } }];
}

/**
 * What is sent for a scene, with or without a patch on its text.
 * @param {{ text: string, type: string, patch?: Patch | null }} scene @param {AbortSignal} [signal] @returns {Promise<Sent>}
 */
export async function sentFor({ text, type, patch }, signal) {
  if (type !== "application/json" || text.length < LARGE) return { body: text, type };
  const before = base ? patchOf(text) : null;
  if (before === null && !patch) return { body: text, type };
  const id = base && before !== null ? await base.id : await post(text, signal);
  return { body: JSON.stringify({ base: id, patch: { ...(before ?? {}), ...(patch ?? {}) } }), type: "application/vnd.strahl.variation+json" };
}

/** Whether the service has forgotten the base: then it is posted again. @param {unknown} error */
export function isForgotten(error) {
  if (!(error instanceof Problem) || error.status !== 404 || !base) return false;
  base = null;
  return true;
}
