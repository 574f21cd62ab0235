// Two pictures against each other: which, how they are shown, how far they are apart, and the pixel under the pointer in both.
import { html } from "../../vendor/preact.js";
import { count, duration } from "../report.js";
import { other, otherAsked, reference, say, setText, settings, text, version } from "../state.js";
import { Button, Empty, Icon } from "../ui.js";
import { Choice, Fact } from "./widgets.js";
import * as layer from "./compare-layer.js";
import * as overlay from "./compare-overlay.js";
import { a, alike, codesOf, compareWith, endComparison, exposure, flipped, gain, isStale, metrics, mode, refer, start as watch, state, wipe } from "./compare-pictures.js";
import { FlipRow } from "./compare-flip.js";

export { Overlay } from "./compare-overlay.js";

export const id = "compare";
export const title = "Compare";

export function start() {
  watch();
  layer.start();
  overlay.start();
}

/** What B may be, to begin with. @type {{ label: string, settings: import("../state.js").Settings }[]} */
const KINDS = [
  { label: "depth 3", settings: { accuracy: "fixed", max_depth: "3" } },
  { label: "depth 5", settings: { accuracy: "fixed", max_depth: "5" } },
  { label: "proved 0", settings: { accuracy: "proved:0" } },
  { label: "double precision", settings: { precision: "double" } },
  { label: "no antialiasing", settings: { antialias: "false" } },
  { label: "16 samples", settings: { samples: "16" } },
];

export function Panel() {
  if (!otherAsked.value) return html`<${Begin} />`;
  return html`<div class="compare">
    <${Sides} />
    ${other.value && html`<${Modes} /><${Differences} /><${UnderPointer} />`}
  </div>`;
}

const keepText = () => compareWith({ label: "the text as it was", settings: {}, text: text.peek() }, "wipe");

