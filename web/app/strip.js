// The cost strip: what goes on, what the picture took and how exact it is. Each word opens what explains it.
import { html } from "../vendor/preact.js";
import { count, duration } from "./report.js";
import { connection, dialog, openPanel, pane, plan, predicted, problems, reveal, shown, status } from "./state.js";
import { renderNow } from "./picture.js";
import { Button } from "./ui.js";

/** @typedef {import("./state.js").Shown} Shown */

const WORDS = { starting: "starting", live: "live", tracing: "tracing", paused: "as you left it", invalid: "invalid", waiting: "waiting", offline: "offline", failed: "failed" };
/** Phases in their order, with words for people. */
const PHASES = { queue: "queue", parse: "read", plan: "plan", bvh: "hierarchy", trace: "trace", png: "PNG" };
const RUNGS = ["quick answer", "full size, one sample a pixel", "as the scene says"];

function press() {
  const { word } = status.peek();
  const [first] = problems.peek();
  if (word === "invalid" && first?.pointer !== undefined) reveal(first.pointer);
  else if (word === "invalid") pane.value = "edit";
  else if (word === "paused") renderNow();
  else openPanel("plan");
}

function State() {
  const { word, detail } = connection.value.online ? status.value : { word: /** @type {const} */ ("offline"), detail: "looking for the service; your text is safe" };
  return html`<button type="button" class=${`strip-item state is-${word}`} onClick=${press} title=${detail || WORDS[word]}>
    <span class="dot" aria-hidden="true"></span><span>${WORDS[word]}</span>${detail !== "" && word !== "invalid" && html`<span class="quiet strip-detail">${detail}</span>`}
  </button>`;
}

/** Milliseconds of each phase as one bar. @param {{ of: Shown }} props */
function Phases({ of: { report } }) {
  const refine = report.phases.find(({ name }) => name === "refine")?.ms ?? 0;
  const parts = Object.entries(PHASES).flatMap(([name, word]) => {
    const ms = report.phases.find((phase) => phase.name === name)?.ms ?? 0;
    return name === "trace" && refine > 0 ? [{ name, word: "trace", ms: ms - refine }, { name: "refine", word: "antialiasing", ms: refine }] : [{ name, word, ms }];
  });
  const words = parts.filter(({ ms }) => ms >= 0.05).map(({ word, ms }) => `${word} ${duration(ms)}`).join(", ");
  return html`<button type="button" class="strip-item phases" title=${words} aria-label=${`Time: ${words}`} onClick=${() => openPanel("plan")}>
    <span class="phase-bar">${parts.map(({ name, ms }) => html`<span key=${name} class=${`phase is-${name}`} style=${{ flexGrow: String(ms) }}></span>`)}</span>
  </button>`;
}

/** @param {{ of: Shown }} props */
function Costs({ of }) {
  const { report, rung, width, height } = of;
  const before = rung === 2 && plan.value ? predicted.value : null;
  const proved = report.proved === null ? "nothing proved" : `proved ≤ ${report.proved} ${report.proved === 1 ? "code" : "codes"}`;
  const more = [report.identical === null ? "" : `${Math.floor(report.identical * 1000) / 10} % identical`, report.estimated === null ? "" : `± ${report.estimated} by sampling`];
  const kinds = report.rays.map(({ name, rays }) => `${name} ${rays.toLocaleString("en")}`).join(", ");
  return html`
    <span class="strip-item" title=${RUNGS[rung]}>${width} × ${height}</span>
    <button type="button" class="strip-item took" onClick=${() => openPanel("plan")} title="What it took, and what was predicted, with its interval">
      <strong>${report.hit ? "cached" : duration(report.ms)}</strong>
      ${before && html`<span class="quiet">predicted ${duration(before.ms)} (${duration(before.low)} to ${duration(before.high)})</span>`}
    </button>
    ${!report.hit && html`<${Phases} of=${of} />`}
    <button type="button" class="strip-item" title=${kinds} onClick=${() => openPanel("plan")}>${count(report.totalRays)} rays</button>
    <button type="button" class="strip-item" title=${report.why || "How far a pixel can be from recursion without end; a code is one step of 255"} onClick=${() => openPanel("accuracy")}>
      ${proved}<span class="quiet">${more.filter((words) => words !== "").join(" · ")}</span>
    </button>
    <button type="button" class="strip-item mono digest" title=${`SHA-256 of the picture: ${report.digest}`} onClick=${() => (dialog.value = "share")}>${report.digest.slice(0, 8)}</button>`;
}

export function Strip() {
  const of = shown.value;
  return html`<footer class="strip" aria-label="Cost">
    <${State} />
    ${of && html`<${Costs} of=${of} />`}
    ${connection.value.upgraded && html`<span class="strip-item">The service has a new version. <${Button} press=${() => location.reload()}>Reload<//></span>`}
  </footer>`;
}
