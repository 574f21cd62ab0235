// The plan: which effects the scene calls for, why, and what they take; measured beside estimated. EXPLAIN for pictures.
import { effect, html, signal, untracked, useEffect, useRef } from "../../vendor/preact.js";
import { keysOf } from "../pointers.js";
import { wordsOf } from "../problems.js";
import { count, duration } from "../report.js";
import { editAt, openPanel, other, otherAsked, plan, problems, say, scene, settings, shown, status } from "../state.js";
import { Button, Empty, Icon, Pointer } from "../ui.js";
import { failure, isCurrent, measure, measured, measuring, start as startMeasuring, stop } from "./plan-measured.js";
import { hasRays, rowsOf, sentenceOf, titleOf, totalsOf } from "./plan-rows.js";
import { canLeaveOut, without } from "./plan-without.js";

export const id = "plan";
export const title = "Plan";

/** @typedef {import("./plan-rows.js").Row} Row */

/** The rows that show what is behind them. */
const unfolded = signal(/** @type {ReadonlySet<string>} */ (new Set()));
/** The row that the address names. */
const linked = signal("");
const isListed = signal(false);

/** Makes the scene without an effect the other picture. @param {string} name */
function compareWithout(name) {
  const label = `without ${name.replaceAll("_", " ")}`;
  const rest = without(scene.peek(), settings.peek(), name);
  if (!rest) return say(`${titleOf(name)} cannot be left out alone.`);
  otherAsked.value = { label, ...rest };
  say(`B is the scene ${label}.`, { label: "Compare", run: () => openPanel("compare") });
}

