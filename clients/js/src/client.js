import { Backoff, Connection, json, pause, withList } from "./connection.js";
import { Assets } from "./assets.js";
import { Jobs, checkLayers, checked, fileOf, textOf, typeOf } from "./jobs.js";
import { pictureOf } from "./picture.js";
import { passes } from "./parts.js";
import { ConnectionError } from "./problems.js";

const JSON_TYPE = { "content-type": "application/json" };

/** @typedef {import("../types/contract.js").components["schemas"]} Schemas */

/**
 * A scene: an object, its JSON text, or a file, in bytes or as a `Blob`. The type of a `Blob` says whether it is
 * `application/json`, `text/x-nff`, `application/gzip` or a model (`model/gltf-binary`); models in bytes need none. Or a
 * variation of a scene that the service knows, by a merge patch (RFC 7396).
 * @typedef {Schemas["Scene"] | { base: string, patch: object } | string | BufferSource | Blob} Scene
 */
/** @typedef {string | { scene: Scene, settings?: Settings }} ImageLike an image id, or a scene with settings or without */
/** @typedef {Schemas["Overrides"]} Settings settings over the scene's */
/** @typedef {{ format?: Schemas["PictureOutput"]["format"], bits?: 8 | 16, quality?: number }} Output how a picture is written */
/** @typedef {{ layers?: string }} Layers further layers of an EXR; streams and jobs have none */
/** @typedef {{ signal?: AbortSignal }} Given `signal` gives a request up; the service cancels its work. */

/**
 * A service.
 *
 * Requests to a service that is busy (429, 503) or away are sent again, up to `retries` times, when `Retry-After` says.
 */
export class Client {
  #connection;