function Begin() {
  return html`<${Empty} title="Compare two pictures">
      A is the picture of the scene. Choose what B is. The wipe then lies over the picture: drag it, or hold the space bar to see B alone.
    <//>
    <h3 class="section">B is the scene with</h3>
    <div class="choices">${KINDS.map((kind) => html`<${Button} key=${kind.label} press=${() => compareWith({ ...kind, text: null }, "wipe")}>${kind.label}<//>`)}</div>
    <h3 class="section">B is an earlier text</h3>
    <p class="quiet">Keep the text as it is now as B, then edit: A follows the text, and B stays.</p>
    <p><${Button} press=${keepText}>Keep this text as B<//></p>
    <p class="quiet">Each stop of <em>Accuracy</em> and each point of its plot can be B, too.</p>`;
}

function Sides() {
  const asked = otherAsked.value;
  const { word, detail } = state.value;
  const report = other.value?.report;
  const kept = asked?.text ?? null;
  return html`<ul class="plain-list sides">
    <li><span class="side-mark of-a">A</span><div>${a.value?.label ?? "no picture yet"}<${Cost} report=${a.value?.report} /></div>
      ${reference.value && html`<${Button} kind="quiet" press=${() => refer(null)}>Use the scene<//>`}</li>
    <li><span class="side-mark of-b">B</span><div>${asked?.label}${report && html`<${Cost} report=${report} />`}</div>
      <${Button} label="End the comparison" icon="close" kind="quiet" press=${endComparison} /></li>
  </ul>
  <p class="compare-state" role="status">${word === "rendering" ? "Rendering B …" : word === "waiting" ? detail : word === "failed" ? html`<span class="bad"><${Icon} name="warning" /> ${detail}</span>`
    : isStale.value ? "B is of an earlier text; a new one is coming." : ""}</p>
  <p class="actions">
    ${word === "failed" && html`<${Button} press=${() => (otherAsked.value = asked && { ...asked })}>Try again<//>`}
    ${asked && kept === null && Object.keys(asked.settings).length > 0 && html`<${Button} press=${() => take(asked)} title="Renders the picture with these settings; the text stays as it is">Use B for the picture<//>`}
    ${kept !== null && html`<${Button} press=${() => back(kept)}>Go back to B's text<//>`}
    ${kept === null && html`<${Button} press=${keepText}>Keep this text as B<//>`}
  </p>`;
}

/** @param {NonNullable<typeof otherAsked.value>} asked */
function take(asked) {
  const before = settings.peek();
  settings.value = { ...before, ...asked.settings };
  endComparison();
  say(`The picture now has ${asked.label}.`, { label: "Undo", run: () => (settings.value = before) });
}

/** @param {string} kept */
function back(kept) {
  setText(kept);
  endComparison();
}

/** @param {{ report: import("../report.js").Report | undefined }} props */
const Cost = ({ report }) =>
  report ? html`<span class="quiet side-cost">${report.hit ? "cached" : duration(report.ms)} · ${count(report.totalRays)} rays${report.proved === null ? "" : ` · proved ≤ ${report.proved}`}</span>` : null;

function Modes() {
  return html`<${Choice} label="How they are shown" name="compare-mode" chosen=${mode.value} choose=${(/** @type {any} */ next) => (mode.value = next)}
      options=${[["wipe", "Wipe"], ["side", "Side by side"], ["flip", "Flip"], ["difference", "Difference"]]} />
    ${mode.value === "wipe" && html`<label class="slider"><span>Wipe</span><input type="range" min="0" max="100" value=${Math.round(100 * wipe.value)}
      onInput=${(/** @type {any} */ event) => (wipe.value = event.target.value / 100)} /><output>${Math.round(100 * wipe.value)} %</output></label>
      <p class="choices">${[["B only", 0], ["Half", 0.5], ["A only", 1]].map(([label, to]) => html`<${Button} key=${label} kind="quiet" press=${() => (wipe.value = Number(to))}>${label}<//>`)}</p>`}
    ${mode.value === "flip" && html`<p class="quiet">Hold <kbd>Space</kbd> for B, or <${Hold} />.</p>`}
    ${mode.value === "difference" && html`<label class="slider"><span>Gain</span><input type="range" min="0" max="8" value=${Math.log2(gain.value)} aria-valuetext=${`${gain.value} times`}
      onInput=${(/** @type {any} */ event) => (gain.value = 2 ** event.target.value)} /><output>× ${gain.value}</output></label>`}
    <div class="slider"><span id="exposure-label">Exposure</span><span class="stepper" role="group" aria-labelledby="exposure-label">
      <${Button} label="Darker" icon="minus" keys="[" press=${() => (exposure.value = Math.max(-10, exposure.value - 0.5))} />
      <${Button} label="Brighter" icon="plus" keys="]" press=${() => (exposure.value = Math.min(10, exposure.value + 0.5))} /></span>
      <output>${exposure.value === 0 ? "as it is" : `${exposure.value > 0 ? "+" : ""}${exposure.value} EV`}</output></div>
    ${exposure.value !== 0 && html`<p class="quiet">Both are drawn from their linear floats, without a tone curve. <${Button} kind="quiet" press=${() => (exposure.value = 0)}>Reset<//></p>`}`;
}

/** Holding it shows B. */
function Hold() {
  const show = (/** @type {boolean} */ on) => () => (flipped.value = on);
  return html`<button type="button" class="button" onPointerDown=${show(true)} onPointerUp=${show(false)} onPointerLeave=${show(false)}
    onKeyDown=${(/** @type {KeyboardEvent} */ event) => event.key === "Enter" && (flipped.value = true)} onKeyUp=${show(false)} onBlur=${show(false)}>hold this</button>`;
}

function Differences() {
  const of = metrics.value;
  const isQuick = (a.value?.rung ?? 0) < 2;
  if (!alike.value) return html`<p class="quiet">${isQuick ? "The numbers come with the whole picture." : `A has ${a.value?.width} × ${a.value?.height} pixels and B ${other.value?.width} × ${other.value?.height}: they cannot be compared pixel by pixel.`}</p>`;
  if (!of) return html`<p class="quiet">${isQuick ? "The numbers come with the whole picture." : "Measuring …"}</p>`;
  return html`<h3 class="section">How far they are apart</h3>
    ${of.max === 0 ? html`<p class="same"><${Icon} name="check" /> The same: all ${count(/** @type {any} */ (a.value).width * /** @type {any} */ (a.value).height)} pixels are equal.</p>` : ""}
    <dl class="facts">
      <${Fact} name="Largest difference" value=${codes(of.max)} note=${of.max > 0 ? `at ${of.worst.x}, ${of.worst.y}` : ""} />
      <${Fact} name="In 99.9 % of the pixels" value=${codes(of.p999)} />
      <${Fact} name="Root mean square" value=${codes(of.rms, 2)} />
      <${Fact} name="Identical pixels" value=${percent(of.identical)} />
      <${FlipRow} key=${`${version.value} ${JSON.stringify(otherAsked.value?.settings)}`} />
    </dl>
    <p class="quiet">${of.max === 0 ? "" : of.max <= 1 ? "One code cannot be seen." : of.p999 <= 10 ? "Up to 10 codes show only where two pictures take turns in one place." : of.p999 <= 30 ? "These show when pictures stand side by side." : "These are obvious."}</p>`;
}

const codes = (/** @type {number} */ value, digits = 0) => `${value.toFixed(digits)} code${value === 1 ? "" : "s"}`;
/** A share that says 100 % only if it is all. @param {number} share */
const percent = (share) => (share === 1 ? "100 %" : `${Math.min(99.99, 100 * share).toFixed(share > 0.99 ? 2 : 1)} %`);

function UnderPointer() {
  const at = layer.probe.value;
  const [one, two] = [a.value, other.value];
  if (!at || !one || !two) return html`<p class="quiet">Point at a pixel to see it in both.</p>`;
  const read = (/** @type {import("../state.js").Shown} */ of) => {
    const all = codesOf(of);
    const [x, y] = [Math.floor((at.x * of.width) / one.width), Math.floor((at.y * of.height) / one.height)];
    return all ? Array.from(all.subarray(4 * (y * of.width + x), 4 * (y * of.width + x) + 3)) : [];
  };
  const [left, right] = [read(one), read(two)];
  return html`<h3 class="section">Pixel ${at.x}, ${at.y}</h3>
    <table class="table pixel-pair"><caption class="hidden-visually">The pixel in both pictures</caption>
      <thead><tr><td></td>${["Red", "Green", "Blue"].map((name) => html`<th scope="col" class="number" key=${name}>${name}</th>`)}</tr></thead>
      <tbody>${[["A", left], ["B", right], ["B − A", right.map((value, i) => value - left[i])]].map(([name, values], row) => html`<tr key=${name}>
        <th scope="row">${row < 2 && html`<span class="swatch" style=${{ background: `rgb(${/** @type {number[]} */ (values).join(" ")})` }}></span>`}${name}</th>
        ${/** @type {number[]} */ (values).map((value, c) => html`<td class="number" key=${c}>${row === 2 && value > 0 ? "+" : ""}${value}</td>`)}</tr>`)}</tbody>
    </table>`;
}
