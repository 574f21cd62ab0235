// Shared widgets, without state of the page.
import { html, useEffect, useId, useRef } from "../vendor/preact.js";
import { nodeOf, plain } from "./pointers.js";
import { reveal, syntax, text } from "./state.js";

/** @typedef {import("../vendor/preact.js").ComponentChildren} Children */

/** Paths of 16 x 16 icons, drawn with lines. */
const ICONS = {
  close: "M4 4 12 12M12 4 4 12",
  undo: "M6.5 3 3 6.5 6.5 10M3.5 6.5H10a3 3 0 0 1 0 6H7",
  redo: "M9.5 3 13 6.5 9.5 10M12.5 6.5H6a3 3 0 0 0 0 6h3",
  play: "M5 3.2 12.5 8 5 12.8Z",
  pause: "M5.5 3.5v9M10.5 3.5v9",
  share: "M8 10V2.5M5 5l3-2.7L11 5M3.5 8v5h9V8",
  lock: "M4 7.5h8v6H4zM5.5 7.5V5a2.5 2.5 0 0 1 5 0v2.5",
  unlock: "M4 7.5h8v6H4zM5.5 7.5V5a2.5 2.5 0 0 1 4.8-.8",
  help: "M6 6a2 2 0 1 1 2.8 1.9c-.6.3-.8.7-.8 1.4M8 11.8v.2",
  sun: "M8 5.2a2.8 2.8 0 1 0 0 5.6 2.8 2.8 0 0 0 0-5.6M8 1.5V3M8 13v1.5M1.5 8H3M13 8h1.5M3.4 3.4l1 1M11.6 11.6l1 1M3.4 12.6l1-1M11.6 4.4l1-1",
  moon: "M13 9.5A5.5 5.5 0 0 1 6.5 3 5.5 5.5 0 1 0 13 9.5Z",
  plus: "M8 3.5v9M3.5 8h9",
  minus: "M3.5 8h9",
  fit: "M3 6V3h3M10 3h3v3M13 10v3h-3M6 13H3v-3",
  orbit: "M8 5.8a2.2 2.2 0 1 0 0 4.4 2.2 2.2 0 0 0 0-4.4M2 8c0-1.6 2.7-2.9 6-2.9s6 1.3 6 2.9-2.7 2.9-6 2.9-6-1.3-6-2.9",
  cursor: "M8 2v4M8 10v4M2 8h4M10 8h4",
  panel: "M2.5 3.5h11v9h-11zM10 3.5v9",
  edit: "M6 4 2.5 8 6 12M10 4l3.5 4L10 12",
  more: "M3.5 8h.1M8 8h.1M12.5 8h.1",
  images: "M2.5 3.5h11v9h-11zM2.5 10.5 6 7.5l3 2.5 2-1.5 2.5 2",
  check: "M3.5 8.5 6.5 11.5 12.5 4.5",
  warning: "M8 2.5 14 13H2zM8 6.5v3M8 11.4v.1",
  copy: "M5.5 5.5h7v8h-7zM10 5.5v-3H3.5v8h2",
  search: "M7 3a4 4 0 1 0 0 8 4 4 0 0 0 0-8M10 10l3.5 3.5",
  compare: "M2.5 3.5h11v9h-11zM8 2v12",
};
/** @typedef {keyof typeof ICONS} IconName */

/** A picture beside words; alone it needs a label on its button. @param {{ name: IconName }} props */
export const Icon = ({ name }) => html`<svg class="icon" viewBox="0 0 16 16" aria-hidden="true"><path d=${ICONS[name]} /></svg>`;

/**
 * A button. With `pressed` it is a toggle.
 * @param {{ label?: string, icon?: IconName, children?: Children, press: (event: MouseEvent) => void, kind?: "plain" | "quiet" | "main",
 *   pressed?: boolean, disabled?: boolean, keys?: string, title?: string }} props
 */
export function Button({ label, icon, children, press, kind = "plain", pressed, disabled, keys, title }) {
  const hint = title ?? label;
  return html`<button type="button" class=${`button ${kind}${icon && !children ? " only-icon" : ""}`} aria-label=${label}
    aria-pressed=${pressed === undefined ? undefined : String(pressed)} aria-keyshortcuts=${keys} disabled=${disabled}
    title=${hint && keys ? `${hint} (${keys.replaceAll("+", "-").replace("Control", "Ctrl")})` : hint} onClick=${press}
  >${icon && html`<${Icon} name=${icon} />`}${children}</button>`;
}

/**
 * Tabs with their panel; the arrows choose (WAI-ARIA: tabs with automatic activation).
 * @param {{ label: string, tabs: { id: string, title: string }[], chosen: string, choose: (id: string) => void, children: Children }} props
 */
