import { isObject } from "./connection.js";
import { DamagedError } from "./problems.js";

const MOST = 1 << 20;

/**
 * Server-Sent Events (WHATWG HTML, 9.2) in a stream of bytes.
 * @param {AsyncIterable<Uint8Array>} parts
 * @param {(ms: number) => void} [retry] is told how long to wait before the stream is opened again, when the stream says so
 * @returns {AsyncGenerator<{ name: string, id: string, data: any }>}
 */
export async function* events(parts, retry) {
  const decoder = new TextDecoder();
  let rest = "";
  /** @type {Map<string, string>} */
  let fields = new Map();
  for await (const part of parts) {
    const lines = (rest + decoder.decode(part, { stream: true })).split("\n");
    rest = lines.pop() ?? "";
    if (rest.length > MOST) throw new DamagedError("an event of the stream has no end");
    for (const raw of lines) {
      const line = raw.replace(/\r$/, "");
      if (line) {
        const at = line.indexOf(":"), end = at < 0 ? line.length : at, name = line.slice(0, end), value = line.slice(end + 1).replace(/^ /, "");
        fields.set(name, value);
        if (name === "retry" && /^\d+$/.test(value)) retry?.(Number(value));
        continue;
      }
      const data = fields.get("data");
      if (data !== undefined) yield { name: fields.get("event") ?? "message", id: fields.get("id") ?? "", data: read(data) };
      fields = new Map();
    }
  }
}

/** @param {string} text */
function read(text) {
  let data;
  try {
    data = JSON.parse(text);
  } catch (cause) {
    throw new DamagedError("an event of the stream is not JSON", { cause });
  }
  if (!isObject(data)) throw new DamagedError("an event of the stream is no object");
  return data;
}
