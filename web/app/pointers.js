// JSON pointers and where they are in the text: a scanner that keeps what it has read when the text is not JSON (yet).

/** @typedef {"object" | "array" | "string" | "number" | "literal"} Kind */
/** @typedef {{ pointer: string, kind: Kind, from: number, to: number, key: { from: number, to: number } | null, parent: Node | null, size: number }} Node */
/** @typedef {{ nodes: Map<string, Node>, root: Node | null, error: { at: number, detail: string } | null }} Syntax */

/** Elements of an array that get nodes if they are no objects. The numbers of a mesh would be too many. */
const LISTED = 256;
/** Deeper texts are refused by the service, too. */
const DEEPEST = 127;

/** @param {string} text @returns {Syntax} */
export function scan(text) {
  /** @type {Map<string, Node>} */
  const nodes = new Map();
  let at = 0;

  /** @param {string} detail @returns {never} */
  const fail = (detail) => {
    throw { at, detail };
  };
  const space = () => {
    while (at < text.length && " \t\n\r".includes(text[at])) at += 1;
  };
  const string = () => {
    const from = at;
    for (at += 1; text[at] !== '"'; at += 1) {
      if (at >= text.length || text[at] === "\n") fail("this string does not end");
      if (text[at] === "\\") at += 1;
    }
    at += 1;
    return { from, to: at };
  };
  /** @param {string} pointer @param {Node | null} parent @param {Node["key"]} key @param {number} depth @param {boolean} listed @returns {Node} */
  const value = (pointer, parent, key, depth, listed) => {
    space();
    const first = text[at];
    const kind = first === "{" ? "object" : first === "[" ? "array" : first === '"' ? "string" : /[-\d]/.test(first ?? "") ? "number" : "literal";
    /** @type {Node} */
    const node = { pointer, kind, from: at, to: text.length, key, parent, size: 0 };
    if (listed || kind === "object") nodes.set(pointer, node);
    if (depth > DEEPEST) fail("too deep");
    if (kind === "object") object(node, depth);
    else if (kind === "array") array(node, depth, listed);
    else if (kind === "string") string();
    else {
      const word = /[-+.\w]*/y;
      word.lastIndex = at;
      const found = word.exec(text)?.[0] ?? "";
      if (found === "" || (kind === "literal" && !["true", "false", "null"].includes(found))) fail("a value is missing here");
      at += found.length;
    }
    node.to = at;
    return node;
  };
  /** @param {Node} node @param {number} depth */
  const object = (node, depth) => {
    at += 1;
    space();
    while (text[at] !== "}") {
      if (text[at] !== '"') fail(at >= text.length ? "this object does not end" : "the name of a key is missing here");
      const key = string();
      const name = valueOf(text.slice(key.from, key.to), text.slice(key.from + 1, key.to - 1));
      space();
      if (text[at] !== ":") fail("a colon is missing here");
      at += 1;
      value(`${node.pointer}/${escaped(name)}`, node, key, depth + 1, true);
      node.size += 1;
      separator("}");
    }
    at += 1;
  };
  /** @param {Node} node @param {number} depth @param {boolean} listed */
  const array = (node, depth, listed) => {
    at += 1;
    space();
    while (text[at] !== "]") {
      if (at >= text.length) fail("this list does not end");
      value(`${node.pointer}/${node.size}`, node, null, depth + 1, listed && node.size < LISTED);
      node.size += 1;
      separator("]");
    }
    at += 1;
  };
  /** @param {string} end */
  const separator = (end) => {
    space();
    if (text[at] === ",") {
      at += 1;
      space();
      if (text[at] === end) fail("there is nothing after this comma");
    } else if (text[at] !== end) fail("a comma is missing here");
  };

  try {
    const root = value("", null, null, 0, true);
    space();
    if (at < text.length) fail("there is something after the end");
    return { nodes, root, error: null };
  } catch (error) {
    const wrong = /** @type {{ at: number, detail: string }} */ (error);
    if (typeof wrong.at !== "number") throw error;
    return { nodes, root: nodes.get("") ?? null, error: wrong };
  }
}

