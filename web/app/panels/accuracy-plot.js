// The trade-off of a scene: measured by the service, drawn as error against time. Each point is a button that makes it B.
import { html, signal, useEffect, useRef, useState } from "../../vendor/preact.js";
import { Problem, ask, patiently } from "../api.js";
import { ERRORS, earlyPoint, layout, ofOneSize, pointOf, queryOf } from "../pareto.js";
import { count, duration } from "../report.js";
import { eventsOf } from "../sse.js";
import { otherAsked, origin, settings, text, version } from "../state.js";
import { Button } from "../ui.js";
import { compareWith } from "./compare-pictures.js";
import { Choice, Failure, Table } from "./widgets.js";

/** @typedef {import("../pareto.js").Point} Point */
/** @typedef {import("../pareto.js").ErrorName} ErrorName */
/**
 * @typedef {{ state: "measuring" | "done" | "failed", version: number, choices: Point[], points: Point[], report: any, error: string,
 *   began: number }} Tradeoff
 * `version`: of the text; `choices`: whole requests; `points`: tracing alone, of a smaller picture
 */
export const SECONDS = 10;
export const tradeoff = signal(/** @type {Tradeoff | null} */ (null));
let control = new AbortController();

/** Stops measuring. */
export function stop() {
  control.abort();
  tradeoff.value = null;
}

/** Measures all settings; the service streams them if it can. */
export async function measureAll() {
  control.abort();
  control = new AbortController();
  const { signal: ended } = control;
  /** @type {Tradeoff} */
  let now = { state: "measuring", version: version.peek(), choices: [], points: [], report: null, error: "", began: performance.now() };
  const put = (/** @type {Partial<Tradeoff>} */ change) => !ended.aborted && (tradeoff.value = now = { ...now, ...change });
  const finish = (/** @type {any} */ report) => put({ state: "done", report, choices: report.choices.all.map(pointOf), points: report.points.map(pointOf) });
  put({});
  try {
    const request = { body: text.peek(), type: origin.peek().type, query: { ...settings.peek(), seconds: SECONDS }, accept: "text/event-stream, application/json;q=0.5", signal: ended };
    const answer = await patiently(() => ask("v1/tradeoff", request), ended);
    if (!answer.headers.get("content-type")?.startsWith("text/event-stream")) return void finish(await answer.json());
    /** @type {{ choices: any[], points: any[] }} */
    const measured = { choices: [], points: [] };
    for await (const { event, data } of eventsOf(answer)) {
      if (event === "point") {
        // The same one comes again, measured on a larger picture.
        const part = data.part === "choices" ? "choices" : "points";
        if (data.error) measured[part].push(data);
        put({ [part]: ofOneSize(measured[part]).map(earlyPoint) });
      } else if (event === "done") return void finish(data.report ?? data);
      else if (event === "failed") throw new Problem(data.problem?.status ?? 500, data.problem ?? {}, 0);
    }
    throw new Error("the service broke off before it had measured all");
  } catch (error) {
    if (!ended.aborted) put({ state: "failed", error: /** @type {Error} */ (error).message });
  }
}

/** @param {Point} point */
export const asB = (point) => compareWith({ label: point.name, settings: queryOf(point.settings), text: null });

const FRAME = { width: 348, height: 236, left: 34, right: 14, top: 14, bottom: 34 };
const isB = (/** @type {Point} */ point) => otherAsked.value?.label === point.name && otherAsked.value.text === null;

/** What a point is, in a sentence. @param {Point} point @param {ErrorName} error */
const sentence = (point, error) =>
  `${point.name}: ${duration(point.ms)}, ${ERRORS[error].title.toLowerCase()} ${shownError(point.errors[error], error)}, ${point.proved === null ? "nothing proved" : `proved at most ${point.proved}`}`;
/** @param {number} value @param {ErrorName} error */
const shownError = (value, error) => (error === "flip" ? value.toFixed(4) : `${value < 10 && value % 1 !== 0 ? value.toFixed(1) : Math.round(value)} codes`);

