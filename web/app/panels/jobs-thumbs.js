// Small pictures of jobs: three at a time, drawn into the canvas of their row and closed.
import { askBlob, patiently } from "../api.js";
import { bitmaps } from "../state.js";
import { inside } from "./jobs-model.js";

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
      const blob = await patiently(() => askBlob(`v1/jobs/${job.id}/preview`, { query: { wait: 0 }, signal, priority: "low" }), signal);
      const bitmap = await createImageBitmap(blob);
      bitmaps.made += 1;
      const context = canvas.getContext("2d");
      if (!signal.aborted && context) {
        // The contact sheet of a sequence is of another shape.
        const { x, y, w, h } = job.frames ? inside(bitmap, canvas) : { x: 0, y: 0, w: canvas.width, h: canvas.height };
        context.imageSmoothingQuality = "high";
        context.clearRect(0, 0, canvas.width, canvas.height);
        context.drawImage(bitmap, x, y, w, h);
      }
      bitmap.close();
      bitmaps.closed += 1;
    } catch {
      // No picture yet, or none any more: the row says which.
    }
  }, signal);
}
