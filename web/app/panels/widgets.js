// Small parts of Accuracy, Compare, Maps and Jobs.
import { html, useState } from "../../vendor/preact.js";

/** @typedef {import("../../vendor/preact.js").ComponentChildren} Children */

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

/**
 * A bar as long as its value, with a whisker for an interval. Tiny is a hairline, absent is nothing.
 * @param {{ value: number | null, max: number, low?: number, high?: number, label: string }} props
 */
export function Meter({ value, max, low, high, label }) {
  const share = (/** @type {number} */ of) => `${Math.min(100, (100 * of) / (max || 1))}%`;
  return html`<span class="meter" role="img" aria-label=${label} title=${label}>
    ${value !== null && html`<span class="meter-bar" style=${{ width: share(value) }}></span>`}
    ${low !== undefined && high !== undefined && html`<span class="meter-whisker" style=${{ left: share(low), width: share(Math.min(high, max) - low) }}></span>`}
  </span>`;
}

/**
 * A table that can be sorted by its columns.
 * @template Row
 * @param {{ caption: string, rows: Row[], rowKey: (row: Row) => string, sort?: [string, 1 | -1],
 *   columns: { id: string, title: string, by?: (row: Row) => number | string, cell: (row: Row) => Children, number?: boolean }[] }} props
 */
export function Table({ caption, columns, rows, rowKey, sort }) {
  const [[by, direction], setSort] = useState(/** @type {[string, 1 | -1]} */ (sort ?? ["", 1]));
  const column = columns.find(({ id }) => id === by);
  const value = column?.by;
  const sorted = value ? rows.toSorted((a, b) => (value(a) < value(b) ? -direction : value(a) > value(b) ? direction : 0)) : rows;
  const turn = (/** @type {string} */ id) => setSort([id, id === by ? (direction === 1 ? -1 : 1) : -1]);
  return html`<table class="table"><caption class="hidden-visually">${caption}</caption>
    <thead><tr>${columns.map(({ id, title, by: sortable, number }) => html`<th key=${id} scope="col" class=${number ? "number" : ""}
      aria-sort=${id === by ? (direction === 1 ? "ascending" : "descending") : undefined}>${sortable
        ? html`<button type="button" class="sort" onClick=${() => turn(id)}>${title}</button>` : title}</th>`)}</tr></thead>
    <tbody>${sorted.map((row) => html`<tr key=${rowKey(row)}>${columns.map(({ id, cell, number }) => html`<td key=${id} class=${number ? "number" : ""}>${cell(row)}</td>`)}</tr>`)}</tbody>
  </table>`;
}
