// Jobs: pictures that the service renders while one does something else.
import { effect, html, signal, untracked, useEffect, useState } from "../../vendor/preact.js";
import { address } from "../api.js";
import { more } from "../commands.js";
import { copy } from "../share.js";
import { connection, key, offer, panel, problems, status, text } from "../state.js";
import { Button, Empty } from "../ui.js";
import { filter, isLoading, jobs, load, pages, setFilter, start as watch, trouble, turn, updated } from "./jobs-list.js";
import { STATES, ago } from "./jobs-model.js";
import { Row } from "./jobs-row.js";
import { start as startShowing } from "./jobs-show.js";
import { Submit } from "./jobs-submit.js";
import { Failure } from "./widgets.js";

export { Overlay } from "./jobs-show.js";

export const id = "jobs";
export const title = "Jobs";

const isSubmitting = signal(false);

/** Moves the focus to the next row, or the one before. @param {1 | -1} by */
function step(by) {
  if (panel.peek() !== "jobs") return;
  const rows = /** @type {HTMLElement[]} */ ([...document.querySelectorAll(".job")]);
  const at = rows.findIndex((row) => row.contains(document.activeElement));
  rows[Math.max(0, Math.min(rows.length - 1, at + by))]?.focus();
}

export function start() {
  watch();
  startShowing();
  more.value = [
    ...more.peek(),
    { title: "Render as a job", keys: "N", run: () => ((panel.value = "jobs"), (isSubmitting.value = true)) },
    { title: "Jobs: ask again", keys: "R", run: () => panel.peek() === "jobs" && load() },
    { title: "Jobs: next", keys: "J", run: () => step(1) },
    { title: "Jobs: the one before", keys: "K", run: () => step(-1) },
  ];
  // Who comes for a long picture finds the dialog.
  effect(() => {
    if (panel.value === "jobs") untracked(() => (offer.peek() !== null || status.peek().job) && (isSubmitting.value = true));
  });
}

export function Panel() {
  return html`<div class="jobs">
    <div class="jobs-head"><${Button} kind="main" icon="plus" keys="N" disabled=${text.value === "" || problems.value.length > 0} press=${() => (isSubmitting.value = true)} title="Render this scene as a job">New job<//>
      <${Updated} /><${Button} kind="quiet" keys="R" press=${load} title="Ask again">Reload<//></div>
    <${Filter} />
    ${trouble.value !== "" && html`<${Failure} error=${trouble.value} retry=${load} />`}
    ${jobs.value.length > 0 ? html`<ul class=${`plain-list job-list${trouble.value !== "" || !connection.value.online ? " is-stale" : ""}`} aria-label="Jobs">${jobs.value.map((job) => html`<${Row} key=${job.id} job=${job} />`)}</ul>`
      : updated.value > 0 && trouble.value === "" ? html`<${None} />` : trouble.value === "" ? html`<ul class="plain-list" aria-hidden="true">${[1, 2, 3].map((n) => html`<li key=${n} class="job is-ghost"><span class="ghost"></span></li>`)}</ul>` : ""}
    <${Pages} />
    ${isSubmitting.value && html`<${Submit} close=${() => (isSubmitting.value = false)} />`}
  </div>`;
}

/** How old the list is. */
function Updated() {
  const [now, setNow] = useState(performance.now());
  useEffect(() => {
    const timer = setInterval(() => setNow(performance.now()), 1000);
    return () => clearInterval(timer);
  }, []);
  if (!connection.value.online) return html`<span class="jobs-updated stale-note" role="status">offline${updated.value === 0 ? "" : `, as of ${ago(Math.max(0, now - updated.value))}`}</span>`;
  return html`<span class="quiet jobs-updated">${updated.value === 0 ? (isLoading.value ? "loading …" : "") : `updated ${ago(Math.max(0, now - updated.value))}`}</span>`;
}

function Filter() {
  const { state, label } = filter.value;
  if (jobs.value.length === 0 && state === "" && label === "") return null;
  return html`<div class="filter"><label class="hidden-visually" for="jobs-state">State</label>
    <select id="jobs-state" value=${state} onChange=${(/** @type {any} */ event) => setFilter({ state: event.target.value })}><option value="">All states</option>${Object.entries(STATES).map(([name, word]) => html`<option key=${name} value=${name}>${word}</option>`)}</select>
    <label class="hidden-visually" for="jobs-label">Label</label>
    <input id="jobs-label" placeholder="label" value=${label} onChange=${(/** @type {any} */ event) => setFilter({ label: event.target.value.trim() })} />
    ${(state !== "" || label !== "") && html`<${Button} kind="quiet" press=${() => setFilter({ state: "", label: "" })}>All<//>`}</div>`;
}

function None() {
  const { state, label } = filter.value;
  if (state !== "" || label !== "") return html`<${Empty} title="No such job">None is ${state === "" ? "" : STATES[/** @type {import("./jobs-model.js").JobState} */ (state)]}${label === "" ? "" : ` labeled “${label}”`}.<//>`;
  const secret = key.value === "" ? "" : ' -H "Authorization: Bearer $STRAHL_KEY"';
  const line = `(echo '{"scene":'; cat scene.json; echo '}') | curl -sS${secret} ${address("v1/jobs")} --data-binary @-`;
  return html`<${Empty} title="No jobs">A job renders in the background: large pictures, many samples. It goes on when this page is closed.<//>
    <p class="quiet">From a shell:</p><pre class="curl"><code>${line}</code></pre><p><${Button} icon="copy" press=${() => copy(line, "The line")}>Copy<//></p>`;
}

/** Another page begins at its top. @param {1 | -1} by */
function leaf(by) {
  turn(by);
  document.querySelector(".jobs-head")?.scrollIntoView({ block: "end" });
}

function Pages() {
  const { before, next } = pages.value;
  if (before.length === 0 && !next) return null;
  return html`<nav class="pages" aria-label="Pages of jobs"><${Button} disabled=${before.length === 0} press=${() => leaf(-1)}>Newer<//><span class="quiet">Page ${before.length + 1}</span><${Button} disabled=${!next} press=${() => leaf(1)}>Older<//></nav>`;
}
