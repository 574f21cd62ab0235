// The left pane: the editor and the list of what is wrong.
import { html, useEffect, useRef } from "../vendor/preact.js";
import { nextProblem } from "./commands.js";
import { fixOf, isOfText, lineOf, rangeOf, wordsOf } from "./problems.js";
import { missing, problems, reveal, setText, settings, syntax, text } from "./state.js";
import { Button } from "./ui.js";

/** @param {import("./problems.js").Fix} fix */
const mend = (fix) => setText(text.peek().slice(0, fix.from) + fix.insert + text.peek().slice(fix.to));

/** A problem of the text: its line, and what would mend it. @param {{ problem: import("./problems.js").TextProblem }} props */
function InText({ problem }) {
  const fix = fixOf(syntax.value, problem);
  const line = lineOf(text.value, rangeOf(text.value, syntax.value, problem).from);
  return html`<li><button type="button" class="problem" onClick=${() => reveal(problem.pointer)}><span class="problem-line">${line}</span><span>${problem.detail}</span></button>
    ${fix && html`<${Button} press=${() => mend(fix)}>Write "${fix.word}"<//>`}</li>`;
}

/** Takes back a setting, which a link has brought: nothing in the text could. @param {{ problem: import("./state.js").SceneProblem }} props */
export function LeaveOut({ problem: { parameter = "" } }) {
  if (!Object.hasOwn(settings.value, parameter)) return null;
  const { [parameter]: _, ...rest } = settings.value;
  return html`<${Button} press=${() => (settings.value = rest)}>Leave it out<//>`;
}

function Problems() {
  const all = problems.value;
  if (all.length === 0) return null;
  return html`<div class="problems" role="region" aria-label="Problems">
    <p class="problems-head"><strong>${all.length === 1 ? "One problem" : `${all.length} problems`}</strong>${all.filter(isOfText).length > 1 && html`<${Button} kind="quiet" keys="F8" press=${nextProblem}>Next<//>`}</p>
    <ol>${all.map((problem, index) => (isOfText(problem) ? html`<${InText} key=${index} problem=${problem} />`
      : html`<li key=${index}><p class="problem">${wordsOf(problem)}</p><${LeaveOut} problem=${problem} /></li>`))}</ol>
  </div>`;
}

export function EditPane() {
  const host = useRef(/** @type {HTMLElement | null} */ (null));
  useEffect(() => {
    // The picture comes first: the editor is the largest file.
    const started = import("./editor.js").then(({ start }) => start(/** @type {HTMLElement} */ (host.current)));
    started.catch(missing);
    return () => void started.then((view) => view.destroy());
  }, []);
  return html`<section class="edit" aria-label="Scene" data-pane-focus>
    <div class="editor-host" ref=${host}></div>
    <${Problems} />
  </section>`;
}
