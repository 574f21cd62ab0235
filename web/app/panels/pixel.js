// One pixel: its value, what it may lack, the rays that it is made of, and that they add up.
import { html } from "../../vendor/preact.js";
import { pixel, size } from "../state.js";
import { Button, Empty, Icon } from "../ui.js";
import { answer, askAgain, askAnyway, asking, chooseSample, inspect, isDrawn, isStale, sample, spot, start as startAsking } from "./pixel-asked.js";
import { Icicle } from "./pixel-icicle.js";
import { start as startLinks } from "./pixel-links.js";
import { Outline } from "./pixel-outline.js";
import { OutsideView } from "./pixel-outside.js";
import { start as startOverlay } from "./pixel-overlay.js";
import { ChosenRay } from "./pixel-ray.js";
import { colorOf, largest, oddOne, short } from "./pixel-rays.js";
import { Sum } from "./pixel-sum.js";

export const id = "pixel";
export const title = "Pixel";

export function start() {
  startAsking();
  startOverlay();
  startLinks();
}

/** Words as a sentence. @param {string} words */
const ended = (words) => (/[.?!]$/.test(words) ? words : `${words}.`);

/** Why what is shown is not about the pixel and the text of now, or that it is on its way. */
function State() {
  const { state, detail } = asking.value;
  const old = answer.value ? " Below are the rays of before." : "";
  const at = pixel.value;
  const said = {
    idle: null,
    loading: detail || "Tracing the pixel …",
    invalid: `The text is no sound scene now: ${ended(detail)}${old}`,
    offline: `The service does not answer.${old}`,
    failed: `No rays: ${ended(detail)}${old}`,
    outside: `The picture has ${detail} pixels now: this one is outside.${old}`,
    large: `Pixel ${at?.x}, ${at?.y} has very many rays, more than 24 MB of them.`,
  }[state];
  if (!said) return null;
  return html`<p class=${`panel-state ${state}`} role="status">${state !== "loading" && html`<${Icon} name="warning" />`}<span>${said}</span>
    ${(state === "failed" || state === "offline") && html`<${Button} press=${askAgain}>Try again<//>`}${state === "outside" && at && html`<${Button} press=${() => inspect({ x: Math.min(at.x, size.value.width - 1), y: Math.min(at.y, size.value.height - 1) })}>Take the nearest<//>`}${state === "large" && html`<${Button} press=${askAnyway}>Load them all<//>`}</p>`;
}

/** @param {{ tree: import("./pixel-rays.js").Tree }} props */
function Value({ tree }) {
  const { codes } = tree;
  const row = (/** @type {string} */ name, /** @type {(string | number)[]} */ values) => html`<tr><th scope="row">${name}</th>${values.map((value, c) => html`<td key=${c} class="number mono">${value}</td>`)}</tr>`;
  return html`<div class="pixel-value">
    <span class="pixel-swatch" style=${{ background: `rgb(${codes.join(" ")})` }} role="img" aria-label="Color of the pixel"></span>
    <table><caption class="hidden-visually">Value of the pixel</caption><thead class="hidden-visually"><tr><td></td><th scope="col">red</th><th scope="col">green</th><th scope="col">blue</th></tr></thead>
      <tbody>${row("codes", codes)}${row("linear", tree.value.map((value) => short(value, 5)))}
      <tr><th scope="row">CSS</th><td colspan="3" class="number mono">#${codes.map((code) => code.toString(16).padStart(2, "0")).join("")}</td></tr></tbody></table>
  </div>`;
}

/** How far the pixel may be off, and why. @param {{ tree: import("./pixel-rays.js").Tree }} props */
function Lacking({ tree }) {
  const ended = tree.rays.reduce((sum, { not_followed: of = [] }) => sum + of.length, 0);
  const left = ended === 0 ? "Lights that could not matter were not asked for" : `${ended.toLocaleString("en")} ${ended === 1 ? "ray was" : "rays were"} not followed`;
  if (largest(tree.lacking) === 0) return html`<p class="lacking-line whole"><${Icon} name="check" /><span><strong>Lacks nothing.</strong>${" "}${ended === 0 ? "Every ray was followed to its end." : `${left}, which could not show.`}</span></p>`;
  const codes = tree.codes_off;
  const most = html`<span class="mono">${tree.lacking.map((lack) => short(lack, 2)).join(", ")}</span>`;
  return html`<p class="lacking-line"><span class="hatch" aria-hidden="true"></span><span>
    <strong>${codes === 0 ? "Exact to the code." : `At most ${codes} ${codes === 1 ? "code" : "codes"} off.`}</strong>${" "}${left}: that could add at most ${most}${largest(tree.raised) > 0 ? ", of which a part is added already, so that the pixel lies in the middle." : "."}</span></p>`;
}

