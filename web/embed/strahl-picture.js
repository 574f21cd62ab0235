// docs/embed.md. It makes no HTML from text and follows no address of an answer.

// Of six connections.
const STREAMS = 3, FETCHES = 3, JOBS = 32, TRIES = 5;
// Milliseconds; streams have comments.
const SILENCE = 40_000, POLL = 2_000, LATE = 60_000, PATIENCE = 4_000;
// Pixels a side; tiles kept, 1 MiB each; zoom without tiles; waiting tiles that a preview replaces.
const SIDE = 2_048, TILES = 48, ZOOM = 16, WAITING = 12;
const OVER = ["succeeded", "failed", "canceled", "expired"];

const pause = (ms, signal) => new Promise((done, stop) => {
  setTimeout(done, ms);
  signal?.addEventListener("abort", stop);
});
const isBusy = ({ status }) => /429|50[23]/.test(status);
const refused = ({ ok, status, headers }, problem) => Object.assign(
  new Error(ok ? "no answer of the service: check src" : problem?.detail ?? `HTTP ${status}`),
  { status, problem, seconds: headers.get("retry-after") });
const wait = (failures, { seconds }) => 1_000 * (seconds > 0 ? Math.min(seconds, 120)
  : Math.min(2 ** failures, 15) * (1 + Math.random()));

let asking = 0;
const queue = [];

class Service {
  constructor(own) { Object.assign(this, own); }
  /** Its id is in the path. */
  right(path) { return this.capabilities.find((one) => path.includes(one.split(/[.~]/)[2])) ?? ""; }
  /** `patience`: for the headers. */
  async fetch(path, options) {
    const late = new AbortController(), { signal = late.signal, patience, headers } = options;
    const timer = setTimeout(() => late.abort({ status: patience && 504 }), patience ?? LATE);
    const answer = await fetch(`${this.base}${this.right(path)}/${path}`, { ...options, signal: AbortSignal.any([signal, late.signal]),
      headers: { ...headers, ...this.key && { authorization: `Bearer ${this.key}` } } });
    clearTimeout(timer);
    return answer;
  }
  async ask(path, { signal = this.signal, ...options } = {}) {
    for (let failures = 0, busy = 0; ; failures++) {
      let problem;
      while (asking >= FETCHES) await new Promise((done) => queue.push(done));
      asking++;
      try {
        const answer = await this.fetch(path, { ...options, signal });
        const type = answer.headers.get("content-type"), body = await (/json/.test(type) ? answer.json() : answer.blob());
        problem = refused(answer, /problem/.test(type) ? body : undefined);
        // A gateway's: the service is away.
        if (answer.status >= 500 && !problem.problem) problem.status = 0;
        else if (failures) signal.tell?.("waiting");
        if (answer.ok && !/^text/.test(type)) return { answer, body };
      } catch (error) {
        signal.throwIfAborted();
        problem = error;
      } finally {
        asking--;
        queue.shift()?.();
      }
      if (!problem.status) signal.tell?.("offline");
      else if (!isBusy(problem) || busy++ >= TRIES) throw problem;
      await pause(wait(failures, problem), signal);
    }
  }
}

// Jobs share streams; hidden tabs have none.
const lines = new Set();
let open = 0;
document.addEventListener("visibilitychange", () => lines.forEach((line) => line.turn?.abort()));

