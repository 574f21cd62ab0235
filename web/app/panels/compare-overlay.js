// The handle of the wipe and the names of A and B, over the picture; and the keys of a comparison.
import { html } from "../../vendor/preact.js";
import { more } from "../commands.js";
import { openPanel, other, size, view } from "../state.js";
import { a, endComparison, exposure, flipped, gain, isOn, mode, wipe } from "./compare-pictures.js";

const clamped = (/** @type {number} */ value) => Math.min(1, Math.max(0, value));

/** Moves the wipe to a place in the viewport. @param {PointerEvent} event */
function drag(event) {
  const handle = /** @type {HTMLElement} */ (event.currentTarget);
  if (event.type === "pointerdown") handle.setPointerCapture(event.pointerId);
  else if (!handle.hasPointerCapture(event.pointerId)) return;
  event.preventDefault();
  event.stopPropagation();
  const left = /** @type {HTMLElement} */ (handle.parentElement).getBoundingClientRect().left;
  wipe.value = clamped((event.clientX - left - view.peek().left) / (size.peek().width * view.peek().scale));
}

/** @param {KeyboardEvent} event */
function nudge(event) {
  const step = event.shiftKey ? 0.1 : 0.01;
  const to = { ArrowLeft: wipe.peek() - step, ArrowRight: wipe.peek() + step, Home: 0, End: 1 }[event.key];
  if (to === undefined) return;
  event.preventDefault();
  event.stopPropagation();
  wipe.value = clamped(to);
}

/** What lies over the viewport, in its coordinates. */
export function Overlay() {
  if (!isOn.value) return null;
  const { left, top, scale, width } = view.value;
  const edge = Math.min(width, Math.max(0, left + wipe.value * size.value.width * scale));
  const isWipe = mode.value === "wipe" && !flipped.value;
  const names = { wipe: "", side: "", flip: "", difference: `difference × ${gain.value}`, "flip map": "FLIP, 0 dark to 1 bright" }[mode.value];
  const stops = exposure.value === 0 ? "" : `, ${exposure.value > 0 ? "+" : ""}${exposure.value} EV, without tone curve`;
  const name = flipped.value ? `B · ${other.value?.label}` : names || `A · ${a.value?.label}`;
  return html`<div class="compare-over">
    ${isWipe && html`<div class="wipe" role="slider" tabindex="0" aria-label="Wipe between A and B" aria-valuemin="0" aria-valuemax="100"
      aria-valuenow=${Math.round(100 * wipe.value)} aria-valuetext=${`A on the left ${Math.round(100 * wipe.value)} %`} style=${{ left: `${edge}px` }}
      onPointerDown=${drag} onPointerMove=${drag} onKeyDown=${nudge}><span class="wipe-grip" aria-hidden="true"></span></div>`}
    <p class="compare-name of-a" style=${{ top: `${Math.max(8, top + 8)}px`, left: `${Math.max(8, left + 8)}px` }}>${name}${stops}</p>
    ${(isWipe || mode.value === "side") && !flipped.value && html`<p class="compare-name of-b" style=${{ top: `${Math.max(8, top + 8)}px`, right: `${Math.max(8, width - left - size.value.width * scale + 8)}px` }}>B · ${other.value?.label}${stops}</p>`}
  </div>`;
}

/** The space bar writes, presses buttons and opens lists. @param {EventTarget | null} target */
const takesSpace = (target) =>
  target instanceof HTMLElement && (target.isContentEditable || target.shadowRoot !== null || target.closest("input, textarea, select, button, a, summary, dialog, [role=treeitem]") !== null);

/** @param {number} stops */
const expose = (stops) => (exposure.value = Math.max(-10, Math.min(10, exposure.peek() + stops)));

/** Adds the commands, and shows B while the space bar is held. */
export function start() {
  const when = (/** @type {() => void} */ run) => () => (isOn.peek() ? run() : openPanel("compare"));
  more.value = [
    ...more.peek(),
    { title: "Wipe or flip between A and B", keys: "W", run: when(() => (mode.value = mode.peek() === "wipe" ? "flip" : "wipe")) },
    { title: "Darker: half a stop", keys: "[", run: when(() => expose(-0.5)) },
    { title: "Brighter: half a stop", keys: "]", run: when(() => expose(0.5)) },
    { title: "End the comparison", run: endComparison },
  ];
  const release = () => (flipped.value = false);
  addEventListener("keydown", (event) => {
    if (event.key !== " " || !isOn.peek() || event.defaultPrevented || event.ctrlKey || event.altKey || event.metaKey || takesSpace(event.composedPath()[0])) return;
    event.preventDefault();
    flipped.value = true;
  });
  addEventListener("keyup", (event) => event.key === " " && release());
  addEventListener("blur", release);
}
