import { hexOf, json, withList } from "./connection.js";
import { checked } from "./jobs.js";

const JSON_TYPE = { "content-type": "application/json" };

/** Files that scenes name by their SHA-256, models and pictures. */
export class Assets {
  #connection;
  /** @param {import("./connection.js").Connection} connection */
  constructor(connection) {
    this.#connection = connection;
  }

  /**
   * Sends a file unless the service has it from you; its name in scenes: `sha256:` and digits. Pages can do so only over https or from
   * localhost: elsewhere browsers have no SHA-256.
   * @param {BufferSource | Blob} content
   * @param {import("./client.js").Given} [given]
   */
  async add(content, { signal } = {}) {
    if (!crypto.subtle) throw new TypeError("assets.add needs https or localhost: in other pages the browser has no SHA-256");
    const bytes = content instanceof Blob ? await content.arrayBuffer() : content;
    const digits = hexOf(new Uint8Array(await crypto.subtle.digest("SHA-256", bytes)));
    if ((await this.missing([digits], { signal })).length) {
      const headers = { "content-type": "application/octet-stream" };
      await this.#connection.ask(`/v1/assets/${digits}`, { method: "PUT", headers, body: content, signal }, json);
    }
    return `sha256:${digits}`;
  }

  /**
   * Those that you have yet to send, by their digits.
   * @param {string[]} names
   * @param {import("./client.js").Given} [given]
   * @returns {Promise<string[]>}
   */
  async missing(names, { signal } = {}) {
    const asked = { method: "POST", headers: JSON_TYPE, body: JSON.stringify({ sha256: names }), signal };
    return (await this.#connection.ask("/v1/assets/missing", asked, withList("missing"))).missing;
  }

  /**
   * Forgets one. Scenes that name it are refused then.
   * @param {string} name
   * @param {import("./client.js").Given} [given]
   */
  async delete(name, { signal } = {}) {
    const digits = checked(name.replace(/^sha256:/, ""));
    await this.#connection.ask(`/v1/assets/${digits}`, { method: "DELETE", once: true, signal }, async () => {});
  }
}
