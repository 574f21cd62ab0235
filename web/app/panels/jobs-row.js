// One job of the list: its picture so far, what it does, and what can be done with it.
import { html, signal, useEffect, useRef, useState } from "../../vendor/preact.js";
import { Problem, address, askJson, askText } from "../api.js";
import { count, duration } from "../report.js";
import { openSoon } from "../scenes.js";
import { copy } from "../share.js";
import { say } from "../state.js";
import { Button, Icon } from "../ui.js";
import { end, hasPreview, pending, prioritise, revisions, setFilter, showing, takeBack, updated } from "./jobs-list.js";
import { isActive, nameOf, stateWords, visible } from "./jobs-model.js";
import { show } from "./jobs-show.js";
import { thumbnail } from "./jobs-thumbs.js";

/** @typedef {import("./jobs-model.js").Job} Job */

/** The picture so far, while the row is in sight. @param {{ job: Job }} props */
function Thumb({ job }) {
  const canvas = useRef(/** @type {HTMLCanvasElement | null} */ (null));
  const [isNear, setNear] = useState(false);
  const revision = `${revisions.value.get(job.id) ?? 0} ${job.state}`;
  useEffect(() => {
    const seen = new IntersectionObserver(([entry]) => setNear(entry.isIntersecting), { rootMargin: "80px" });
    seen.observe(/** @type {HTMLCanvasElement} */ (canvas.current));
    return () => seen.disconnect();
  }, []);
  useEffect(() => {
    if (!isNear || !hasPreview(job)) return;
    const control = new AbortController();
    thumbnail(job, /** @type {HTMLCanvasElement} */ (canvas.current), control.signal);
    return () => control.abort();
  }, [isNear, revision]);
  return html`<canvas ref=${canvas} class="job-thumb" width="176" height=${Math.max(40, Math.min(176, Math.round((176 * job.height) / job.width)))} aria-hidden="true"></canvas>`;
}

/** The time of today, else the day. @param {Date} at */
const moment = (at) => (at.toDateString() === new Date().toDateString() ? at.toLocaleTimeString([], { hour: "2-digit", minute: "2-digit" }) : at.toLocaleDateString([], { month: "short", day: "numeric" }));

/** Time that is left, counted down between two answers. @param {{ job: Job }} props */
function Left({ job }) {
  const [now, setNow] = useState(performance.now());
  useEffect(() => {
    const timer = setInterval(() => setNow(performance.now()), 1000);
    return () => clearInterval(timer);
  }, []);
  if (job.eta_ms === null) return html`<span>${job.state === "queued" ? "waits for its turn" : ""}</span>`;
  return html`<span>about ${duration(Math.max(0, job.eta_ms - Math.max(0, now - updated.value)))} left</span>`;
}

/** @param {Job} job */
async function openScene(job) {
  if (!job.scene_id) return say("The scene of this job has no id: it depends on files, or on a clock.");
  try {
    const source = askText(`v1/scenes/${job.scene_id}/source`).catch((error) => {
      if (error instanceof Problem && error.status === 404) return askText(`v1/scenes/${job.scene_id}`);
      throw error;
    });
    await openSoon(source, nameOf(job));
  } catch (error) {
    say(/** @type {Error} */ (error).message);
  }
}

/** @param {{ job: Job }} props */
function Priority({ job }) {
  // Presses within a moment are one change.
  const [wanted, setWanted] = useState(/** @type {number | null} */ (null));
  useEffect(() => {
    if (wanted === null) return;
    const timer = setTimeout(() => prioritise(job, wanted).finally(() => setWanted(null)), 350);
    return () => clearTimeout(timer);
  }, [wanted]);
  const now = wanted ?? job.priority;
  const step = (/** @type {number} */ by) => () => setWanted(Math.max(0, Math.min(100, now + by)));
  return html`<span class="stepper" role="group" aria-label=${`Priority of ${nameOf(job)}`}><span class="quiet" aria-hidden="true">Priority</span>
    <${Button} label="Lower priority" icon="minus" kind="quiet" disabled=${now === 0} press=${step(-10)} /><output class="priority">${now}</output>
    <${Button} label="Higher priority" icon="plus" kind="quiet" disabled=${now === 100} press=${step(10)} /></span>`;
}

const LIFETIMES = /** @type {[string, number][]} */ ([["an hour", 3600], ["a day", 86_400], ["a week", 604_800]]);

