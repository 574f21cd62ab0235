// The chosen ray in numbers, and Snell's law where it meets a surface that transmits, drawn in its plane of incidence.
import { html } from "../../vendor/preact.js";
import { Pointer } from "../ui.js";
import { answer, chosen, places, rows } from "./pixel-asked.js";
import { Badge, mediumName, targetWith } from "./pixel-outline.js";
import { KINDS, codesOf, colorOf, isBlocked, isTotal, largest, lastOf, mediaOf, short, whyOf } from "./pixel-rays.js";

/** @typedef {import("./pixel-rays.js").Snell} Snell */
/** @typedef {import("./pixel-rays.js").Triple} Triple */

const triple = (/** @type {Triple} */ of) => of.map((value) => short(value, 4)).join("  ");

const [WIDTH, HEIGHT, REACH] = [330, 168, 68];

/** A place at an angle from the normal. @param {number} degrees @param {1 | -1} side @param {1 | -1} down @param {number} [reach] */
function at(degrees, side, down, reach = REACH) {
  const angle = (degrees * Math.PI) / 180;
  return [WIDTH / 2 + side * reach * Math.sin(angle), HEIGHT / 2 + down * reach * Math.cos(angle)];
}

/** @param {number} degrees @param {1 | -1} side @param {1 | -1} down */
function arc(degrees, side, down) {
  const [x, y] = at(degrees, side, down, 24);
  const sweep = side * down > 0 ? 0 : 1;
  return `M${WIDTH / 2} ${HEIGHT / 2 + down * 24}A24 24 0 0 ${sweep} ${x} ${y}`;
}

/** @param {{ snell: Snell, media: string[] }} props */
function Incidence({ snell, media }) {
  const { n1, n2, theta1_deg: in1, theta2_deg: out2, tir } = snell;
  const [from, mirror] = [at(in1, -1, -1), at(in1, 1, -1)];
  const to = out2 === null ? null : at(out2, 1, 1);
  const [cx, cy] = [WIDTH / 2, HEIGHT / 2];
  const [above, below] = [media[0] ?? "", media[1] ?? ""];
  // The denser medium is the darker one.
  const shade = (/** @type {number} */ n) => ({ fillOpacity: Math.min(0.3, Math.max(0, (n - 1) * 0.32)) });
  const label = (/** @type {number} */ degrees, /** @type {1 | -1} */ side, /** @type {1 | -1} */ down) => {
    const [x, y] = at(Math.max(9, degrees / 2), side, down, 42);
    return html`<text x=${x} y=${y + 4} class="angle">${degrees.toFixed(1)}°</text>`;
  };
  const words = tir ? `Total reflection: ${in1.toFixed(2)} degrees is beyond the critical angle of ${critical(snell)} degrees.` : `The ray comes in at ${in1.toFixed(2)} degrees and goes on at ${out2?.toFixed(2)} degrees.`;
  return html`<figure class="snell"><svg viewBox=${`0 0 ${WIDTH} ${HEIGHT}`} role="img" aria-label=${words}>
      <rect class="medium" x="0" y="0" width=${WIDTH} height=${cy} style=${shade(n1)} /><rect class="medium" x="0" y=${cy} width=${WIDTH} height=${cy} style=${shade(n2)} />
      <path class="surface" d=${`M0 ${cy}H${WIDTH}`} /><path class="normal" d=${`M${cx} 10V${HEIGHT - 10}`} />
      <path class="angle-arc" d=${arc(in1, -1, -1)} />${to && out2 !== null && html`<path class="angle-arc" d=${arc(out2, 1, 1)} />`}
      <path class="line kind-camera" d=${`M${from[0]} ${from[1]}L${cx} ${cy}`} />
      <path class="line kind-reflected" stroke-dasharray=${KINDS.reflected.dash} d=${`M${cx} ${cy}L${mirror[0]} ${mirror[1]}`} stroke-width=${tir ? 2.6 : 1.6} />
      ${to && html`<path class="line kind-transmitted" d=${`M${cx} ${cy}L${to[0]} ${to[1]}`} stroke-dasharray=${KINDS.transmitted.dash} />`}
      <circle cx=${cx} cy=${cy} r="2.5" class="point" />
      ${label(in1, -1, -1)}${out2 !== null && label(out2, 1, 1)}
      <text x="8" y="16" class="index">${clip(above)}</text><text x="8" y="30" class="index">n ${short(n1, 4)}</text>
      <text x="8" y=${HEIGHT - 20} class="index">${clip(below)}</text><text x="8" y=${HEIGHT - 6} class="index">n ${short(n2, 4)}</text>
      ${tir && html`<text x=${WIDTH - 8} y=${HEIGHT - 8} class="index end strong">total reflection</text>`}
    </svg>
    <figcaption class="quiet">${tir
      ? html`${in1.toFixed(2)}° is beyond the critical angle ${critical(snell)}°: all light is reflected.`
      : html`${short(n1, 4)} sin ${in1.toFixed(2)}° = ${short(n2, 4)} sin ${out2?.toFixed(2)}° = ${short(n1 * Math.sin((in1 * Math.PI) / 180), 4)}. By Fresnel ${short(100 * snell.reflectance)} % would be reflected.`}
    </figcaption></figure>`;
}

