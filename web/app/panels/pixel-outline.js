// The rays of a sample as an outline: each below the one that sent it, with what was not followed as dashed stubs.
import { html, useEffect, useRef, useState } from "../../vendor/preact.js";
import { nodeOf, valueAt } from "../pointers.js";
import { lit, reveal, scene, syntax, text } from "../state.js";
import { answer, chosen, closed, places, pointed, rows, sample } from "./pixel-asked.js";
import { KINDS, codesOf, colorOf, isBlocked, isTotal, largest, lastOf, mediaOf, nameOf, short, targetOf, whyOf } from "./pixel-rays.js";

/** @typedef {import("./pixel-rays.js").Row} Row */
/** @typedef {import("./pixel-rays.js").Kind} Kind */

/** Height of a row in CSS pixels at 16 pixels a rem; two lines. */
const ROW = 2.75;
/** From so many rows on, only those in sight are in the page. */
const ALL = 200;
/** Levels that are indented; deeper ones say their depth. */
const INDENTED = 9;

/** A kind of ray: letter, dashes and color, since none of them says it alone. @param {{ kind: Kind, ended?: boolean }} props */
export const Badge = ({ kind, ended }) => html`<svg class=${`ray-badge kind-${kind}${ended ? " ended" : ""}`} viewBox="0 0 22 20" aria-hidden="true">
  <rect x="1" y="0.5" width="20" height="14" rx="3" /><text x="11" y="11.2">${KINDS[kind].letter}</text>
  <path d="M0 18H22" stroke-dasharray=${ended ? "1.5 2.5" : KINDS[kind].dash} />
</svg>`;

/** The line of a pointer in the text, or 0. @param {string | null} pointer */
export function lineOf(pointer) {
  const node = pointer === null ? null : nodeOf(syntax.value, pointer);
  return node ? text.value.slice(0, node.key?.from ?? node.from).split("\n").length : 0;
}

/** What a ray ends at, with the kind of the body where it has no name: "plane 0". @param {import("./pixel-rays.js").Ray} ray */
export function targetWith(ray) {
  const target = targetOf(ray);
  if (target.pointer === null || ray.hit?.name) return target;
  const kinds = Object.keys(valueAt(scene.value, target.pointer) ?? {});
  return kinds.length === 1 ? { ...target, name: target.name.replace(/^object(?= \d+$)|^\S*light(?= \d+$)/, kinds[0] + (ray.hit ? "" : " light")) } : target;
}

/** The name of the medium of a body: that of its material, as far as the tree says it. @param {string} pointer */
export function mediumName(pointer) {
  const hit = answer.value?.grown.tree.rays.find(({ hit }) => (hit?.body ?? hit?.object) === pointer)?.hit;
  return hit && hit.material !== "default" ? (hit.material.split("/").at(-1) ?? "").replaceAll("~1", "/").replaceAll("~0", "~") : lastOf(pointer);
}

/** Words that only screen readers need: others see a letter, a bar, or a place. @param {{ words: string }} props */
const Hidden = ({ words }) => html`<span class="hidden-visually">${words}${" "}</span>`;

/** @param {{ row: Row, scale: number, most: number }} props */
function Content({ row: { ray, stub, level }, scale, most }) {
  const tree = /** @type {import("./pixel-asked.js").Answer} */ (answer.value).grown;
  const deep = level > INDENTED ? html`<span class="ray-deep">${level}</span>` : null;
  if (stub) {
    return html`${deep}<${Badge} kind=${stub.kind} ended /><span class="ray-main"><span class="ray-top"><${Hidden} words=${`${KINDS[stub.kind].name},`} /><span class="ray-name">not followed</span>
      <${Hidden} words=", weight" /><span class="ray-weight">${short(largest(stub.weight) * scale)}</span></span>
      <span class="ray-below">${whyOf(stub)} · ${codesOf(stub.codes)}</span></span>`;
  }
  const target = targetWith(ray);
  const line = lineOf(target.pointer);
  const media = mediaOf(tree, ray, mediumName);
  const weight = largest(ray.weight) * scale;
  const flags = [isTotal(tree.tree, ray) && "total reflection", isBlocked(ray) && "blocked"].filter(Boolean).join(", ");
  const own = largest(ray.contribution) > 0;
  return html`${deep}<${Badge} kind=${ray.kind} /><span class="ray-main">
    <span class="ray-top"><${Hidden} words=${`${KINDS[ray.kind].name}, to`} /><bdi class="ray-name" title=${target.name}>${target.name}</bdi>
      ${line > 0 && html`<${Hidden} words=", line" /><span class="ray-line" title="To this line (Enter)" onClick=${() => reveal(/** @type {string} */ (target.pointer))}>${line}</span>`}
      <${Hidden} words=", weight" /><span class="ray-bar"><span style=${{ width: `${Math.min(100, 100 * weight)}%` }}></span></span><span class="ray-weight">${short(weight)}</span></span>
    <span class="ray-below">${ray.hit && html`<span>t ${short(ray.hit.t)}</span>`}
      ${(media.length > 1 || media[0] !== "air") && html`<span class="ray-media">${media.map((name, at) => html`${at > 0 && html`<i>›</i>`}<bdi class="chip">${name}</bdi>`)}</span>`}
      ${flags !== "" && html`<span class="ray-flag">${flags}</span>`}
      ${own && html`<span class="ray-own" title="What it adds itself"><i style=${{ background: colorOf(ray.contribution, scale) }}></i>${short((100 * largest(ray.contribution)) / (most || 1), 2)} %</span>`}
    </span></span>`;
}

