// What can be read off the tree of a pixel's rays: who has sent whom, which samples there are, and whether they add up. Pure.

import { encoded } from "../values.js";

/** @typedef {[number, number, number]} Triple */
/** @typedef {"camera" | "reflected" | "transmitted" | "gathered" | "shadow"} Kind */
/** @typedef {{ t: number, point: Triple, normal: Triple, object: string, body?: string, name?: string, material: string, entering: boolean }} Hit */
/** @typedef {{ n1: number, n2: number, theta1_deg: number, theta2_deg: number | null, tir: boolean, reflectance: number }} Snell */
/** @typedef {{ kind: Kind, weight: Triple, why: string, codes: number }} Stub a ray that was not followed */
/**
 * @typedef {{ id: number, parent: number | null, kind: Kind, depth: number, weight: Triple, contribution: Triple, origin: Triple,
 *   direction: Triple, media: { object: string, ior: number }[], hit?: Hit, snell?: Snell, light?: number,
 *   transmittance?: Triple, not_followed?: Stub[] }} Ray
 */
/** @typedef {{ pixel: [number, number], precision: "single" | "double", samples: number, value: Triple, codes: Triple, codes_off: number, raised: Triple, lacking: Triple, truncated: boolean, rays: Ray[] }} Tree */
/** @typedef {ReturnType<typeof grow>} Grown `total`: what each ray and all that come from it add to the pixel, three channels for each */
/** @typedef {{ ray: Ray, stub: null, level: number, place: number, siblings: number, open: boolean | null } | { ray: Ray, stub: Stub, level: number, place: number, siblings: number, open: null }} Row */

/** The camera ray of each sample (`roots`), the sample and the children of each ray, and what they add. @param {Tree} tree */
export function grow(tree) {
  const count = tree.rays.length;
  const children = Array.from({ length: count }, () => /** @type {number[]} */ ([]));
  const sample = new Int32Array(count);
  const total = new Float64Array(3 * count);
  /** @type {number[]} */
  const roots = [];
  for (const { id, parent } of tree.rays) {
    if (parent === null) {
      sample[id] = roots.length;
      roots.push(id);
    } else {
      sample[id] = sample[parent];
      children[parent].push(id);
    }
  }
  // Each ray comes after its parent.
  for (let id = count - 1; id >= 0; id -= 1) {
    const { parent, contribution } = tree.rays[id];
    for (let c = 0; c < 3; c += 1) total[3 * id + c] += contribution[c];
    if (parent === null) continue;
    for (let c = 0; c < 3; c += 1) total[3 * parent + c] += total[3 * id + c];
  }
  return { tree, roots, sample, children, total };
}

/** Samples that the renderer adds before it goes on: a batch of the kernel. */
const BATCH = 16;
/** Samples of an adaptive pixel's first run; each further run doubles their number. */
const FIRST = 8;

/**
 * Adds the contributions as the renderer does: within a sample in the order of the rays, in their precision, together with the
 * rounding errors of these additions; samples in double precision, both halves of a batch apart.
 * @param {Grown} grown
 * @returns {{ sum: Triple, samples: Triple[], verdict: "exact" | "close" | "truncated" | "off" }}
 */
export function addUp({ tree, roots, sample }) {
  const count = tree.samples;
  const round = tree.precision === "single" ? Math.fround : (/** @type {number} */ value) => value;
  const sums = roots.map(() => [0, 0, 0]);
  const errors = roots.map(() => [0, 0, 0]);
  for (const { id, contribution } of tree.rays) {
    const [sum, error] = [sums[sample[id]], errors[sample[id]]];
    for (let c = 0; c < 3; c += 1) {
      // The rounding error of each addition is exact (Knuth's TwoSum), and is added up beside the sum.
      const part = contribution[c] * count;
      const before = sum[c];
      sum[c] = round(before + part);
      const added = round(sum[c] - before);
      error[c] = round(error[c] + round(round(before - round(sum[c] - added)) + round(part - added)));
    }
  }
  const samples = sums.map((sum, of) => /** @type {Triple} */ (sum.map((value, c) => value + errors[of][c])));
  const means = [inBatches(samples), inRuns(samples)].map((sum) => /** @type {Triple} */ (sum.map((all, c) => all * (1 / count) + tree.raised[c])));
  const isExact = (/** @type {Triple} */ of) => of.every((value, c) => value === tree.value[c]);
  const sum = means.find(isExact) ?? means[0];
  if (tree.truncated) return { sum, samples, verdict: "truncated" };
  if (isExact(sum)) return { sum, samples, verdict: "exact" };
  // The service divides by the number of samples. Unless that is a power of two, multiplying again may be off by a bit.
  const isClose = sum.every((value, c) => Math.abs(value - tree.value[c]) <= 4e-15 * tree.value[c]);
  return { sum, samples, verdict: isClose && (count & (count - 1)) !== 0 ? "close" : "off" };
}

/** @param {Triple[]} samples @returns {Triple} */
function inBatches(samples) {
  const half = Math.ceil(samples.length / 2);
  const sum = /** @type {Triple} */ ([0, 0, 0]);
  for (let from = 0; from < samples.length; from += BATCH) {
    const batch = samples.slice(from, from + BATCH);
    for (let c = 0; c < 3; c += 1) {
      let [early, late] = [0, 0];
      batch.forEach((light, at) => (from + at < half ? (early += light[c]) : (late += light[c])));
      sum[c] += early + late;
    }
  }
  return sum;
}

/** As pixels do that get more samples until they are sure. @param {Triple[]} samples @returns {Triple} */
function inRuns(samples) {
  let sum = inBatches(samples.slice(0, FIRST));
  for (let n = FIRST; n < samples.length; n *= 2) {
    const run = inBatches(samples.slice(n, 2 * n));
    sum = /** @type {Triple} */ (sum.map((all, c) => all + run[c]));
  }
  return sum;
}

