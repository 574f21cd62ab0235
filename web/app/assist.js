// Completion and hover in the editor, from the schema of scenes.
import { hoverTooltip, syntaxTree } from "../vendor/editor.js";
import { askJson } from "./api.js";
import { keysOf, nodeAt, valueOf } from "./pointers.js";
import { keysAt, meaningAt, valuesAt } from "./schema.js";
import { scene, syntax } from "./state.js";

/** @typedef {import("@codemirror/autocomplete").CompletionContext} CompletionContext */
/** @typedef {import("@codemirror/autocomplete").Completion} Completion */
/** @typedef {import("@lezer/common").SyntaxNode} SyntaxNode */
/** @typedef {import("@codemirror/state").EditorState} EditorState */

let asked = /** @type {Promise<any> | null} */ (null);
/** The schema, once it is here. */
export let known = /** @type {any} */ (null);
/** The last scene that was JSON: names stay known while one types. */
let lastScene = /** @type {any} */ (null);

/** The schema, asked for once. @returns {Promise<any>} */
export function schema() {
  asked ??= askJson("schema/scene.json", { accept: "application/schema+json" }).then(
    (found) => (known = found),
    (error) => {
      asked = null;
      throw error;
    },
  );
  return asked;
}

/** Keys and indices of the value or key at a node. The tree of the editor holds also where the text is not JSON. @param {EditorState} state @param {SyntaxNode} node */
function pathOf(state, node) {
  const path = [];
  for (let at = /** @type {SyntaxNode | null} */ (node); at; at = at.parent) {
    const parent = at.parent;
    if (parent?.name === "Array" && at.name !== "[" && at.name !== "]") {
      let index = 0;
      for (let before = at.prevSibling; before; before = before.prevSibling) if (!["[", "]", ",", "⚠"].includes(before.name)) index += 1;
      path.unshift(String(index));
    } else if (at.name === "Property") path.unshift(keyOf(state, at));
  }
  return path;
}

/** @param {EditorState} state @param {SyntaxNode} property */
function keyOf(state, property) {
  const name = property.getChild("PropertyName");
  const text = name ? state.sliceDoc(name.from, name.to) : "";
  return String(valueOf(text, text.replaceAll('"', "")));
}

/** @param {CompletionContext} context */
export async function complete(context) {
  const { state, pos } = context;
  const word = context.matchBefore(/"?[\w$#.-]*/);
  if (!word || (word.from === word.to && !context.explicit)) return null;
  const root = await schema().catch(() => null);
  if (!root) return null;
  lastScene = scene.peek() ?? lastScene;
  let node = syntaxTree(state).resolveInner(pos, -1);
  while (node.name === "⚠" && node.parent) node = node.parent;
  const property = node.name === "PropertyName" ? node.parent : null;
  const isKey = property !== null || node.name === "Object" || node.name === "{";
  const closing = state.sliceDoc(pos, pos + 1) === '"' ? 1 : 0;
  if (isKey) {
    const object = property?.parent ?? (node.name === "{" ? /** @type {SyntaxNode} */ (node.parent) : node);
    const present = object.getChildren("Property").filter((of) => of.from !== property?.from).map((of) => keyOf(state, of));
    const hasValue = /^\s*:/.test(state.sliceDoc(pos + closing, pos + closing + 20));
    const options = keysAt(root, pathOf(state, object), present).map((choice) => ({
      label: choice.name,
      detail: choice.isRequired ? "required" : "",
      info: choice.about,
      boost: choice.isRequired ? 10 : 0,
      type: "property",
      apply: applied(hasValue ? JSON.stringify(choice.name) : `${JSON.stringify(choice.name)}: ${choice.insert}`, closing),
    }));
    return { from: word.from + (word.text.startsWith('"') ? 1 : 0), options, validFor: /^[\w$-]*$/ };
  }
  const path = pathOf(state, node);
  const options = valuesAt(root, path, lastScene).map((choice) => ({
    label: choice.name.replaceAll('"', ""),
    info: choice.about,
    type: "enum",
    apply: applied(choice.insert, closing),
  }));
  return options.length === 0 ? null : { from: word.from + (word.text.startsWith('"') ? 1 : 0), options, validFor: /^[\w$#.-]*$/ };
}

/** Puts a text in the place of a word and its quotation marks. @param {string} insert @param {number} closing @returns {Completion["apply"]} */
function applied(insert, closing) {
  return (view, _completion, from, to) => {
    const start = view.state.sliceDoc(from - 1, from) === '"' ? from - 1 : from;
    // The caret goes to the first thing that one will want to change.
    const inside = /(?:: |\{ \S+ )/.exec(insert);
    const at = inside && inside.index > 0 ? start + inside.index + 2 : start + insert.length;
    view.dispatch({ changes: { from: start, to: to + closing, insert }, selection: { anchor: at, head: start + insert.length }, userEvent: "input.complete" });
  };
}

/** What the value under the pointer means. */
export const meanings = hoverTooltip(async (view, at) => {
  const node = nodeAt(syntax.peek(), at);
  if (!node || node.pointer === "") return null;
  const root = await schema().catch(() => null);
  const meaning = root && meaningAt(root, keysOf(node.pointer));
  if (!meaning || (meaning.about === "" && meaning.range === "")) return null;
  const place = node.key && at <= node.key.to ? node.key : node;
  if (node.kind === "object" && place === node) return null;
  return {
    pos: place.from,
    end: place.to,
    above: true,
    create: () => {
      const dom = document.createElement("div");
      dom.className = "meaning";
      for (const [name, words] of [["strong", meaning.title], ["span", meaning.about], ["small", meaning.range]]) {
        if (words === "") continue;
        const part = document.createElement(name);
        part.textContent = words;
        dom.append(part);
      }
      return { dom };
    },
  };
});