/** @param {{ count: number }} props */
function Samples({ count }) {
  const of = /** @type {import("./pixel-asked.js").Answer} */ (answer.value);
  const odd = oddOne(of.sum.samples);
  return html`<div class="samples" role="group" aria-label="Samples">
    <${Button} label="Previous sample" kind="quiet" press=${() => chooseSample(sample.value - 1)}>‹<//>
    <span class="samples-at" aria-live="polite">Sample ${sample.value + 1} of ${count}</span>
    <${Button} label="Next sample" kind="quiet" press=${() => chooseSample(sample.value + 1)}>›<//>
    <span class="samples-strip" aria-hidden="true">${of.sum.samples.slice(0, 64).map((light, at) => html`<i key=${at} class=${at === sample.value ? "now" : ""} style=${{ background: colorOf(light) }} onClick=${() => chooseSample(at)}></i>`)}</span>
    <${Button} press=${() => chooseSample(odd)} pressed=${odd === sample.value} title="The sample farthest from the mean">Odd one<//>
  </div>`;
}

/** Which pixel, as numbers that can be changed. */
function Where() {
  const at = /** @type {{ x: number, y: number }} */ (pixel.value);
  const { width, height } = size.value;
  const set = (/** @type {"x" | "y"} */ axis, /** @type {number} */ most) => (/** @type {Event} */ event) => {
    const value = Math.round(Number(/** @type {HTMLInputElement} */ (event.currentTarget).value));
    if (Number.isFinite(value)) inspect({ ...at, [axis]: Math.min(most - 1, Math.max(0, value)) });
  };
  return html`<div class="pixel-where"><h2>Pixel</h2>
    <label>x <input type="number" min="0" max=${width - 1} value=${at.x} onChange=${set("x", width)} /></label>
    <label>y <input type="number" min="0" max=${height - 1} value=${at.y} onChange=${set("y", height)} /></label>
    ${spot.value && html`<span class="tag">× ${(2 ** spot.value.zoom).toLocaleString("en")}</span><${Button} kind="quiet" press=${() => (spot.value = null)} title=${`Pixel ${spot.value.x}, ${spot.value.y} of the picture at that size`}>Whole pixel<//>`}
    <span class="grow"></span>
    <${Button} label="Let go of the pixel" icon="close" kind="quiet" press=${() => (pixel.value = null)} /></div>`;
}

export function Panel() {
  if (!pixel.value) {
    return html`<${Empty} title="From pixel to proof"><p>Click a pixel in the picture. Here are then all rays that it is made of, whose light adds up to it to the last bit.</p>
      <p><${Button} press=${() => inspect({ x: size.value.width >> 1, y: size.value.height >> 1 })}>Take the middle<//></p><//>`;
  }
  const of = answer.value;
  if (!of) return html`<${Where} /><${State} />${asking.value.state === "idle" || asking.value.state === "loading" ? html`<div class="skeleton" aria-hidden="true"><i></i><i></i><i></i></div>` : null}`;
  const { tree, roots } = of.grown;
  const { length: count } = tree.rays;
  return html`<${Where} /><${State} />
    <div class=${isStale.value && asking.value.state !== "idle" ? "pixel-body stale" : "pixel-body"}>
      <${Value} tree=${tree} /><${Lacking} tree=${tree} />
      ${tree.truncated && html`<p class="panel-state"><${Icon} name="warning" /><span>There are more rays than the service records (${count.toLocaleString("en")} are here): the list is cut, and does not add up.</span></p>`}
      ${roots.length > 1 && html`<${Samples} count=${roots.length} />`}
      <div class="rays-head"><h3>${count === 1 ? "One ray" : `${count.toLocaleString("en")} rays`}</h3><span class="quiet grow">${roots.length > 1 ? "in all samples, " : ""}${tree.precision} precision</span>
        <${Button} icon="cursor" pressed=${isDrawn.value} press=${() => (isDrawn.value = !isDrawn.value)} title="Draw the rays over the picture">In the picture<//></div>
      <${Icicle} />
      <${Outline} />
      <${ChosenRay} />
      <${Sum} />
      <${OutsideView} />
    </div>`;
}
