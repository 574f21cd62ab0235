// What accuracy costs: the dial with predictions and receipts, the trade-off, and the stamp of equal bytes.
import { batch, html } from "../../vendor/preact.js";
import { count, duration } from "../report.js";
import { editAt, otherAsked, problems, reference, say, setText, text } from "../state.js";
import { Button, Empty } from "../ui.js";
import { against, choose, chosen, precision, predictions, receipts, start as watch, trouble } from "./accuracy-dial.js";
import { Tradeoff, tradeoff } from "./accuracy-plot.js";
import { Stamp } from "./accuracy-stamp.js";
import { STOPS, edits, settingsOf } from "./accuracy-stops.js";
import { endComparison, metrics, state } from "./compare-pictures.js";
import { Choice, Failure, Meter } from "./widgets.js";

export const id = "accuracy";
export const title = "Accuracy";

/** @typedef {import("./accuracy-stops.js").Stop} Stop */

export const start = watch;

export function Panel() {
  if (text.value === "") return html`<${Empty} title="No scene yet">The dial needs one.<//>`;
  return html`<div class="accuracy">
    <${Dial} />
    <h3 class="section">Trade-off</h3><${Tradeoff} key=${tradeoff.value?.began} />
    <h3 class="section">Same bytes</h3><${Stamp} />
  </div>`;
}

function Dial() {
  const stop = chosen.value;
  const longest = Math.max(1000, ...[...predictions.value.values()].map(({ high }) => high), ...[...receipts.value.values()].map(({ ms }) => ms ?? 0));
  const groups = [...new Set(STOPS.map(({ group }) => group))];
  return html`<p class="lead">${stop ? stop.words : "Choose how exact the picture is to be. It lies over the scene's own as B."}</p>
    ${trouble.value !== "" && html`<p class="bad">No predictions: ${trouble.value}</p>`}
    <fieldset class="dial"><legend class="hidden-visually">Accuracy</legend>
      ${groups.map((group) => html`<div key=${group} class="dial-group"><span class="dial-name quiet" aria-hidden="true">${group}</span><div>
        ${STOPS.filter((of) => of.group === group).map((of) => html`<${Row} key=${of.id} stop=${of} longest=${longest} isChosen=${of === stop} />`)}</div></div>`)}
    </fieldset>
    <p class="legend-line quiet"><span><i class="key whisker-key"></i>predicted, with interval</span><span><i class="key took-key"></i>what it took</span></p>
    <${Chosen} stop=${stop} />
    <div class="slider two"><span>Precision</span><${Choice} label="Precision" name="precision" chosen=${precision.value} choose=${(/** @type {any} */ next) => (precision.value = next)} options=${[["", "Scene’s"], ["single", "Single"], ["double", "Double"]]} /></div>
    <div class="slider two"><span>Held against</span><${Choice} label="A is" name="against" chosen=${against.value} choose=${(/** @type {any} */ next) => (against.value = next)} options=${[["scene", "The scene"], ["finest", "Finest seen"]]} /></div>`;
}

/** Places on a logarithmic scale from 1 ms. @param {number} ms @param {number} longest */
const place = (ms, longest) => Math.log(Math.max(1, ms)) / Math.log(longest);

/** @param {{ stop: Stop, longest: number, isChosen: boolean }} props */
function Row({ stop, longest, isChosen }) {
  const before = predictions.value.get(stop.id);
  const after = receipts.value.get(stop.id);
  const predicted = before ? `predicted ${duration(before.ms)}, ${duration(before.low)} to ${duration(before.high)}` : "not predicted yet";
  const took = after?.ms ?? null;
  const words = took !== null ? `took ${duration(took)}; ${predicted}` : predicted;
  const isRunning = isChosen && (state.value.word === "rendering" || state.value.word === "waiting");
  return html`<label class=${`stop${isChosen ? " is-chosen" : ""}`}>
    <input type="radio" name="stop" value=${stop.id} checked=${isChosen} onChange=${() => choose(stop)} aria-describedby=${`stop-${stop.id}`} />
    <span class="stop-label">${stop.short ?? stop.label}</span>
    <${Meter} value=${took === null ? null : place(took, longest)} max=${1} low=${before && place(before.low, longest)} high=${before && place(before.high, longest)} label=${words} />
    <span class="stop-time" id=${`stop-${stop.id}`}>${isRunning ? html`<span class="quiet">tracing …</span>` : took !== null ? html`<strong>${duration(took)}</strong>` : after ? html`<span title="The service had this picture already">cached</span>` : before ? html`<span class="quiet">${stop.budget ? "≤" : "≈"} ${duration(before.ms)}</span>` : html`<span class="ghost"></span>`}</span>
    ${after && html`<span class="stop-receipt quiet">${receiptWords(after)}</span>`}
  </label>`;
}

/** @param {import("./accuracy-dial.js").Receipt} receipt */
function receiptWords({ rays, proved, identical, estimated }) {
  const parts = [`${count(rays)} rays`, proved === null ? "nothing proved" : `proved ≤ ${proved}`];
  if (identical !== null) parts.push(`${(Math.floor(identical * 1000) / 10).toFixed(1)} % identical`);
  if (estimated !== null) parts.push(`± ${estimated} estimated`);
  return parts.join(" · ");
}

/** @param {{ stop: Stop | null }} props */
function Chosen({ stop }) {
  const asked = otherAsked.value;
  if (!asked || asked.text !== null) return null;
  const of = metrics.value;
  const held = reference.value?.label ?? "the scene";
  return html`<div class="chosen">
    ${state.value.word === "failed" && html`<${Failure} error=${state.value.detail} retry=${() => (otherAsked.value = { ...asked })} />`}
    <p role="status">${held === asked.label ? "This is the finest that you have seen. Choose another stop to hold it against this one." : of === null ? "" : of.max === 0 ? html`The same picture as that of ${held}, in each pixel.` : html`Against ${held}: at most ${of.max} code${of.max === 1 ? "" : "s"} off, ${of.p999} in 99.9 %, ${(100 * of.identical).toFixed(1)} % identical.`}</p>
    <p class="actions"><${Button} kind="main" disabled=${problems.value.length > 0} press=${() => put(stop ? settingsOf(stop, {}, precision.value) : asked.settings, asked.label)}>Put it into the scene<//>
      <${Button} press=${endComparison}>End the comparison<//></p>
  </div>`;
}

/** Writes settings into the text, as one step of undo. @param {import("../state.js").Settings} settings @param {string} label */
function put(settings, label) {
  const before = text.peek();
  batch(() => {
    for (const [pointer, value] of edits(settings)) editAt(pointer, value);
  });
  endComparison();
  if (text.peek() !== before) say(`The scene now says ${label}.`, { label: "Undo", run: () => setText(before) });
  else say(`The scene says ${label} already.`);
}