function follow(service, job, signal) {
  const name = [service.base, service.key, service.right(job.id)].join(" ");
  let line = [...lines].find((one) => one.name === name && one.jobs.size < JOBS && [...one.jobs].every(({ id }) => id !== job.id));
  if (line) line.jobs.add(job); else lines.add(line = { name, service, jobs: new Set([job]), failures: 0 }) && run(line);
  line.turn?.abort();
  signal.addEventListener("abort", () => line.jobs.delete(job) && line.turn?.abort());
}
const tell = (line, id, event, data) => line.jobs.forEach((job) => {
  if (job.id !== id) return;
  job.seen = data.seq ?? job.seen;
  if (OVER.includes(event)) line.jobs.delete(job);
  job.hear(event, data);
});
async function run(line) {
  while (await pause(10), line.jobs.size) {
    const { signal } = line.turn = new AbortController(), polls = document.hidden || open >= STREAMS;
    signal.tell = (state) => line.jobs.forEach((job) => job.hear(state, {}));
    let ms = 0;
    if (!polls) open++;
    try {
      ms = await (polls ? poll(line, signal) : listen(line, signal));
    } catch (error) {
      if (!signal.aborted) {
        signal.tell(error.status ? "waiting" : "offline");
        ms = wait(line.failures++, error);
      }
    }
    if (!polls) open--;
    await pause(ms, signal).catch(() => {});
  }
  lines.delete(line);
}
async function listen(line, signal) {
  const jobs = [...line.jobs], seen = jobs.map((job) => job.seen).join(), first = jobs[0].id;
  const path = jobs.length > 1 ? `v1/events?${jobs.map(({ id }) => `job=${id}`).join("&")}` : `v1/jobs/${first}/events`;
  const answer = await line.service.fetch(path, { signal, headers: /\d/.test(seen) && { "last-event-id": seen } });
  if (isBusy(answer)) throw refused(answer);
  // All have ended, or one is refused: which?
  if (!/event-stream/.test(answer.headers.get("content-type"))) return poll(line, signal);
  const reader = answer.body.pipeThrough(new TextDecoderStream()).getReader(), { turn } = line;
  for (let text = ""; ;) {
    const timer = setTimeout(() => turn.abort(), SILENCE), { done, value } = await reader.read();
    clearTimeout(timer);
    if (done) return line.jobs.size && POLL;
    text += value;
    for (let end; (end = text.indexOf("\n\n")) >= 0; text = text.slice(end + 2)) {
      const [, event, json] = text.slice(0, end).match(/^event: ?(.*)[^]*^data: ?(.*)/m) ?? [];
      if (!event) continue;
      const data = JSON.parse(json);
      line.failures = 0;
      if (event === "shutdown") return data.retry_ms;
      tell(line, data.job, event, data);
    }
  }
}
async function poll(line, signal) {
  for (const { id } of [...line.jobs]) {
    try {
      const { body } = await line.service.ask(`v1/jobs/${id}`, { signal });
      tell(line, id, "snapshot", { ...body, ...body.progress });
      if (OVER.includes(body.state)) tell(line, id, body.state, body);
    } catch (error) {
      if (!error.status) throw error;
      tell(line, id, "failed", error);
    }
  }
  return document.hidden ? 15_000 : POLL;
}

