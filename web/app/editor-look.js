// How the editor looks: the tokens of studio.css reach into its shadow root. What the defaults of CodeMirror draw with
// `data:` pictures, which the policy forbids, is drawn with text decoration and letters.
import { EditorView } from "../vendor/editor.js";

export const look = EditorView.theme({
  "&": { height: "100%", backgroundColor: "var(--raised)", color: "var(--ink)", fontSize: "var(--editor-size, 0.78125rem)" },
  "&.cm-focused": { outline: "none" },
  ".cm-scroller": { fontFamily: "var(--mono)", lineHeight: "1.6", scrollbarWidth: "thin" },
  ".cm-content": { padding: "0.5rem 0 4rem", caretColor: "var(--accent)" },
  ".cm-content:focus-visible": { outline: "none" },
  ".cm-line": { padding: "0 0.75rem 0 0.25rem" },
  ".cm-gutters": { backgroundColor: "var(--raised)", color: "var(--quiet)", border: "none", paddingLeft: "0.25rem" },
  ".cm-lineNumbers .cm-gutterElement": { minWidth: "2rem", fontSize: "0.92em" },
  ".cm-foldGutter .cm-gutterElement": { cursor: "pointer", width: "0.9rem" },
  ".cm-foldGutter span": { opacity: "0.75" },
  ".cm-activeLine": { backgroundColor: "color-mix(in srgb, var(--ink) 4%, transparent)" },
  ".cm-lit": { backgroundColor: "color-mix(in srgb, var(--accent) 13%, transparent)", boxShadow: "inset 2px 0 var(--accent)" },
  ".cm-cursor": { borderLeftColor: "var(--accent)", borderLeftWidth: "2px" },
  "&.cm-focused > .cm-scroller > .cm-selectionLayer .cm-selectionBackground, .cm-selectionBackground": {
    background: "color-mix(in srgb, var(--accent) 26%, transparent)",
  },
  ".cm-matchingBracket, &.cm-focused .cm-matchingBracket": { backgroundColor: "transparent", outline: "1px solid var(--edge)" },
  ".cm-selectionMatch": { backgroundColor: "color-mix(in srgb, var(--accent) 14%, transparent)" },
  ".cm-foldPlaceholder": { backgroundColor: "var(--sunken)", border: "1px solid var(--line)", color: "var(--quiet)", padding: "0 0.4em" },
  ".tok-key": { color: "var(--ink)" },
  ".tok-string": { color: "var(--code-string)" },
  ".tok-number": { color: "var(--code-number)" },
  ".tok-word": { color: "var(--code-word)" },
  ".swatch": {
    appearance: "none", width: "0.95em", height: "0.95em", padding: "0", margin: "0 0.35em 0 0.1em", border: "1px solid var(--edge)", borderRadius: "3px",
    verticalAlign: "-0.1em", cursor: "pointer", background: "none", overflow: "hidden",
  },
  ".cm-lintRange-error": { backgroundImage: "none", textDecoration: "underline wavy var(--error)", textDecorationSkipInk: "none", textUnderlineOffset: "0.25em" },
  ".cm-lintPoint-error::after": { borderBottomColor: "var(--error)" },
  ".cm-tooltip": { backgroundColor: "var(--raised)", color: "var(--ink)", border: "1px solid var(--line)", borderRadius: "6px", boxShadow: "var(--shadow)", maxWidth: "26rem", fontFamily: "var(--sans)", fontSize: "0.8125rem" },
  ".cm-tooltip.cm-tooltip-autocomplete > ul": { fontFamily: "var(--mono)", maxHeight: "16rem" },
  ".cm-tooltip.cm-tooltip-autocomplete > ul > li": { padding: "0.15rem 0.6rem", lineHeight: "1.6" },
  ".cm-tooltip-autocomplete ul li[aria-selected]": { background: "var(--accent)", color: "var(--accent-ink)" },
  ".cm-completionDetail": { color: "inherit", opacity: "0.75", fontStyle: "normal", fontFamily: "var(--sans)" },
  ".cm-completionMatchedText": { textDecoration: "none", fontWeight: "700" },
  ".cm-completionInfo": { padding: "0.5rem 0.75rem", maxWidth: "20rem" },
  ".meaning": { padding: "0.5rem 0.75rem", display: "grid", gap: "0.15rem", lineHeight: "1.45" },
  ".meaning strong": { fontFamily: "var(--mono)" },
  ".meaning small": { color: "var(--quiet)", fontSize: "0.75rem" },
  ".cm-diagnostic": { padding: "0.5rem 0.75rem", borderLeft: "3px solid var(--error)" },
  ".cm-diagnosticAction": { backgroundColor: "var(--accent)", color: "var(--accent-ink)", borderRadius: "4px", padding: "0.15rem 0.5rem", marginLeft: "0.5rem", font: "inherit", fontSize: "0.75rem" },
  ".cm-panels": { backgroundColor: "var(--ground)", color: "var(--ink)", borderBottom: "1px solid var(--line)", fontFamily: "var(--sans)" },
  ".cm-panels.cm-panels-top": { borderBottom: "1px solid var(--line)" },
  ".cm-textfield": { backgroundColor: "var(--raised)", border: "1px solid var(--edge)", borderRadius: "4px", color: "var(--ink)", minHeight: "1.5rem" },
  ".cm-button": { backgroundImage: "none", backgroundColor: "var(--raised)", border: "1px solid var(--line)", borderRadius: "4px", color: "var(--ink)", minHeight: "1.5rem" },
  ".cm-panel.cm-search [name=close]": { minWidth: "1.5rem", minHeight: "1.5rem", color: "var(--ink)" },
});

/** Rules that only some browsers know: each drops those of the others, which the theme above would not. A phone has no room for line numbers. */
export const more = new CSSStyleSheet();
more.replaceSync(`
  @media (max-width: 719px) { .cm-gutters { display: none !important } .cm-line { padding-left: 0.75rem !important } }
  .swatch::-webkit-color-swatch-wrapper { padding: 0 }
  .swatch::-webkit-color-swatch { border: none }
  .swatch::-moz-color-swatch { border: none }
`);
