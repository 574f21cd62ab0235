// The farm: its nodes, what waits for them, and what goes wrong. Only a service that has a farm shows it.
import { effect, html, signal, untracked } from "../../vendor/preact.js";
import { askJson, pause } from "../api.js";
import { count } from "../report.js";
import { connection, key, panel, panels } from "../state.js";
import { Empty, Icon } from "../ui.js";
import { age, alarmsOf, sentenceOf, tilesPerSecond } from "./farm-model.js";
import { Fact, Failure, Meter, Table } from "./widgets.js";

export const id = "farm";
export const title = "Farm";

/** @typedef {import("./farm-model.js").Farm} Farm */

/** Milliseconds between two questions. */
const EVERY = 2000;
/** Answers that the rate is taken over. */
const SPAN = 5;

const answers = signal(/** @type {{ at: number, farm: Farm }[]} */ ([]));
const trouble = signal("");

/** @param {AbortSignal} ended */
async function ask(ended) {
  try {
    const { farm } = await askJson("v1/farm", { signal: ended });
    if (farm) answers.value = [...answers.peek().slice(1 - SPAN), { at: performance.now(), farm }];
    trouble.value = "";
    return farm !== null;
  } catch (error) {
    if (!ended.aborted) trouble.value = /** @type {Error} */ (error).message;
    return false;
  }
}

export function start() {
  // Whether there is a farm at all, once for each key.
  effect(() => {
    const known = key.value;
    if (!connection.value.online || untracked(() => panels.value.some((of) => of.id === id))) return;
    const ended = new AbortController();
    ask(ended.signal).then((isThere) => isThere && known === key.peek() && !panels.peek().some((of) => of.id === id) && (panels.value = [...panels.peek(), { id, title, Panel }]));
    return () => ended.abort();
  });
  effect(() => {
    if (panel.value !== id || !connection.value.online || !panels.value.some((of) => of.id === id)) return;
    const ended = new AbortController();
    (async () => {
      while (!ended.signal.aborted) {
        if (document.visibilityState === "visible") await ask(ended.signal);
        await pause(EVERY, ended.signal);
      }
    })().catch(() => {});
    return () => ended.abort();
  });
}

const COLUMNS = [
  { id: "name", title: "Node", by: (/** @type {any} */ of) => of.name, cell: (/** @type {any} */ of) => html`${of.name}${of.reason && html`<br /><span class="bad">${of.reason}</span>`}` },
  { id: "state", title: "State", by: (/** @type {any} */ of) => of.state, cell: (/** @type {any} */ of) => html`${of.state}${!of.same_renderer && html`<br /><span class="quiet">version ${of.version}</span>`}` },
  { id: "busy", title: "Slots", by: (/** @type {any} */ of) => of.slots, cell: (/** @type {any} */ of) => html`<${Meter} value=${of.busy} max=${of.slots} label=${`${of.busy} of ${of.slots} slots`} /> ${of.busy}/${of.slots}` },
  { id: "tiles", title: "Tiles", number: true, by: (/** @type {any} */ of) => of.tiles, cell: (/** @type {any} */ of) => count(of.tiles) },
  { id: "failures", title: "Failed", number: true, by: (/** @type {any} */ of) => of.failures, cell: (/** @type {any} */ of) => count(of.failures) },
  { id: "started", title: "Up", number: true, by: (/** @type {any} */ of) => of.started_s, cell: (/** @type {any} */ of) => age(of.started_s) },
];

export function Panel() {
  const now = answers.value.at(-1);
  if (!now) return trouble.value !== "" ? html`<${Failure} error=${trouble.value} />` : html`<${Empty} title="No figures yet">The service is asked.<//>`;
  const { farm } = now;
  const rate = tilesPerSecond(answers.value.length > 1 ? answers.value[0] : null, now);
  const { backlog_seconds: backlog, trouble: wrong } = farm;
  const alarms = alarmsOf(farm);
  return html`<div class=${trouble.value !== "" || !connection.value.online ? "farm is-stale" : "farm"}>
    <p class="lead">${sentenceOf(farm)}</p>
    <${Meter} value=${farm.busy} max=${Math.max(1, farm.slots)} label=${`${farm.busy} of ${farm.slots} slots are busy`} />
    ${alarms.length > 0 && html`<ul class="plain-list farm-alarms" role="status">${alarms.map((alarm) => html`<li key=${alarm}><${Icon} name="warning" /><span>${alarm}</span></li>`)}</ul>`}
    ${trouble.value !== "" && html`<${Failure} error=${trouble.value} />`}
    <h3 class="section">Work that waits, in time of one slot</h3>
    <dl class="facts"><${Fact} name="Somebody waits for it" value=${age(backlog.hi)} /><${Fact} name="Jobs" value=${age(backlog.norm)} /><${Fact} name="Jobs of low priority" value=${age(backlog.bulk)} /></dl>
    <h3 class="section">Done</h3>
    <dl class="facts"><${Fact} name="Tiles a second" value=${rate === null ? "–" : rate.toFixed(1)} />
      <${Fact} name="Tiles" value=${count(farm.done.tiles)} note="of the nodes there are" />
      <${Fact} name="Failed pieces" value=${count(farm.done.failures)} /></dl>
    <h3 class="section">Since this service started</h3>
    <dl class="facts"><${Fact} name="Lost and sent again" value=${count(wrong.sent_again)} /><${Fact} name="Slow and rendered twice" value=${count(wrong.rendered_twice)} />
      <${Fact} name="Given up" value=${count(wrong.dead_letters)} /><${Fact} name="Tiles with different pixels" value=${count(wrong.determinism_alarms)} />
      <${Fact} name="Refused by the broker" value=${count(wrong.broker_errors)} /></dl>
    <h3 class="section">Nodes</h3>
    ${farm.each === null ? html`<p class="quiet">Keys with the scope “admin” see them one by one.</p>`
      : farm.each.length === 0 ? html`<p class="quiet">None. Start one with <code>strahl node</code>.</p>`
      : html`<div class="scroll-x"><${Table} caption="Nodes" columns=${COLUMNS} rows=${farm.each} rowKey=${(/** @type {any} */ of) => of.id} sort=${["name", 1]} /></div>`}
  </div>`;
}