const clip = (/** @type {string} */ name) => (name.length > 14 ? `${name.slice(0, 13)}…` : name);
const critical = (/** @type {Snell} */ { n1, n2 }) => ((Math.asin(Math.min(1, n2 / n1)) * 180) / Math.PI).toFixed(2);

export function ChosenRay() {
  const of = /** @type {import("./pixel-asked.js").Answer} */ (answer.value);
  const { tree, total, children } = of.grown;
  const row = rows.value[places.value.get(chosen.value) ?? -1];
  if (!row) return null;
  const { ray, stub } = row;
  const scale = tree.samples;
  if (stub) {
    return html`<section class="ray-card" aria-label="The chosen ray"><h3><${Badge} kind=${stub.kind} ended />A ray that was not followed</h3>
      <p>It would have been ${KINDS[stub.kind].name} with weight <span class="mono">${triple(/** @type {Triple} */ (stub.weight.map((w) => w * scale)))}</span>, but ${whyOf(stub)}. With it the pixel could change ${stub.codes >= 255 ? "without a known bound" : `by ${codesOf(stub.codes)}`}.</p></section>`;
  }
  const target = targetWith(ray);
  const media = mediaOf(of.grown, ray, mediumName);
  const passes = ray.transmittance;
  const fact = (/** @type {string} */ name, /** @type {any} */ value) => html`<div><dt>${name}</dt><dd>${value}</dd></div>`;
  const light = /** @type {Triple} */ ([0, 1, 2].map((c) => total[3 * ray.id + c] * scale));
  const own = /** @type {Triple} */ (ray.contribution.map((value) => value * scale));
  return html`<section class="ray-card" aria-label="The chosen ray">
    <h3><${Badge} kind=${ray.kind} />${KINDS[ray.kind].letter}${ray.id}, ${KINDS[ray.kind].name}${isTotal(tree, ray) ? " (total reflection)" : ""}</h3>
    <p>${isBlocked(ray) ? "Blocked on its way to " : "To "}${target.pointer === null ? html`<span>the background</span>` : html`<${Pointer} pointer=${target.pointer}><bdi>${target.name}</bdi><//>`}
      ${ray.hit && ray.hit.material !== "default" && html` of <${Pointer} pointer=${ray.hit.material}><bdi>${lastOf(ray.hit.material).replace(/^materials /, "")}</bdi><//>`}
      ${ray.hit && html`<span class="quiet"> ${ray.hit.entering ? "from outside" : "from inside"}</span>`}</p>
    ${ray.snell && html`<${Incidence} snell=${ray.snell} media=${media.length > 1 ? media : [media[0], ray.snell.tir ? "outside" : ""]} />`}
    <dl class="ray-facts">
      ${fact("weight", html`<span class="mono">${triple(/** @type {Triple} */ (ray.weight.map((w) => w * scale)))}</span>`)}
      ${fact("adds itself", html`<i class="pixel-swatch small" style=${{ background: colorOf(own) }}></i><span class="mono">${triple(own)}</span>`)}
      ${children[ray.id].length > 0 && fact("with its branch", html`<i class="pixel-swatch small" style=${{ background: colorOf(light) }}></i><span class="mono">${triple(light)}</span>`)}
      ${passes && largest(passes) > 0 && fact("lets through", html`<span class="mono">${triple(passes)}</span>`)}
      ${ray.hit && fact("distance", html`<span class="mono">${short(ray.hit.t, 6)}</span>`)}
      ${fact("from", html`<span class="mono">${triple(ray.origin)}</span>`)}
      ${ray.hit && fact("hits", html`<span class="mono">${triple(ray.hit.point)}</span>`)}
      ${fact("direction", html`<span class="mono">${triple(ray.direction)}</span>`)}
      ${ray.hit && fact("normal", html`<span class="mono">${triple(ray.hit.normal)}</span>`)}
      ${fact("depth", String(ray.depth))}
      ${fact("inside", ray.media.length === 0 ? "nothing" : ray.media.map(({ object, ior }, i) => html`<span key=${i} class="chip"><bdi>${mediumName(object)}</bdi> n ${short(ior, 4)}</span>`))}
    </dl>
  </section>`;
}
