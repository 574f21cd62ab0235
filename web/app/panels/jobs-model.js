// Jobs as the service tells of them, and what its events change. Pure.

/** @typedef {"queued" | "running" | "succeeded" | "failed" | "canceled" | "expired"} JobState */
/**
 * @typedef {{ id: string, state: JobState, progress: { fraction: number, tiles_done: number, tiles_total: number, rays: number },
 *   position: number | null, eta_ms: number | null, estimate_ms: number, priority: number, labels: string[], width: number,
 *   height: number, tile: number, scene_id: string | null, image_id: string | null,
 *   frames?: { count: number, done: number }, created_at: string, started_at: string | null, finished_at: string | null,
 *   expires_at: string | null, problem?: { detail: string, title: string } | null,
 *   stats: { rays: number, render_ms: number, tiles_recovered: number, reused: boolean } }} Job
 * `frames`: of a sequence
 */

/** How a picture of another shape lies in a canvas: as large as it goes, in the middle. @param {{ width: number, height: number }} picture @param {{ width: number, height: number }} canvas */
export function inside(picture, canvas) {
  const fit = Math.min(canvas.width / picture.width, canvas.height / picture.height);
  const [w, h] = [picture.width * fit, picture.height * fit];
  return { x: (canvas.width - w) / 2, y: (canvas.height - h) / 2, w, h };
}

/** @type {Record<JobState, string>} */
export const STATES = { queued: "waiting", running: "running", succeeded: "done", failed: "failed", canceled: "canceled", expired: "expired" };
export const isActive = (/** @type {Job} */ { state }) => state === "queued" || state === "running";

/** Text of strangers without what turns the reading direction around, or is not seen at all. @param {string} words */
export const visible = (words) => words.replace(/[\p{Cc}\p{Cf}\p{Zl}\p{Zp}]/gu, "\ufffd");

/** What people call it: its first label, else the end of its id. @param {Job} job */
export const nameOf = ({ id, labels }) => (labels[0] === undefined ? `job ${id.slice(-6)}` : visible(labels[0]));

/** The state in words, with the place in line. @param {Job} job */
export function stateWords({ state, position, progress }) {
  if (state === "queued") return position === null ? "waiting" : position === 1 ? "next in line" : `${position - 1} ahead`;
  return state === "running" ? `${Math.floor(100 * progress.fraction)} %` : STATES[state];
}

/**
 * A list after an event. Null if the list has to be asked for again.
 * @param {Job[]} jobs @param {string} event @param {any} data @returns {Job[] | null}
 */
export function after(jobs, event, data) {
  const at = jobs.findIndex(({ id }) => id === data?.job);
  if (event === "created" || event === "removed" || event === "queued") return null;
  if (at < 0) return jobs;
  const job = jobs[at];
  const change = (/** @type {Partial<Job>} */ next) => jobs.with(at, { ...job, ...next });
  if (event === "tile" || event === "progress" || event === "snapshot") {
    const { tiles_done: done = job.progress.tiles_done, tiles_total: total = job.progress.tiles_total } = data;
    const state = event === "snapshot" && data.state ? data.state : event === "tile" ? "running" : job.state;
    if (state !== job.state) return null;
    const fraction = typeof data.fraction === "number" ? data.fraction : total > 0 ? done / total : job.progress.fraction;
    return change({ progress: { ...job.progress, tiles_done: done, tiles_total: total, fraction: Math.max(fraction, job.progress.fraction) }, eta_ms: data.eta_ms ?? job.eta_ms });
  }
  return event === "preview" ? jobs : null;
}

/** How long ago, for people. @param {number} ms */
export function ago(ms) {
  const seconds = Math.max(0, Math.round(ms / 1000));
  if (seconds < 60) return `${seconds} s ago`;
  if (seconds < 3600) return `${Math.floor(seconds / 60)} min ago`;
  return seconds < 86_400 ? `${Math.floor(seconds / 3600)} h ago` : `${Math.floor(seconds / 86_400)} d ago`;
}

/** Labels as people write them, between commas. The service takes 16 of 64 letters. @param {string} words */
export const labelsOf = (words) => [...new Set(words.split(",").map((word) => Array.from(word.trim()).slice(0, 64).join("")).filter(Boolean))].slice(0, 16);

/** The body of a submission: the scene goes as it is written, so that problems name its lines. @param {string} scene @param {any} rest */
export const submission = (scene, rest) => `{"scene":${scene.trim()},${JSON.stringify(rest).slice(1)}`;

/** The filter in an address. @param {URL} url */
export function filterOf(url) {
  const state = url.searchParams.get("state") ?? "";
  return { state: Object.hasOwn(STATES, state) ? state : "", label: (url.searchParams.get("label") ?? "").slice(0, 64) };
}

/** An address with a filter. @param {URL} url @param {{ state: string, label: string }} filter */
export function withFilter(url, filter) {
  const next = new URL(url);
  for (const [name, value] of Object.entries(filter)) value === "" ? next.searchParams.delete(name) : next.searchParams.set(name, value);
  return next;
}
