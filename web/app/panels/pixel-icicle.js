// The rays of a sample as an icicle: each is as wide as the share of the pixel that comes through it; what may lack is hatched.
import { computed, html } from "../../vendor/preact.js";
import { answer, chosen, pointed, sample } from "./pixel-asked.js";
import { KINDS, largest, short, targetOf } from "./pixel-rays.js";

/** Levels that are drawn. */
const LEVELS = 10;
const ROW = 15;
const WIDTH = 1000;
/** Narrower parts are left out: they could be neither seen nor hit. */
const LEAST = 2;

/** @typedef {{ id: number, level: number, from: number, width: number }} Part */

/** @param {import("./pixel-rays.js").Grown} grown @param {number} root @param {number} lacking @returns {Part[]} */
export function partsOf({ children, total }, root, lacking) {
  const weight = (/** @type {number} */ id) => total[3 * id] + total[3 * id + 1] + total[3 * id + 2];
  const all = weight(root) + lacking;
  if (!(all > 0 && all < 1e300)) return [];
  /** @type {Part[]} */
  const parts = [];
  const open = [{ id: root, level: 0, from: 0 }];
  for (let next = open.pop(); next; next = open.pop()) {
    const { id, level } = next;
    const width = (WIDTH * weight(id)) / all;
    if (width < LEAST || level >= LEVELS) continue;
    parts.push({ ...next, width });
    let { from } = next;
    for (const child of children[id]) {
      open.push({ id: child, level: level + 1, from });
      from += (WIDTH * weight(child)) / all;
    }
  }
  return parts;
}

const drawn = computed(() => {
  const of = answer.value?.grown;
  if (!of) return [];
  const { lacking, samples } = of.tree;
  return partsOf(of, of.roots[sample.value] ?? 0, (lacking[0] + lacking[1] + lacking[2]) / samples);
});

export function Icicle() {
  const of = /** @type {import("./pixel-asked.js").Answer} */ (answer.value);
  const { tree, roots, total } = of.grown;
  const root = roots[sample.value] ?? 0;
  const parts = drawn.value;
  if (parts.length === 0) return null;
  const levels = Math.max(...parts.map(({ level }) => level)) + 1;
  const height = levels * ROW;
  const share = (/** @type {number} */ id) => (total[3 * id] + total[3 * id + 1] + total[3 * id + 2]) / ((total[3 * root] + total[3 * root + 1] + total[3 * root + 2]) || 1);
  const used = parts.find(({ id }) => id === root)?.width ?? WIDTH;
  const current = Number.parseInt(chosen.value, 10);
  const under = pointed.value === "" ? -1 : Number.parseInt(pointed.value, 10);
  return html`<figure class="icicle">
    <svg viewBox=${`0 0 ${WIDTH} ${height}`} preserveAspectRatio="none" style=${{ height: `${height}px` }} role="img"
      aria-label="Share of the pixel that comes through each ray; the list below says the same" onPointerLeave=${() => (pointed.value = "")}>
      <defs><pattern id="hatched" width="10" height="6" patternUnits="userSpaceOnUse"><path d="M0 6L10 0" /></pattern></defs>
      ${parts.map(({ id, level, from, width }) => {
        const ray = tree.rays[id];
        return html`<rect key=${id} x=${from} y=${level * ROW} width=${Math.max(1, width - 1.5)} height=${ROW - 1.5} class=${`kind-${ray.kind}${id === current ? " chosen" : ""}${id === under ? " pointed" : ""}`}
          onClick=${() => (chosen.value = String(id))} onPointerEnter=${() => (pointed.value = String(id))}><title>${`${KINDS[ray.kind].letter} to ${targetOf(ray).name}: ${short(100 * share(id))} %`}</title></rect>`;
      })}
      ${used < WIDTH - LEAST && html`<rect class="lacking" x=${used} y="0" width=${WIDTH - used} height=${ROW - 1.5}><title>what may lack, at most</title></rect>`}
    </svg>
    <div class="icicle-letters" aria-hidden="true" style=${{ height: `${height}px` }}>${parts.filter(({ width }) => width > 45).map(({ id, level, from, width }) => html`<span key=${id} style=${{ left: `${from / 10}%`, width: `${width / 10}%`, top: `${level * ROW}px` }}>${KINDS[tree.rays[id].kind].letter}${width > 260 ? ` ${short(100 * share(id), 2)} %` : ""}</span>`)}</div>
    <figcaption class="quiet">Width: share of the ${tree.samples > 1 ? "sample" : "pixel"}.${largest(tree.lacking) > 0 ? " Hatched: what may lack." : ""}</figcaption>
  </figure>`;
}
