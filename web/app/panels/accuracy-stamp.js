// "Same bytes": traces the picture again in other ways, and says whether each byte stays. Pieces are never the same twice, so that
// the service cannot answer from what it has kept.
import { html, useEffect, useState } from "../../vendor/preact.js";
import { askBlob, patiently } from "../api.js";
import { duration } from "../report.js";
import { origin, shown } from "../state.js";
import { Button, Icon } from "../ui.js";
import { codesOf } from "./compare-pictures.js";

/** @typedef {import("../state.js").Shown} Shown */
/** @typedef {{ x: number, y: number, w: number, h: number }} Piece */
/** @typedef {{ word: "same" | "differs" | "running" | "failed", detail: string }} Result */

const AT_ONCE = 3;
/** About as many tiles. */
const TILES = 24;

/** The whole picture in two pieces, cut somewhere. @param {number} width @param {number} height @returns {Piece[]} */
export function cut(width, height) {
  const at = Math.min(width - 1, 1 + Math.floor(Math.random() * (width - 1)));
  return at < 1 ? [{ x: 0, y: 0, w: width, h: height }] : [{ x: 0, y: 0, w: at, h: height }, { x: at, y: 0, w: width - at, h: height }];
}

/** The picture in square tiles, shifted. @param {number} width @param {number} height @returns {Piece[]} */
export function tiled(width, height) {
  const edge = Math.max(64, Math.ceil(Math.sqrt((width * height) / TILES)));
  const [dx, dy] = [Math.random(), Math.random()].map((of) => Math.floor(of * edge));
  const pieces = [];
  for (let top = -dy; top < height; top += edge) {
    for (let left = -dx; left < width; left += edge) {
      const [x, y] = [Math.max(0, left), Math.max(0, top)];
      const [w, h] = [Math.min(width, left + edge) - x, Math.min(height, top + edge) - y];
      if (w > 0 && h > 0) pieces.push({ x, y, w, h });
    }
  }
  return pieces;
}

/** Bytes of color that differ. @param {Uint8ClampedArray} a @param {Uint8ClampedArray} b */
export function apart(a, b) {
  let [pixels, most] = [0, 0];
  for (let i = 0; i < a.length; i += 4) {
    const error = Math.max(Math.abs(a[i] - b[i]), Math.abs(a[i + 1] - b[i + 1]), Math.abs(a[i + 2] - b[i + 2]));
    if (error > 0) pixels += 1;
    if (error > most) most = error;
  }
  return { pixels, most };
}

/** Puts pieces together and gives the codes. @param {Shown} of @param {Piece[]} pieces @param {Record<string, string>} extra @param {AbortSignal} signal */
async function assemble(of, pieces, extra, signal) {
  const context = /** @type {OffscreenCanvasRenderingContext2D} */ (new OffscreenCanvas(of.width, of.height).getContext("2d", { willReadFrequently: true }));
  const left = [...pieces];
  const work = async () => {
    for (let piece = left.shift(); piece; piece = left.shift()) {
      const { x, y, w, h } = piece;
      const query = { ...of.settings, ...extra, x, y, w, h };
      const blob = await patiently(() => askBlob("v1/render/tile", { body: of.text, type: origin.peek().type, query, accept: "image/png", signal }), signal);
      const bitmap = await createImageBitmap(blob);
      context.drawImage(bitmap, x, y);
      bitmap.close();
    }
  };
  await Promise.all(Array.from({ length: AT_ONCE }, work));
  return context.getImageData(0, 0, of.width, of.height).data;
}

/** @type {{ id: string, label: string, words: string, extra: Record<string, string>, pieces: (width: number, height: number) => Piece[] }[]} */
const WAYS = [
  { id: "again", label: "Again", words: "traced once more, in two pieces", extra: {}, pieces: cut },
  { id: "tiles", label: "By tiles", words: "put together from tiles, three at a time", extra: {}, pieces: tiled },
  { id: "double", label: "Double", words: "in double precision", extra: { precision: "double" }, pieces: cut },
];

/** @param {Shown} of @param {(typeof WAYS)[number]} way @param {AbortSignal} signal @returns {Promise<Result>} */
async function run(of, way, signal) {
  const began = performance.now();
  const pieces = way.pieces(of.width, of.height);
  try {
    const [before, after] = [codesOf(of), await assemble(of, pieces, way.extra, signal)];
    if (!before) return { word: "failed", detail: "the picture has changed meanwhile" };
    const { pixels, most } = apart(before, after);
    const how = `${pieces.length > 2 ? `${pieces.length} tiles, ` : ""}${duration(performance.now() - began)}`;
    if (pixels === 0) return { word: "same", detail: `all ${(of.width * of.height * 3).toLocaleString("en")} bytes of its pixels are the same (${how})` };
    return { word: "differs", detail: `${pixels.toLocaleString("en")} of ${(of.width * of.height).toLocaleString("en")} pixels differ, by at most ${most} code${most === 1 ? "" : "s"} (${how})` };
  } catch (error) {
    if (signal.aborted) throw error;
    return { word: "failed", detail: /** @type {Error} */ (error).message };
  }
}

export function Stamp() {
  const of = shown.value;
  const digest = of?.report.digest ?? "";
  const [results, setResults] = useState(/** @type {Record<string, Result>} */ ({}));
  const [control, setControl] = useState(/** @type {AbortController | null} */ (null));
  useEffect(() => {
    setResults({});
    setControl(null);
  }, [digest]);
  useEffect(() => () => control?.abort(), [control]);
  if (!of || of.rung < 2) return html`<p class="quiet">The stamp comes with the whole picture.</p>`;
  const isTimed = (of.settings.accuracy ?? "").startsWith("time") || /"time"\s*:/.test(of.text);
  const press = async (/** @type {(typeof WAYS)[number]} */ way) => {
    const next = new AbortController();
    setControl(next);
    setResults((all) => ({ ...all, [way.id]: { word: "running", detail: way.words } }));
    try {
      const result = await run(of, way, next.signal);
      if (!next.signal.aborted) setResults((all) => ({ ...all, [way.id]: result }));
    } catch {
      setResults(({ [way.id]: _, ...all }) => all);
    }
    setControl((now) => (now === next ? null : now));
  };
  return html`<p class="stamp"><span class="quiet">SHA-256</span> <code class="digest">${digest.slice(0, 32)}<wbr />${digest.slice(32)}</code></p>
    ${isTimed ? html`<p class="quiet">A picture that ends by time depends on the machine, so its bytes need not come again.</p>` : html`
    <div class="choices">${WAYS.map((way) => html`<${Button} key=${way.id} title=${way.words} disabled=${control !== null} press=${() => press(way)}>${way.label}<//>`)}
      ${control && html`<${Button} kind="quiet" press=${() => (control.abort(), setControl(null))}>Stop<//>`}</div>
    <ul class="plain-list stamp-results" aria-live="polite">${WAYS.filter(({ id }) => results[id]).map((way) => {
      const { word, detail } = results[way.id];
      return html`<li key=${way.id} class=${`is-${word}`}><${Icon} name=${word === "same" ? "check" : word === "running" ? "more" : "warning"} />
        <span><strong>${way.label}</strong>: ${word === "running" ? `${detail} …` : word === "same" ? html`${detail}` : detail}</span></li>`;
    })}</ul>`}`;
}