/** @param {{ points: Point[], error: ErrorName, knee: number | null }} props */
function Plot({ points, error, knee }) {
  const place = layout(points, error, FRAME);
  const list = useRef(/** @type {SVGGElement | null} */ (null));
  const [at, setAt] = useState(0);
  const order = points.map((_, i) => i).sort((a, b) => points[a].ms - points[b].ms);
  // One stop for the tab key; the arrows go from point to point.
  const move = (/** @type {KeyboardEvent} */ event) => {
    const now = order.indexOf(at);
    const to = { ArrowRight: now + 1, ArrowDown: now + 1, ArrowLeft: now - 1, ArrowUp: now - 1, Home: 0, End: order.length - 1 }[event.key];
    if (event.key === "Enter" || event.key === " ") return event.preventDefault(), asB(points[at]);
    if (to === undefined || order[to] === undefined) return;
    event.preventDefault();
    setAt(order[to]);
    /** @type {SVGElement | null | undefined} */ (list.current?.querySelector(`[data-point="${order[to]}"]`))?.focus();
  };
  const active = Math.min(at, points.length - 1);
  const path = place.front.map((i, n) => `${n === 0 ? "M" : "L"}${place.points[i].x.toFixed(1)} ${place.points[i].y.toFixed(1)}`).join("");
  const bottom = FRAME.height - FRAME.bottom;
  return html`<svg class="plot" viewBox=${`0 0 ${FRAME.width} ${FRAME.height}`} role="group" aria-label=${`Error against time, ${points.length} settings`}>
    ${place.errors.map(({ tick, y }) => html`<g key=${tick}><line class="grid" x1=${FRAME.left} x2=${FRAME.width - FRAME.right} y1=${y} y2=${y} /><text class="tick" x=${FRAME.left - 6} y=${y + 3.5} text-anchor="end">${tick}</text></g>`)}
    ${place.times.map(({ tick, x }) => html`<g key=${tick}><line class="grid" x1=${x} x2=${x} y1=${FRAME.top} y2=${bottom} /><text class="tick" x=${x} y=${bottom + 14} text-anchor="middle">${tick >= 1000 ? `${tick / 1000} s` : `${tick} ms`}</text></g>`)}
    <text class="axis" x=${FRAME.width - FRAME.right} y=${FRAME.height - 3} text-anchor="end">time →</text>
    <text class="axis" x=${FRAME.left - 28} y=${FRAME.top - 4}>${ERRORS[error].unit || "FLIP"} off</text>
    ${points.map(({ name }, i) => { const { x, y, proved } = place.points[i]; return proved !== null && html`<path key=${`${i} ${name}`} class="proved-bar" d=${`M${x} ${y}V${proved}M${x - 3} ${proved}h6`} />`; })}
    <path class="front" d=${path} />
    <g ref=${list} onKeyDown=${move}>${points.map((point, i) => html`<g key=${`${i} ${point.name}`} class=${`point${isB(point) ? " is-b" : ""}${place.front.includes(i) ? " on-front" : ""}`} role="button" tabindex=${i === active ? 0 : -1}
      data-point=${i} aria-label=${sentence(point, error)} aria-pressed=${String(isB(point))} transform=${`translate(${place.points[i].x} ${place.points[i].y})`} onClick=${() => (setAt(i), asB(point))} onFocus=${() => setAt(i)}>
      <title>${sentence(point, error)}</title><circle class="target" r="12" />${i === knee && html`<circle class="knee" r="8.5" />`}<circle class="dot" r="4.5" />${isB(point) && html`<text class="b-mark" x="0" y="-11" text-anchor="middle">B</text>`}</g>`)}</g>
  </svg>`;
}

/** The rest of the time, while the service says nothing. @param {{ began: number }} props */
function Waiting({ began }) {
  const [now, setNow] = useState(performance.now());
  useEffect(() => {
    const timer = setInterval(() => setNow(performance.now()), 250);
    return () => clearInterval(timer);
  }, []);
  const part = Math.min(1, (now - began) / (SECONDS * 1000));
  return html`<div class="progress-line"><progress max="1" value=${part} aria-label="Measuring"></progress><span class="quiet">${part < 1 ? `about ${Math.ceil(SECONDS * (1 - part))} s left` : "nearly done"}</span><${Button} kind="quiet" press=${stop}>Stop<//></div>`;
}

