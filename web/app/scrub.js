// Numbers that one drags and colors that one picks, in the editor: Alt and drag, Alt and arrow keys, or the swatch.
import { Decoration, EditorView, Transaction, ViewPlugin, WidgetType, isolateHistory, keymap } from "../vendor/editor.js";
import { batch } from "../vendor/preact.js";
import { known } from "./assist.js";
import { keysOf, nodeAt, valueOf } from "./pointers.js";
import { isColor } from "./schema.js";
import { syntax } from "./state.js";
import { fromHex, scrubbed, toHex } from "./values.js";

/** @typedef {import("./pointers.js").Node} Node */

/** CSS pixels for one step. */
const PER_STEP = 4;

/** @param {EditorView} view @param {number} at @returns {Node | null} */
function numberAt(view, at) {
  const node = nodeAt(syntax.peek(), at);
  return node?.kind === "number" && node.to <= view.state.doc.length ? node : null;
}

/** @param {EditorView} view @param {{ from: number, to: number }} place @param {string} insert */
function write(view, place, insert) {
  view.dispatch({ changes: { from: place.from, to: place.to, insert } });
}

const dragging = EditorView.domEventHandlers({
  mousedown(event, view) {
    if (!event.altKey || event.button !== 0) return false;
    const at = view.posAtCoords({ x: event.clientX, y: event.clientY });
    const node = at === null ? null : numberAt(view, at);
    if (!node) return false;
    event.preventDefault();
    const start = view.state.sliceDoc(node.from, node.to);
    let to = node.to;
    view.dispatch({ selection: { anchor: node.from, head: node.to } });
    const stop = new AbortController();
    const move = (/** @type {MouseEvent} */ moved) => {
      const steps = Math.round((moved.clientX - event.clientX) / PER_STEP);
      const next = scrubbed(start, steps * (moved.shiftKey ? 10 : 1));
      if (next === view.state.sliceDoc(node.from, to)) return;
      put(next, Transaction.addToHistory.of(false));
    };
    const put = (/** @type {string} */ next, /** @type {import("@codemirror/state").Annotation<any>} */ as) => {
      view.dispatch({ changes: { from: node.from, to, insert: next }, selection: { anchor: node.from, head: node.from + next.length }, annotations: as });
      to = node.from + next.length;
    };
    // The whole way is one step of undo, however long it took.
    const up = () => {
      stop.abort();
      const last = view.state.sliceDoc(node.from, to);
      batch(() => (put(start, Transaction.addToHistory.of(false)), put(last, isolateHistory.of("full"))));
    };
    addEventListener("mousemove", move, { signal: stop.signal });
    addEventListener("mouseup", up, { signal: stop.signal });
    return true;
  },
});

/** @param {number} steps @returns {(view: EditorView) => boolean} */
const stepBy = (steps) => (view) => {
  const node = numberAt(view, view.state.selection.main.head);
  if (!node) return false;
  write(view, node, scrubbed(view.state.sliceDoc(node.from, node.to), steps));
  return true;
};

const keys = keymap.of([
  { key: "Alt-ArrowUp", run: stepBy(1), shift: stepBy(10) },
  { key: "Alt-ArrowDown", run: stepBy(-1), shift: stepBy(-10) },
]);

class Swatch extends WidgetType {
  /** @param {string} hex @param {string} pointer @param {boolean} isText */
  constructor(hex, pointer, isText) {
    super();
    this.hex = hex;
    this.pointer = pointer;
    this.isText = isText;
  }
  /** @param {Swatch} other */
  eq(other) {
    return other.hex === this.hex && other.pointer === this.pointer && other.isText === this.isText;
  }
  /** @param {EditorView} view */
  toDOM(view) {
    const input = document.createElement("input");
    input.type = "color";
    input.className = "swatch";
    input.value = this.hex;
    input.tabIndex = -1;
    input.setAttribute("aria-label", `Color of ${this.pointer.slice(1).replaceAll("/", " ")}`);
    input.addEventListener("input", () => {
      const node = syntax.peek().nodes.get(this.pointer);
      if (node) write(view, node, this.isText ? JSON.stringify(input.value) : `[${fromHex(input.value).join(", ")}]`);
    });
    return input;
  }
  // A picker stays open while its color changes: the element is kept.
  /** @param {HTMLElement} dom */
  updateDOM(dom) {
    if (dom.getAttribute("aria-label") !== `Color of ${this.pointer.slice(1).replaceAll("/", " ")}`) return false;
    /** @type {HTMLInputElement} */ (dom).value = this.hex;
    return true;
  }
  ignoreEvent() {
    return true;
  }
}

/** Swatches of the colors that are in sight. @param {EditorView} view */
function swatches(view) {
  const places = syntax.peek();
  if (!known) return Decoration.none;
  const found = [];
  for (const { from, to } of view.visibleRanges) {
    for (const node of places.nodes.values()) {
      if (node.from < from || node.to > to || (node.kind !== "array" && node.kind !== "string")) continue;
      if (node.kind === "array" ? node.size !== 3 : view.state.sliceDoc(node.from, node.from + 2) !== '"#') continue;
      if (!isColor(known, keysOf(node.pointer))) continue;
      const hex = toHex(valueOf(view.state.sliceDoc(node.from, node.to)));
      if (hex) found.push(Decoration.widget({ widget: new Swatch(hex, node.pointer, node.kind === "string"), side: -1 }).range(node.from));
    }
  }
  return Decoration.set(found, true);
}

const colors = ViewPlugin.fromClass(
  class {
    /** @param {EditorView} view */
    constructor(view) {
      this.decorations = swatches(view);
    }
    /** @param {import("@codemirror/view").ViewUpdate} update */
    update(update) {
      // Halfway through a word what comes behind it is not known: its swatches stay, so that no line moves.
      if (update.docChanged && syntax.peek().error) this.decorations = this.decorations.map(update.changes);
      else if (update.docChanged || update.viewportChanged) this.decorations = swatches(update.view);
    }
  },
  { decorations: (plugin) => plugin.decorations },
);

export const scrubbing = [dragging, keys, colors];
