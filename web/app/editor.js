// The editor: CodeMirror 6 in a shadow root, where its styles need no exception from the policy of the page (style-mod puts
// them into adoptedStyleSheets there). Its text and the signal `text` follow each other.
import {
  Annotation, Compartment, Decoration, EditorSelection, EditorState, EditorView, HighlightStyle, Prec, StateEffect, StateField, Transaction, ViewPlugin,
  autocompletion, bracketMatching, closeBrackets, closeBracketsKeymap, codeFolding, completionKeymap, defaultKeymap, drawSelection, foldGutter,
  foldKeymap, highlightActiveLine, highlightSelectionMatches, highlightSpecialChars, history, historyKeymap, indentOnInput, invertedEffects, isolateHistory, json, keymap,
  lineNumbers, lintKeymap, redo, redoDepth, search, searchKeymap, setDiagnostics, syntaxHighlighting, tags, undo, undoDepth,
} from "../vendor/editor.js";
import { effect, untracked } from "../vendor/preact.js";
import { complete, meanings, schema } from "./assist.js";
import { look, more } from "./editor-look.js";
import { nodeAt, nodeOf, objectOf } from "./pointers.js";
import { fixOf, isOfText, rangeOf } from "./problems.js";
import { scrubbing } from "./scrub.js";
import { caret, lit, origin, problems, revealed, setText, steps, syntax, text } from "./state.js";

/** Characters above which a text is not colored, and above which it is only shown. */
const COLORED = 1 << 20;
const SHOWN = 4 << 20;
const HEAD = { lines: 200, characters: 20_000 };

/** Marks changes that come from the signal. */
const outside = Annotation.define();
const setLit = /** @type {import("@codemirror/state").StateEffectType<import("@codemirror/view").DecorationSet>} */ (StateEffect.define());
const litLines = StateField.define({
  create: () => Decoration.none,
  update: (lines, transaction) => transaction.effects.reduce((found, of) => (of.is(setLit) ? of.value : found), lines.map(transaction.changes)),
  provide: (field) => EditorView.decorations.from(field),
});
const litLine = Decoration.line({ class: "cm-lit" });

/** @typedef {import("./state.js").Origin} Origin */
/** What the text came from is a step of undo, together with the text. */
const setOrigin = /** @type {import("@codemirror/state").StateEffectType<{ from: Origin, to: Origin }>} */ (StateEffect.define());
const originField = StateField.define({
  create: () => origin.peek(),
  update: (before, transaction) => transaction.effects.reduce((found, of) => (of.is(setOrigin) ? of.value.to : found), before),
});
const undoneOrigin = invertedEffects.of((transaction) => transaction.effects.flatMap((of) => (of.is(setOrigin) ? [setOrigin.of({ from: of.value.to, to: of.value.from })] : [])));

const language = new Compartment();
const writable = new Compartment();

/** Tells the rest of the page, before all other plugins see the new syntax. */
const telling = Prec.highest(
  ViewPlugin.define((view) => ({
    update(update) {
      if (update.docChanged && !update.transactions.some((of) => of.annotation(outside))) setText(update.state.doc.toString(), update.state.field(originField));
      if (update.docChanged || update.selectionSet) {
        caret.value = nodeAt(syntax.peek(), update.state.selection.main.head)?.pointer ?? "";
        const can = (/** @type {number} */ depth, /** @type {typeof undo} */ step) => (depth > 0 ? () => void step(view) : null);
        if (update.docChanged) steps.value = { undo: can(undoDepth(update.state), undo), redo: can(redoDepth(update.state), redo) };
      }
    },
  })),
);

const colors = HighlightStyle.define([
  { tag: tags.propertyName, class: "tok-key" },
  { tag: tags.string, class: "tok-string" },
  { tag: tags.number, class: "tok-number" },
  { tag: [tags.bool, tags.null], class: "tok-word" },
]);

const extensions = [
  telling,
  lineNumbers(),
  highlightSpecialChars(),
  history(),
  originField,
  undoneOrigin,
  codeFolding(),
  foldGutter(),
  drawSelection(),
  indentOnInput(),
  bracketMatching(),
  closeBrackets(),
  autocompletion({ override: [complete], activateOnTyping: true, icons: false }),
  highlightActiveLine(),
  highlightSelectionMatches(),
  search({ top: true }),
  syntaxHighlighting(colors),
  meanings,
  scrubbing,
  litLines,
  EditorView.lineWrapping,
  EditorView.contentAttributes.of({ "aria-label": "Scene as JSON", tabindex: "0", spellcheck: "false", autocorrect: "off", autocapitalize: "off" }),
  // Tab leaves the editor, so it is no trap (WCAG 2.1.2). Ctrl-Enter renders, which the page does.
  keymap.of([
    { key: "Mod-Enter", run: () => true },
    ...closeBracketsKeymap, ...completionKeymap, ...searchKeymap, ...historyKeymap, ...foldKeymap, ...lintKeymap,
    ...defaultKeymap.filter(({ key }) => key !== "Mod-Enter" && key !== "Alt-ArrowUp" && key !== "Alt-ArrowDown"),
    { key: "Escape", run: (view) => (view.contentDOM.blur(), true) },
  ]),
  look,
];

