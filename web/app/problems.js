// Where a problem is in the text, and the change that its "did you mean" offers. No effects.
import { keysOf, nodeOf, plain } from "./pointers.js";

/** @typedef {import("./state.js").SceneProblem} SceneProblem */
/** @typedef {SceneProblem & { pointer: string }} TextProblem */
/** @typedef {import("./pointers.js").Syntax} Syntax */
/** @typedef {{ from: number, to: number, insert: string, word: string }} Fix */

/** The place of a byte in a text: the service counts bytes, the editor UTF-16 units. @param {string} text @param {number} line from 1 @param {number} column bytes from 1 */
export function placeOf(text, line, column) {
  let from = 0;
  for (let at = 1; at < line; at += 1) {
    const end = text.indexOf("\n", from);
    if (end < 0) return text.length;
    from = end + 1;
  }
  let bytes = column - 1;
  let place = from;
  while (bytes > 0 && place < text.length && text[place] !== "\n") {
    const code = /** @type {number} */ (text.codePointAt(place));
    bytes -= code < 0x80 ? 1 : code < 0x800 ? 2 : code < 0x10000 ? 3 : 4;
    place += code < 0x10000 ? 1 : 2;
  }
  return place;
}

/** The line of a place, from 1. @param {string} text @param {number} place */
export function lineOf(text, place) {
  let line = 1;
  for (let at = text.indexOf("\n"); at >= 0 && at < place; at = text.indexOf("\n", at + 1)) line += 1;
  return line;
}

/** A problem in words, of a setting with its name. @param {SceneProblem} problem */
export const wordsOf = ({ parameter, detail }) => (parameter === undefined ? detail : `${parameter}: ${detail}`);

/** Whether a problem is one of the text; others are of the settings. @param {SceneProblem} problem @returns {problem is TextProblem} */
export const isOfText = (problem) => problem.pointer !== undefined;

/** @param {string} text @param {Syntax} syntax @param {TextProblem} problem @returns {{ from: number, to: number }} */
export function rangeOf(text, syntax, problem) {
  if (problem.code === "invalid-json" && syntax.error) {
    const from = Math.min(syntax.error.at, Math.max(0, text.length - 1));
    return { from, to: Math.min(text.length, from + 1) };
  }
  const node = nodeOf(syntax, problem.pointer);
  if (node && node.pointer === plain(problem.pointer)) return problem.code === "unknown-key" && node.key ? node.key : trimmed(text, node);
  if (problem.line !== undefined) {
    const from = placeOf(text, problem.line, problem.column ?? 1);
    const word = /[-+.\w]+|"[^"\n]*"|\S?/y;
    word.lastIndex = from;
    return { from, to: from + Math.max(1, word.exec(text)?.[0].length ?? 1) };
  }
  return node ? trimmed(text, node) : { from: 0, to: Math.min(1, text.length) };
}

/** Of a long value its first line: an underlined scene helps nobody. @param {string} text @param {{ from: number, to: number }} node */
function trimmed(text, { from, to }) {
  const end = text.indexOf("\n", from);
  return { from, to: end < 0 ? to : Math.min(to, end) };
}

/** @param {Syntax} syntax @param {TextProblem} problem @returns {Fix | null} */
export function fixOf(syntax, problem) {
  const word = /did you mean "((?:[^"\\]|\\.)*)"/.exec(problem.detail)?.[1];
  const node = syntax.nodes.get(plain(problem.pointer));
  if (word === undefined || !node) return null;
  const isKey = problem.code === "unknown-key" || (node.kind !== "string" && keysOf(problem.pointer).length > 0);
  const place = isKey ? node.key : node;
  return place ? { from: place.from, to: place.to, insert: JSON.stringify(word), word } : null;
}
