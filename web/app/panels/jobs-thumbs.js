// Small pictures of jobs: three at a time, drawn into the canvas of their row and closed.
import { ask } from "../api.js";
import { bitmaps } from "../state.js";

/** @typedef {import("./jobs-model.js").Job} Job */

const AT_ONCE = 3;
/** Milliseconds between two pictures of one job. */
const EVERY = 1500;
const waiting = /** @type {(() => void)[]} */ ([]);
const latest = /** @type {Map<string, number>} */ (new Map());
let running = 0;

/** @param {() => Promise<void>} task @param {AbortSignal} signal */
async function inTurn(task, signal) {
  if (running >= AT_ONCE) await new Promise((over) => waiting.push(() => over(undefined)));
  running += 1;
  try {
    if (!signal.aborted) await task();
  } finally {
    running -= 1;
    waiting.shift()?.();
  }
}

/** Draws the newest picture of a job. @param {Job} job @param {HTMLCanvasElement} canvas @param {AbortSignal} signal */
export async function thumbnail(job, canvas, signal) {
  const wait = (latest.get(job.id) ?? 0) + EVERY - performance.now();
  if (wait > 0 && job.state === "running") {
    await new Promise((over) => setTimeout(over, wait));
    if (signal.aborted) return;
  }
  await inTurn(async () => {
    latest.set(job.id, performance.now());
    try {
      const answer = await ask(`v1/jobs/${job.id}/preview`, { query: { wait: 0 }, signal, priority: "low" });
      const { width, height } = canvas;
      const bitmap = await createImageBitmap(await answer.blob(), { resizeWidth: width, resizeHeight: height, resizeQuality: "medium" });
      bitmaps.made += 1;
      if (!signal.aborted) canvas.getContext("2d")?.drawImage(bitmap, 0, 0);
      bitmap.close();
      bitmaps.closed += 1;
    } catch {
      // No picture yet, or none any more: the row says which.
    }
  }, signal);
}
