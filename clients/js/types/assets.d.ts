/** Files that scenes name by their SHA-256, models and pictures. */
export class Assets {
    /** @param {import("./connection.js").Connection} connection */
    constructor(connection: import("./connection.js").Connection);
    /**
     * Sends a file unless the service has it from you; its name in scenes: `sha256:` and digits. Pages can do so only over https or from
     * localhost: elsewhere browsers have no SHA-256.
     * @param {BufferSource | Blob} content
     * @param {import("./client.js").Given} [given]
     */
    add(content: BufferSource | Blob, { signal }?: import("./client.js").Given): Promise<string>;
    /**
     * Those that you have yet to send, by their digits.
     * @param {string[]} names
     * @param {import("./client.js").Given} [given]
     * @returns {Promise<string[]>}
     */
    missing(names: string[], { signal }?: import("./client.js").Given): Promise<string[]>;
    /**
     * Forgets one. Scenes that name it are refused then.
     * @param {string} name
     * @param {import("./client.js").Given} [given]
     */
    delete(name: string, { signal }?: import("./client.js").Given): Promise<void>;
    #private;
}