/** The sample that lies farthest from the mean, or 0. @param {Triple[]} samples */
export function oddOne(samples) {
  const mean = [0, 1, 2].map((c) => samples.reduce((sum, of) => sum + of[c], 0) / samples.length);
  const off = samples.map((of) => Math.max(...of.map((value, c) => Math.abs(value - mean[c]))));
  return off.reduce((best, value, at) => (value > off[best] ? at : best), 0);
}

/** The outline's rows: a ray, what was not followed from it, what was. @param {Grown} grown @param {number} root @param {ReadonlySet<number>} closed */
export function rowsOf({ tree, children }, root, closed) {
  /** @type {Row[]} */
  const rows = [];
  /** What is still to be written, the next last. @type {{ id: number, level: number, place: number, siblings: number }[]} */
  const open = tree.rays[root] ? [{ id: root, level: 1, place: 1, siblings: 1 }] : [];
  for (let next = open.pop(); next; next = open.pop()) {
    const { id, ...at } = next;
    const ray = tree.rays[id];
    const ended = ray.not_followed ?? [];
    const siblings = children[id].length + ended.length;
    const isOpen = siblings === 0 ? null : !closed.has(id);
    rows.push({ ray, stub: null, ...at, open: isOpen });
    if (!isOpen) continue;
    const level = at.level + 1;
    // A stub has nothing below, so that it comes first without tearing a branch apart.
    ended.forEach((stub, place) => rows.push({ ray, stub, level, place: place + 1, siblings, open: null }));
    for (let child = children[id].length - 1; child >= 0; child -= 1) {
      open.push({ id: children[id][child], level, place: ended.length + child + 1, siblings });
    }
  }
  return rows;
}

/** The name of a row, which stays while others open and close. @param {Row} row */
export const nameOf = ({ ray, stub, place }) => (stub ? `${ray.id}.${place}` : String(ray.id));

export const largest = (/** @type {Triple | number[]} */ triple) => Math.max(...triple);

export const KINDS = /** @type {const} */ ({
  camera: { letter: "C", name: "from the camera", dash: "" },
  reflected: { letter: "R", name: "reflected", dash: "7 3" },
  transmitted: { letter: "T", name: "transmitted", dash: "11 3 2 3" },
  shadow: { letter: "S", name: "to a light", dash: "2 3" },
  gathered: { letter: "G", name: "gathered", dash: "5 3 1 3 1 3" },
});

/** Why a ray was not followed. @param {Stub} stub */
export const whyOf = ({ why }) => ({ depth: "the depth ends here", weight: "too light to matter", budget: "the budget of rays is used up" })[why] ?? why;

/** What a ray ends at, and the pointer of that. @param {Ray} ray @returns {{ name: string, pointer: string | null }} */
export function targetOf(ray) {
  if (ray.hit) {
    const pointer = ray.hit.body ?? ray.hit.object;
    return { name: ray.hit.name || lastOf(pointer), pointer };
  }
  if (ray.light !== undefined && ray.light !== null) return { name: `light ${ray.light}`, pointer: `/lights/${ray.light}` };
  return { name: "background", pointer: null };
}

/** @param {string} pointer */
export const lastOf = (pointer) => pointer.split("/").slice(-2).join(" ").replace(/^objects /, "object ").replaceAll("~1", "/").replaceAll("~0", "~");

/** Whether a shadow ray is stopped on its way. @param {Ray} ray */
export const isBlocked = ({ kind, transmittance }) => kind === "shadow" && transmittance !== undefined && largest(transmittance) === 0;

/** Whether a ray was reflected since it could not leave a denser medium. @param {Tree} tree @param {Ray} ray */
export const isTotal = (tree, { kind, parent }) => kind === "reflected" && parent !== null && tree.rays[parent].snell?.tir === true;

/**
 * The media that a ray goes through: the one it is in, and behind what it hits the next one.
 * @param {Grown} grown @param {Ray} ray @param {(pointer: string) => string} named @returns {string[]}
 */
export function mediaOf({ tree, children }, ray, named) {
  const inside = (/** @type {Ray} */ of) => (of.media.length > 0 && of.media[0].ior !== 1 ? named(of.media[0].object) : "air");
  const next = children[ray.id].map((id) => tree.rays[id]).find(({ kind }) => kind === "transmitted");
  return next ? [inside(ray), inside(next)] : [inside(ray)];
}

/** A linear value as code of sRGB, with its fraction. @param {number} linear */
export const codeOf = (linear) => 255 * encoded(Math.min(1, Math.max(0, linear)));

/** The color of a linear value for CSS. @param {ArrayLike<number>} linear @param {number} [gain] */
export const colorOf = (linear, gain = 1) => `rgb(${[0, 1, 2].map((c) => Math.round(codeOf(linear[c] * gain))).join(" ")})`;

/** A number with a few digits: 0.0123, 1.23, 123, 1.2e-5. @param {number} value @param {number} [digits] */
export function short(value, digits = 3) {
  if (value === 0) return "0";
  if (!Number.isFinite(value)) return String(value);
  const size = Math.abs(value);
  if (size < 1e-4 || size >= 1e6) return value.toExponential(digits - 1).replace("+", "");
  return String(Number(value.toPrecision(digits)));
}

/** Codes for people: "at most 0.31 codes". @param {number} codes */
export const codesOf = (codes) => (codes >= 255 ? "without a bound" : codes === 0 ? "less than half a code" : `at most ${short(codes, 2)} ${codes === 1 ? "code" : "codes"}`);
