/**
 * Anything that this package throws, but for `AbortError` and `TimeoutError` of the platform, and its `TypeError` and `RangeError`
 * for an argument that cannot be sent.
 */
export class StrahlError extends Error {
  /** @override */
  name = "StrahlError";
}

/** The service does not answer, or its answer broke off, also when asked again. */
export class ConnectionError extends StrahlError {
  /** @override */
  name = "ConnectionError";
}

/** What arrived is not what the service has sent. */
export class DamagedError extends StrahlError {
  /** @override */
  name = "DamagedError";
}

/**
 * One thing that is wrong with a request or a scene.
 * @typedef {object} Mistake
 * @property {string} code
 * @property {string} detail
 * @property {string} [pointer] Where it is in the scene: a JSON pointer, such as `/objects/3/sphere/radius`.
 * @property {string} [parameter] The query parameter that is wrong.
 * @property {number} [line] Line in the body, from 1.
 * @property {number} [column] Column in the line, from 1.
 */

/** An answer that is a problem (RFC 9457). `slug` says which kind: `/problems/{slug}` of the service explains it. */
export class Problem extends StrahlError {
  /** @override */
  name = "Problem";

  /**
   * @param {number} status
   * @param {unknown} document what the service said; an answer of a proxy may be anything
   * @param {number} [retryAfter]
   * @param {boolean} [isGateway]
   */
  constructor(status, document, retryAfter, isGateway = false) {
    const known = /** @type {Record<string, unknown>} */ (document && typeof document === "object" ? document : {});
    const text = (/** @type {unknown} */ value) => (typeof value === "string" ? value : "");
    const title = text(known.title) || `HTTP ${status}`, detail = text(known.detail);
    const entries = Array.isArray(known.errors) ? known.errors.filter((one) => one && typeof one === "object") : [];
    const mistakes = entries.map(mistakeOf);
    const lines = mistakes.length > 1 || mistakes[0]?.line ? mistakes.map((one) => `\n  ${described(one)}`) : [];
    super(printable(`${title} (${status})${detail ? `: ${detail}` : ""}`) + lines.join(""));
    this.status = status;
    /** The whole document. */
    this.document = known;
    /** What kind it is, such as `invalid-scene`. */
    this.slug = text(known.type).split("/").pop() ?? "";
    this.detail = detail;
    /** The request's id, which the log of the service has, too. */
    this.requestId = text(known.instance);
    /** What is wrong, one by one. */
    this.mistakes = mistakes;
    /** How many more there are. */
    this.more = typeof known.more === "number" ? known.more : 0;
    /** The limit that was exceeded. */
    this.limit = /** @type {{ name: string, max: number } | undefined} */ (known.limit);
    /** Seconds to wait before the next try. */
    this.retryAfter = retryAfter;
    /** Whether it is a server error of something before the service, whose own are documents. */
    this.isGateway = isGateway;
  }

  /** Whether the same request may do later. */
  get isBusy() {
    return [429, 502, 503].includes(this.status);
  }
}

/**
 * @param {Record<string, unknown>} entry
 * @returns {Mistake}
 */
function mistakeOf(entry) {
  const { code, detail, pointer, parameter, line, column } = entry;
  return {
    code: String(code ?? ""),
    detail: String(detail ?? ""),
    ...(typeof pointer === "string" && { pointer: pointerOf(pointer) }),
    ...(typeof parameter === "string" && { parameter }),
    ...(typeof line === "number" && { line }),
    ...(typeof column === "number" && { column }),
  };
}

/**
 * A JSON pointer. One that is a URI fragment is percent-encoded (RFC 6901, 6); what is no UTF-8 becomes U+FFFD.
 * @param {string} text
 */
function pointerOf(text) {
  if (!text.startsWith("#")) return text;
  const bytes = (/** @type {string} */ run) => Uint8Array.from(run.slice(1).split("%"), (hex) => Number.parseInt(hex, 16));
  return text.slice(1).replace(/(?:%[\da-f]{2})+/gi, (run) => new TextDecoder("utf-8", { ignoreBOM: true }).decode(bytes(run)));
}

/** @param {Mistake} mistake */
function described({ line, column, pointer, parameter, detail }) {
  const place = pointer ?? parameter;
  return printable(`${line ? `line ${line}, column ${column}: ` : ""}${place ? `${place}: ` : ""}${detail}`);
}

/**
 * Text for a terminal: names in scenes may contain what controls one.
 * @param {string} text
 */
const printable = (text) =>
  text.replace(/[\p{Cc}\p{Cf}\p{Zl}\p{Zp}]/gu, (one) => `\\u{${/** @type {number} */ (one.codePointAt(0)).toString(16)}}`);
