// The real service on a free port, and something between it and the client that can do harm.
import { spawn } from "node:child_process";
import http from "node:http";
import path from "node:path";
import { fileURLToPath } from "node:url";

export const ROOT = fileURLToPath(new URL("../../..", import.meta.url));
export const BINARY = process.env.STRAHL_BINARY ?? path.join(ROOT, "target/release/strahl");

export const SCENE = {
  version: 1,
  image: { width: 48, height: 32 },
  camera: { pinhole: { eye: [0, 1, 5], look_at: [0, 0.5, 0] } },
  background: [0.3, 0.5, 0.8],
  lights: [{ point: { position: [3, 5, 4] } }],
  materials: { red: { diffuse: [0.8, 0.2, 0.1], specular: 0.5, reflection: 0.2 } },
  objects: [
    { sphere: { center: [0, 1, 0], radius: 1, material: "red" } },
    { plane: { point: [0, 0, 0], normal: [0, 1, 0] } },
  ],
};

/** A scene that takes a second or more as a job, and that no other test has. */
export const busyScene = (name) => ({
  ...SCENE,
  name,
  materials: { ...SCENE.materials, mirror: { diffuse: 0.1, reflection: 0.9 } },
  objects: [...SCENE.objects, ...[-3, 9].map((z) => ({ plane: { point: [0, 0, z], normal: [0, 0, -z], material: "mirror" } }))],
  render: { max_depth: 60, accuracy: { fixed: {} }, antialias: false },
});

/** Starts the program; `url` is its address. */
export async function start(...flags) {
  const running = spawn(BINARY, ["serve", "--listen", "127.0.0.1:0", ...flags], { stdio: ["ignore", "ignore", "pipe"] });
  const url = await new Promise((found, fails) => {
    let said = "";
    running.stderr.on("data", (part) => {
      said += part;
      const listening = said.match(/listening on (http:\/\/\S+)/);
      if (listening) found(listening[1]);
    });
    running.on("exit", (code) => fails(new Error(`the service ended with ${code}: ${said}`)));
  });
  const stop = (signal = "SIGTERM") => new Promise((over) => { running.on("exit", over); running.kill(signal); });
  return { url, port: new URL(url).port, stop };
}

/** A proxy that closes the connection after so many bytes of an answer, `cuts` times. */
export async function between(port) {
  const proxy = { cutAfter: 0, cuts: 0, asked: [] };
  const server = http.createServer((request, response) => {
    proxy.asked.push({ url: request.url, last: request.headers["last-event-id"] });
    const options = { port, host: "127.0.0.1", method: request.method, path: request.url, headers: { ...request.headers, host: `127.0.0.1:${port}` } };
    const forth = http.request(options, (answer) => {
      response.writeHead(answer.statusCode, answer.headers);
      let sent = 0;
      answer.on("data", (part) => {
        sent += part.length;
        if (proxy.cuts > 0 && sent > proxy.cutAfter) {
          proxy.cuts--;
          response.destroy();
          forth.destroy();
        } else response.write(part);
      });
      answer.on("end", () => response.end());
      answer.on("error", () => response.destroy());
    });
    forth.on("error", () => response.destroy());
    response.on("close", () => forth.destroy());
    request.pipe(forth);
  });
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  proxy.url = `http://127.0.0.1:${server.address().port}`;
  proxy.close = () => { server.closeAllConnections(); server.close(); };
  return proxy;
}
