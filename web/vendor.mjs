// Makes the two files of other people's code in vendor/, with their hashes and licences. Run after a change of a version in
// package.json; `--check` says whether the files are those that this program makes.
import { createHash } from "node:crypto";
import { existsSync, readFileSync, readdirSync, writeFileSync } from "node:fs";
import { build, version } from "esbuild";

// One file holds preact, its signals and htm: two copies of preact in a page fail without a word (preactjs/signals#253).
const FILES = {
  "preact.js": `
export { Component, Fragment, createContext, h, render } from "preact";
export { useCallback, useEffect, useId, useLayoutEffect, useMemo, useRef, useState } from "preact/hooks";
export { batch, computed, effect, signal, untracked, useComputed, useSignal, useSignalEffect } from "@preact/signals";
import { h as element } from "preact";
import htm from "htm";
export const html = htm.bind(element);
`,
  "editor.js": `
export { autocompletion, closeBrackets, closeBracketsKeymap, completionKeymap, startCompletion } from "@codemirror/autocomplete";
export { defaultKeymap, history, historyKeymap, invertedEffects, isolateHistory, redo, redoDepth, undo, undoDepth } from "@codemirror/commands";
export { json } from "@codemirror/lang-json";
export { HighlightStyle, bracketMatching, codeFolding, foldGutter, foldKeymap, indentOnInput, syntaxHighlighting, syntaxTree } from "@codemirror/language";
export { forEachDiagnostic, lintGutter, lintKeymap, nextDiagnostic, previousDiagnostic, setDiagnostics } from "@codemirror/lint";
export { highlightSelectionMatches, openSearchPanel, search, searchKeymap } from "@codemirror/search";
export { Annotation, Compartment, EditorSelection, EditorState, Prec, RangeSetBuilder, StateEffect, StateField, Transaction } from "@codemirror/state";
export { Decoration, EditorView, ViewPlugin, WidgetType, drawSelection, highlightActiveLine, highlightActiveLineGutter, highlightSpecialChars, hoverTooltip, keymap, lineNumbers, placeholder } from "@codemirror/view";
export { tags } from "@lezer/highlight";
`,
};

const here = new URL("./", import.meta.url);
const read = (path) => readFileSync(new URL(path, here), "utf8");
const lock = JSON.parse(read("package-lock.json")).packages;
const sha256 = (text) => createHash("sha256").update(text).digest("hex");

async function bundle(name, source) {
  const made = await build({
    stdin: { contents: source, resolveDir: new URL(".", here).pathname, loader: "js" },
    bundle: true,
    format: "esm",
    legalComments: "none",
    metafile: true,
    minify: true,
    target: "es2022",
    write: false,
    logLevel: "error",
  });
  const inputs = Object.keys(made.metafile.inputs).filter((path) => path.includes("node_modules/"));
  const packages = new Set(inputs.map((path) => /.*node_modules\/((?:@[^/]+\/)?[^/]+)/.exec(path)[1]));
  const about = [...packages].sort().map((of) => {
    const { version, license, integrity } = lock[`node_modules/${of}`];
    return { name: of, version, license: license ?? JSON.parse(read(`node_modules/${of}/package.json`)).license, integrity };
  });
  const header = `// Made by web/vendor.mjs from ${about.map((of) => `${of.name} ${of.version}`).join(", ")}. Licences: LICENSES.txt\n`;
  const code = header + made.outputFiles[0].text;
  return { name, code, about: { file: name, sha256: sha256(code), packages: about } };
}

function licence({ name, version, license }) {
  const folder = `node_modules/${name}/`;
  const file = readdirSync(new URL(folder, here)).find((of) => /^licen[cs]e/i.test(of));
  if (!file) throw new Error(`${name} has no licence file`);
  return `${name} ${version} (${license})\n\n${read(folder + file).trim()}\n`;
}

const bundles = await Promise.all(Object.entries(FILES).map(([name, source]) => bundle(name, source)));
const packages = bundles.flatMap((of) => of.about.packages);
const made = {
  "vendor/LICENSES.txt": packages.map(licence).join(`\n${"-".repeat(100)}\n\n`),
  "vendor/vendor.json": `${JSON.stringify({ esbuild: version, files: bundles.map((of) => of.about) }, null, 2)}\n`,
};
for (const { name, code } of bundles) made[`vendor/${name}`] = code;
// The names and types that the modules import are those of the packages.
for (const [name, source] of Object.entries(FILES)) {
  const types = source.replace('import { h as element } from "preact";\n', `import { h as element } from "preact";
export type { ComponentChild, ComponentChildren } from "preact";
export type { Signal, ReadonlySignal } from "@preact/signals";
`).replace('import htm from "htm";\n', "").replace(
    "const html = htm.bind(element);",
    "const html: (strings: TemplateStringsArray, ...values: any[]) => ReturnType<typeof element>;",
  );
  made[`vendor/${name.replace(".js", ".d.ts")}`] = `// Made by web/vendor.mjs.${types}`;
}

if (process.argv.includes("--check")) {
  const wrong = Object.keys(made).filter((path) => !existsSync(new URL(path, here)) || read(path) !== made[path]);
  if (wrong.length > 0) {
    console.error(`not what vendor.mjs makes: ${wrong.join(", ")}; run node vendor.mjs`);
    process.exit(1);
  }
} else {
  for (const [path, text] of Object.entries(made)) writeFileSync(new URL(path, here), text);
}
