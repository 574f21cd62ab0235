// A job in the viewport: its picture so far lies over the scene's, and what is under the pointer is rendered next.
import { computed, effect, html, signal, untracked } from "../../vendor/preact.js";
import { Problem, ask, patiently, pause, whole } from "../api.js";
import { bitmaps, connection, hover, putLayer, removeLayer, size } from "../state.js";
import { Button } from "../ui.js";
import { apart, hasPreview, jobs, revisions, showing } from "./jobs-list.js";
import { inside, isActive, nameOf, stateWords } from "./jobs-model.js";

/** Milliseconds between two pictures, and between two wishes. */
const PICTURES = 500;
const WISHES = 350;
/** Pixels of a finished picture that the page still takes whole. */
const LARGEST = 16_000_000;

/** The job, as the list last knew it. */
const shown = signal(/** @type {import("./jobs-model.js").Job | null} */ (null));
const bitmap = signal(/** @type {ImageBitmap | null} */ (null));
/** The part that was asked for, in pixels of the job. */
const wished = signal(/** @type {{ x: number, y: number, w: number, h: number } | null} */ (null));

/** Shows a job, or none. @param {import("./jobs-model.js").Job | null} job */
export function show(job) {
  shown.value = job;
  showing.value = job?.id ?? "";
}

/** @param {ImageBitmap | null} next */
function put(next) {
  const before = bitmap.peek();
  bitmap.value = next;
  bitmaps.made += next ? 1 : 0;
  if (!before) return;
  before.close();
  bitmaps.closed += 1;
}

/** How the job's picture lies in that of the scene: as large as it goes, in the middle. */
const place = computed(() => {
  const job = shown.value;
  if (!job) return { left: 0, top: 0, scale: 1 };
  const scale = Math.min(size.value.width / job.width, size.value.height / job.height);
  return { left: (size.value.width - job.width * scale) / 2, top: (size.value.height - job.height * scale) / 2, scale };
});

/** @param {CanvasRenderingContext2D} context @param {import("../state.js").View} view */
function draw(context, view) {
  const [job, picture] = [shown.peek(), bitmap.peek()];
  const { left, top, scale } = place.peek();
  if (!job || !picture) return;
  const at = (/** @type {number} */ x, /** @type {number} */ y) => /** @type {[number, number]} */ ([view.left + (left + x * scale) * view.scale, view.top + (top + y * scale) * view.scale]);
  context.imageSmoothingEnabled = picture.width < job.width || view.scale < 1;
  const unit = scale * view.scale;
  // At its end a sequence has a contact sheet, which is of another shape than its frames.
  const box = job.frames ? inside(picture, job) : { x: 0, y: 0, w: job.width, h: job.height };
  const [x, y] = at(box.x, box.y);
  // Beside it the scene's own picture would look like a part of it.
  if (job.frames) context.clearRect(...at(0, 0), job.width * unit, job.height * unit);
  context.drawImage(picture, x, y, box.w * unit, box.h * unit);
  const part = wished.peek();
  if (!part || !isActive(job)) return;
  const [px, py] = at(part.x, part.y);
  for (const [color, dash] of /** @type {[string, number[]][]} */ ([["#000", []], ["#fff", [4, 4]]])) {
    context.strokeStyle = color;
    context.setLineDash(dash);
    context.strokeRect(px + 0.5, py + 0.5, part.w * unit, part.h * unit);
  }
}

/** The newest picture of a job. @param {import("./jobs-model.js").Job} job @param {AbortSignal} signal */
async function load(job, signal) {
  const isWhole = job.state === "succeeded" && job.width * job.height <= LARGEST && job.width <= 16_384;
  try {
    const answer = await patiently(() => ask(isWhole ? `v1/jobs/${job.id}/image` : `v1/jobs/${job.id}/preview`, { query: isWhole ? {} : { wait: 0 }, signal, priority: "low" }), signal);
    if (isWhole && !/^image\/(png|jpeg|webp)/.test(answer.headers.get("content-type") ?? "")) {
      await answer.body?.cancel();
      return load({ ...job, state: "running" }, signal);
    }
    const next = await createImageBitmap(await whole(answer.blob(), signal));
    if (signal.aborted) next.close();
    else put(next);
  } catch (error) {
    // There is none any more, or not for this key; others come with the next event.
    if (!signal.aborted && error instanceof Problem && [401, 403, 404, 410].includes(error.status)) show(null);
  }
}

/** The tile that a pixel of the scene lies in. @param {import("./jobs-model.js").Job} job @param {import("../state.js").Pixel} pixel */
function tileAt(job, pixel) {
  const { left, top, scale } = place.peek();
  const edge = job.tile || 64;
  const [x, y] = [(pixel.x - left) / scale, (pixel.y - top) / scale].map((of) => Math.floor(of / edge) * edge);
  if (x < 0 || y < 0 || x >= job.width || y >= job.height) return null;
  return { x, y, w: Math.min(edge, job.width - x), h: Math.min(edge, job.height - y) };
}

export function start() {
  effect(() => {
    const job = [...jobs.value, apart.value].find((of) => of?.id === showing.value);
    if (job && job !== shown.peek()) shown.value = job;
    if (showing.value === "") shown.value = null;
  });
  // What the service could not send comes when it is back.
  const revision = computed(() => `${connection.value.online} ${showing.value} ${revisions.value.get(showing.value) ?? 0} ${shown.value?.state === "succeeded"} ${(shown.value?.progress.tiles_done ?? 0) > 0}`);
  let last = 0;
  let before = "";
  let taking = new AbortController();
  effect(() => {
    void revision.value;
    const control = new AbortController();
    untracked(async () => {
      const job = shown.peek();
      if (before !== showing.peek()) taking.abort(), (taking = new AbortController()), put(null);
      before = showing.peek();
      if (!job) return put(null);
      if (!hasPreview(job)) return;
      // Not more often than that: tiles come faster than anybody looks.
      const wait = Math.max(0, last + PICTURES - performance.now());
      await pause(wait, control.signal).catch(() => {});
      if (control.signal.aborted) return;
      last = performance.now();
      load(job, taking.signal);
    });
    return () => control.abort();
  });
  // As a word, so that a pointer that moves within a tile changes nothing.
  const wish = computed(() => {
    const [at, job] = [hover.value, shown.value];
    return at && job && isActive(job) ? JSON.stringify(tileAt(job, at)) : "null";
  });
  effect(() => {
    const part = JSON.parse(wish.value);
    const control = new AbortController();
    untracked(async () => {
      const isFirst = wished.peek() === null;
      wished.value = part;
      if (!part) return;
      await pause(isFirst ? 0 : WISHES, control.signal).catch(() => {});
      if (!control.signal.aborted) await ask(`v1/jobs/${showing.peek()}/look`, { method: "POST", query: part, signal: control.signal }).catch(() => {});
    });
    return () => control.abort();
  });
  effect(() => {
    void [wished.value, place.value];
    if (bitmap.value) putLayer({ id: "job", order: 6, draw });
    else removeLayer("job");
  });
}

export function Overlay() {
  const job = shown.value;
  if (!job) return null;
  return html`<div class="job-over"><p class="job-caption"><strong>${nameOf(job)}</strong><span>${stateWords(job)}${isActive(job) ? " · what you point at is rendered next" : ""}</span>
    <${Button} kind="quiet" icon="close" label="Stop showing the job" press=${() => show(null)} /></p></div>`;
}
