// What can be read off a plan: its rows by time, its sentence, whether what was measured lies in the interval. Pure.
import { count, duration } from "../report.js";

/** @typedef {{ rays: number, rays_ci: [number, number], ms: number | null }} Estimated */
/** @typedef {{ rays: number, share_ms: number | null, saves_ms: number | null }} Actual */
/** @typedef {{ effect: string, state: "on" | "removed" | "off", reason: string, because: string[], values?: Record<string, any>, est?: Estimated, act?: Actual }} Effect */
/**
 * @typedef {object} Row
 * @property {string} name
 * @property {string} title the name for people
 * @property {Effect} effect
 * @property {number | null} ms estimated; null if its time is part of other effects' rays
 * @property {number} low of the interval
 * @property {number} high
 * @property {number | null} took milliseconds that its rays took, if the picture was measured
 * @property {string} outside how far the counted rays lie outside of the interval, or ""
 */

/** @param {string} name */
export function titleOf(name) {
  const words = name.replaceAll("_", " ");
  return words.charAt(0).toUpperCase() + words.slice(1);
}

/** @param {any} plan @param {any} [measured] the plan with what the picture took @returns {Row[]} the effects that are on or removed, the longest first */
export function rowsOf(plan, measured) {
  const acts = new Map((measured?.effects ?? []).map((/** @type {Effect} */ of) => [of.effect, of]));
  const rows = plan.effects.filter((/** @type {Effect} */ { state }) => state !== "off").map((/** @type {Effect} */ of) => {
    const est = of.est ?? { rays: 0, rays_ci: [0, 0], ms: null };
    // Milliseconds are rays times what one takes.
    const per = est.rays > 0 && est.ms !== null ? est.ms / est.rays : 0;
    const both = /** @type {Effect | undefined} */ (acts.get(of.effect));
    const act = both?.act;
    return {
      name: of.effect,
      title: titleOf(of.effect),
      effect: { ...of, act },
      ms: of.state === "on" ? est.ms : null,
      low: est.rays_ci[0] * per,
      high: est.rays_ci[1] * per,
      took: act && of.state === "on" ? act.share_ms : null,
      // The interval is that of the same run.
      outside: act ? outsideOf(act.rays, both?.est ?? est) : "",
    };
  });
  const key = (/** @type {Row} */ row) => (row.effect.state === "removed" ? -2 : row.took ?? row.ms ?? -1);
  return rows.sort((/** @type {Row} */ a, /** @type {Row} */ b) => key(b) - key(a));
}

/** @param {number} actual @param {Estimated} est */
function outsideOf(actual, { rays, rays_ci: [low, high] }) {
  if (actual >= low && actual <= high) return "";
  if (rays === 0 || actual === 0) return actual > high ? "more than estimated" : "less than estimated";
  const factor = actual > high ? actual / rays : rays / actual;
  return `${factor.toFixed(factor < 9.95 ? 1 : 0)} times ${actual > high ? "more" : "less"}`;
}

/** Rows without time of their own are said to have none. @param {Pick<Row, "ms" | "took">} row */
export const hasRays = ({ ms, took }) => ms !== null || took !== null;

/** The plan in a sentence or two. @param {any} plan @param {Row[]} rows @param {any} [measured] */
export function sentenceOf(plan, rows, measured) {
  const on = rows.filter(({ effect }) => effect.state === "on");
  const [heaviest] = on.filter(hasRays);
  const total = measured ? measured.actual.wall_ms : plan.estimate?.ms;
  const parts = [`${on.length} ${on.length === 1 ? "effect is" : "effects are"} on.`];
  const own = heaviest ? (heaviest.took ?? heaviest.ms ?? 0) : 0;
  const ofTrace = measured ? (measured.actual.phases_ms.trace ?? total) : total;
  if (heaviest && own > 0 && ofTrace > 0) {
    const share = Math.min(99, Math.round((100 * own) / ofTrace));
    parts.push(`${heaviest.title} takes ${share < 1 ? "less than 1" : share}\u00a0% of ${duration(total).replace(" ", "\u00a0")}.`);
  } else if (total) parts.push(`The picture ${measured ? "took" : "should take"} ${duration(total)}.`);
  const { requested, proved_sufficient: enough, reached } = measured?.depth ?? plan.depth;
  if (enough !== null) parts.push(`Depth ${enough} is enough, proved.`);
  else if (reached !== null) parts.push(`The longest chain had ${reached} rays${requested !== null && reached >= requested ? ", as many as it may" : ""}.`);
  return parts.join(" ");
}

/** Estimate and measurement side by side. @param {any} plan @param {any} [measured] */
export function totalsOf(plan, measured) {
  const est = measured?.estimate ?? plan.estimate;
  if (!est) return [];
  const rays = measured ? ["camera", "shadow", "reflected", "transmitted", "gathered"].reduce((sum, kind) => sum + (measured.actual.rays[kind] ?? 0), 0) : null;
  const row = (/** @type {string} */ name, /** @type {number} */ value, /** @type {[number, number]} */ [low, high], /** @type {number | null} */ actual, /** @type {(value: number) => string} */ words) => ({
    name, estimate: `${est.at_least ? "at least " : ""}${words(value)}`, interval: low < 0.01 * value ? `up to ${words(high)}` : `${words(low)} to ${words(high)}`,
    actual: actual === null ? "" : words(actual), isOutside: actual !== null && (actual < low || actual > high), value, low, high, took: actual,
  });
  return [row("time", est.ms, est.ms_ci, measured ? (measured.actual.phases_ms.trace ?? measured.actual.wall_ms) : null, duration), row("rays", est.rays, est.rays_ci, rays, count)];
}
