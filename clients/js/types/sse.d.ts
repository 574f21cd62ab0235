/**
 * Server-Sent Events (WHATWG HTML, 9.2) in a stream of bytes.
 * @param {AsyncIterable<Uint8Array>} parts
 * @param {(ms: number) => void} [retry] is told how long to wait before the stream is opened again, when the stream says so
 * @returns {AsyncGenerator<{ name: string, id: string, data: any }>}
 */
export function events(parts: AsyncIterable<Uint8Array>, retry?: (ms: number) => void): AsyncGenerator<{
    name: string;
    id: string;
    data: any;
}>;
