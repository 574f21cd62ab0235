// The left pane: the editor and the list of what is wrong.
import { html, useEffect, useRef } from "../vendor/preact.js";
import { nextProblem } from "./commands.js";
import { fixOf, lineOf, rangeOf } from "./problems.js";
import { problems, reveal, setText, syntax, text } from "./state.js";
import { Button } from "./ui.js";

/** @param {import("./problems.js").Fix} fix */
const mend = (fix) => setText(text.peek().slice(0, fix.from) + fix.insert + text.peek().slice(fix.to));

function Problems() {
  const all = problems.value;
  if (all.length === 0) return null;
  return html`<div class="problems" role="region" aria-label="Problems">
    <p class="problems-head"><strong>${all.length === 1 ? "One problem" : `${all.length} problems`}</strong>${all.length > 1 && html`<${Button} kind="quiet" keys="F8" press=${nextProblem}>Next<//>`}</p>
    <ol>${all.map((problem, index) => {
      const fix = fixOf(syntax.value, problem);
      const line = lineOf(text.value, rangeOf(text.value, syntax.value, problem).from);
      return html`<li key=${index}><button type="button" class="problem" onClick=${() => reveal(problem.pointer)}><span class="problem-line">${line}</span><span>${problem.detail}</span></button>
        ${fix && html`<${Button} press=${() => mend(fix)}>Write "${fix.word}"<//>`}</li>`;
    })}</ol>
  </div>`;
}

export function EditPane() {
  const host = useRef(/** @type {HTMLElement | null} */ (null));
  useEffect(() => {
    // The picture comes first: the editor is the largest file.
    const started = import("./editor.js").then(({ start }) => start(/** @type {HTMLElement} */ (host.current)));
    return () => void started.then((view) => view.destroy());
  }, []);
  return html`<section class="edit" aria-label="Scene" data-pane-focus>
    <div class="editor-host" ref=${host}></div>
    <${Problems} />
  </section>`;
}