  /**
   * @param {string} [url] `http://127.0.0.1:8080` by default
   * @param {{ key?: string, timeout?: number, retries?: number, fetch?: typeof fetch }} [options] `timeout` is in seconds,
   *   for each request, and `Infinity` is no limit; a stream is asked for again if it is silent so long
   */
  constructor(url = "http://127.0.0.1:8080", { key, timeout = 60, retries = 5, fetch: own = fetch } = {}) {
    // Browsers want `fetch` to be called on nothing else than the window.
    this.#connection = new Connection(url, { key, timeout, retries, fetch: (...given) => own(...given) });
    this.jobs = new Jobs(this.#connection);
    this.assets = new Assets(this.#connection);
  }

  /**
   * The picture of a scene.
   * @param {Scene} scene
   * @param {Settings & Output & Layers} [options]
   * @param {Given} [given]
   */
  render(scene, options = {}, given) {
    return this.#about("/v1/render", scene, options, given, pictureOf);
  }

  /**
   * Pictures from all around a scene or a model, as an animation, or on a sheet of columns and rows. A GIF has 256 colors a frame, and
   * the warnings say how far they are off.
   * @param {Scene} scene
   * @param {Settings & { count?: number, format?: "png" | "webp" | "gif", sheet?: readonly [columns: number, rows: number] }} [options]
   * @param {Given} [given]
   * @returns {Promise<import("./picture.js").Picture>}
   */
  async turntable(scene, { count = 36, format = "png", sheet, ...settings } = {}, given = {}) {
    const shown = sheet ? { sheet: sheet.join("x") } : { format };
    const { body, headers, query } = await this.#asked(scene, { turntable: count, ...shown, ...settings });
    for (;;) {
      const read = async (/** @type {Response} */ response) => (response.status === 202 ? undefined : pictureOf(response));
      const picture = await this.#connection.ask("/v1/render", { method: "POST", query, headers, body, patience: 60, ...given }, read);
      if (picture) return picture;
      // It goes on as a job, which the same request finds again.
      await pause(1, given.signal);
    }
  }

  /**
   * A region of the picture: the same bytes as in the whole.
   * @param {Scene} scene
   * @param {readonly [x: number, y: number, width: number, height: number]} region
   * @param {Settings & Output & Layers} [options]
   * @param {Given} [given]
   */
  tile(scene, [x, y, w, h], options = {}, given) {
    return this.#about("/v1/render/tile", scene, { x, y, w, h, ...options }, given, pictureOf);
  }

  /**
   * The picture from coarse to fine; the last pass is the picture itself. Who stops listening cancels the render.
   * @param {Scene} scene
   * @param {Settings & Output} [options]
   * @param {Given} [given]
   * @returns {AsyncGenerator<import("./parts.js").Pass, void>}
   */
  async *stream(scene, options = {}, { signal } = {}) {
    checkLayers("a stream", options);
    const { headers, ...request } = await this.#asked(scene, options), backoff = new Backoff(this.#connection.retries);
    const asked = { ...request, headers: { ...headers, accept: "multipart/mixed" }, signal };
    for (let scale = Infinity; ; ) {
      /** @type {unknown} */
      let error = new ConnectionError("the answer broke off before the picture");
      /** @type {AsyncIterable<Uint8Array> | undefined} */
      let parts;
      try {
        parts = await this.#connection.open("/v1/render", asked, this.#connection.timeout);
        for await (const pass of passes(parts ?? [])) {
          // After a broken answer the coarse ones come again.
          if (pass.final || pass.scale < scale) yield pass;
          if (pass.final) return;
          scale = Math.min(scale, pass.scale);
        }
      } catch (broken) {
        signal?.throwIfAborted();
        error = broken;
      }
      // Who gives a time wants to wait no longer than that for an answer; one that falls silent is torn.
      const late = !parts && /** @type {Error} */ (error).name === "TimeoutError";
      const seconds = late ? undefined : backoff.next(error);
      if (seconds === undefined) throw this.#connection.shown(error);
      await pause(seconds, signal);
    }
  }

  /**
   * The plan: effects, why, and what they should cost.
   * @param {Scene} scene
   * @param {Settings} [options]
   * @param {Given} [given]
   * @returns {Promise<Schemas["Plan"]>}
   */
  explain(scene, options = {}, given) {
    return this.#about("/v1/explain", scene, options, given, json);
  }

  /**
   * The plan, and what the picture cost.
   * @param {Scene} scene
   * @param {Settings} [options]
   * @param {Given} [given]
   * @returns {Promise<Schemas["Analyzed"]>}
   */
  analyze(scene, options = {}, given) {
    return this.#about("/v1/explain", scene, { analyze: true, ...options }, given, json);
  }

  /**
   * The plan, and what the picture should cost with each of up to 32 settings.
   * @param {Scene} scene
   * @param {Settings[]} settings
   * @param {Given} [given]
   * @returns {Promise<Schemas["SettingsEstimates"]>}
   */
  async explainEach(scene, settings, { signal } = {}) {
    const body = `{"scene":${await textOf(scene)},"settings":${JSON.stringify(settings)}}`;
    return this.#connection.ask("/v1/explain", { method: "POST", headers: JSON_TYPE, body, signal }, json);
  }

  /**
   * How far b is from a, in codes and as people see it.
   * @param {ImageLike} a
   * @param {ImageLike} b
   * @param {Given} [given]
   * @returns {Promise<Schemas["PictureDifference"]>}
   */
  async compare(a, b, { signal } = {}) {
    const body = `{"a":${await side(a)},"b":${await side(b)}}`;
    return this.#connection.ask("/v1/compare", { method: "POST", headers: JSON_TYPE, body, patience: 30, signal }, json);
  }

  /**
   * A picture of how far b is from a: `png` (codes times `gain`), `pfm` (light of b less that of a), `flip`.
   * @param {ImageLike} a
   * @param {ImageLike} b
   * @param {{ format?: "png" | "pfm" | "flip", gain?: number }} [options]
   * @param {Given} [given]
   */
  async difference(a, b, { format = "png", gain } = {}, { signal } = {}) {
    const body = `{"a":${await side(a)},"b":${await side(b)}}`;
    return this.#connection.ask("/v1/compare", { method: "POST", query: { format, gain }, headers: JSON_TYPE, body, patience: 30, signal }, pictureOf);
  }

  /**
   * What accuracy costs, measured in so many seconds.
   * @param {Scene} scene
   * @param {Settings & { seconds?: number }} [options]
   * @param {Given} [given]
   * @returns {Promise<Schemas["Tradeoff"]>}
   */
  tradeoff(scene, options = {}, given) {
    return this.#about("/v1/tradeoff", scene, { format: "json", ...options }, given, json, options.seconds ?? 10);
  }

  /**
   * Warnings about a scene. One with mistakes rejects with a `Problem` that has all of them in `mistakes`.
   * @param {Scene} scene
   * @param {Settings} [options]
   * @param {Given} [given]
   * @returns {Promise<Schemas["SceneProblem"][]>}
   */
  async validate(scene, options = {}, given) {
    return (await this.#about("/v1/scenes/validate", scene, options, given, withList("warnings"))).warnings;
  }

  /**
   * A map of the picture: `proved`, `rays`, `time`, `depth`, `samples` of each pixel.
   * @param {Scene} scene
   * @param {string} of
   * @param {Settings & { format?: "png" | "pfm" | "exr", step?: number }} [options]
   * @param {Given} [given]
   */
  map(scene, of, options = {}, given) {
    return this.#about("/v1/map", scene, { of, format: "pfm", ...options }, given, pictureOf);
  }

  /**
   * The rays behind a pixel.
   * @param {Scene} scene
   * @param {number} x
   * @param {number} y
   * @param {Settings & { all_samples?: boolean }} [options]
   * @param {Given} [given]
   * @returns {Promise<Schemas["RayTree"]>}
   */
  tree(scene, x, y, options = {}, given) {
    return this.#about("/v1/tree", scene, { x, y, ...options }, given, json);
  }

  /**
   * What rays hit.
   * @param {Scene} scene
   * @param {Schemas["RayQuery"][]} queries
   * @param {Settings} [options]
   * @param {Given} [given]
   * @returns {Promise<Schemas["RayAnswer"][]>}
   */
  async rays(scene, queries, options = {}, { signal } = {}) {
    const body = `{"scene":${await textOf(scene)},"rays":${JSON.stringify(queries)}}`;
    const headers = { "content-type": "application/json" };
    return (await this.#connection.ask("/v1/rays", { method: "POST", query: options, headers, body, signal }, withList("answers"))).answers;
  }

  /**
   * Stores a scene. The answer has its ids, and the addresses of its picture and tiles.
   * @param {Scene} scene
   * @param {Settings & { zoom?: number }} [options]
   * @param {Given} [given]
   * @returns {Promise<Schemas["KnownScene"]>}
   */
  addScene(scene, options = {}, given) {
    return this.#about("/v1/scenes", scene, options, given, json);
  }

  /**
   * The picture of an image id.
   * @param {string} id
   * @param {Output} [options]
   * @param {Given} [given]
   */
  async image(id, { format = "png", ...query } = {}, { signal } = {}) {
    return this.#connection.ask(`/v1/images/${checked(id)}.${format}`, { query, signal }, pictureOf);
  }

  /**
   * A prefix of paths with which pages can read one job, picture or scene without a key.
   * @param {Schemas["CapabilityRequest"]} of
   * @param {Given} [given]
   * @returns {Promise<Schemas["Capability"]>}
   */
  capability(of, { signal } = {}) {
    const headers = { "content-type": "application/json" };
    return this.#connection.ask("/v1/capabilities", { method: "POST", headers, body: JSON.stringify(of), signal }, json);
  }

  /**
   * The text of a stored scene as you have sent it.
   * @param {string} id
   * @param {Given} [given]
   */
  async source(id, { signal } = {}) {
    return this.#connection.ask(`/v1/scenes/${checked(id)}/source`, { signal }, (answer) => answer.text());
  }

  /**
   * Whose key it is, what it may do, and what is left of its limits.
   * @param {Given} [given]
   * @returns {Promise<Schemas["KeyInfo"]>}
   */
  me({ signal } = {}) {
    return this.#connection.ask("/v1/me", { signal }, json);
  }

  /**
   * Who has the renderer and waits for it.
   * @param {Given} [given]
   * @returns {Promise<Schemas["QueueStatus"]>}
   */
  queue({ signal } = {}) {
    return this.#connection.ask("/v1/queue", { signal }, json);
  }

  /**
   * What a request may ask for.
   * @param {Given} [given]
   * @returns {Promise<Schemas["AllLimits"]>}
   */
  limits({ signal } = {}) {
    return this.#connection.ask("/v1/limits", { signal }, json);
  }

  /**
   * The service's version.
   * @param {Given} [given]
   * @returns {Promise<Schemas["Version"]>}
   */
  version({ signal } = {}) {
    return this.#connection.ask("/v1/version", { signal }, json);
  }

  /**
   * @template T
   * @param {string} path
   * @param {Scene} scene
   * @param {Record<string, unknown>} query
   * @param {Given | undefined} given
   * @param {(answer: Response) => Promise<T>} read
   * @param {number} [patience]
   */
  async #about(path, scene, query, given, read, patience) {
    return this.#connection.ask(path, { ...(await this.#asked(scene, query)), patience, signal: given?.signal }, read);
  }

  /**
   * @param {Scene} scene
   * @param {Record<string, unknown>} query
   */
  async #asked(scene, query) {
    const type = await typeOf(scene);
    const body = fileOf(scene) ?? (await textOf(scene));
    return { method: "POST", query, headers: { "content-type": type }, body };
  }
}

/** @param {ImageLike} one */
async function side(one) {
  if (typeof one === "string") return JSON.stringify({ image: one });
  return `{"scene":${await textOf(one.scene)},"settings":${JSON.stringify(one.settings ?? {})}}`;
}
