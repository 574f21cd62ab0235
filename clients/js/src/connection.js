import { ConnectionError, Problem, StrahlError } from "./problems.js";

/** Longest wait that the service may ask for, in seconds. */
export const PATIENCE = 120;
/** Longest wait otherwise. */
const LONGEST = 30;

/** When something is tried again: as the service says, else twice as long each time. */
export class Backoff {
  #tries = 0;
  /** @param {number} retries */
  constructor(retries) {
    this.retries = retries;
  }
  /**
   * Seconds until the next try; undefined if there is none.
   * @param {unknown} error
   */
  next(error) {
    if (this.#tries >= this.retries || (error instanceof Problem && !error.isBusy)) return undefined;
    this.#tries++;
    if (error instanceof Problem && error.retryAfter !== undefined) return Math.min(error.retryAfter, PATIENCE);
    // Clients that were refused together do not come back together.
    return Math.min(0.25 * 2 ** this.#tries, LONGEST) * (0.75 + Math.random() / 2);
  }
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
    this.url = url.replace(/\/+$/, "");
    this.retries = retries;
    this.timeout = timeout;
    this.fetch = fetch;
    /** @type {Record<string, string>} */
    this.headers = key ? { authorization: `Bearer ${key}` } : {};
  }

  /**
   * Sends a request once. The answer is a success.
   * @param {string} path
   * @param {Asked} asked
   * @param {AbortSignal} [signal]
   */
  async send(path, { method = "GET", query = {}, headers = {}, body }, signal) {
    const given = Object.entries(query).filter(([, value]) => value !== undefined && value !== null);
    const text = new URLSearchParams(given.map(([name, value]) => [name, String(value)])).toString();
    const answer = await this.fetch(`${this.url}${path}${text && `?${text}`}`, {
      method, headers: { ...headers, ...this.headers }, ...(body !== undefined && { body }), ...(signal && { signal }),
    });
    if (answer.ok) return answer;
    const said = await answer.text();
    const after = answer.headers.get("retry-after");
    throw new Problem(answer.status, parsed(said), after === null || !(Number(after) >= 0) ? undefined : Number(after));
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
    const backoff = new Backoff(this.retries), { signal } = asked;
    for (;;) {
      const limit = AbortSignal.timeout((this.timeout + (asked.patience ?? 0)) * 1_000);
      try {
        return await read(await this.send(path, asked, signal ? AbortSignal.any([signal, limit]) : limit));
      } catch (error) {
        signal?.throwIfAborted();
        // Who gives a time wants to wait no longer than that, and the answer to what must not be sent twice may have been lost.
        const again = !limit.aborted && (!asked.once || error instanceof Problem) ? backoff.next(error) : undefined;
        if (again === undefined) throw this.shown(error);
        await pause(again, signal);
      }
    }
  }

  /**
   * An error of the platform as one of this package.
   * @param {unknown} cause
   */
  shown(cause) {
    if (cause instanceof StrahlError || /** @type {Error} */ (cause).name === "TimeoutError") return cause;
    const { message, cause: why } = /** @type {Error} */ (cause);
    return new ConnectionError(`${this.url}: ${why instanceof Error ? why.message : message}`, { cause });
  }
}

/** @param {string} text */
function parsed(text) {
  try {
    return JSON.parse(text);
  } catch {
    return { detail: text.slice(0, 500) };
  }
}
