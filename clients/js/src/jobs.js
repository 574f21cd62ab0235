import { Backoff, PATIENCE, first, headerValue, hexOf, json, limitOf, pause, withList } from "./connection.js";
import { pictureOf } from "./picture.js";
import { ConnectionError, DamagedError, Problem } from "./problems.js";
import { events } from "./sse.js";

// Seconds without a byte after which a stream is dead; the service sends a comment each 15 seconds.
const SILENCE = 45;
// Seconds before a stream is opened again: at least, and where it does not say how many.
const LEAST = 0.5, USUAL = 1;
const OVER = ["succeeded", "failed", "canceled"];

/** @typedef {import("../types/contract.js").components["schemas"]} Schemas */

/**
 * What has happened to a job. `name`: snapshot, queued, started, preview, tile, progress, succeeded, failed, canceled.
 * @typedef {{ name: string, id: string, data: Record<string, any> }} JobEvent
 */

/**
 * How far a job is.
 * @typedef {object} Progress
 * @property {string} state
 * @property {number} fraction From 0 to 1.
 * @property {number} tilesDone
 * @property {number} tilesTotal
 * @property {number | null} etaMs Milliseconds until the end, estimated.
 */

/** The jobs of a service. */
export class Jobs {
  #connection;
  /** @param {import("./connection.js").Connection} connection */
  constructor(connection) {
    this.#connection = connection;
  }

