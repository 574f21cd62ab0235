// The list of jobs: one page of it, kept true by one stream of events while somebody looks, else by asking every five seconds.
import { batch, computed, effect, signal, untracked } from "../../vendor/preact.js";
import { Problem, Unreachable, ask, askJson, patiently } from "../api.js";
import { follow } from "../sse.js";
import { connection, key, panel, say } from "../state.js";
import { after, filterOf, isActive, nameOf, withFilter } from "./jobs-model.js";

/** @typedef {import("./jobs-model.js").Job} Job */

const PAGE = 50;
const EVERY = 5000;
/** A stream tells at once; then the list is asked for only to see what no event tells. */
const RARELY = 20_000;
/** Jobs of a stream that names them. */
const MOST = 32;
/** Milliseconds in which something that was canceled can be taken back. */
export const UNDO = 5000;

export const jobs = signal(/** @type {Job[]} */ ([]));
/** When the list was last true, by `performance.now()`; 0: never. */
export const updated = signal(0);
export const trouble = signal("");
export const isLoading = signal(false);
export const filter = signal(filterOf(new URL(location.href)));
/** Cursors of the pages before this one, and of the next. */
export const pages = signal(/** @type {{ before: string[], next: string | null }} */ ({ before: [], next: null }));
/** The job that is shown in the viewport, or "". */
export const showing = signal("");
/** What will be sent in a moment. */
export const pending = signal(/** @type {Map<string, "cancel" | "delete">} */ (new Map()));
/** That job, if it is not on the page of the list. */
export const apart = signal(/** @type {Job | null} */ (null));
/** Numbers of previews by job: another one is another picture. */
export const revisions = signal(/** @type {Map<string, number>} */ (new Map()));
/** The key that was refused, until there is another: asking again would only open its dialog again. */
const refused = signal(/** @type {string | null} */ (null));
const isVisible = signal(document.visibilityState === "visible");
/** Whether somebody looks: at the list, or at a job in the viewport. */
const isWatched = computed(() => isVisible.value && connection.value.online && refused.value !== key.value && (panel.value === "jobs" || showing.value !== ""));

let loading = new AbortController();
/** The service has said when to come back. */
let notBefore = 0;
/** Asks for the page that is shown. */
export async function load() {
  loading.abort();
  loading = new AbortController();
  const { signal: ended } = loading;
  const { state, label } = filter.peek();
  isLoading.value = true;
  try {
    const answer = await askJson("v1/jobs", { query: { limit: PAGE, state: state || undefined, label: label || undefined, cursor: pages.peek().before.at(-1) }, signal: ended });
    batch(() => {
      jobs.value = answer.jobs;
      pages.value = { ...pages.peek(), next: answer.next };
      updated.value = performance.now();
      trouble.value = "";
      isLoading.value = false;
    });
    lookAfterShown();
  } catch (error) {
    if (ended.aborted) return;
    batch(() => ((isLoading.value = false), (trouble.value = error instanceof Unreachable ? "The service does not answer; jobs go on without this page." : /** @type {Error} */ (error).message)));
    if (!(error instanceof Problem)) return;
    if (error.status === 401 || error.status === 403) refused.value = key.peek();
    notBefore = performance.now() + error.retryAfter * 1000;
  }
}

/** Asks for the job in the viewport if it is not on the page of the list: it may be on another one, or gone. */
async function lookAfterShown() {
  const id = showing.peek();
  if (id === "" || jobs.peek().some((job) => job.id === id)) return;
  try {
    apart.value = await askJson(`v1/jobs/${id}`);
  } catch (error) {
    if (error instanceof Problem && (error.status === 404 || error.status === 410)) leave(id);
  }
}

/** Stops showing a job that the service does not have any more. @param {string} id */
function leave(id) {
  if (showing.peek() !== id) return;
  showing.value = "";
  say("The job in the viewport was deleted.");
}

let soon = 0;
/** Asks once for however many events; also when the stream of all jobs, which cannot be continued, opens again. */
const loadSoon = () => (soon ||= window.setTimeout(() => ((soon = 0), load()), 700));

/** @param {Partial<{ state: string, label: string }>} change */
export function setFilter(change) {
  batch(() => {
    filter.value = { ...filter.peek(), ...change };
    pages.value = { before: [], next: null };
  });
  history.replaceState(null, "", withFilter(new URL(location.href), filter.peek()));
  load();
}

/** @param {1 | -1} by */
export function turn(by) {
  const { before, next } = pages.peek();
  pages.value = { before: by > 0 && next ? [...before, next] : before.slice(0, -1), next: null };
  load();
}

/** Whether there is a picture of a job so far: a first coarse one comes before the first tile. @param {Job} job */
export const hasPreview = (job) => job.state === "succeeded" || (job.state !== "expired" && (job.progress.tiles_done > 0 || (isActive(job) && revisions.value.has(job.id))));

