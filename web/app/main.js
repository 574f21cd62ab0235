// The start of the page: its layout and what it begins with.
import { effect, html, render, useEffect, useSignal } from "../vendor/preact.js";
import { Bar } from "./bar.js";
import * as commands from "./commands.js";
import { Dialogs } from "./dialogs.js";
import { EditPane } from "./edit-pane.js";
import { PicturePane } from "./picture-pane.js";
import * as picking from "./picking.js";
import * as picture from "./picture.js";
import { isDropping, takeDrops } from "./scenes.js";
import * as session from "./session.js";
import { dialog, missing, notice, openPanel, pane, panel, panels, panelsOpen, shown, title, version } from "./state.js";
import { Strip } from "./strip.js";
import { Button, Icon, Split, Tabs } from "./ui.js";

/** Milliseconds that a sentence stays at the foot, and for each of its letters if that is longer. */
const NOTICED = 6000;
const READ = 60;

/** Milliseconds that the panels wait for the first picture. */
const PATIENCE = 1000;

function Notice() {
  const of = notice.value;
  useEffect(() => {
    if (!of) return;
    const timer = setTimeout(() => (notice.value = null), Math.max(NOTICED, READ * of.text.length));
    return () => clearTimeout(timer);
  }, [of]);
  return html`<div class="notices" role="status">${of && (of.action || of.version === version.value) && html`<p class="notice">${of.text}
    ${of.action && html`<${Button} kind="quiet" press=${() => ((notice.value = null), of.action?.run())}>${of.action.label}<//>`}</p>`}</div>`;
}

/** Tabs at the foot of a phone. */
function PhoneBar() {
  const tabs = /** @type {const} */ ([["edit", "Edit", "edit"], ["plan", "Plan", "panel"], ["pixel", "Pixel", "cursor"], ["accuracy", "Accuracy", "compare"]]);
  const shown = tabs.filter(([id]) => id === "edit" || panels.value.some((of) => of.id === id));
  return html`<nav class="phone-bar" aria-label="Panes">
    ${shown.map(([id, title, icon]) => html`<button type="button" key=${id} class="phone-tab" aria-current=${pane.value === id ? "page" : undefined}
      onClick=${() => (id === "edit" ? (pane.value = id) : openPanel(id))}><${Icon} name=${icon} />${title}</button>`)}
    <button type="button" class="phone-tab" onClick=${() => (dialog.value = "commands")}><${Icon} name="more" />More</button>
  </nav>`;
}

function App() {
  const open = panels.value.find(({ id }) => id === panel.value) ?? panels.value[0];
  const widths = useSignal({ edit: 0, panels: 0 });
  const { edit, panels: right } = widths.value;
  const style = { "--edit-width": edit > 0 ? `${edit}px` : null, "--panels-width": right > 0 ? `${right}px` : null };
  return html`<div class=${`shell on-${pane.value === "edit" ? "edit" : "panels"}${panelsOpen.value ? "" : " no-panels"}`} style=${style}>
    <${Bar} />
    <${EditPane} />
    <${Split} label="Width of the text" place="split-a" of=".edit" change=${(/** @type {number} */ width) => (widths.value = { ...widths.peek(), edit: width })} />
    <main class="main"><${PicturePane} /></main>
    <${Split} label="Width of the panels" place="split-b" of=".panels" fromRight change=${(/** @type {number} */ width) => (widths.value = { ...widths.peek(), panels: width })} />
    <section class="panels" aria-label="Panels" data-pane-focus>
      ${open && html`<${Tabs} label="Panels" tabs=${panels.value} chosen=${open.id} choose=${openPanel}><${open.Panel} /><//>`}
    </section>
    <${Strip} />
    <${PhoneBar} />
    <${Dialogs} />
    <${Notice} />
    ${isDropping.value && html`<p class="drop">Drop a scene or a model</p>`}
  </div>`;
}

const app = /** @type {HTMLElement} */ (document.getElementById("app"));
picture.start();
session.start();
render(html`<${App} />`, app);
picking.start();
commands.listen();
takeDrops();

let isLoading = false;
/** The panels come after the first picture, or when it does not come. */
async function loadPanels() {
  if (isLoading) return;
  isLoading = true;
  const found = await import("./panels/registry.js").catch(missing);
  // The next picture tries again.
  if (!found) return void (isLoading = false);
  const { panels: all, later } = found;
  panels.value = all;
  for (const { start } of [...all, ...later]) start?.();
}
effect(() => {
  if (shown.value) loadPanels();
});
setTimeout(loadPanels, PATIENCE);
effect(() => {
  document.title = `${title.value || "a scene"} · strahl`;
});