export function Tradeoff() {
  const of = tradeoff.value;
  const [error, setError] = useState(/** @type {ErrorName} */ ("p999"));
  const [which, setWhich] = useState("choices");
  if (!of) return html`<p class="quiet">Renders the scene with about forty settings on a smaller picture, and shows which of them no other beats.</p>
    <p class="actions"><${Button} kind="main" press=${measureAll}>Measure all (${SECONDS} s)<//></p>`;
  const points = (which === "choices" ? of.choices : of.points).filter(({ errors }) => Number.isFinite(errors[error]));
  const choices = of.report?.choices;
  const fronts = of.report?.fronts ?? [];
  const knee = which === "choices" ? (choices?.recommended ?? null) : (fronts.find((/** @type {any} */ front) => front.error === "total" && front.cost === "time")?.knee ?? null);
  const isStale = of.version !== version.value;
  return html`${of.state === "measuring" && html`<${Waiting} began=${of.began} />`}
    ${of.state === "failed" && html`<${Failure} error=${of.error} retry=${measureAll} />`}
    ${isStale && html`<p class="stale-note">This is of an earlier text. <${Button} kind="quiet" press=${measureAll}>Measure again<//></p>`}
    ${choices && html`<p class="advice">${choices.answer}</p>`}
    ${points.length > 1 && html`
      ${of.points.length > 1 && html`<${Choice} label="Which settings" name="tradeoff-which" chosen=${which} choose=${setWhich} options=${[["choices", "Whole requests"], ["points", "Tracing alone"]]} />`}
      <div class="plot-head"><label>Error <select value=${error} onChange=${(/** @type {any} */ event) => setError(event.target.value)}>
        ${Object.entries(ERRORS).filter(([id]) => of.report || id === "p999" || id === "max").map(([id, { title }]) => html`<option key=${id} value=${id}>${title}</option>`)}</select></label></div>
      <figure class=${isStale ? "is-stale" : ""}><${Plot} points=${points} error=${error} knee=${knee} />
        <figcaption class="quiet legend-line"><span><i class="key front-key"></i>not beaten</span><span><i class="key knee-key"></i>${which === "choices" ? "recommended" : "knee"}</span>
          <span><i class="key proved-key"></i>proved bound</span></figcaption></figure>
      <details class="points-table"><summary>The same as a table</summary><div class="scroll-x" tabindex="0" role="region" aria-label="Settings that were measured"><${Table} caption="Settings that were measured" rows=${points} rowKey=${(/** @type {Point} */ { name }) => name} sort=${["ms", 1]} columns=${[
        { id: "name", title: "Setting", by: (/** @type {Point} */ of) => of.name, cell: (/** @type {Point} */ of) => html`<button type="button" class="row-button" aria-pressed=${String(isB(of))} onClick=${() => asB(of)}>${of.name}</button>` },
        { id: "ms", title: "Time", number: true, by: (/** @type {Point} */ of) => of.ms, cell: (/** @type {Point} */ of) => duration(of.ms) },
        { id: "error", title: "Off", number: true, by: (/** @type {Point} */ of) => of.errors[error], cell: (/** @type {Point} */ of) => shownError(of.errors[error], error) },
        { id: "proved", title: "Proved", number: true, by: (/** @type {Point} */ of) => of.proved ?? 256, cell: (/** @type {Point} */ of) => of.proved ?? "–" },
        { id: "rays", title: "Rays", number: true, by: (/** @type {Point} */ of) => of.rays, cell: (/** @type {Point} */ of) => count(of.rays) },
      ]} /></div></details>`}
    ${of.report && html`<details class="more-advice"><summary>What the service advises</summary><ul>${[...(choices?.remarks ?? []), ...(of.report.advice ?? [])].map((/** @type {string} */ line) => html`<li key=${line}>${line}</li>`)}</ul>
      <p class="quiet">Measured on ${choices.size.join(" × ")} pixels in ${duration(of.report.circumstances.took_seconds * 1000)}, with ${of.report.circumstances.threads} threads (${of.report.circumstances.instructions}).</p></details>`}
    ${of.state === "done" && !isStale && html`<p class="actions"><${Button} press=${measureAll}>Measure again<//></p>`}`;
}