/** The words of an address that name a row: `#plan=gloss`, also beside other words. */
const ROW_WORD = /(?:^#?|&)plan=(\w+)/;

function readAddress() {
  const name = ROW_WORD.exec(location.hash)?.[1] ?? "";
  linked.value = name;
  if (name === "") return;
  openPanel("plan");
  unfolded.value = new Set([...unfolded.peek(), name]);
}

/** The address of what is seen now, with a row. @param {string} name */
function addressOf(name) {
  const words = location.hash.slice(1).split("&").filter((word) => word !== "" && !word.startsWith("plan="));
  return `#${[...words, `plan=${name}`].join("&")}`;
}

/** Copies the link: to follow it would load the page's own scene again. @param {MouseEvent} event @param {string} name */
async function copyLink(event, name) {
  if (event.ctrlKey || event.metaKey || event.shiftKey || event.button !== 0) return;
  event.preventDefault();
  linked.value = name;
  try {
    await navigator.clipboard.writeText(new URL(addressOf(name), location.href).href);
    say("The link to this row is copied.");
  } catch {
    say("The browser did not let the link be copied; the menu of the link does.");
  }
}

export function start() {
  startMeasuring();
  readAddress();
  addEventListener("hashchange", readAddress);
  // A row that is not there any more needs no light.
  effect(() => {
    const of = plan.value;
    untracked(() => of && linked.peek() !== "" && !of.effects.some((/** @type {any} */ { effect: name }) => name === linked.peek()) && (linked.value = ""));
  });
}

/** @param {{ row: Row, max: number }} props */
function Bar({ row, max }) {
  const share = (/** @type {number} */ ms) => Math.min(100, (100 * ms) / (max || 1));
  const { ms, took, low, high } = row;
  return html`<span class="plan-bar" aria-hidden="true">
    ${ms !== null && html`<i class="est" style=${{ width: `${share(ms)}%` }}></i>`}
    ${took !== null && html`<i class="act" style=${{ width: `${share(took)}%` }}></i>`}
    ${ms !== null && high > low && html`<i class="whisker" style=${{ left: `${share(low)}%`, width: `${share(high) - share(low)}%` }}></i>`}
  </span>`;
}

/** A pointer for people: "glass › ior". @param {string} pointer */
const pathOf = (pointer) => keysOf(pointer).filter((key, at) => at > 0 || key !== "materials").join(" › ");
/** A short value; a grey is one number. @param {any} value */
const valueOf = (value) => (Array.isArray(value) ? [...new Set(value)].join(", ") : String(value));

/** @param {{ row: Row }} props */
function Details({ row: { name, effect: of } }) {
  const { because, values = {}, act, est } = of;
  const asked = otherAsked.value?.label === `without ${name.replaceAll("_", " ")}`;
  const b = asked ? other.value : null;
  return html`<div class="plan-details">
    ${because.length > 0 && html`<p class="plan-because">${because.map((pointer) => html`<${Pointer} key=${pointer} pointer=${pointer}><bdi>${pathOf(pointer)}</bdi>${pointer in values && html`<span class="quiet">${valueOf(values[pointer])}</span>`}<//>`)}</p>`}
    ${est && hasRays({ ms: est.ms, took: act?.share_ms ?? null }) && html`<p class="quiet">${est.ms !== null && `${duration(est.ms)} and `}${count(est.rays)} rays estimated (${count(est.rays_ci[0])} to ${count(est.rays_ci[1])})${act ? `, ${count(act.rays)} counted` : ""}.${name === "antialiasing" ? " They count among the others, too." : ""}</p>`}
    ${act && act.saves_ms !== null && html`<p>${act.saves_ms >= 0 ? html`Without it the picture would save <strong>${duration(act.saves_ms)}</strong>, by a pilot.` : html`Without it the picture would take <strong>${duration(-act.saves_ms)}</strong> longer, by a pilot.`}</p>`}
    <p class="plan-actions">
      ${of.state === "on" && canLeaveOut(name) && scene.value && html`<${Button} icon="compare" pressed=${asked} press=${() => (asked ? (otherAsked.value = null) : compareWithout(name))}>Without it<//>`}
      <a class="plan-link" href=${addressOf(name)} onClick=${(/** @type {MouseEvent} */ event) => copyLink(event, name)}>Copy link to this row</a></p>
    ${asked && html`<p class="plan-b" role="status">${b && shown.value ? `B took ${duration(b.report.ms)} and ${count(b.report.totalRays)} rays; the scene itself ${duration(shown.value.report.ms)} and ${count(shown.value.report.totalRays)}.` : "B is on its way."}</p>`}
  </div>`;
}

/** @param {{ row: Row, max: number }} props */
function EffectRow({ row, max }) {
  const { name, title: words, effect: of, ms, took, outside } = row;
  const element = useRef(/** @type {HTMLElement | null} */ (null));
  const isOpen = unfolded.value.has(name);
  const isLinked = linked.value === name;
  useEffect(() => {
    if (isLinked) element.current?.scrollIntoView({ block: "nearest" });
  }, [isLinked]);
  const toggle = () => {
    const next = new Set(unfolded.peek());
    if (!next.delete(name)) next.add(name);
    unfolded.value = next;
  };
  const isPart = of.state === "on" && hasRays(row);
  return html`<tr ref=${element} class=${`plan-row ${of.state}${isLinked ? " linked" : ""}`}>
    <th scope="row"><button type="button" class="fold" aria-expanded=${String(isOpen)} onClick=${toggle}>${words}</button></th>
    ${isPart
      ? html`<td class="plan-bar-cell"><${Bar} row=${row} max=${max} /></td><td class="number">${took !== null ? html`<strong>${duration(took)}</strong>` : ms === null ? "–" : duration(ms)}</td>`
      : html`<td colspan="2" class="plan-none">${of.state === "removed" ? "removed: cannot show" : "no rays of its own"}</td>`}
  </tr><tr class=${`plan-more${isLinked ? " linked" : ""}`}><td colspan="3"><span class="plan-reason">${of.reason}</span>
    ${outside !== "" && html`<span class="tag outside"><${Icon} name="warning" />${outside} rays</span>`}
    ${isOpen && html`<${Details} row=${row} />`}</td></tr>`;
}

/** @param {{ of: any, by: any }} props */
function Totals({ of, by }) {
  const totals = totalsOf(of, by);
  if (totals.length === 0) return null;
  return html`<table class="plan-totals"><caption class="hidden-visually">Estimate and measurement of the picture</caption>
    <thead><tr><td></td><th scope="col" class="number">estimated</th><th scope="col" class="number">19 of 20 times</th>${by && html`<th scope="col" class="number">measured</th>`}</tr></thead>
    <tbody>${totals.map(({ name, estimate, interval, actual, isOutside }) => html`<tr key=${name}><th scope="row">${name}</th><td class="number">${estimate}</td><td class="number quiet">${interval}</td>
      ${by && html`<td class="number"><strong>${actual}</strong>${isOutside && html` <span class="tag outside"><${Icon} name="warning" />outside</span>`}</td>`}</tr>`)}</tbody></table>`;
}

/** @param {{ of: any, by: any }} props */
function Foot({ of, by }) {
  const depth = by?.depth ?? of.depth;
  const enough = depth.proved_sufficient;
  const names = (/** @type {string[]} */ list) => list.map((name) => html`<span key=${name} class="chip">${name.toLowerCase().replaceAll("_", " ")}</span>`);
  return html`<dl class="plan-foot">
    <div><dt>Depth</dt><dd>${depth.why.charAt(0).toUpperCase() + depth.why.slice(1)}.${depth.requested !== null && html` The scene asks for ${depth.requested}.`}
      ${depth.reached !== null && html` The longest chain had ${depth.reached} rays.`}
      ${depth.because.length > 0 && html`<br />${depth.because.slice(0, 6).map((/** @type {string} */ pointer) => html`<${Pointer} key=${pointer} pointer=${pointer}><bdi>${pathOf(pointer)}</bdi><//>`)}`}
      ${enough !== null && enough !== depth.requested && scene.value && html`<br /><${Button} press=${() => editAt("/render/max_depth", enough)}>Set depth ${enough}<//>`}</dd></div>
    <div><dt>Kernel</dt><dd>${names(of.kernel.split("|"))} <span class="quiet">in ${of.precision} precision, <code>${of.kernel_hash}</code></span>
      ${of.superset_of_needed.length > 0 && html`<br /><span class="quiet">Not needed by this scene:</span> ${names(of.superset_of_needed)}`}</dd></div>
    ${of.overlap > 0 && html`<div><dt>Overlap</dt><dd class="quiet">Up to ${Math.round(of.overlap)} primitives lie around one point.</dd></div>`}
    <div><dt>Not simulated</dt><dd>${names(of.not_simulated)}</dd></div>
  </dl>`;
}

/** @param {{ of: any }} props */
const Warnings = ({ of }) => of.warnings.length > 0 && html`<ul class="plan-warnings">${of.warnings.map((/** @type {any} */ { pointer, detail }, /** @type {number} */ at) => html`<li key=${at}><${Icon} name="warning" /><span>${detail} ${pointer && html`<${Pointer} pointer=${pointer} />`}</span></li>`)}</ul>`;

function Measure() {
  if (measuring.value) return html`<p class="plan-measure" role="status"><span class="spinner" aria-hidden="true"></span><span class="grow">${measuring.value.waiting > 0 ? `The service is busy; again in ${measuring.value.waiting} s` : "Rendering to measure …"}</span><${Button} press=${stop}>Stop<//></p>`;
  const isOld = measured.value !== null && !isCurrent();
  return html`<p class="plan-measure"><span class="grow quiet">${isCurrent() ? "Measured: thin bars are estimates, thick ones what it took." : isOld ? "Measured before the last edit." : "Estimates come from a pilot of a few milliseconds."}</span>
    <${Button} press=${measure} title="EXPLAIN ANALYZE: render it once and count">${isOld || isCurrent() ? "Measure again" : "Measure"}<//></p>
    ${failure.value !== "" && html`<p class="panel-state failed" role="status"><${Icon} name="warning" /><span>It was not measured: ${failure.value}</span></p>`}`;
}

export function Panel() {
  const of = plan.value;
  if (!of) {
    if (problems.value.length > 0) return html`<${Empty} title="No plan"><p>The scene has to be sound first: ${wordsOf(problems.value[0])}</p><//>`;
    if (status.value.word === "offline") return html`<${Empty} title="No plan"><p>The service does not answer.</p><//>`;
    return html`<div class="skeleton" role="status" aria-label="The plan comes with the first picture"><i></i><i></i><i></i><i></i></div>`;
  }
  const by = isCurrent() ? measured.value?.plan : null;
  const rows = rowsOf(of, by);
  const max = Math.max(...rows.map(({ ms, took }) => Math.max(ms ?? 0, took ?? 0)));
  const off = of.effects.filter((/** @type {any} */ { state }) => state === "off");
  const isStale = problems.value.length > 0;
  return html`<div class=${isStale ? "plan-body stale" : "plan-body"}>
    <p class="lead">${sentenceOf(of, rows, by)}</p>
    ${isStale && html`<p class="panel-state invalid" role="status"><${Icon} name="warning" /><span>This is the plan of the last sound text.</span></p>`}
    <${Warnings} of=${of} />
    <${Totals} of=${of} by=${by} />
    <${Measure} />
    <table class="plan-table"><caption class="hidden-visually">Effects by time</caption>
      <thead class="hidden-visually"><tr><th scope="col">Effect</th><th scope="col">Time as a bar</th><th scope="col">Milliseconds</th></tr></thead>
      <tbody>${rows.map((row) => html`<${EffectRow} key=${row.name} row=${row} max=${max} />`)}</tbody></table>
    <p><button type="button" class="fold quiet" aria-expanded=${String(isListed.value)} onClick=${() => (isListed.value = !isListed.value)}>${off.length} effects are off</button></p>
    ${isListed.value && html`<ul class="plan-off">${off.map((/** @type {any} */ { effect: name, reason }) => html`<li key=${name}><strong>${titleOf(name)}</strong> <span class="quiet">${reason}</span></li>`)}</ul>`}
    <${Foot} of=${of} by=${by} />
  </div>`;
}
