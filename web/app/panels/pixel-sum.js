// The foot of the panel: what each ray adds, in the order in which the renderer adds it, and whether that is the pixel.
import { computed, html, useState } from "../../vendor/preact.js";
import { Button, Icon } from "../ui.js";
import { answer, chosen, pointed, sample } from "./pixel-asked.js";
import { KINDS, colorOf, largest, short } from "./pixel-rays.js";

/** Lines that are shown at first, and at most. */
const [FEW, MOST] = [6, 500];

/** The rays of the sample that add something. */
const adding = computed(() => {
  const of = answer.value?.grown;
  return of ? of.tree.rays.filter(({ id, contribution }) => of.sample[id] === sample.value && largest(contribution) !== 0) : [];
});

/** As many digits as tell the number from its neighbours. @param {number} value */
const digits = (value) => (value === 0 ? "0" : short(value, 6));

/** What the check says. @param {import("./pixel-asked.js").Answer} of */
function verdictOf({ grown: { tree }, sum }) {
  switch (sum.verdict) {
    case "exact":
      return { icon: /** @type {const} */ ("check"), text: "= the pixel, to the last bit", why: `added by this page ${tree.precision === "single" ? "in single precision, each sum rounded as the renderer does" : "in double precision"}` };
    case "close":
      return { icon: /** @type {const} */ ("check"), text: "= the pixel", why: `up to the last bit, since ${tree.samples} samples are no power of two` };
    case "truncated":
      return { icon: /** @type {const} */ ("warning"), text: "not the pixel", why: "there are more rays than the service records, so that some are missing here" };
    default:
      return { icon: /** @type {const} */ ("warning"), text: "≠ the pixel", why: "this should never be; please report the scene and the pixel" };
  }
}

export function Sum() {
  const [isLong, setLong] = useState(false);
  const of = /** @type {import("./pixel-asked.js").Answer} */ (answer.value);
  const { tree } = of.grown;
  const count = tree.samples;
  const all = adding.value;
  const listed = isLong ? all.slice(0, MOST) : all.slice(0, all.length <= FEW + 2 ? FEW + 2 : FEW);
  const rest = all.length - listed.length;
  const own = of.sum.samples[sample.value] ?? [0, 0, 0];
  const verdict = verdictOf(of);
  const cells = (/** @type {ArrayLike<number>} */ values) => [0, 1, 2].map((c) => html`<td key=${c} class="number mono">${digits(values[c])}</td>`);
  return html`<section class="pixel-sum" aria-label="Contributions">
    <h3>What adds up</h3>
    <table class="table sum-table"><caption class="hidden-visually">Contributions of the rays in the order in which they are added</caption>
      <thead><tr><th scope="col">ray</th><th scope="col" class="number">red</th><th scope="col" class="number">green</th><th scope="col" class="number">blue</th></tr></thead>
      <tbody>
        ${listed.map((ray) => html`<tr key=${ray.id} class=${String(ray.id) === chosen.value ? "chosen" : ""} onPointerEnter=${() => (pointed.value = String(ray.id))} onPointerLeave=${() => (pointed.value = "")}>
          <th scope="row"><button type="button" class="sum-ray" onClick=${() => (chosen.value = String(ray.id))}><i class="pixel-swatch small" style=${{ background: colorOf(ray.contribution, count) }}></i>${KINDS[ray.kind].letter}${ray.id}</button></th>
          ${cells(ray.contribution.map((value) => value * count))}</tr>`)}
        ${rest > 0 && html`<tr class="rest"><td colspan="4"><${Button} kind="quiet" press=${() => setLong(true)}>${rest} more${isLong ? " are not listed" : ""}<//></td></tr>`}
      </tbody>
      <tfoot>
        ${count > 1 && html`<tr><th scope="row">sample ${sample.value + 1}</th>${cells(own)}</tr>`}
        ${largest(tree.raised) > 0 && html`<tr><th scope="row" title="Added so that the pixel lies in the middle of what it may be">raised</th>${cells(tree.raised)}</tr>`}
        <tr class="sum-total"><th scope="row">${count > 1 ? `mean of ${count}` : "sum"}</th>${cells(of.sum.sum)}</tr>
      </tfoot>
    </table>
    <p class=${`verdict ${of.sum.verdict}`}><${Icon} name=${verdict.icon} /><strong>${verdict.text}</strong><span class="quiet">${verdict.why}</span></p>
  </section>`;
}
