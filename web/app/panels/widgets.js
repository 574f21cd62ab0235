// Small parts of Accuracy, Compare, Maps and Jobs.
import { html } from "../../vendor/preact.js";

/**
 * One of a few, as radio buttons that look like one control.
 * @param {{ label: string, name: string, options: [string, string][], chosen: string, choose: (id: string) => void, disabled?: string[] }} props
 */
export const Choice = ({ label, name, options, chosen, choose, disabled = [] }) => html`<fieldset class="choice">
  <legend class="hidden-visually">${label}</legend>
  ${options.map(([id, title]) => html`<label key=${id} class=${id === chosen ? "is-chosen" : ""}><input type="radio" name=${name} value=${id} checked=${id === chosen}
    disabled=${disabled.includes(id)} onChange=${() => choose(id)} /><span>${title}</span></label>`)}
</fieldset>`;

/** A name and its value. @param {{ name: string, value: any, note?: any }} props */
export const Fact = ({ name, value, note }) => html`<div class="fact"><dt>${name}</dt><dd>${value}${note ? html`<span class="quiet"> ${note}</span>` : ""}</dd></div>`;

/** A switch. @param {{ label: string, on: boolean, set: (on: boolean) => void }} props */
export const Switch = ({ label, on, set }) =>
  html`<label class="switch"><input type="checkbox" checked=${on} onChange=${(/** @type {any} */ event) => set(event.target.checked)} /><span>${label}</span></label>`;

/** A problem, and a way on. @param {{ error: string, retry?: () => void }} props */
export const Failure = ({ error, retry }) => html`<div class="failure" role="alert"><p>${error}</p>
  ${retry && html`<button type="button" class="button" onClick=${retry}>Try again</button>`}</div>`;
