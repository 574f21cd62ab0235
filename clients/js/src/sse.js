import { DamagedError } from "./problems.js";

const MOST = 1 << 20;

/**
 * Server-Sent Events (WHATWG HTML, 9.2) in a stream of bytes.
 * @param {ReadableStream<Uint8Array>} body
 * @param {() => void} alive is called whenever something comes
 * @returns {AsyncGenerator<{ name: string, id: string, data: any }>}
 */
export async function* events(body, alive) {
  const reader = body.getReader(), decoder = new TextDecoder();
  let rest = "";
  /** @type {Map<string, string>} */
  let fields = new Map();
  try {
    for (let part; !(part = await reader.read()).done; ) {
      alive();
      const lines = (rest + decoder.decode(part.value, { stream: true })).split("\n");
      rest = lines.pop() ?? "";
      if (rest.length > MOST) throw new DamagedError("an event of the stream has no end");
      for (const raw of lines) {
        const line = raw.replace(/\r$/, "");
        if (line) {
          const at = line.indexOf(":"), end = at < 0 ? line.length : at;
          fields.set(line.slice(0, end), line.slice(end + 1).replace(/^ /, ""));
          continue;
        }
        const data = fields.get("data");
        if (data !== undefined) yield { name: fields.get("event") ?? "message", id: fields.get("id") ?? "", data: read(data) };
        fields = new Map();
      }
    }
  } finally {
    // Who stops listening closes the connection.
    await reader.cancel().catch(() => {});
  }
}

/** @param {string} text */
function read(text) {
  try {
    return JSON.parse(text);
  } catch (cause) {
    throw new DamagedError("an event of the stream is not JSON", { cause });
  }
}
