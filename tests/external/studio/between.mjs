// A proxy between a page and the service that makes trouble. `rule` gets each request and says what becomes of it: nothing for an
// answer as it is, `{ status, headers, body }` for another answer, `{ wait }` milliseconds before it, `{ cut }` after so many bytes,
// `{ refuse: true }` for no answer.
import http from "node:http";

/** @param {string} base address of the service */
export async function between(base) {
  const { hostname, port, host } = new URL(base);
  const proxy = { address: "", rule: () => undefined, asked: [] };
  const server = http.createServer(async (request, response) => {
    proxy.asked.push(`${request.method} ${request.url}`);
    const { status, headers = {}, body = "", wait = 0, cut = Infinity, refuse = false } = proxy.rule(request) ?? {};
    if (wait > 0) await new Promise((over) => setTimeout(over, wait));
    if (refuse) return request.socket.destroy();
    if (status) return response.writeHead(status, headers).end(body);
    // The service answers to its own name only.
    const up = http.request({ hostname, port, path: request.url, method: request.method, headers: { ...request.headers, host, ...(request.headers.origin && { origin: base }) } }, (answer) => {
      response.writeHead(answer.statusCode, answer.headers);
      let sent = 0;
      answer.on("data", (part) => {
        response.write(part.subarray(0, Math.max(0, cut - sent)));
        sent += part.length;
        if (sent > cut) setTimeout(() => response.destroy(), 50);
      });
      answer.on("end", () => sent > cut || response.end());
      answer.on("error", () => response.destroy());
    });
    up.on("error", () => response.destroy());
    response.on("close", () => up.destroy());
    request.pipe(up);
  });
  await new Promise((over) => server.listen(0, "127.0.0.1", over));
  proxy.address = `http://127.0.0.1:${server.address().port}`;
  proxy.close = () => (server.closeAllConnections(), server.close());
  return proxy;
}

/** A problem document of the service that says when to come back. */
export const busy = (status, seconds) => ({
  status, headers: { "retry-after": String(seconds), "content-type": "application/problem+json" },
  body: JSON.stringify({ type: "/problems/rate-limited", title: "Rate limited", detail: `used up; in ${seconds} s`, status }),
});
/** What a proxy says while the service behind it is away. */
export const gateway = (status = 502) => ({ status, headers: { "content-type": "text/html" }, body: "<html>Bad Gateway</html>" });
