import { ConnectionError, DamagedError, Problem, StrahlError } from "./problems.js";

/** Longest wait that the service may ask for, in seconds. */
export const PATIENCE = 120;
/** Longest wait otherwise. */
const LONGEST = 30;
/** Longest time of the platform's timers, in milliseconds: more than three weeks. */
const LONGEST_TIMER = 0x7fff_ffff;

/** When something is tried again: as the service says, else twice as long each time. */
export class Backoff {
  #tries = 0;
  /**
   * @param {number} retries
   * @param {boolean} [following] Whether a job is followed: what a gateway says of a service that it cannot reach is a break then.
   */
  constructor(retries, following = false) {
    this.retries = retries;
    this.following = following;
  }
  /**
   * Seconds until the next try; undefined if there is none.
   * @param {unknown} error
   */
  next(error) {
    const broken = error instanceof Problem && this.following && error.isGateway;
    // A request with the same idempotency key that is still being accepted is a conflict for a moment.
    const pending = error instanceof Problem && error.slug === "conflict" && error.retryAfter !== undefined;
    if (this.#tries >= this.retries || (error instanceof Problem && !error.isBusy && !broken && !pending)) return undefined;
    this.#tries++;
    // Clients that were refused together do not come back together, and none too early.
    if (error instanceof Problem && error.retryAfter !== undefined) return Math.min(error.retryAfter, PATIENCE) * (1 + Math.random() / 4);
    return Math.min(0.25 * 2 ** this.#tries, LONGEST) * (0.75 + Math.random() / 2);
  }
}

/**
 * Seconds for a timer, which wants whole milliseconds; undefined is without limit, as what is beyond all timers.
 * @param {number} seconds
 */
function milliseconds(seconds) {
  const all = Math.max(0, Math.ceil(seconds * 1_000));
  return all > LONGEST_TIMER ? undefined : all;
}

/**
 * A signal that aborts after so many seconds, if they have an end.
 * @param {number} seconds
 */
export function limitOf(seconds) {
  if (typeof seconds !== "number" || Number.isNaN(seconds)) throw new RangeError(`a time must be a number of seconds, not ${seconds}`);
  const all = milliseconds(seconds);
  return all === undefined ? undefined : AbortSignal.timeout(all);
}

/**
 * A signal that aborts with the first of several.
 * @param {(AbortSignal | undefined)[]} signals
 */
export function first(...signals) {
  const given = signals.filter((one) => one !== undefined);
  return given.length > 1 ? AbortSignal.any(given) : given[0];
}

/**
 * @param {number} seconds
 * @param {AbortSignal} [signal]
 * @returns {Promise<void>}
 */
export const pause = (seconds, signal) =>
  new Promise((done, stop) => {
    const over = () => {
      clearTimeout(timer);
      stop(signal?.reason);
    };
    const timer = setTimeout(() => {
      signal?.removeEventListener("abort", over);
      done();
    }, seconds * 1_000);
    if (signal?.aborted) over();
    signal?.addEventListener("abort", over, { once: true });
  });

/**
 * A request.
 * @typedef {object} Asked
 * @property {string} [method]
 * @property {Record<string, unknown>} [query] what is null or undefined is left out
 * @property {Record<string, string>} [headers]
 * @property {BodyInit} [body]
 * @property {boolean} [once] It must not be sent again if it may have been received.
 * @property {boolean} [following] It follows a job, which goes on whatever a gateway says.
 * @property {number} [patience] Seconds that the service may take beyond the usual.
 * @property {AbortSignal} [signal]
 */

/** How a service is asked. */
export class Connection {
  /**
   * @param {string} url
   * @param {{ key?: string, timeout: number, retries: number, fetch: typeof fetch }} options
   */
  constructor(url, { key, timeout, retries, fetch }) {
    if (typeof timeout !== "number" || !(timeout > 0)) {
      throw new RangeError(`timeout must be seconds above 0, and is ${timeout}: Infinity is no limit`);
    }
    this.url = url.trim().replace(/\/+$/, "");
    // What errors show of the URL: its path may have a capability.
    this.host = hostOf(this.url);
    this.retries = retries;
    this.timeout = timeout;
    this.fetch = fetch;
    const sent = headerValue("the key", key?.trim() ?? "");
    /** @type {Record<string, string>} */
    this.headers = sent ? { authorization: `Bearer ${sent}` } : {};
  }

  /**
   * Sends a request once. The answer is a success, and no page.
   * @param {string} path
   * @param {Asked} asked
   * @param {AbortSignal} [signal]
   */
  async send(path, { method = "GET", query, headers = {}, body }, signal) {
    const given = Object.entries(query ?? {}).filter(([, value]) => value !== undefined && value !== null);
    const text = new URLSearchParams(given.map(([name, value]) => [name, String(value)])).toString();
    const answer = await this.fetch(`${this.url}${path}${text && `?${text}`}`, {
      method, headers: { ...headers, ...this.headers }, ...(body !== undefined && { body }), ...(signal && { signal }),
    });
    if (answer.ok) {
      if (kindOf(answer) !== "text/html") return answer;
      await answer.body?.cancel();
      throw foreign(answer, "what was asked for");
    }
    const said = await answer.text();
    // A date would need a clock that agrees; the service sends seconds.
    const after = answer.headers.get("retry-after") ?? "";
    const seconds = /^\d+$/.test(after) ? Number(after) : undefined, isGateway = answer.status >= 500 && kindOf(answer) !== "application/problem+json";
    throw new Problem(answer.status, parsed(said), seconds, isGateway);
  }

  /**
   * Asks, again if the service is busy or away, and reads the answer.
   * @template T
   * @param {string} path
   * @param {Asked} asked
   * @param {(answer: Response) => Promise<T>} read
   * @returns {Promise<T>}
   */
  async ask(path, asked, read) {
    const backoff = new Backoff(this.retries, asked.following), { signal } = asked;
    for (;;) {
      const limit = limitOf(this.timeout + (asked.patience ?? 0));
      try {
        return await read(await this.send(path, asked, first(signal, limit)));
      } catch (error) {
        signal?.throwIfAborted();
        // Who gives a time wants to wait no longer than that, and the answer to what must not be sent twice may have been lost.
        const again = !limit?.aborted && (!asked.once || error instanceof Problem) ? backoff.next(error) : undefined;
        if (again === undefined) throw this.shown(error);
        await pause(again, signal);
      }
    }
  }

  /**
   * Sends a request once whose answer comes in parts, of the type that it accepts. The service may be silent for so many seconds:
   * before the answer that is a `TimeoutError`, and within it a `ConnectionError`. Who stops listening closes the connection.
   * @param {string} path
   * @param {Asked & { headers: { accept: string } }} asked
   * @param {number} seconds
   * @returns {Promise<AsyncIterable<Uint8Array> | undefined>} undefined if the answer is empty (204)
   */
  async open(path, asked, seconds) {
    const stop = new AbortController(), late = new DOMException(`no answer for ${seconds} seconds`, "TimeoutError");
    const answer = await within(seconds, this.send(path, asked, first(stop.signal, asked.signal)), () => stop.abort(late));
    if (!answer.body) return undefined;
    if (kindOf(answer) !== asked.headers.accept) {
      await answer.body.cancel();
      throw foreign(answer, asked.headers.accept);
    }
    const silent = new ConnectionError(`the answer is silent for ${seconds} seconds`);
    return partsOf(answer.body, seconds, () => stop.abort(silent));
  }

  /**
   * An error of the platform as one of this package.
   * @param {unknown} cause
   */
  shown(cause) {
    if (cause instanceof StrahlError || /** @type {Error} */ (cause).name === "TimeoutError") return cause;
    const { message, cause: why } = /** @type {Error} */ (cause);
    return new ConnectionError(`${this.host}: ${why instanceof Error ? why.message : message}`, { cause });
  }
}

/**
 * What is said, and `late` is called if it is not said within so many seconds.
 * @template T
 * @param {number} seconds
 * @param {Promise<T>} said
 * @param {() => void} late
 */
async function within(seconds, said, late) {
  const most = milliseconds(seconds), timer = most && setTimeout(late, most);
  try {
    return await said;
  } finally {
    clearTimeout(timer);
  }
}

/**
 * The bytes of an answer as they come. Only the service is waited for, not who reads them.
 * @param {ReadableStream<Uint8Array>} body
 * @param {number} seconds
 * @param {() => void} silent
 */
async function* partsOf(body, seconds, silent) {
  const reader = body.getReader();
  try {
    for (let part; !(part = await within(seconds, reader.read(), silent)).done; ) yield part.value;
  } finally {
    await reader.cancel().catch(() => {});
  }
}

/**
 * The answer of a service that speaks JSON, which is always an object.
 * @param {Response} answer
 * @returns {Promise<any>}
 */
export async function json(answer) {
  const text = await answer.text();
  let said;
  try {
    said = JSON.parse(text);
  } catch (cause) {
    throw foreign(answer, "JSON", cause);
  }
  if (!isObject(said)) throw foreign(answer, "an object in JSON");
  return said;
}

/**
 * Reads an answer that has a list.
 * @param {string} name
 * @returns {(answer: Response) => Promise<any>}
 */
export const withList = (name) => async (answer) => {
  const said = await json(answer);
  if (!Array.isArray(said[name])) throw foreign(answer, `an object with ${name}`);
  return said;
};

/** @param {Uint8Array} bytes */
export const hexOf = (bytes) => Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");

/** @param {unknown} value */
export const isObject = (value) => typeof value === "object" && value !== null && !Array.isArray(value);

/**
 * Text for a header, which is checked here: `fetch` would show it in its error.
 * @param {string} what
 * @param {string} text
 */
export function headerValue(what, text) {
  if (!/^[ -~]*$/.test(text)) throw new TypeError(`${what} has characters that no header may have: it must be printable ASCII in one line`);
  return text;
}

/**
 * The host of a service, whose URL in a page may be relative. The URL is not shown if it is wrong, for it may have a password.
 * @param {string} url
 */
function hostOf(url) {
  const base = globalThis.location?.href;
  const { protocol, username, password, origin } = URL.canParse(url, base) ? new URL(url, base) : new URL("none:");
  if (!/^https?:$/.test(protocol)) throw new TypeError("the URL of the service must be one of http or https, such as http://127.0.0.1:8080");
  if (username || password) throw new TypeError("the URL of the service must have no password: fetch sends none");
  return origin;
}

/** @param {Response} answer */
export const kindOf = (answer) => (answer.headers.get("content-type") ?? "").replace(/;.*/s, "").trim().toLowerCase();

/**
 * An answer that is not the service's: mostly the URL is that of something else.
 * @param {Response} answer
 * @param {string} wanted
 * @param {unknown} [cause]
 */
export const foreign = (answer, wanted, cause) =>
  new DamagedError(`the answer is ${kindOf(answer) || "of no type"}, not ${wanted}: check that the URL is that of the service`, { cause });

/** @param {string} text */
function parsed(text) {
  try {
    return JSON.parse(text);
  } catch {
    return { detail: text.slice(0, 500) };
  }
}