/** A link that needs no key. @param {{ job: Job, close: () => void }} props */
function ShareJob({ job, close }) {
  const [made, setMade] = useState(/** @type {{ url: string, until: string } | null} */ (null));
  const [error, setError] = useState("");
  const make = async (/** @type {number} */ ttl) => {
    setError("");
    try {
      const { prefix, expires } = await askJson("v1/capabilities", { body: JSON.stringify({ job_id: job.id, ttl }), type: "application/json" });
      const url = String(address(`${prefix}/v1/jobs/${job.id}/${job.state === "succeeded" ? "image" : "preview"}`));
      setMade({ url, until: new Date(expires * 1000).toLocaleString() });
    } catch (failure) {
      setError(/** @type {Error} */ (failure).message);
    }
  };
  return html`<div class="job-share">
    ${made ? html`<label>Link to the picture<input class="field" readonly value=${made.url} onFocus=${(/** @type {any} */ event) => event.target.select()} /></label>
      <p class="quiet">It opens this picture and nothing else, without a key, until ${made.until}.</p><p class="actions"><${Button} icon="copy" press=${() => copy(made.url, "The link")}>Copy<//><${Button} kind="quiet" press=${close}>Done<//></p>`
    : html`<p class="quiet">A link to this picture that needs no key, for</p><p class="actions">${LIFETIMES.map(([name, ttl]) => html`<${Button} key=${ttl} press=${() => make(ttl)}>${name}<//>`)}<${Button} kind="quiet" press=${close}>Cancel<//></p>`}
    ${error && html`<p class="bad" role="alert">${error}</p>`}</div>`;
}

/** @type {Record<string, import("../ui.js").IconName>} */
const ICONS = { queued: "more", running: "play", succeeded: "check", failed: "warning", canceled: "close", expired: "close" };
/** The row whose link is being made. */
const sharing = signal("");

/** @param {{ job: Job }} props */
export function Row({ job }) {
  const what = pending.value.get(job.id);
  const isShown = showing.value === job.id;
  const active = isActive(job);
  const name = nameOf(job);
  const hasPicture = hasPreview(job);
  const made = new Date(job.created_at);
  return html`<li class=${`job is-${job.state}${isShown ? " is-shown" : ""}`} tabindex="-1" data-job=${job.id} aria-label=${`${name}, ${stateWords(job)}`}>
    <button type="button" class="job-picture" disabled=${!hasPicture} aria-pressed=${String(isShown)} onClick=${() => show(isShown ? null : job)} aria-label=${isShown ? `Stop showing ${name}` : `Show ${name} in the viewport`}><${Thumb} job=${job} /></button>
    <div class="job-main">
      <p class="job-head"><strong class="job-name" title=${name}>${name}</strong><span class="job-state"><${Icon} name=${ICONS[job.state]} />${stateWords(job)}</span></p>
      ${active && html`<progress max="1" value=${job.state === "queued" && job.progress.fraction === 0 ? 0 : job.progress.fraction} aria-label=${`Progress of ${name}`}></progress>`}
      <p class="quiet job-about"><span>${job.width} × ${job.height}</span>${active ? html`<${Left} job=${job} />` : job.stats.rays > 0 && html`${job.stats.render_ms > 0 && html`<span>${duration(job.stats.render_ms)}</span>`}<span>${count(job.stats.rays)} rays</span>`}
        <time datetime=${job.created_at} title=${made.toLocaleString()}>${moment(made)}</time>
        ${job.stats.reused && html`<span>known already</span>`}${job.stats.tiles_recovered > 0 && html`<span>${job.stats.tiles_recovered} tiles from before a restart</span>`}</p>
      ${job.labels.length > 1 && html`<p class="job-labels">${job.labels.slice(1).map((label) => html`<button type="button" class="label" key=${label} title=${`Only jobs with the label ${visible(label)}`} onClick=${() => setFilter({ label })}>${visible(label)}</button>`)}</p>`}
      ${job.problem && html`<p class="bad job-problem">${visible(job.problem.detail || job.problem.title)}</p>`}
    </div>
    <div class="job-actions">
      ${what ? html`<span role="status">${what === "cancel" ? "Is canceled" : "Is deleted"} in 5 s</span><${Button} icon="undo" press=${() => takeBack(job.id)}>Keep it<//>`
      : html`${active && html`<${Priority} job=${job} />`}
        ${job.scene_id && html`<${Button} kind="quiet" press=${() => openScene(job)} title="Opens its scene in the editor">Open<//>`}
        ${hasPicture && html`<${Button} kind="quiet" press=${() => (sharing.value = sharing.value === job.id ? "" : job.id)}>Share<//>`}
        ${active ? html`<${Button} kind="quiet" press=${() => end(job, "cancel")}>Cancel<//>` : html`<${Button} kind="quiet" press=${() => end(job, "delete")}>Delete<//>`}`}
    </div>
    ${sharing.value === job.id && html`<${ShareJob} job=${job} close=${() => (sharing.value = "")} />`}
  </li>`;
}
