// Server-Sent Events over fetch: the browser's own reader sends no key (whatwg/html#2177).
import { Problem, Unreachable, ask, pause } from "./api.js";
import { valueOf } from "./pointers.js";

/** @typedef {{ event: string, data: any, id: string }} ServerEvent */

/** Splits a stream's text into events. It keeps what is not whole yet. */
export class EventParser {
  #rest = "";
  #event = "";
  #id = "";
  /** @type {string[]} */
  #data = [];
  /** Milliseconds after which the service wants to be asked again. */
  retry = 2000;

  /** Forgets the event that a broken stream has left half said. */
  begin() {
    this.#rest = "";
    this.#event = "";
    this.#data = [];
  }

  /** @param {string} chunk @returns {ServerEvent[]} */
  take(chunk) {
    const all = this.#rest + chunk;
    // A carriage return at the end may be half of a line's end.
    const lines = all.replace(/\r\n/g, "\n").replace(/\r(?!$)/g, "\n").split("\n");
    this.#rest = /** @type {string} */ (lines.pop());
    return lines.flatMap((line) => this.#line(line));
  }

  /** @param {string} line @returns {ServerEvent[]} */
  #line(line) {
    if (line === "") return this.#end();
    const colon = line.indexOf(":");
    const field = colon < 0 ? line : line.slice(0, colon);
    const value = colon < 0 ? "" : line.slice(colon + 1).replace(/^ /, "");
    if (field === "event") this.#event = value;
    else if (field === "data") this.#data.push(value);
    else if (field === "id" && !value.includes("\0")) this.#id = value;
    else if (field === "retry" && /^\d+$/.test(value)) this.retry = Number(value);
    return [];
  }

  /** @returns {ServerEvent[]} */
  #end() {
    const event = { event: this.#event || "message", data: this.#data.join("\n"), id: this.#id };
    const isEmpty = this.#data.length === 0;
    this.#event = "";
    this.#data = [];
    return isEmpty ? [] : [{ ...event, data: valueOf(event.data, event.data) }];
  }
}

/**
 * The events of an answer, until it ends. @param {Response} answer @param {EventParser} [parser] @returns {AsyncGenerator<ServerEvent>}
 */
export async function* eventsOf(answer, parser = new EventParser()) {
  const reader = /** @type {ReadableStream<Uint8Array>} */ (answer.body).getReader();
  const decoder = new TextDecoder();
  parser.begin();
  try {
    for (;;) {
      const { done, value } = await reader.read();
      if (done) return;
      yield* parser.take(decoder.decode(value, { stream: true }));
    }
  } finally {
    reader.cancel().catch(() => {});
  }
}

/**
 * Follows a stream and goes on after the last event when it breaks: after `retry` and up to 30 s. It ends when the service has no
 * more to say (204), when it refuses (throws `Problem`), or by the signal (throws the abort).
 * @param {string} path
 * @param {{ query?: Record<string, string | number | undefined>, jobs?: string[], signal: AbortSignal, take: (event: ServerEvent) => void, opened?: () => void }} options
 */
export async function follow(path, { query, jobs = [], signal, take, opened }) {
  const parser = new EventParser();
  const many = jobs.map((id) => `job=${encodeURIComponent(id)}`).join("&");
  let last = "";
  for (let broken = 0; ; broken += 1) {
    try {
      const headers = last === "" ? undefined : { "last-event-id": last };
      const answer = await ask(many ? `${path}?${many}` : path, { query, headers, accept: "text/event-stream", signal });
      if (answer.status === 204) return;
      opened?.();
      for await (const event of eventsOf(answer, parser)) {
        broken = 0;
        if (event.id !== "") last = event.id;
        take(event);
      }
    } catch (error) {
      if (signal.aborted) throw error;
      if (error instanceof Problem && error.status !== 503 && error.status !== 429) throw error;
      if (!(error instanceof Problem) && !(error instanceof Unreachable) && !(error instanceof TypeError)) throw error;
      if (error instanceof Problem && error.retryAfter > 0) await pause(error.retryAfter * 1000, signal);
    }
    await pause(Math.min(30_000, parser.retry * 2 ** Math.min(broken, 4)), signal);
  }
}