function reportOf({ headers }) {
  const [error, rays] = ["error", "rays"].map((name) => Object.fromEntries(
    [...(headers.get(`render-${name}`) ?? "").matchAll(/([\w-]+)=(?:"([^"]*)"|([^,\s]+))/g)]
      .map(([, key, text, value]) => [key, text ?? (value === "?0" ? false : +value)])));
  return { error, rays, image: headers.get("content-location")?.match(/i_\w+/)?.[0] };
}

const STYLE = `:host { display: inline-block; position: relative; max-width: 100%; min-height: 4px }
:host([hidden]), [hidden], p:empty { display: none !important }
canvas, progress { position: absolute; inset: 0; width: 100%; height: 100% }
progress { top: auto; height: 4px }
div { position: absolute; inset: 8px 8px auto auto }
p { inset: auto 0 0; max-height: 100%; margin: 0; overflow: auto; overflow-wrap: anywhere; color: CanvasText; background: Canvas }
button { width: 28px; height: 28px; padding: 0 }`;
const make = (name, part, more) => Object.assign(document.createElement(name), { part, ...more });

class StrahlPicture extends HTMLElement {
  static observedAttributes = "src job capability scene image width height alt controls zoom".split(" ");
  #key; #stop = new AbortController(); #style = new CSSStyleSheet();
  #canvas = make("canvas", "picture"); #bar = make("progress", "progress", { ariaLabel: "Rendering" }); #status = make("p", "status", { role: "status" }); #controls = make("div", "controls");
  #size; #film; #xyz; #tiles = new Map(); #view; #frame; #fingers = new Map();
  #resized = new ResizeObserver(() => this.#draw());

  constructor() {
    super();
    const root = this.attachShadow({ mode: "open" });
    root.adoptedStyleSheets = [this.#style];
    for (const [textContent, ariaLabel, factor] of [["+", "Zoom in", 2], ["−", "Zoom out", 0.5], ["□", "Whole picture", 0]]) {
      this.#controls.append(make("button", "button", { textContent, ariaLabel, onclick: () => this.zoomBy(factor) }));
    }
    root.append(this.#canvas, this.#bar, this.#controls, this.#status);
    this.#listen();
    // Set before the module.
    const { key } = this;
    delete this.key;
    this.#key = key;
  }
  /** No attribute: others can read the page. */
  set key(key) { this.#key = key; this.#restart(); }
  connectedCallback() { this.#resized.observe(this); this.#restart(); }
  disconnectedCallback() { this.#resized.disconnect(); this.#clear(); }
  attributeChangedCallback(name) { if (/alt|controls|zoom/.test(name)) this.#dress(); else this.#restart(); }

  #dress() {
    const canvas = this.#canvas, alt = this.getAttribute("alt"), zooms = this.hasAttribute("zoom");
    canvas.role = alt === "" ? "presentation" : "img";
    canvas.ariaLabel = alt ?? "A rendered picture";
    canvas.title = zooms ? "Plus and minus zoom, arrows move, 0 shows the whole picture." : "";
    canvas.tabIndex = zooms ? 0 : -1;
    // CSS ignores NaN; without a size the status makes room.
    const [w, h] = ["width", "height"].map((name) => Math.max(0, this.getAttribute(name))), [across, down] = w && h ? [w, h] : this.#size ?? [];
    const shape = across ? `aspect-ratio: ${across} / ${down} } p { position: absolute` : `height: ${h || ""}px`;
    this.#style.replaceSync(`${STYLE} :host { width: ${w || h * across / down || across}px; ${shape} }`);
    this.#controls.hidden = !across || !this.hasAttribute("controls");
  }
  #clear() {
    this.#stop.abort();
    this.#tiles.forEach((tile) => { tile.stop.abort(); tile.bitmap?.close(); });
    this.#tiles.clear();
    this.#film = this.#xyz = undefined;
  }
  async #restart() {
    this.#clear();
    const { signal } = this.#stop = new AbortController();
    // Once a turn.
    await 0;
    if (signal.aborted || !this.isConnected) return;
    signal.tell = (state) => this.#tell({ state });
    this.#dress();
    this.zoomTo();
    this.#tell({ state: "waiting", fraction: 0 });
    try {
      const src = this.getAttribute("src"), base = new URL(src ?? ".", src === null ? import.meta.url : document.baseURI);
      // A path, never another host.
      const capabilities = this.getAttribute("capability")?.match(/\/c\/[^/?#\s\\]+/g) ?? [];
      const service = new Service({ base: base.href.replace(/\/+$/, ""), capabilities, key: this.#key, signal });
      const [job, image] = ["job", "image"].map((name) => encodeURIComponent(this.getAttribute(name) ?? ""));
      const [blob, detail] = await (job ? this.#job(service, job) : image ? this.#image(service, image) : this.#scene(service));
      if (blob) await this.#put(blob, signal);
      // An image id and its capability let zoom beyond it.
      const xyz = detail.image && (service.right(detail.image) || !capabilities[0]) && await service.ask(`xyz/${detail.image}.json`).catch(() => {});
      signal.throwIfAborted();
      this.#xyz = xyz && { ...xyz.body, service, image: detail.image };
      this.#draw();
      this.#tell({ state: "succeeded", fraction: 1 });
      const [width, height] = this.#size;
      this.#emit("done", { width, height, ...detail });
    } catch (error) {
      if (signal.aborted) return;
      this.#bar.hidden = true;
      this.#status.textContent = /x-nff/.test(error.message) ? "no scene, no model" : error.message;
      this.#emit("error", { error, status: error.status, problem: error.problem });
    }
  }

  async #job(service, id) {
    const path = `v1/jobs/${id}`, { signal } = service;
    let tiles = [], look, total, over, wake;
    signal.addEventListener("abort", () => wake?.());
    follow(service, { id, hear: (event, data) => {
      if (event === "snapshot") {
        total = data.tiles_total;
        this.#open(data.width, data.height);
        look = data.tiles_done || data.revision;
      }
      if (event === "tile") tiles.push(data);
      if (event === "preview") look = true;
      if (tiles.length > WAITING) look = tiles = [];
      if (OVER.includes(event)) over = Object.assign(data, { event });
      const fraction = data.tiles_done / total;
      this.#tell({ state: data.state ?? event, job: id, eta_ms: data.eta_ms, fraction: fraction >= 0 ? fraction : undefined });
      wake?.();
    } }, signal);
    // Fewer requests than events.
    while (!over) {
      const { x, y, w, h } = (look ? 0 : tiles.shift()) ?? {}, tile = w && [x, y, w, h];
      if (!look && !tile) {
        await new Promise((done) => { wake = done; });
        signal.throwIfAborted();
        continue;
      }
      look = false;
      try {
        const { body } = await service.ask(path + (tile ? `/tile?x=${x}&y=${y}&w=${w}&h=${h}` : "/preview?wait=0"));
        await this.#put(body, signal, tile);
      } catch (error) {
        // None yet, or no more.
        if (!error.status) throw error;
      }
    }
    if (/failed|canceled/.test(over.event)) throw Object.assign(new Error(over.problem?.detail ?? over.message ?? "the job was canceled"), over);
    const { body: job } = await service.ask(path);
    let last = await service.ask(`${path}/image`);
    const report = reportOf(last.answer);
    this.#open(job.width, job.height);
    // No browser reads EXR.
    if (!/png|jpeg|webp/.test(last.body.type)) last = await service.ask(`${path}/preview`);
    return [last.body, { ...report, image: job.image_id, job, report: job.report }];
  }
  async #image(service, image) {
    const { width, height, nativezoom } = (await service.ask(`xyz/${image}.json`)).body;
    this.#open(width, height);
    const { body } = await service.ask(`xyz/${image}/0/0/0.png`), less = 2 ** nativezoom;
    await this.#put(body, service.signal, undefined, [width / less, height / less]);
    if (Math.max(width, height) > SIDE) return [undefined, { image }];
    const whole = await service.ask(`v1/images/${image}.png`);
    return [whole.body, { ...reportOf(whole.answer), image }];
  }
  async #scene(service) {
    const { signal } = service, address = this.getAttribute("scene"), file = address && await fetch(address, { signal });
    if (file && !file.ok) throw new Error(`HTTP ${file.status}: ${file.url}`);
    const body = file ? await file.blob() : this.querySelector("script[type='application/json']")?.textContent;
    if (!body) throw new Error("no job, image or scene is named");
    const size = ["width", "height"].map((name) => this.hasAttribute(name) ? `&${name}=${this.getAttribute(name)}` : "").join("");
    // Untyped: its bytes tell a model.
    const render = (accuracy, more) => service.ask(`v1/render?format=png${size}${accuracy}`,
      { method: "POST", body: new Blob([body]), ...more });
    // Too much for one answer.
    const unless = (error) => { if (!/413|504/.test(error.status)) throw error; };
    const first = await render("&accuracy=time:100").catch(unless);
    if (first) await this.#put(first.body, signal);
    const { answer, body: made } = await render("", { patience: PATIENCE }).catch(unless)
      ?? await render("", { headers: { prefer: "respond-async" } });
    if (answer.status !== 202) return [made, reportOf(answer)];
    let over;
    signal.addEventListener("abort", () => over ?? service.fetch(`v1/jobs/${made.id}/cancel`, { method: "POST", keepalive: true }).catch(() => {}));
    addEventListener("pagehide", () => {
      if (over) return;
      this.#stop.abort();
      addEventListener("pageshow", () => this.#restart(), { once: true });
    }, { signal });
    over = await this.#job(service, made.id);
    return over;
  }
  #tell(detail) {
    const { state, fraction } = detail;
    this.#bar.hidden = fraction === 1;
    this.#bar.value = fraction ?? this.#bar.value;
    this.#status.textContent = state === "offline" ? "No answer. Trying again." : "";
    this.#emit("progress", detail);
  }
  #emit(name, detail) { this.dispatchEvent(new CustomEvent(`strahl-${name}`, { detail, bubbles: true, composed: true })); }

  #open(width, height) {
    if (this.#film && `${this.#size}` === `${[width, height]}`) return;
    this.#size = [width, height];
    this.#dress();
    const less = Math.min(1, SIDE / Math.max(width, height));
    this.#film = new OffscreenCanvas(Math.ceil(width * less), Math.ceil(height * less));
  }
  /** `crop`: the part of the file that is the picture. */
  async #put(blob, signal, region, crop) {
    const bitmap = await createImageBitmap(blob);
    signal.throwIfAborted();
    if (!this.#film) this.#open(bitmap.width, bitmap.height);
    const film = this.#film, context = film.getContext("2d"), [width, height] = this.#size;
    const box = (region ?? [0, 0, width, height]).map((at) => at * film.width / width);
    context.clearRect(...box);
    context.drawImage(bitmap, 0, 0, ...(crop ?? [bitmap.width, bitmap.height]), ...box);
    bitmap.close();
    this.#draw();
  }

  #draw() { this.#frame ??= requestAnimationFrame(() => { this.#frame = undefined; this.#paint(); }); }
  /** Left, top and pixels of the canvas for one of the picture. */
  #place() {
    const canvas = this.#canvas, { scale, x, y } = this.#view, [width, height] = this.#size;
    const fit = Math.min(canvas.width / width, canvas.height / height) * scale;
    return [canvas.width / 2 - x * width * fit, canvas.height / 2 - y * height * fit, fit];
  }
  #paint() {
    const canvas = this.#canvas, context = canvas.getContext("2d");
    canvas.width = this.clientWidth * devicePixelRatio;
    canvas.height = this.clientHeight * devicePixelRatio;
    if (!this.#film || !canvas.width || !canvas.height) return;
    const [left, top, fit] = this.#place(), [width, height] = this.#size;
    context.imageSmoothingQuality = "high";
    context.drawImage(this.#film, left, top, width * fit, height * fit);
    if (!this.#xyz) return;
    // Tiles, where the film has too few pixels.
    const { tileSize, nativezoom, maxzoom } = this.#xyz, zoom = Math.min(maxzoom, Math.max(0, nativezoom + Math.ceil(Math.log2(fit) - 0.01)));
    const side = (z) => tileSize * 2 ** (nativezoom - z) * fit, wanted = new Set();
    if (fit * width > this.#film.width * 1.01) {
      const count = (at, end, size) => [Math.max(0, Math.floor(-at / side(zoom))), Math.ceil(Math.min(end - at, size * fit) / side(zoom))];
      const [x0, x1] = count(left, canvas.width, width), [y0, y1] = count(top, canvas.height, height);
      for (let x = x0; x < x1; x++) for (let y = y0; y < y1; y++) wanted.add(`${zoom}/${x}/${y}`);
    }
    for (const [name, tile] of this.#tiles) if (!wanted.has(name) && !tile.bitmap) tile.stop.abort();
    for (const name of wanted) {
      const tile = this.#tiles.get(name) ?? this.#fetch(name);
      this.#tiles.delete(name);
      this.#tiles.set(name, tile);
    }
    context.rect(left, top, width * fit, height * fit);
    context.clip();
    const known = [...this.#tiles.values()].filter(({ z, bitmap }) => bitmap && z <= zoom);
    for (const { z, x, y, bitmap } of known.sort((a, b) => a.z - b.z)) {
      // Whole pixels leave no seams.
      const at = (start, n) => Math.round(start + n * side(z)), x0 = at(left, x), y0 = at(top, y);
      const box = [x0, y0, at(left, x + 1) - x0, at(top, y + 1) - y0];
      context.clearRect(...box);
      context.drawImage(bitmap, ...box);
    }
  }
  #fetch(name) {
    const { service, image } = this.#xyz, [z, x, y] = name.split("/").map(Number), tile = { z, x, y, stop: new AbortController() };
    service.ask(`xyz/${image}/${name}.png`, tile.stop).then(async ({ body }) => {
      tile.bitmap = await createImageBitmap(body);
      for (const [old, { bitmap }] of this.#tiles) if (this.#tiles.size > TILES && bitmap) { bitmap.close(); this.#tiles.delete(old); }
      this.#draw();
    // A move asks again.
    }).catch(() => { if (this.#tiles.get(name) === tile) this.#tiles.delete(name); });
    return tile;
  }

  /** `x`, `y`: CSS pixels from the middle. */
  zoomBy(factor, x = 0, y = 0) {
    if (!this.#film) return;
    const { scale } = this.#view, more = this.#limit(scale * factor) / scale, share = 1 / more - 1;
    this.#move(x * share, y * share, more);
  }
  #limit(scale) {
    const most = this.#xyz ? 4 * 2 ** (this.#xyz.maxzoom - this.#xyz.nativezoom) * this.#view.scale / this.#place()[2] : ZOOM;
    return Math.max(1, Math.min(scale, most)) || 1;
  }
  /** `x`, `y`: the middle, from 0 to 1. */
  zoomTo(wanted, x, y) {
    const scale = this.#limit(wanted), within = (value) => Math.min(Math.max(value, 0.5 / scale), 1 - 0.5 / scale) || 0.5;
    this.#view = { scale, x: within(x), y: within(y) };
    this.#canvas.style.touchAction = this.hasAttribute("zoom") ? (scale > 1 ? "none" : "pan-x pan-y") : "";
    this.#draw();
  }
  get view() { return this.#view; }
  #move(dx, dy, more = 1) {
    const { scale, x, y } = this.#view, fit = this.#place()[2] / devicePixelRatio;
    this.zoomTo(scale * more, x - dx / fit / this.#size[0], y - dy / fit / this.#size[1]);
  }
  #listen() {
    const canvas = this.#canvas, fingers = this.#fingers;
    const on = (names, act) => names.split(" ").forEach((name) => canvas.addEventListener(name, (event) => {
      if (this.hasAttribute("zoom") && this.#film) act(event);
    }, { passive: false }));
    const at = ({ offsetX, offsetY }) => [offsetX - canvas.clientWidth / 2, offsetY - canvas.clientHeight / 2];
    on("wheel", (event) => {
      // Else it scrolls the page. Ctrl: a pinch.
      if (!event.ctrlKey && (this.shadowRoot.activeElement !== canvas || (event.deltaY > 0 && this.#view.scale === 1))) return;
      event.preventDefault();
      this.zoomBy(2 ** (-Math.max(-100, Math.min(event.deltaY, 100)) / 200), ...at(event));
    });
    on("dblclick", (event) => this.zoomBy(2, ...at(event)));
    on("keydown", (event) => {
      const arrow = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key], { scale } = this.#view;
      if (event.ctrlKey || event.metaKey || event.altKey || !(arrow ? scale > 1 : /^[-+=0]$/.test(event.key))) return;
      event.preventDefault();
      if (arrow) this.#move(...arrow.map((step) => step * canvas.clientHeight / 8));
      else this.zoomBy({ 0: 0, "-": 1 / 1.5 }[event.key] ?? 1.5);
    });
    /** Middle and distance. */
    const grip = () => {
      const [a, b = a] = fingers.values();
      return [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, Math.hypot(a[0] - b[0], a[1] - b[1])];
    };
    on("pointerdown", (event) => {
      if (fingers.size < 2) fingers.set(event.pointerId, at(event));
      if (this.#view.scale > 1) canvas.setPointerCapture(event.pointerId);
    });
    on("pointermove", (event) => {
      if (!fingers.has(event.pointerId)) return;
      const [x, y, apart] = grip();
      fingers.set(event.pointerId, at(event));
      const [nextX, nextY, next] = grip();
      if (apart && next) this.zoomBy(next / apart, x, y);
      if (this.#view.scale > 1) this.#move(nextX - x, nextY - y);
    });
    on("pointerup pointercancel pointerleave", (event) => fingers.delete(event.pointerId));
  }
}
customElements.define("strahl-picture", StrahlPicture);
