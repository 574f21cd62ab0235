// The dialog that makes a job of the scene: what it will be, and what it should take.
import { html, useEffect, useRef, useState } from "../../vendor/preact.js";
import { Problem, ask, askJson, pause } from "../api.js";
import { sized } from "../framing.js";
import { duration, count } from "../report.js";
import { limits, origin, scene, settings, size, text } from "../state.js";
import { Button, Dialog } from "../ui.js";
import { typed } from "./accuracy-stops.js";
import { load } from "./jobs-list.js";
import { labelsOf, submission } from "./jobs-model.js";
import { show } from "./jobs-show.js";

/** A name for a submission: sent again after an error, it makes no second job. */
const freshKey = () => Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, "0")).join("");

/** @typedef {{ width: string, height: string, samples: string, format: string, priority: string, labels: string }} Form */

/** @param {Form} form @returns {import("../state.js").Settings} */
const settingsOf = ({ width, height, samples }) => ({ ...sized(settings.peek(), { width, height }), ...(samples === "" ? {} : { samples }) });

/** @param {Form} form @param {string} idempotency */
async function submit(form, idempotency) {
  const type = origin.peek().type;
  const headers = { "idempotency-key": idempotency };
  if (type === "application/json") {
    const rest = { settings: typed(settingsOf(form)), output: { format: form.format }, priority: Number(form.priority), labels: labelsOf(form.labels) };
    return (await ask("v1/jobs", { body: submission(text.peek(), rest), type, headers, accept: "application/json" })).json();
  }
  // Other kinds of scenes become jobs as asynchronous renders.
  return (await ask("v1/render", { body: text.peek(), type, query: { ...settingsOf(form), format: form.format }, headers: { ...headers, prefer: "respond-async" } })).json();
}

/** @param {{ close: () => void }} props */
export function Submit({ close }) {
  const [form, setForm] = useState(/** @type {Form} */ ({
    width: String(size.peek().width), height: String(size.peek().height), samples: settings.peek().samples ?? "", format: "png", priority: "50",
    labels: Array.from(String(scene.peek()?.name ?? origin.peek().name).replaceAll(",", " ").trim()).slice(0, 64).join(""),
  }));
  const [estimate, setEstimate] = useState(/** @type {any} */ (null));
  const [trouble, setTrouble] = useState("");
  const [isSending, setSending] = useState(false);
  const idempotency = useRef("");
  const isJson = origin.value.type === "application/json";
  const field = (/** @type {keyof Form} */ name) => (/** @type {any} */ event) => {
    // Another body is another submission.
    idempotency.current = "";
    setForm((now) => ({ ...now, [name]: event.target.value }));
  };
  useEffect(() => {
    const control = new AbortController();
    const run = async () => {
      await pause(350, control.signal);
      const { estimate: found } = await askJson("v1/explain", { body: text.peek(), type: origin.peek().type, query: settingsOf(form), signal: control.signal });
      if (!control.signal.aborted) setEstimate(found), setTrouble("");
    };
    run().catch((error) => control.signal.aborted || (setEstimate(null), setTrouble(error.message)));
    return () => control.abort();
  }, [form.width, form.height, form.samples]);
  const send = async (/** @type {Event} */ event) => {
    event.preventDefault();
    idempotency.current ||= freshKey();
    setSending(true);
    setTrouble("");
    try {
      const job = await submit(form, idempotency.current);
      close();
      show(job);
      load();
    } catch (error) {
      const wait = error instanceof Problem && error.retryAfter > 0 ? ` Try again in ${error.retryAfter} s.` : "";
      setTrouble(`${/** @type {Error} */ (error).message}${wait}`);
    }
    setSending(false);
  };
  const pixels = Number(form.width) * Number(form.height);
  const most = limits.value?.jobs?.job_max_pixels ?? 100_000_000;
  return html`<${Dialog} title="Render as a job" close=${close}>
    <form class="form job-form" onSubmit=${send}>
      <p>A job goes on when this page is closed${limits.value?.jobs?.durable ? ", and when the service is restarted" : ""}.</p>
      <div class="form-row"><label>Width<input class="field" type="number" min="1" max="16384" required value=${form.width} onInput=${field("width")} /></label>
        <label>Height<input class="field" type="number" min="1" max="16384" required value=${form.height} onInput=${field("height")} /></label>
        <label>Samples<input class="field" type="number" min="1" max="1024" placeholder="scene’s" value=${form.samples} onInput=${field("samples")} /></label></div>
      <p class="actions">${[1, 2, 4].map((times) => html`<${Button} key=${times} kind="quiet" press=${() => { field("width")({ target: { value: String(size.value.width * times) } }); field("height")({ target: { value: String(size.value.height * times) } }); }}>${size.value.width * times} × ${size.value.height * times}<//>`)}</p>
      <div class="form-row"><label>Format<select class="field" value=${form.format} onChange=${field("format")}>${["png", "webp", "jpg", "exr", "pfm"].map((name) => html`<option key=${name} value=${name}>${name.toUpperCase()}</option>`)}</select></label>
        ${isJson && html`<label>Priority<input class="field" type="number" min="0" max="100" required value=${form.priority} onInput=${field("priority")} /></label>`}</div>
      ${isJson && html`<label>Labels, with commas between<input class="field" value=${form.labels} maxlength="1000" onInput=${field("labels")} /></label>`}
      <p role="status" class="job-estimate">${pixels > most ? html`<span class="bad">The service takes at most ${count(most)} pixels; these are ${count(pixels)}.</span>`
        : estimate ? html`Should take <strong>${duration(estimate.ms)}</strong> <span class="quiet">(${duration(estimate.ms_ci[0])} to ${duration(estimate.ms_ci[1])}) and ${count(estimate.rays)} rays on a machine that does nothing else</span>` : trouble === "" ? html`<span class="quiet">Predicting …</span>` : ""}</p>
      ${trouble !== "" && html`<p class="bad" role="alert">${trouble}</p>`}
      <p class="actions"><button type="submit" class="button main" disabled=${isSending || pixels > most}>${isSending ? "Sending …" : "Render it"}</button><${Button} press=${close}>Cancel<//></p>
    </form>
  <//>`;
}
