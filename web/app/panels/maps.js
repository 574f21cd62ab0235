// Maps of the picture, over it: what is proved of each pixel, and what each takes.
import { html } from "../../vendor/preact.js";
import { along, at, gradient } from "../ramps.js";
import { duration } from "../report.js";
import { pixel, predicted, problems } from "../state.js";
import { Button, Empty } from "../ui.js";
import { KINDS, askAgain, bins, choose, found, isClipped, isLogarithmic, isStale, kind, onlyPositive, opacity, progress, rampName, read, scale, start as watch, sums } from "./maps-load.js";
import { ObjectLegend } from "./maps-objects.js";
import { Choice, Fact, Failure, Switch } from "./widgets.js";

export const id = "maps";
export const title = "Maps";
export const start = watch;

export function Panel() {
  const of = KINDS[kind.value];
  return html`<div class="maps">
    <${Choice} label="Map" name="map" chosen=${kind.value} choose=${choose} options=${[["", "None"], ...Object.entries(KINDS).map(([name, { title }]) => [name, title])]} />
    ${of ? html`<p class="lead">${of.words}</p><${Progress} />${found.value?.objects ? html`<dl class="facts"><${UnderPointer} kind=${of} /></dl><${ObjectLegend} of=${{ ...found.value.floats, objects: found.value.objects }} />`
      : found.value && html`<${Legend} kind=${of} /><${Figures} kind=${of} />`}<${Looks} />` : html`<${Begin} />`}
  </div>`;
}

const Begin = () => html`<${Empty} title="No map">A map lies over the picture and has a number for each pixel. A coarse one comes at once, the whole one a little later.<//>
  <ul class="plain-list map-kinds">${Object.entries(KINDS).map(([name, { title, words }]) => html`<li key=${name}><button type="button" class="map-kind" onClick=${() => choose(name)}><strong>${title}</strong><span class="quiet">${words}</span></button></li>`)}</ul>`;

function Progress() {
  const { word, detail } = progress.value;
  if (problems.value.length > 0) return html`<p class="stale-note">The text has problems; this map is of the last good one.</p>`;
  if (word === "failed") return html`<${Failure} error=${detail} retry=${askAgain} />`;
  if (word === "held") return html`<p class="stale-note">This is coarse: one pixel of each 8 × 8. The whole map takes about ${duration(predicted.value?.ms ?? 0)}. <${Button} press=${askAgain}>Make it<//></p>`;
  if (word === "") return isStale.value ? html`<p class="stale-note" role="status">This is of an earlier text.</p>` : html`<p class="map-progress" role="status"></p>`;
  const words = word === "waiting" ? detail : word === "coarse" ? "A coarse map is coming …" : "This is coarse; the whole map is coming …";
  return html`<div class="progress-line map-progress" role="status"><progress aria-label="Making the map"></progress><span class="quiet">${words}</span><${Button} kind="quiet" press=${() => choose("")}>Stop<//></div>`;
}

/** The scale with its histogram. @param {{ kind: import("./maps-load.js").Kind }} props */
function Legend({ kind: of }) {
  const range = scale.value;
  const counts = bins.value;
  if (!range) return null;
  const most = Math.max(1, ...counts);
  const marker = read.value && (!onlyPositive.value || read.value.value > 0) ? along(range, read.value.value) : null;
  const bars = counts.map((count, i) => (count === 0 ? "" : `M${i} 24V${(24 - Math.max(0.8, (22 * Math.log1p(count)) / Math.log1p(most))).toFixed(2)}h1V24z`)).join("");
  return html`<figure class="legend" aria-label=${`From ${of.shown(range.low)} to ${of.shown(range.high)}, ${range.isLogarithmic ? "logarithmic" : "linear"}`}>
    <svg class="histogram" viewBox=${`0 0 ${counts.length} 24`} preserveAspectRatio="none" aria-hidden="true"><path d=${bars} /></svg>
    <div class="legend-bar" style=${{ background: gradient(rampName.value) }}>${marker !== null && html`<span class="legend-marker" style=${{ left: `${100 * marker}%` }}></span>`}</div>
    <div class="legend-ticks">${[0, 0.5, 1].map((part) => html`<span key=${part}>${part === 0 && isClipped.value ? "≤ " : part === 1 && isClipped.value ? "≥ " : ""}${of.shown(rounded(at(range, part)))}</span>`)}</div>
  </figure>`;
}
const rounded = (/** @type {number} */ value) => (value >= 100 ? Math.round(value) : Number(value.toPrecision(3)));

/** @param {{ kind: import("./maps-load.js").Kind }} props */
function UnderPointer({ kind: of }) {
  const { at: place, value } = read.value ?? { at: null, value: 0 };
  return html`<${Fact} name=${place ? `Pixel ${place.x}, ${place.y}` : "Under the pointer"} value=${place ? html`<strong>${Number.isFinite(value) ? of.shown(value) : kind.value === "distance" ? "nothing there" : "nothing bounds it"}</strong>` : "–"} />`;
}

/** @param {{ kind: import("./maps-load.js").Kind }} props */
function Figures({ kind: of }) {
  const all = sums.value;
  return html`<dl class="facts">
    <${UnderPointer} kind=${of} />
    ${all && html`<${Fact} name="Mean" value=${of.shown(all.mean)} />
      <${Fact} name="Most" value=${of.shown(all.most)} note=${html`<button type="button" class="row-button" onClick=${() => (pixel.value = all.place)}>at ${all.place.x}, ${all.place.y}</button>`} />
      ${["rays", "time", "samples"].includes(kind.value) && found.value?.step === 1 && html`<${Fact} name="Together" value=${of.shown(all.sum)} />`}`}
  </dl>`;
}

const Looks = () => html`<h3 class="section">Looks</h3><${Opacity} />${kind.value !== "object" && html`<${Colors} />`}`;

const Opacity = () => html`<label class="slider"><span>Opacity</span><input type="range" min="0" max="100" value=${Math.round(100 * opacity.value)} onInput=${(/** @type {any} */ event) => (opacity.value = event.target.value / 100)} /><output>${Math.round(100 * opacity.value)} %</output></label>`;

const Colors = () => html`<div class="slider two"><span>Scale</span><${Choice} label="Scale" name="map-scale" chosen=${isLogarithmic.value ? "log" : "linear"} choose=${(/** @type {string} */ next) => (isLogarithmic.value = next === "log")} options=${[["linear", "Linear"], ["log", "Logarithmic"]]} /></div>
  <div class="slider two"><span>Colors</span><${Choice} label="Colors" name="map-ramp" chosen=${rampName.value} choose=${(/** @type {any} */ next) => (rampName.value = next)} options=${[["cividis", "Cividis"], ["viridis", "Viridis"]]} /></div>
  <${Switch} label="Clip to the middle 96 % of the pixels" on=${isClipped.value} set=${(/** @type {boolean} */ on) => (isClipped.value = on)} />
  <${Switch} label="Only where it is above 0" on=${onlyPositive.value} set=${(/** @type {boolean} */ on) => (onlyPositive.value = on)} />`;