/** The least change from one text to the other. @param {string} from @param {string} to */
function difference(from, to) {
  let start = 0;
  const shorter = Math.min(from.length, to.length);
  while (start < shorter && from[start] === to[start]) start += 1;
  let end = 0;
  while (end < shorter - start && from[from.length - 1 - end] === to[to.length - 1 - end]) end += 1;
  return { from: start, to: from.length - end, insert: to.slice(start, to.length - end) };
}

/** @param {string} whole */
const head = (whole) => `${whole.slice(0, HEAD.characters).split("\n", HEAD.lines).join("\n")}\n…`;

/** Puts an editor into an element. @param {HTMLElement} host @returns {Promise<EditorView>} */
export async function start(host) {
  // First the schema: swatches that come later would move the lines.
  await schema().catch(() => null);
  const root = host.attachShadow({ mode: "open" });
  root.adoptedStyleSheets.push(more);
  const isLong = (/** @type {string} */ of) => of.length > SHOWN;
  const shownOf = (/** @type {string} */ of) => (isLong(of) ? head(of) : of);
  const stateOf = (/** @type {string} */ of) => EditorState.create({ doc: shownOf(of), extensions: [extensions, language.of([]), writable.of([])] });
  const view = new EditorView({ root, parent: root, state: stateOf(text.peek()) });
  let wasLong = isLong(text.peek());
  // Signals may change while the editor updates itself.
  const soon = (/** @type {() => void} */ run) => queueMicrotask(run);

  effect(() => {
    const next = text.value;
    const isJson = origin.value.type === "application/json" && next.length <= COLORED;
    untracked(() => soon(() => {
      const current = text.peek();
      const shown = shownOf(current);
      // Undo must not bring the head of a long text as if it were all of it.
      const isFresh = wasLong !== isLong(current);
      if (isFresh) {
        wasLong = !wasLong;
        view.setState(stateOf(current));
        steps.value = { undo: null, redo: null };
      }
      const now = view.state.doc.toString();
      const another = originChange(view);
      const effects = [
        ...another,
        language.reconfigure(isJson ? json() : []),
        writable.reconfigure(isLong(current) ? [EditorState.readOnly.of(true), EditorView.editable.of(false)] : []),
      ];
      if (now !== shown) view.dispatch({ changes: difference(now, shown), annotations: [outside.of(true), isolateHistory.of("full"), Transaction.addToHistory.of(!isLong(current))], effects });
      else if (isFresh || another.length > 0 || (language.get(view.state) instanceof Array) === isJson) view.dispatch({ effects, annotations: Transaction.addToHistory.of(false) });
    }));
  });
  effect(() => {
    const all = problems.value;
    soon(() => view.dispatch(setDiagnostics(view.state, all.filter(isOfText).map((problem) => diagnostic(view, problem)))));
  });
  effect(() => {
    const pointers = lit.value;
    soon(() => view.dispatch({ effects: setLit.of(linesOf(view, pointers)) }));
  });
  effect(() => {
    const of = revealed.value;
    if (of) soon(() => show(view, of.pointer));
  });
  return view;
}

/** What tells the history that the text comes from elsewhere, if it does. @param {EditorView} view */
function originChange(view) {
  const [from, to] = [view.state.field(originField), origin.peek()];
  return from.name === to.name && from.type === to.type ? [] : [setOrigin.of({ from, to })];
}

/** @param {EditorView} view @param {import("./problems.js").TextProblem} problem @returns {import("@codemirror/lint").Diagnostic} */
function diagnostic(view, problem) {
  const { length } = view.state.doc;
  const { from, to } = rangeOf(text.peek(), syntax.peek(), problem);
  const fix = fixOf(syntax.peek(), problem);
  const actions = fix ? [{ name: `Write "${fix.word}"`, apply: () => view.dispatch({ changes: { from: fix.from, to: fix.to, insert: fix.insert }, annotations: isolateHistory.of("full") }) }] : [];
  return { from: Math.min(from, length), to: Math.min(Math.max(to, from), length), severity: "error", message: problem.detail, actions };
}

/** @param {EditorView} view @param {string[]} pointers */
function linesOf(view, pointers) {
  const starts = new Set();
  for (const pointer of pointers) {
    const node = nodeOf(syntax.peek(), pointer);
    if (!node || node.pointer === "" || node.to > view.state.doc.length) continue;
    const last = view.state.doc.lineAt(node.to).number;
    for (let line = view.state.doc.lineAt(node.from).number; line <= last && starts.size < 500; line += 1) starts.add(view.state.doc.line(line).from);
  }
  return Decoration.set([...starts].sort((a, b) => a - b).map((from) => litLine.range(from)));
}

/** @param {EditorView} view @param {string} pointer */
function show(view, pointer) {
  const node = nodeOf(syntax.peek(), pointer);
  if (!node || node.to > view.state.doc.length) return;
  const isObject = objectOf(node.pointer) === node.pointer;
  const anchor = isObject || node.to - node.from > 200 ? node.from : node.to;
  view.dispatch({ selection: EditorSelection.single(anchor, node.from), effects: EditorView.scrollIntoView(node.from, { y: "center" }) });
  view.focus();
}