  /**
   * Submits a job. The same `idempotencyKey` with the same request gives the same job; without one it has its own, so a
   * request that was lost is sent again and is still one job.
   * @param {import("./client.js").Scene} scene
   * @param {import("./client.js").Settings & import("./client.js").Output & { priority?: number, labels?: string[],
   *   webhook?: string, store?: string | true, idempotencyKey?: string, wait?: number, frames?: Schemas["Sequence"] }} [options] `wait`:
   *   seconds to wait for its end; `webhook`: a URL that hears of its end; `store`: the name of its picture in the service's store, or
   *   true for one of its own; `frames` makes a sequence of it, such as `{ count: 36, turntable: {} }`
   * @param {import("./client.js").Given} [given]
   */
  async submit(scene, options = {}, { signal } = {}) {
    checkLayers("a job", options);
    // Pages of plain http have no `randomUUID`.
    const ownKey = hexOf(crypto.getRandomValues(new Uint8Array(16)));
    const { priority, labels, webhook, store, idempotencyKey = ownKey, wait, frames, format, bits, quality, ...settings } = options;
    const output = { format, bits: bits === undefined ? undefined : String(bits), quality };
    const after = { webhook: webhook && { url: webhook }, store: store && (store === true ? {} : { key: store }) };
    const about = JSON.stringify({ settings, output, priority, labels, frames, ...after });
    // The scene's text goes in as it is.
    const body = `{"scene":${await textOf(scene)},${about.slice(1)}`;
    const headers = {
      "content-type": "application/json", "idempotency-key": headerValue("the idempotency key", idempotencyKey), ...(wait && { prefer: `wait=${wait}` }),
    };
    return new Job(this.#connection, await this.#connection.ask("/v1/jobs", { method: "POST", headers, body, patience: wait, signal }, json));
  }

  /**
   * The job of an id.
   * @param {string} id
   * @param {import("./client.js").Given} [given]
   */
  async get(id, { signal } = {}) {
    return new Job(this.#connection, await this.#connection.ask(`/v1/jobs/${checked(id)}`, { following: true, signal }, json));
  }

  /**
   * All jobs of the tenant, the newest first.
   * @param {{ state?: Schemas["JobState"], label?: string } & import("./client.js").Given} [filters]
   */
  async *list({ state, label, signal } = {}) {
    /** @type {string | null | undefined} */
    let cursor;
    do {
      /** @type {Schemas["JobList"]} */
      const page = await this.#connection.ask("/v1/jobs", { query: { state, label, cursor }, signal }, withList("jobs"));
      for (const view of page.jobs) yield new Job(this.#connection, view);
      cursor = page.next;
    } while (cursor);
  }

  /**
   * What happens to all jobs of the tenant, with `created` and `removed` as they come and go, without an end. First comes a
   * snapshot of each job that has not ended, also when the stream begins again after it broke: it cannot be continued.
   * @param {{ label?: string } & import("./client.js").Given} [filters]
   */
  events({ label, signal } = {}) {
    return follow(this.#connection, "/v1/events", { label }, "", signal);
  }
}

/**
 * The events of a stream, which goes on after the last one if it breaks, until the service has no more (204).
 * @param {import("./connection.js").Connection} connection
 * @param {string} path
 * @param {Record<string, unknown>} query
 * @param {string} last id of the last event that was seen
 * @param {AbortSignal} [signal]
 * @returns {AsyncGenerator<JobEvent, void>}
 */
async function* follow(connection, path, query, last, signal) {
  for (let backoff = new Backoff(connection.retries, true), usual = USUAL; ; ) {
    /** @type {unknown} */
    let error = new ConnectionError("the stream of events ends too soon");
    /** @type {number | undefined} */
    let seconds;
    /** @type {AsyncIterable<Uint8Array> | undefined} */
    let parts;
    try {
      const headers = { accept: "text/event-stream", ...(last && { "last-event-id": last }) };
      parts = await connection.open(path, { query, headers, signal }, SILENCE);
      if (!parts) return;
      for await (const event of events(parts, (ms) => (usual = bounded(ms)))) {
        if (event.name === "shutdown") {
          seconds = bounded(Number(event.data.retry_ms) || 5_000);
          break;
        }
        last = event.id || last;
        yield event;
      }
    } catch (broken) {
      signal?.throwIfAborted();
      error = broken;
    }
    // A stream that was answered is alive, also if nothing happened on it. What is damaged may be so each time.
    if (parts && !(error instanceof DamagedError)) backoff = new Backoff(connection.retries, true);
    seconds ??= backoff.next(error);
    if (seconds === undefined) throw connection.shown(error);
    await pause(Math.max(seconds, usual), signal);
  }
}

/**
 * Seconds of a pause that is not too short for the service, nor too long for who listens.
 * @param {number} ms
 */
const bounded = (ms) => Math.min(Math.max(ms / 1_000, LEAST), PATIENCE);

/** A job. `view` is what the service last said about it. */
export class Job {
  #connection;
  /**
   * @param {import("./connection.js").Connection} connection
   * @param {Schemas["JobView"]} view
   */
  constructor(connection, view) {
    this.#connection = connection;
    this.view = view;
  }
  get id() {
    return this.view.id;
  }
  get state() {
    return this.view.state;
  }
  get #path() {
    return `/v1/jobs/${checked(this.id)}`;
  }

  /**
   * Asks for it again.
   * @param {{ wait?: number } & import("./client.js").Given} [options] `wait`: seconds to wait for its end
   */
  async refresh({ wait, signal } = {}) {
    /** @type {Record<string, string>} */
    const headers = wait ? { prefer: `wait=${wait}` } : {};
    this.view = await this.#connection.ask(this.#path, { headers, patience: wait, following: true, signal }, json);
    return this;
  }

  /**
   * What happens to it, until it has ended. A stream that breaks goes on after the last event.
   * @param {{ since?: string } & import("./client.js").Given} [options]
   * @returns {AsyncGenerator<JobEvent, void>}
   */
  async *events({ since = "", signal } = {}) {
    const last = headerValue("the id of an event", since);
    for await (const event of follow(this.#connection, `${this.#path}/events`, {}, last, signal)) {
      yield event;
      if (OVER.includes(event.name)) return;
    }
  }

  /**
   * How far it is, until it has ended.
   * @param {import("./client.js").Given} [given]
   * @returns {AsyncGenerator<Progress, void>}
   */
  async *progress({ signal } = {}) {
    /** @type {Progress} */
    let known = { state: "queued", fraction: 0, tilesDone: 0, tilesTotal: 0, etaMs: null };
    for await (const { name, data } of this.events({ signal })) {
      if (name === "preview") continue;
      const state = name === "snapshot" ? data.state : OVER.includes(name) || name === "queued" ? name : "running";
      const tilesTotal = data.tiles_total ?? known.tilesTotal;
      // After a restart the service may know of fewer tiles than it had told.
      const tilesDone = name === "succeeded" ? tilesTotal : Math.max(known.tilesDone, data.tiles_done ?? 0);
      const fraction = name === "succeeded" ? 1 : tilesTotal && tilesDone / tilesTotal;
      known = { state, fraction, tilesDone, tilesTotal, etaMs: data.eta_ms ?? known.etaMs };
      yield known;
    }
  }

  /**
   * Waits for its end; its picture. Rejects with a `Problem` if there is none, with a `TimeoutError` after so many seconds:
   * at once after 0 or less, never after `Infinity`.
   * @param {{ timeout?: number, onProgress?: (progress: Progress) => void } & import("./client.js").Given} [options]
   */
  async wait({ timeout, onProgress, signal } = {}) {
    const either = first(signal, timeout === undefined ? undefined : limitOf(timeout));
    while (this.state === "queued" || this.state === "running") {
      await this.refresh({ wait: onProgress ? 1 : 20, signal: either });
      const { fraction, tiles_done: tilesDone, tiles_total: tilesTotal } = this.view.progress;
      onProgress?.({ state: this.state, fraction, tilesDone, tilesTotal, etaMs: this.view.eta_ms });
    }
    return this.result({ signal });
  }

  /**
   * Its picture, if it has succeeded.
   * @param {import("./client.js").Given} [given]
   */
  async result({ signal } = {}) {
    if (this.state === "failed" || this.state === "canceled") {
      const canceled = { type: "/problems/job-failed", title: "The job has no picture", status: 409, detail: `job ${this.id} was canceled` };
      const problem = this.view.problem ?? canceled;
      throw new Problem(problem.status, problem);
    }
    return this.#connection.ask(`${this.#path}/image`, { following: true, signal }, pictureOf);
  }

  /**
   * The finished frames of a sequence, with what each cost and how far it may be off.
   * @param {import("./client.js").Given} [given]
   * @returns {Promise<Schemas["FrameList"]>}
   */
  frames({ signal } = {}) {
    return this.#connection.ask(`${this.#path}/frames`, { signal }, withList("frames"));
  }

  /**
   * A frame of a sequence, from 0, as soon as it is finished.
   * @param {number} number
   * @param {import("./client.js").Given} [given]
   */
  frame(number, { signal } = {}) {
    return this.#connection.ask(`${this.#path}/frames/${Math.trunc(number)}`, { patience: 30, signal }, pictureOf);
  }

  /**
   * All frames of a sequence that has succeeded.
   * @param {{ format?: "png" | "webp" | "gif" } & import("./client.js").Given} [options]
   */
  animation({ format = "png", signal } = {}) {
    return this.#connection.ask(`${this.#path}/animation`, { query: { format }, patience: 30, signal }, pictureOf);
  }

  /**
   * The finished frames of a sequence, small and side by side.
   * @param {{ columns?: number } & import("./client.js").Given} [options]
   */
  sheet({ columns, signal } = {}) {
    return this.#connection.ask(`${this.#path}/sheet`, { query: { columns }, patience: 30, signal }, pictureOf);
  }

  /**
   * The picture so far, at most 1,024 pixels a side; waits for the first coarse one.
   * @param {import("./client.js").Given} [given]
   */
  preview({ signal } = {}) {
    return this.#connection.ask(`${this.#path}/preview`, { patience: 30, signal }, pictureOf);
  }

  /**
   * A region as soon as it is finished; it is rendered next.
   * @param {readonly [x: number, y: number, width: number, height: number]} region
   * @param {import("./client.js").Given} [given]
   */
  tile([x, y, w, h], { signal } = {}) {
    return this.#connection.ask(`${this.#path}/tile`, { query: { x, y, w, h }, patience: 30, signal }, pictureOf);
  }

  /**
   * Stops it. One that has ended already rejects with a `Problem`, `conflict`.
   * @param {import("./client.js").Given} [given]
   */
  async cancel({ signal } = {}) {
    this.view = await this.#connection.ask(`${this.#path}/cancel`, { method: "POST", once: true, signal }, json);
    return this;
  }

  /**
   * Changes its priority.
   * @param {number} priority 0 to 100
   * @param {import("./client.js").Given} [given]
   */
  async prioritize(priority, { signal } = {}) {
    const headers = { "content-type": "application/merge-patch+json" };
    this.view = await this.#connection.ask(this.#path, { method: "PATCH", headers, body: JSON.stringify({ priority }), signal }, json);
    return this;
  }

  /**
   * Forgets it and its picture.
   * @param {import("./client.js").Given} [given]
   */
  async delete({ signal } = {}) {
    await this.#connection.ask(this.#path, { method: "DELETE", once: true, signal }, async () => {});
  }
}

/**
 * An id as a part of a path, whatever it is.
 * @param {string} id
 */
export function checked(id) {
  if (!/^[\w-]+$/.test(id)) throw new TypeError(`${JSON.stringify(id)} is no id: ids have letters, digits, - and _`);
  return id;
}

/**
 * Refuses what the types have not, before a scene is sent for nothing.
 * @param {string} what
 * @param {object} options
 */
export function checkLayers(what, options) {
  if (Reflect.get(options, "layers") !== undefined) throw new TypeError(`${what} has no layers: render and tile have them`);
}

/**
 * The file that a scene is, if it is one: a `Blob`, or the bytes of a buffer or of a view of one.
 * @param {unknown} scene
 */
export function fileOf(scene) {
  if (scene instanceof Blob) return scene;
  if (ArrayBuffer.isView(scene)) return new Uint8Array(/** @type {ArrayBuffer} */ (scene.buffer), scene.byteOffset, scene.byteLength);
  return scene instanceof ArrayBuffer ? new Uint8Array(scene) : undefined;
}

/**
 * The media type of a scene or a model.
 * @param {import("./client.js").Scene} scene
 */
export async function typeOf(scene) {
  const file = fileOf(scene);
  if (!file) return "application/json";
  if (file instanceof Blob && file.type) return file.type;
  const start = file instanceof Blob ? new Uint8Array(await file.slice(0, 64).arrayBuffer()) : file.subarray(0, 64);
  // The service knows models by their content.
  return /^\ufeff?\s*({|$)/.test(new TextDecoder().decode(start)) ? "application/json" : "application/octet-stream";
}

/**
 * The text of a scene in JSON.
 * @param {import("./client.js").Scene} scene
 */
export async function textOf(scene) {
  if (typeof scene === "string") return scene;
  const file = fileOf(scene);
  if (!file) {
    const text = JSON.stringify(scene), isStream = Symbol.asyncIterator in Object(scene);
    // JSON makes `{}` of promises, answers and maps.
    if (text?.startsWith("{") && text !== "{}" && !isStream) return text;
    throw new TypeError(`a scene is an object, its JSON text, its bytes or a Blob, not ${/** @type {any} */ (scene)?.constructor?.name ?? scene}`);
  }
  if (!/\/json\b/.test(await typeOf(scene))) throw new TypeError("this request takes a scene in JSON; NFF and models can be rendered and explained");
  return file instanceof Blob ? file.text() : new TextDecoder().decode(file);
}
