/**
 * Server-Sent Events (WHATWG HTML, 9.2) in a stream of bytes.
 * @param {ReadableStream<Uint8Array>} body
 * @param {() => void} alive is called whenever something comes
 * @returns {AsyncGenerator<{ name: string, id: string, data: any }>}
 */
export function events(body: ReadableStream<Uint8Array>, alive: () => void): AsyncGenerator<{
    name: string;
    id: string;
    data: any;
}>;