/** Moves in the outline as in any tree (WAI-ARIA: tree view). @param {KeyboardEvent} event */
function onKey(event) {
  const list = rows.peek();
  const at = places.peek().get(chosen.peek()) ?? -1;
  const row = list[Math.max(0, at)];
  if (!row || event.altKey || event.ctrlKey || event.metaKey) return;
  const go = (/** @type {number} */ to) => (chosen.value = nameOf(list[Math.min(list.length - 1, Math.max(0, to))]));
  const fold = (/** @type {boolean} */ isClosed) => {
    const next = new Set(closed.peek());
    if (isClosed) next.add(row.ray.id);
    else next.delete(row.ray.id);
    closed.value = next;
  };
  const keys = /** @type {Record<string, () => void>} */ ({
    ArrowDown: () => go(at + 1),
    ArrowUp: () => go(at - 1),
    Home: () => go(0),
    End: () => go(list.length - 1),
    PageDown: () => go(at + 8),
    PageUp: () => go(at - 8),
    ArrowRight: () => (row.open === false ? fold(false) : row.open === true && go(at + 1)),
    ArrowLeft: () => (row.open === true ? fold(true) : go(list.findLastIndex((of, i) => i < at && of.level < row.level))),
    "*": () => (closed.value = new Set()),
    Enter: () => jump(row),
  });
  // Letters go to the next ray of that kind.
  const letter = event.key.length === 1 ? event.key.toUpperCase() : "";
  const isOfKind = (/** @type {Row} */ of) => KINDS[of.stub?.kind ?? of.ray.kind].letter === letter;
  const move = keys[event.key] ?? (list.some(isOfKind) ? () => {
    const after = list.findIndex((of, i) => i > at && isOfKind(of));
    go(after >= 0 ? after : list.findIndex(isOfKind));
  } : null);
  if (!move) return;
  event.preventDefault();
  event.stopPropagation();
  move();
}

/** @param {Row} row */
function jump({ ray, stub }) {
  const { pointer } = targetOf(ray);
  if (pointer !== null && !stub) reveal(pointer);
}

export function Outline() {
  const box = useRef(/** @type {HTMLElement | null} */ (null));
  const [top, setTop] = useState(0);
  const list = rows.value;
  const of = /** @type {import("./pixel-asked.js").Answer} */ (answer.value);
  const scale = of.grown.tree.samples;
  const most = largest(of.sum.samples[sample.value] ?? [1]) / scale;
  const rem = Number.parseFloat(getComputedStyle(document.documentElement).fontSize) || 16;
  const height = ROW * rem;
  const seen = (box.current?.clientHeight ?? 400) / height;
  const from = list.length <= ALL ? 0 : Math.max(0, Math.floor(top / height) - 8);
  const to = list.length <= ALL ? list.length : Math.min(list.length, Math.ceil(top / height + seen) + 8);
  const at = places.value.get(chosen.value) ?? -1;
  useEffect(() => {
    const element = box.current;
    if (!element || at < 0) return;
    const [above, below] = [at * height, (at + 1) * height - element.clientHeight];
    if (element.scrollTop > above) element.scrollTop = above;
    else if (element.scrollTop < below) element.scrollTop = below;
  }, [at, of]);
  const over = (/** @type {Row | null} */ row) => {
    pointed.value = row ? nameOf(row) : "";
    const pointer = row && !row.stub ? targetOf(row.ray).pointer : null;
    lit.value = pointer === null ? [] : [pointer];
  };
  const visible = list.slice(from, to);
  return html`<div class="ray-tree" role="tree" aria-label="Rays of the pixel" tabindex="0" ref=${box} onKeyDown=${onKey}
    aria-activedescendant=${at >= from && at < to ? `ray-${chosen.value}` : undefined}
    onScroll=${(/** @type {Event} */ event) => list.length > ALL && setTop(/** @type {HTMLElement} */ (event.currentTarget).scrollTop)} onPointerLeave=${() => over(null)}>
    <div role="presentation" style=${{ height: `${from * ROW}rem` }}></div>
    ${visible.map((row) => html`<div key=${nameOf(row)} role="treeitem" id=${`ray-${nameOf(row)}`} class=${`ray-row${row.stub ? " stub" : ""}${nameOf(row) === pointed.value ? " pointed" : ""}`}
      aria-level=${row.level} aria-posinset=${row.place} aria-setsize=${row.siblings} aria-expanded=${row.open === null ? undefined : String(row.open)}
      aria-selected=${String(nameOf(row) === chosen.value)}
      onClick=${() => (chosen.value = nameOf(row))} onDblClick=${() => jump(row)} onPointerEnter=${() => over(row)}>
      <span class="ray-indent" style=${{ width: `${0.625 * (Math.min(row.level, INDENTED) - 1)}rem` }}></span>
      <span class=${`ray-fold${row.open === null ? " none" : row.open ? " open" : ""}`} onClick=${(/** @type {Event} */ event) => row.open !== null && (event.stopPropagation(), toggle(row.ray.id))}></span>
      <${Content} row=${row} scale=${scale} most=${most} />
    </div>`)}
    <div role="presentation" style=${{ height: `${(list.length - to) * ROW}rem` }}></div>
  </div>`;
}

/** @param {number} id */
function toggle(id) {
  const next = new Set(closed.peek());
  if (!next.delete(id)) next.add(id);
  closed.value = next;
}