/** @param {import("../sse.js").ServerEvent} event */
function take({ event, data }) {
  if (event === "shutdown") return;
  if (event === "removed") leave(data.job);
  const isPicture = event === "preview" || event === "tile" || event === "succeeded" || (event === "snapshot" && data.revision > 1);
  if (isPicture) revisions.value = new Map(revisions.peek()).set(data.job, (revisions.peek().get(data.job) ?? 0) + 1);
  const next = after(jobs.peek(), event, data);
  if (next) batch(() => ((jobs.value = next), (updated.value = performance.now())));
  else loadSoon();
}

/** Whether the service tells of all jobs in one stream: null until it is known. */
let tellsAll = /** @type {boolean | null} */ (null);
/** Jobs of the stream, as a word, so that it is opened again only when they are others. */
const streamed = computed(() => [...new Set([showing.value, ...jobs.value.filter(isActive).map(({ id }) => id)])].filter(Boolean).slice(0, MOST).join(" "));

const isKnown = computed(() => updated.value > 0);

/** @param {AbortSignal} signal */
async function watch(signal) {
  if (tellsAll !== false) {
    try {
      return await follow("v1/events", { signal, take, opened: () => void ((tellsAll = true), loadSoon()) });
    } catch (error) {
      if (signal.aborted || !(error instanceof Problem) || ![400, 404].includes(error.status)) throw error;
      tellsAll = false;
    }
  }
  if (streamed.peek() !== "") await follow("v1/events", { jobs: streamed.peek().split(" "), signal, take });
}

/** Changes of the priority as the service numbers them. */
const tags = /** @type {Map<string, string>} */ (new Map());

/** Changes a priority, unless somebody else has. @param {Job} job @param {number} priority */
export async function prioritise(job, priority) {
  const path = `v1/jobs/${job.id}`;
  const put = (/** @type {Job} */ now) => (jobs.value = jobs.peek().map((of) => (of.id === now.id ? now : of)));
  const newest = async () => {
    const answer = await ask(path, { accept: "application/json" });
    tags.set(job.id, answer.headers.get("etag") ?? "");
    return /** @type {Promise<Job>} */ (answer.json());
  };
  try {
    if (!tags.has(job.id)) {
      const now = await newest();
      if (now.priority !== job.priority) {
        put(now);
        return say(`The priority of ${nameOf(job)} is ${now.priority} now: somebody else has changed it.`);
      }
    }
    const headers = { "if-match": /** @type {string} */ (tags.get(job.id)) };
    const answer = await ask(path, { method: "PATCH", body: JSON.stringify({ priority }), type: "application/merge-patch+json", headers, accept: "application/json" });
    tags.set(job.id, answer.headers.get("etag") ?? "");
    put(await answer.json());
    loadSoon();
  } catch (error) {
    if (!(error instanceof Problem) || error.status !== 412) return say(/** @type {Error} */ (error).message);
    const now = await newest().catch(() => null);
    if (now) put(now);
    say(now ? `Somebody else has changed ${nameOf(job)}: its priority is ${now.priority} now.` : error.message);
  }
}

/** @param {string} id @param {"cancel" | "delete" | null} what */
function mark(id, what) {
  const next = new Map(pending.peek());
  if (what) next.set(id, what);
  else next.delete(id);
  pending.value = next;
}

/** Cancels or deletes a job in five seconds, if it is not taken back. @param {Job} job @param {"cancel" | "delete"} what */
export function end(job, what) {
  mark(job.id, what);
  const timer = setTimeout(async () => {
    try {
      // A job that goes on costs: one that is busy is asked again.
      await patiently(() => ask(`v1/jobs/${job.id}${what === "cancel" ? "/cancel" : ""}`, { method: what === "cancel" ? "POST" : "DELETE" }));
      if (what === "delete") batch(() => (leave(job.id), (jobs.value = jobs.peek().filter(({ id }) => id !== job.id))));
    } catch (error) {
      say(`${nameOf(job)}: ${/** @type {Error} */ (error).message}`);
    }
    mark(job.id, null);
    loadSoon();
  }, UNDO);
  undo.set(job.id, () => (clearTimeout(timer), mark(job.id, null)));
}
const undo = /** @type {Map<string, () => void>} */ (new Map());
/** @param {string} id */
export const takeBack = (id) => undo.get(id)?.();

export function start() {
  document.addEventListener("visibilitychange", () => (isVisible.value = document.visibilityState === "visible"));
  effect(() => {
    // Another key sees other jobs.
    void key.value;
    if (!isWatched.value) return;
    untracked(load);
    const isDue = () => performance.now() >= notBefore && (!tellsAll || performance.now() - updated.peek() >= RARELY);
    const timer = setInterval(() => isDue() && load(), EVERY);
    return () => clearInterval(timer);
  });
  effect(() => {
    const ids = tellsAll === true ? "" : streamed.value;
    if (!isWatched.value || !isKnown.value || (tellsAll === false && ids === "")) return;
    const control = new AbortController();
    untracked(() => watch(control.signal).catch(() => {}));
    return () => control.abort();
  });
}
