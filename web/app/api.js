// Requests to the service: fetch with the key, problem documents as errors, Retry-After, abort, and whether it is there.
import { batch } from "../vendor/preact.js";
import { reportOf } from "./report.js";
import { connection, dialog, key } from "./state.js";

/** @typedef {import("./state.js").SceneProblem} SceneProblem */
/** @typedef {import("./state.js").Settings} Settings */

/** An answer that is a problem document (RFC 9457). */
export class Problem extends Error {
  /** @param {number} status @param {any} document @param {number} retryAfter */
  constructor(status, document, retryAfter) {
    super(document.detail ?? document.title ?? `the service answered ${status}`);
    this.status = status;
    /** @type {SceneProblem[]} */
    this.errors = document.errors ?? [];
    /** The limit that it is beyond. @type {string} */
    this.limit = document.limit?.name ?? "";
    /** Seconds after which the service may take it, or 0. */
    this.retryAfter = retryAfter;
  }
}

/** The service did not answer, or its answer broke off. */
export class Unreachable extends Error {}

/**
 * @typedef {{ method?: string, body?: string | Blob | FormData | Uint8Array<ArrayBuffer>, type?: string,
 *   query?: Record<string, string | number | undefined>, headers?: Record<string, string>, accept?: string,
 *   signal?: AbortSignal, priority?: RequestPriority }} Options
 * `type`: media type of the body
 */

/** The address of a path of the service, beside this page. @param {string} path @param {Options["query"]} [query] */
export function address(path, query = {}) {
  const url = new URL(path.replace(/^\//, ""), document.baseURI);
  for (const [name, value] of Object.entries(query)) if (value !== undefined) url.searchParams.set(name, String(value));
  return url;
}

/**
 * Asks the service. Throws `Problem`, `Unreachable`, or the `AbortError` of the signal.
 * @param {string} path @param {Options} [options] @returns {Promise<Response>}
 */
export async function ask(path, { method, body, type, query, headers = {}, accept, signal, priority } = {}) {
  const all = new Headers(headers);
  if (type) all.set("content-type", type);
  if (accept) all.set("accept", accept);
  if (key.peek() !== "") all.set("authorization", `Bearer ${key.peek()}`);
  const options = { method: method ?? (body === undefined ? "GET" : "POST"), body, headers: all, signal, priority, cache: /** @type {const} */ ("no-cache") };
  let answer;
  try {
    answer = await fetch(address(path, query), options);
  } catch (error) {
    if (signal?.aborted) throw error;
    goOffline();
    throw new Unreachable("the service does not answer");
  }
  if (answer.ok) return answer;
  const document = (await answer.json().catch(() => null)) ?? {};
  // A proxy says so while the service behind it is away; the service's own words have a type.
  if (GATEWAY.includes(answer.status) && document.type === undefined) {
    goOffline();
    throw new Unreachable("the service does not answer");
  }
  if (answer.status === 401) batch(() => ((key.value = ""), (dialog.value = "key")));
  // A date instead of seconds is no number.
  throw new Problem(answer.status, document, Number(answer.headers.get("retry-after")) || 0);
}

/**
 * What is read of an answer. One that breaks off is `Unreachable`. @template T @param {Promise<T>} read @param {AbortSignal} [signal] @returns {Promise<T>}
 */
export async function whole(read, signal) {
  try {
    return await read;
  } catch (error) {
    // What is whole but no JSON is a SyntaxError.
    if (signal?.aborted || !(error instanceof TypeError)) throw error;
    goOffline();
    throw new Unreachable("the answer broke off");
  }
}

/** @param {string} path @param {Options} [options] @returns {Promise<any>} */
export const askJson = async (path, options) => whole((await ask(path, { accept: "application/json", ...options })).json(), options?.signal);

/** @param {string} path @param {Options} [options] */
export const askText = async (path, options) => whole((await ask(path, options)).text(), options?.signal);

/** @param {string} path @param {Options} [options] */
export const askBlob = async (path, options) => whole((await ask(path, options)).blob(), options?.signal);

/** A wait that an abort ends. @param {number} ms @param {AbortSignal} [signal] @returns {Promise<void>} */
export const pause = (ms, signal) =>
  new Promise((over, failed) => {
    const timer = setTimeout(over, ms);
    signal?.addEventListener("abort", () => (clearTimeout(timer), failed(signal.reason)), { once: true });
  });

/**
 * Asks again after 429 and 503, as long as the service says when, at most five times.
 * @template T @param {() => Promise<T>} request @param {AbortSignal} [signal] @param {(seconds: number) => void} [waiting] @returns {Promise<T>}
 */
export async function patiently(request, signal, waiting) {
  for (let tries = 0; ; tries += 1) {
    try {
      return await request();
    } catch (error) {
      if (!(error instanceof Problem) || error.retryAfter === 0 || tries === 5) throw error;
      waiting?.(error.retryAfter);
      await pause(error.retryAfter * 1000, signal);
    }
  }
}

/**
 * A picture of a scene.
 * @param {{ text: string, type?: string, settings: Settings, signal?: AbortSignal, priority?: RequestPriority }} of
 */
export async function render({ text, type = "application/json", settings, signal, priority }) {
  const answer = await ask("v1/render", { body: text, type, query: settings, accept: "image/png", signal, priority });
  const blob = await whole(answer.blob(), signal);
  const bitmap = await createImageBitmap(blob);
  if (signal?.aborted) {
    bitmap.close();
    throw signal.reason;
  }
  return { bitmap, blob, report: reportOf(answer.headers) };
}

/** What proxies answer with while the service is away. 504 would repeat what takes too long. */
const GATEWAY = [502, 503];
/** The hash of the files of this page: its folder. */
const OWN = /studio\/([0-9a-f]+)\//.exec(import.meta.url)?.[1] ?? "";
let probing = false;

/** Looks for the service until it answers again: after 0.5 s, then every second, and in a tab that nobody sees every 8 s. */
export async function goOffline() {
  if (probing) return;
  probing = true;
  connection.value = { ...connection.peek(), online: false };
  for (let wait = 500; ; wait = Math.min(document.hidden ? 8000 : 1000, wait * 2)) {
    await pause(wait);
    try {
      await lookForNews();
      break;
    } catch {
      // It is still away.
    }
  }
  probing = false;
}

/** Whether the service has another version of this page, which goes on working meanwhile. */
export async function lookForNews() {
  const answer = await fetch(address("studio"), { method: "HEAD", cache: "no-store" });
  if (GATEWAY.includes(answer.status)) throw new Unreachable("the service does not answer");
  const upgraded = OWN !== "" && answer.ok && !(answer.headers.get("etag") ?? OWN).includes(OWN);
  connection.value = { online: true, upgraded };
}
