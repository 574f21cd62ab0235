// The trade-off as a plot: where points lie, which of them no other beats, and ticks that people read. accuracy-plot.js draws.

/**
 * A measured setting.
 * @typedef {{ name: string, settings: Record<string, any>, ms: number, rays: number, errors: Record<ErrorName, number>,
 *   identical: number, proved: number | null }} Point
 * `settings`: as the service measured them; `identical`: share of the pixels; `proved`: codes
 */
/** @typedef {"p999" | "max" | "rms" | "flip"} ErrorName */
/** @type {Record<ErrorName, { title: string, unit: string }>} */
export const ERRORS = {
  p999: { title: "99.9 % of pixels", unit: "codes" },
  max: { title: "Largest", unit: "codes" },
  rms: { title: "Root mean square", unit: "codes" },
  flip: { title: "FLIP", unit: "" },
};

/** A point while it is measured, which has fewer errors. @param {any} of @returns {Point} */
export function earlyPoint({ settings, time_ms: ms, rays, proved_codes: proved, error }) {
  const errors = { p999: error.p999_codes, max: error.max_codes, rms: Number.NaN, flip: Number.NaN };
  return { name: nameOf(settings), settings, ms, rays: traced(rays), errors, identical: error.identical, proved: proved ?? null };
}

/**
 * The newest of each point on a picture of one size, the largest that most have come to: times on others say nothing about it.
 * @template {{ index: number, width: number, height: number }} Of @param {Of[]} told @returns {Of[]}
 */
export function ofOneSize(told) {
  const sizes = /** @type {Map<number, Map<number, Of>>} */ (new Map());
  for (const of of told) {
    const pixels = of.width * of.height;
    sizes.set(pixels, (sizes.get(pixels) ?? new Map()).set(of.index, of));
  }
  const most = Math.max(0, ...[...sizes.values()].map(({ size }) => size));
  const [found] = [...sizes].sort(([a], [b]) => b - a).filter(([, { size }]) => size >= 0.6 * most);
  return found ? [...found[1].values()] : [];
}

/** Rays of all kinds. @param {Record<string, number> | number | undefined} rays */
function traced(rays) {
  if (typeof rays === "number") return rays;
  const kinds = ["camera", "shadow", "reflected", "transmitted", "gathered"];
  return Object.entries(rays ?? {}).reduce((sum, [kind, count]) => (kinds.includes(kind) ? sum + count : sum), 0);
}

/** A point of the service's report: of `choices.all`, or of `points`. @param {any} of @returns {Point} */
export function pointOf(of) {
  const difference = of.difference ?? of.measured?.total;
  return {
    name: of.name ?? nameOf(of.settings),
    settings: of.settings,
    ms: of.request_ms ?? of.time.median_ms,
    rays: traced(of.rays),
    errors: { p999: difference.codes.error.p999, max: difference.codes.error.max, rms: difference.rms_codes, flip: difference.flip.mean },
    identical: difference.codes.identical,
    proved: of.proved_codes ?? null,
  };
}

/** What a setting is called that the service gave no name. @param {Record<string, any>} settings */
export function nameOf(settings) {
  const ends = settings.max_codes !== undefined ? `proved:${settings.max_codes}` : settings.max_depth === null ? "no limit" : `depth ${settings.max_depth}`;
  const weight = settings.max_codes === undefined && settings.min_weight !== 0.001 ? `weight ${Number(settings.min_weight?.toPrecision(2))}` : "";
  const samples = settings.samples > 1 ? `${settings.samples} samples` : "";
  return [ends, weight, samples, settings.antialias ? "antialiased" : "", settings.precision === "double" ? "double" : ""].filter(Boolean).join(", ");
}

/** The parameters of a request that give the picture of a point. @param {Record<string, any>} settings @returns {Record<string, string>} */
export function queryOf({ max_codes, max_depth, min_weight, samples, antialias, precision }) {
  const query = { accuracy: max_codes === undefined || max_codes === null ? "fixed" : `proved:${max_codes}`, max_depth, min_weight, samples, antialias, precision };
  return Object.fromEntries(Object.entries(query).filter(([, value]) => value !== undefined && value !== null).map(([name, value]) => [name, String(value)]));
}

/**
 * Indices of the points that no other beats in both, from the quickest on.
 * @param {{ ms: number, error: number }[]} points
 */
export function front(points) {
  const order = points.map((_, i) => i).sort((a, b) => points[a].ms - points[b].ms || points[a].error - points[b].error);
  let least = Number.POSITIVE_INFINITY;
  return order.filter((i) => points[i].error < least && ((least = points[i].error), true));
}

/** Errors on an axis that holds 0: even up to 1 code, then by powers. @param {number} error @param {number} unit */
export const bent = (error, unit) => Math.log2(1 + error / unit);

/** Ticks 1, 2, 5, 10 ... within a range, at most `most` of them. @param {number} low @param {number} high @param {number} most */
export function ticks(low, high, most) {
  const all = [];
  for (let power = Math.floor(Math.log10(low)); power <= Math.ceil(Math.log10(high)); power += 1)
    for (const step of [1, 2, 5]) all.push(Number((step * 10 ** power).toPrecision(3)));
  const inside = all.filter((tick) => tick >= low && tick <= high);
  for (const few of [inside, inside.filter((tick) => /^0*\.?0*[15]/.test(String(tick))), inside.filter((tick) => /^0*\.?0*1/.test(String(tick)))]) if (few.length <= most) return few;
  return inside.filter((_, i) => i % Math.ceil(inside.length / most) === 0);
}

/** @typedef {{ width: number, height: number, left: number, right: number, top: number, bottom: number }} Frame */
/**
 * Where everything lies in the plot.
 * @param {Point[]} points @param {ErrorName} error @param {Frame} frame
 */
export function layout(points, error, frame) {
  const unit = error === "flip" ? 0.005 : 1;
  const least = Math.min(...points.map(({ ms }) => ms)) / 1.25;
  const most = Math.max(...points.map(({ ms }) => ms)) * 1.25;
  const highest = Math.max(unit, ...points.map(({ errors, proved }) => Math.max(errors[error], error === "flip" ? 0 : Math.min(255, proved ?? 0)))) * 1.08;
  const x = (/** @type {number} */ ms) => frame.left + ((frame.width - frame.left - frame.right) * Math.log(ms / least)) / Math.log(most / least);
  const y = (/** @type {number} */ of) => frame.height - frame.bottom - ((frame.height - frame.top - frame.bottom) * bent(of, unit)) / bent(highest, unit);
  const onFront = front(points.map((point) => ({ ms: point.ms, error: point.errors[error] })));
  return {
    points: points.map((point) => ({ x: x(point.ms), y: y(point.errors[error]), proved: error === "flip" || point.proved === null ? null : y(Math.min(255, point.proved)) })),
    front: onFront,
    times: ticks(least, most, 6).map((tick) => ({ tick, x: x(tick) })),
    errors: [0, ...ticks(unit, highest, 5)].map((tick) => ({ tick, y: y(tick) })),
  };
}
