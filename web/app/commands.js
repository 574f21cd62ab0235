// Everything that can be done, with its key.
import { signal } from "../vendor/preact.js";
import { renderNow } from "./picture.js";
import { actualSize, fit, zoomBy } from "./looking.js";
import { isOfText } from "./problems.js";
import { caret, deep, dialog, live, openPanel, panels, panelsOpen, pane, pixel, problems, reveal, steps, tool } from "./state.js";
import { turnTheme } from "./theme.js";

/** @typedef {{ title: string, keys?: string, run: () => void, inText?: boolean }} Command `keys`: as "Ctrl-K"; `inText`: also while one types */

/** Whether single letters are commands (WCAG 2.1.4). */
export const letters = signal(true);
let walked = -1;

/** The next problem of the text. */
export function nextProblem() {
  const all = problems.peek().filter(isOfText);
  if (all.length > 0) reveal(all[(walked = (walked + 1) % all.length)].pointer);
}

/** Moves the focus to the next pane, or the one before. @param {1 | -1} by */
function nextPane(by) {
  const panes = [...document.querySelectorAll("[data-pane-focus]")].filter((of) => of.checkVisibility());
  const at = panes.findIndex((of) => of.contains(document.activeElement));
  const next = panes[(at + by + panes.length) % panes.length];
  const host = next?.querySelector(".editor-host");
  const inside = host?.shadowRoot?.querySelector(".cm-content") ?? next?.querySelector("canvas, [role=tab][aria-selected=true], button");
  /** @type {HTMLElement | null | undefined} */ (inside)?.focus();
}

/** Commands of panels: they add theirs at the start. */
export const more = signal(/** @type {Command[]} */ ([]));

/** @returns {Command[]} */
export const commands = () => [
  { title: "Render as the scene says", keys: "Ctrl-Enter", run: renderNow, inText: true },
  { title: live.peek() ? "Pause: edits wait" : "Live: edits render by themselves", keys: "P", run: () => (live.value = !live.peek()) },
  ...panels.peek().map(({ id, title }, index) => ({ title: `Panel: ${title}`, keys: String(index + 1), run: () => openPanel(id) })),
  { title: "Edit the text", keys: "E", run: () => ((pane.value = "edit"), reveal(caret.peek())) },
  { title: "Examples", keys: "O", run: () => (dialog.value = "examples") },
  { title: "Share: link, command line, files", keys: "S", run: () => (dialog.value = "share") },
  { title: "Fit the picture", keys: "0", run: fit },
  { title: "One pixel to one of the screen", keys: "1:1", run: actualSize },
  { title: "Zoom in", keys: "+", run: () => zoomBy(1.5) },
  { title: "Zoom out", keys: "-", run: () => zoomBy(1 / 1.5) },
  { title: deep.peek() ? "Zoom shows pixels" : "Zoom traces more detail", keys: "D", run: () => (deep.value = !deep.peek()) },
  { title: tool.peek() === "orbit" ? "Look: a drag moves the picture" : "Camera: a drag orbits", keys: "C", run: () => (tool.value = tool.peek() === "orbit" ? "look" : "orbit") },
  { title: "Clear the pixel cursor", run: () => (pixel.value = null) },
  { title: "Next problem", keys: "F8", run: nextProblem, inText: true },
  { title: "Undo", keys: "Ctrl-Z", run: () => steps.peek().undo?.() },
  { title: "Redo", keys: "Ctrl-Shift-Z", run: () => steps.peek().redo?.() },
  { title: "Next pane", keys: "F6", run: () => nextPane(1), inText: true },
  { title: "Pane before", keys: "Shift-F6", run: () => nextPane(-1), inText: true },
  { title: "Show or hide the panels", keys: "B", run: () => (panelsOpen.value = !panelsOpen.peek()) },
  { title: "Theme: system, dark, light", keys: "T", run: turnTheme },
  { title: "Key for the service", run: () => (dialog.value = "key") },
  { title: "All commands", keys: "Ctrl-K", run: () => (dialog.value = "commands"), inText: true },
  { title: "Help", keys: "?", run: () => (dialog.value = "help") },
  ...more.peek(),
];

/** The name of a key event as commands have it. @param {KeyboardEvent} event */
function nameOf(event) {
  const parts = [];
  if (event.ctrlKey || event.metaKey) parts.push("Ctrl");
  const letter = event.key.length === 1 ? event.key.toUpperCase() : event.key;
  if (event.shiftKey && (parts.length > 0 || event.key.length > 1)) parts.push("Shift");
  return [...parts, letter].join("-");
}

/** Whether the event comes from a place where one types. @param {KeyboardEvent} event */
function isTyping(event) {
  const target = /** @type {HTMLElement | undefined} */ (event.composedPath()[0]);
  return target instanceof HTMLElement && (target.isContentEditable || ["INPUT", "TEXTAREA", "SELECT"].includes(target.tagName));
}

/** Runs the commands of the keyboard from now on. */
export function listen() {
  addEventListener("keydown", (event) => {
    if (event.defaultPrevented && event.key !== "Enter") return;
    if (event.altKey || (dialog.peek() !== "" && event.key !== "Escape")) return;
    const name = nameOf(event);
    const typing = isTyping(event);
    const found = commands().find((of) => of.keys === name || (of.keys && name === `Shift-${of.keys}` && of.keys.length === 1));
    if (!found || (typing && !found.inText)) return;
    if (name.length === 1 && !letters.peek()) return;
    event.preventDefault();
    found.run();
  });
}