export function Tabs({ label, tabs, chosen, choose, children }) {
  const list = useRef(/** @type {HTMLElement | null} */ (null));
  useEffect(() => {
    list.current?.querySelector("[aria-selected=true]")?.scrollIntoView({ block: "nearest", inline: "nearest" });
  }, [chosen]);
  const move = (/** @type {KeyboardEvent} */ event) => {
    const at = tabs.findIndex(({ id }) => id === chosen);
    const to = { ArrowRight: at + 1, ArrowLeft: at - 1 + tabs.length, Home: 0, End: tabs.length - 1 }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    choose(tabs[to % tabs.length].id);
    /** @type {HTMLElement | undefined} */ (list.current?.children[to % tabs.length])?.focus();
  };
  return html`<div class="tabs">
    <div class="tab-list" role="tablist" aria-label=${label} onKeyDown=${move} ref=${list}>
      ${tabs.map(({ id, title }) => html`<button type="button" key=${id} role="tab" id=${`tab-${id}`} class="tab" aria-selected=${String(id === chosen)}
        aria-controls="tab-panel" tabindex=${id === chosen ? 0 : -1} onClick=${() => choose(id)}>${title}</button>`)}
    </div>
    <div class="tab-panel" role="tabpanel" id="tab-panel" aria-labelledby=${`tab-${chosen}`} tabindex="0">${children}</div>
  </div>`;
}

/**
 * A dialog that keeps the keyboard inside and gives it back. @param {{ title: string, close: () => void, children: Children, wide?: boolean }} props
 */
export function Dialog({ title, close, children, wide }) {
  const dialog = useRef(/** @type {HTMLDialogElement | null} */ (null));
  const id = useId();
  useEffect(() => dialog.current?.showModal(), []);
  // A press on the backdrop is one on the dialog itself.
  const outside = (/** @type {MouseEvent} */ event) => event.target === dialog.current && close();
  return html`<dialog ref=${dialog} class=${wide ? "dialog wide" : "dialog"} aria-labelledby=${id} onClose=${close} onMouseDown=${outside}>
    <div class="dialog-head"><h2 id=${id}>${title}</h2><${Button} label="Close" icon="close" kind="quiet" press=${close} /></div>
    <div class="dialog-body">${children}</div>
  </dialog>`;
}

/** A link to the line of a pointer. @param {{ pointer: string, children?: Children }} props */
export function Pointer({ pointer, children }) {
  const node = nodeOf(syntax.value, pointer);
  const line = node ? text.value.slice(0, node.key?.from ?? node.from).split("\n").length : 0;
  return html`<button type="button" class="pointer" title=${`${plain(pointer)}${line > 0 ? `, line ${line}` : ""}`} onClick=${() => reveal(pointer)}>
    ${children ?? plain(pointer).slice(1).replaceAll("/", " › ")}${line > 0 && html`<span class="line">${line}</span>`}
  </button>`;
}

/** What a panel says while there is nothing. @param {{ title: string, children?: Children }} props */
export const Empty = ({ title, children }) => html`<div class="empty"><p class="empty-title">${title}</p>${children}</div>`;

/**
 * A separator between panes: dragged, or moved by arrow keys. @param {{ label: string, place: string, of: string, fromRight?: boolean, change: (width: number) => void }} props
 */
export function Split({ label, place, of, fromRight, change }) {
  const width = () => document.querySelector(of)?.getBoundingClientRect().width ?? 0;
  const now = useRef(/** @type {HTMLElement | null} */ (null));
  const set = (/** @type {number} */ to) => {
    const next = Math.round(Math.max(256, Math.min(innerWidth - 560, to)));
    now.current?.setAttribute("aria-valuenow", String(next));
    change(next);
  };
  const drag = (/** @type {PointerEvent} */ event) => {
    const target = /** @type {HTMLElement} */ (event.currentTarget);
    target.setPointerCapture(event.pointerId);
    const start = width();
    const move = (/** @type {PointerEvent} */ moved) => set(start + (moved.clientX - event.clientX) * (fromRight ? -1 : 1));
    target.addEventListener("pointermove", move);
    target.addEventListener("lostpointercapture", () => target.removeEventListener("pointermove", move), { once: true });
  };
  const step = (/** @type {KeyboardEvent} */ event) => {
    const by = { ArrowLeft: -24, ArrowRight: 24 }[event.key];
    if (by === undefined) return;
    event.preventDefault();
    set(width() + by * (fromRight ? -1 : 1));
  };
  return html`<div ref=${now} class=${`split ${place}`} role="separator" tabindex="0" aria-orientation="vertical" aria-label=${label} aria-valuemin="256" aria-valuemax=${innerWidth}
    aria-valuenow="400" onPointerDown=${drag} onKeyDown=${step}></div>`;
}
