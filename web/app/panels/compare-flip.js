// FLIP (Andersson et al. 2020) of a comparison, as a number and as a map: the service has it.
import { html, useEffect, useState } from "../../vendor/preact.js";
import { ask, askJson, patiently } from "../api.js";
import { readPfm } from "./pfm.js";
import { colored } from "../ramps.js";
import { other, origin } from "../state.js";
import { Button } from "../ui.js";
import { typed } from "./accuracy-stops.js";
import { a, bitmapOf, mode, putMap } from "./compare-pictures.js";
import { Fact } from "./widgets.js";

/** One side of the request. @param {import("../state.js").Shown} of */
const side = (of) => `{"settings":${JSON.stringify(typed(of.settings))},"scene":${of.text}}`;

export function FlipRow() {
  const [flip, setFlip] = useState(/** @type {number | string | null} */ (null));
  const [asking, setAsking] = useState(/** @type {AbortController | null} */ (null));
  useEffect(() => () => asking?.abort(), [asking]);
  const [one, two] = [a.value, other.value];
  if (!one || !two || origin.value.type !== "application/json") return null;
  const request = { body: `{"a":${side(one)},"b":${side(two)}}`, type: "application/json" };
  const run = async (/** @type {(signal: AbortSignal) => Promise<void>} */ what) => {
    const control = new AbortController();
    setAsking(control);
    try {
      await patiently(() => what(control.signal), control.signal);
    } catch (error) {
      if (control.signal.aborted) return;
      setFlip(/** @type {Error} */ (error).message);
    }
    setAsking(null);
  };
  const measure = () => run(async (signal) => {
    const { flip: found } = await askJson("v1/compare", { ...request, signal });
    setFlip(found?.mean ?? "the pictures are too large for it");
  });
  const show = () => run(async (signal) => {
    const answer = await ask("v1/compare", { ...request, query: { format: "flip" }, signal });
    const { width, height, values } = readPfm(await answer.arrayBuffer());
    const map = await bitmapOf(colored(values, { low: 0, high: 1, isLogarithmic: false }, "viridis", false), width, height);
    if (signal.aborted) return map.close();
    putMap(map);
    mode.value = "flip map";
  });
  const value = typeof flip === "number" ? html`${flip.toFixed(4)} <${Button} kind="quiet" disabled=${asking !== null} pressed=${mode.value === "flip map"} press=${mode.value === "flip map" ? () => (mode.value = "wipe") : show}>Map<//>`
    : (flip ?? html`<${Button} kind="quiet" disabled=${asking !== null} press=${measure}>${asking ? "Measuring …" : "Measure"}<//>`);
  return html`<${Fact} name="FLIP, mean" value=${value} />`;
}
