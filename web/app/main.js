// The start of the page: its layout and what it begins with.
import { html, render } from "../vendor/preact.js";
import { panels } from "./panels/registry.js";
import { openPanel, panel, panelsOpen } from "./state.js";
import { Tabs } from "./ui.js";

function App() {
  const open = panels.find(({ id }) => id === panel.value) ?? panels[0];
  return html`<div class=${panelsOpen.value ? "shell" : "shell no-panels"}>
    <header class="bar"></header>
    <section class="edit" aria-label="Scene"></section>
    <div class="split split-a"></div>
    <section class="picture" aria-label="Picture"></section>
    <div class="split split-b"></div>
    <section class="panels" aria-label="Panels">
      <${Tabs} label="Panels" tabs=${panels} chosen=${open.id} choose=${openPanel}><${open.Panel} /><//>
    </section>
    <footer class="strip"></footer>
  </div>`;
}

render(html`<${App} />`, /** @type {HTMLElement} */ (document.getElementById("app")));
for (const { start } of panels) start?.();