/** The deepest node that holds a place. @param {Syntax} syntax @param {number} at @returns {Node | null} */
export function nodeAt(syntax, at) {
  let best = null;
  for (const node of syntax.nodes.values()) {
    const from = node.key?.from ?? node.from;
    if (from <= at && at <= node.to && (!best || from >= (best.key?.from ?? best.from))) best = node;
  }
  return best;
}

/** The node of a pointer, or of what holds it. @param {Syntax} syntax @param {string} pointer @returns {Node | null} */
export function nodeOf(syntax, pointer) {
  for (let path = plain(pointer); ; path = path.slice(0, path.lastIndexOf("/"))) {
    const node = syntax.nodes.get(path);
    if (node) return node;
    if (!path.includes("/")) return syntax.root;
  }
}

/** A pointer as the service writes it in problems (`#/a/b`) without its `#`. @param {string} pointer */
export function plain(pointer) {
  if (!pointer.startsWith("#")) return pointer;
  try {
    return decodeURIComponent(pointer.slice(1));
  } catch {
    return pointer.slice(1);
  }
}

/** @param {string} pointer */
export const keysOf = (pointer) => plain(pointer).split("/").slice(1).map((key) => key.replaceAll("~1", "/").replaceAll("~0", "~"));

/** @param {string} key */
export const escaped = (key) => key.replaceAll("~", "~0").replaceAll("/", "~1");

/** The innermost object (`/objects/3`, or one of a group or a definition) that a pointer is in, or null. @param {string} pointer */
export function objectOf(pointer) {
  const found = /^(.*\/(?:objects|definitions\/[^/]+)\/\d+)(?:\/|$)/.exec(plain(pointer));
  return found ? found[1] : null;
}

/** @param {any} value @param {string} pointer */
export function valueAt(value, pointer) {
  return keysOf(pointer).reduce((inside, key) => (inside === null || inside === undefined ? undefined : inside[key]), value);
}

/**
 * The change of the text that gives a pointer a value, adding keys where they are missing.
 * @param {string} text @param {Syntax} syntax @param {string} pointer @param {any} value
 * @returns {{ from: number, to: number, insert: string } | null}
 */
export function editOf(text, syntax, pointer, value) {
  const path = plain(pointer);
  const node = syntax.nodes.get(path);
  if (node) return { from: node.from, to: node.to, insert: written(value) };
  const parent = syntax.nodes.get(path.slice(0, path.lastIndexOf("/")));
  const key = keysOf(path).at(-1);
  if (key === undefined) return null;
  if (!parent) return editOf(text, syntax, path.slice(0, path.lastIndexOf("/")), { [key]: value });
  if (parent.kind !== "object") return null;
  const entry = `${JSON.stringify(key)}: ${written(value)}`;
  const children = [...syntax.nodes.values()].filter((of) => of.parent === parent);
  const last = children.at(-1);
  if (!last) return { from: parent.from + 1, to: parent.from + 1, insert: ` ${entry} ` };
  // On a line of its own if the others are.
  const before = /** @type {{ from: number }} */ (last.key).from;
  const lineStart = text.lastIndexOf("\n", before - 1) + 1;
  const indent = text.slice(lineStart, before);
  const separator = /^\s*$/.test(indent) && lineStart > 0 ? `,\n${indent}` : ", ";
  return { from: last.to, to: last.to, insert: separator + entry };
}

/** JSON on one line with spaces, as people write scenes. @param {any} value @returns {string} */
export function written(value) {
  if (Array.isArray(value)) return `[${value.map(written).join(", ")}]`;
  if (value !== null && typeof value === "object") {
    const entries = Object.entries(value).map(([key, of]) => `${JSON.stringify(key)}: ${written(of)}`);
    return entries.length > 0 ? `{ ${entries.join(", ")} }` : "{}";
  }
  return JSON.stringify(value) ?? "null";
}

/** A number with five significant digits. @param {number} value */
export const rounded = (value) => Number(value.toPrecision(5)) || 0;

/** A value, or what stands for it if the text is no JSON. @param {string} json @param {any} [other] @returns {any} */
export function valueOf(json, other = null) {
  try {
    return JSON.parse(json);
  } catch {
    return other;
  }
}
