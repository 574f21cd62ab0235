// FLIP (Andersson et al. 2020) of a comparison: the service has it, if it has `/v1/compare`.
import { html, useEffect, useState } from "../../vendor/preact.js";
import { Problem, askJson, patiently } from "../api.js";
import { other, origin } from "../state.js";
import { Button } from "../ui.js";
import { a } from "./compare-pictures.js";
import { typed } from "./accuracy-stops.js";
import { Fact } from "./widgets.js";

/** Whether the service lacks it: asked once. */
let isAbsent = false;

/** One side of the request. @param {import("../state.js").Shown} of */
const side = (of) => `{"settings":${JSON.stringify(typed(of.settings))},"scene":${of.text}}`;

export function FlipRow() {
  const [flip, setFlip] = useState(/** @type {number | string | null} */ (null));
  const [asking, setAsking] = useState(/** @type {AbortController | null} */ (null));
  useEffect(() => () => asking?.abort(), [asking]);
  const [one, two] = [a.value, other.value];
  if (isAbsent || !one || !two || origin.value.type !== "application/json") return null;
  const measure = async () => {
    const control = new AbortController();
    setAsking(control);
    try {
      const answer = await patiently(() => askJson("v1/compare", { body: `{"a":${side(one)},"b":${side(two)}}`, type: "application/json", signal: control.signal }), control.signal);
      setFlip(typeof answer.flip === "number" ? answer.flip : (answer.flip?.mean ?? null));
    } catch (error) {
      if (control.signal.aborted) return;
      isAbsent = error instanceof Problem && (error.status === 404 || error.status === 405);
      setFlip(isAbsent ? "not in this version of the service" : /** @type {Error} */ (error).message);
    }
    setAsking(null);
  };
  const shown = typeof flip === "number" ? flip.toFixed(4) : flip;
  return html`<${Fact} name="FLIP, mean" value=${shown ?? html`<${Button} kind="quiet" disabled=${asking !== null} press=${measure}>${asking ? "Measuring …" : "Measure"}<//>`} />`;
}
