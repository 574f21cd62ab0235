// The map of what each pixel shows: a color for each object, and the objects as a legend that leads to their lines.
import { html } from "../../vendor/preact.js";
import { askJson } from "../api.js";
import { pixel } from "../state.js";
import { Pointer } from "../ui.js";

/** @typedef {{ pointer: string, name: string | null }} Named */
/** @typedef {{ width: number, height: number, values: Float32Array, objects: Named[] }} Objects 0 is nothing, k is the object k - 1 */

/** Objects of the legend. */
const LISTED = 40;

/** Unpacks runs of equal numbers. @param {{ columns: number, rows: number, runs: [number, number][], objects: Named[] }} answer @returns {Objects} */
export function unpacked({ columns, rows, runs, objects }) {
  const values = new Float32Array(columns * rows);
  let at = 0;
  for (const [value, count] of runs) values.fill(value, at, (at += count));
  return { width: columns, height: rows, values, objects };
}

/** A color for a number: hues by the golden angle, so that neighbours differ, in three brightnesses. @param {number} n @returns {[number, number, number]} */
export function colorOf(n) {
  const hue = (n * 137.508) % 360;
  const light = [0.62, 0.45, 0.78][n % 3];
  const channel = (/** @type {number} */ shift) => {
    const k = (shift + hue / 30) % 12;
    return Math.round(255 * (light - 0.55 * Math.min(light, 1 - light) * Math.max(-1, Math.min(k - 3, 9 - k, 1))));
  };
  return [channel(0), channel(8), channel(4)];
}

/** Pixels in the colors of their objects; where nothing is the picture shows. @param {Float32Array} values */
export function painted(values) {
  const pixels = new Uint8ClampedArray(values.length * 4);
  for (let i = 0; i < values.length; i += 1) if (values[i] > 0) pixels.set([...colorOf(values[i]), 255], 4 * i);
  return pixels;
}

/** @param {{ body: string, type: string, query: Record<string, any>, signal: AbortSignal }} request */
export const loadObjects = async (request) => unpacked(await askJson("v1/map", { ...request, query: { ...request.query, of: "object", format: "json" } }));

/** @param {{ of: Objects }} props */
export function ObjectLegend({ of }) {
  const counts = new Map();
  for (const value of of.values) counts.set(value, (counts.get(value) ?? 0) + 1);
  const listed = [...counts].filter(([value]) => value > 0).sort((a, b) => b[1] - a[1]);
  const share = (/** @type {number} */ count) => `${((100 * count) / of.values.length).toFixed(1)} %`;
  return html`<table class="table"><caption class="hidden-visually">Objects in sight</caption><thead><tr><th scope="col">Object</th><th scope="col" class="number">Pixels</th></tr></thead>
    <tbody>${listed.slice(0, LISTED).map(([value, count]) => {
      const { pointer, name } = of.objects[value - 1];
      return html`<tr key=${pointer}><td><span class="swatch" style=${{ background: `rgb(${colorOf(value).join(" ")})` }}></span><${Pointer} pointer=${pointer}>${name ?? undefined}<//></td><td class="number">${share(count)}</td></tr>`;
    })}</tbody></table>
    ${listed.length > LISTED && html`<p class="quiet">and ${listed.length - LISTED} more</p>`}
    ${pixel.value === null && html`<p class="quiet">Each object leads to its line.</p>`}`;
}
