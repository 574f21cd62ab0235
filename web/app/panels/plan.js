// The plan: which effects the scene calls for, why, and what they take.
import { html } from "../../vendor/preact.js";
import { count, duration } from "../report.js";
import { plan, predicted } from "../state.js";
import { Empty, Meter, Pointer } from "../ui.js";

export const id = "plan";
export const title = "Plan";

export function Panel() {
  const of = plan.value;
  const total = predicted.value;
  if (!of || !total) return html`<${Empty} title="No plan yet">The plan comes with the first picture.<//>`;
  const on = of.effects.filter((/** @type {any} */ effect) => effect.state === "on");
  const max = Math.max(...on.map((/** @type {any} */ effect) => effect.est.ms ?? 0));
  return html`<p class="lead">${on.length} effects are on. The picture should take ${duration(total.ms)} and ${count(total.rays)} rays.</p>
    <ul class="plain-list">${on.map((/** @type {any} */ effect) => html`<li key=${effect.effect} class="effect">
      <strong>${effect.effect.replaceAll("_", " ")}</strong>
      <${Meter} value=${effect.est.ms} max=${max} label=${effect.est.ms === null ? "no rays of its own" : duration(effect.est.ms)} />
      <p class="quiet">${effect.reason}</p>
      <p>${effect.because.map((/** @type {string} */ pointer) => html`<${Pointer} key=${pointer} pointer=${pointer} />`)}</p>
    </li>`)}</ul>`;
}
