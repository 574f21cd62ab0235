// The middle pane: the picture, and over it the tools to look at it.
import { html, useEffect, useSignal } from "../vendor/preact.js";
import { cameraOf, written } from "./camera.js";
import { zoomWords } from "./framing.js";
import { isMovable } from "./gestures.js";
import { valueOf } from "./pointers.js";
import { actualSize, fit, zoomBy } from "./looking.js";
import { deep, draft, hover, limits, moved, offer, openPanel, panels, pixel, problems, reveal, shown, size, status, syntax, text, tool, view } from "./state.js";
import { LeaveOut } from "./edit-pane.js";
import { renderNow } from "./picture.js";
import { duration } from "./report.js";
import { isOfText, lineOf, rangeOf, wordsOf } from "./problems.js";
import { Button, Icon } from "./ui.js";
import { Viewport } from "./viewport.js";

function Tools() {
  const isOrbit = tool.value === "orbit";
  const zoom = zoomWords(view.value.scale * devicePixelRatio);
  return html`<div class="tools" role="toolbar" aria-label="Look at the picture">
    <${Button} label="Move the camera" icon="orbit" kind="quiet" keys="C" pressed=${isOrbit} disabled=${!isMovable()} press=${() => (tool.value = isOrbit ? "look" : "orbit")}><span class="tool-word">Camera</span><//>
    <span class="tools-gap"></span>
    <${Button} label="Zoom out" icon="minus" kind="quiet" keys="-" press=${() => zoomBy(1 / 1.5)} />
    <${Button} label=${`Zoom is ${zoom}; press for 100 %`} kind="quiet" press=${actualSize}><span class="zoom">${zoom}</span><//>
    <${Button} label="Zoom in" icon="plus" kind="quiet" keys="+" press=${() => zoomBy(1.5)} />
    <${Button} label="Fit" icon="fit" kind="quiet" keys="0" press=${fit} />
    <span class="tools-gap"></span>
    <${Button} kind="quiet" keys="D" pressed=${deep.value} press=${() => (deep.value = !deep.value)} title="Closer than its own size the service traces more detail; else pixels become squares">Detail<//>
  </div>`;
}

/** Where the pointer or the cursor is; numbers of the camera while it moves. */
function Readout() {
  const camera = moved.value ? cameraOf(moved.value) : draft.value === null ? null : cameraOf(valueOf(draft.value));
  if (camera) {
    const { eye, look_at } = written(camera);
    return html`<p class="readout moving mono">eye ${eye.join(", ")} · look_at ${look_at.join(", ")}</p>`;
  }
  const at = hover.value ?? pixel.value;
  return at ? html`<p class="readout mono">${at.x}, ${at.y}</p>` : null;
}

/** Tells where the cursor is and what is there, after a rest. */
function Told() {
  const told = useSignal("");
  const at = pixel.value;
  useEffect(() => {
    if (!at) return void (told.value = "");
    const timer = setTimeout(() => (told.value = `Pixel ${at.x}, ${at.y}${colorAt(at)}`), 300);
    return () => clearTimeout(timer);
  }, [at?.x, at?.y]);
  return html`<p class="hidden-visually" aria-live="polite">${told.value}</p>`;
}

/** The color on screen, in codes. @param {import("./state.js").Pixel} at */
function colorAt(at) {
  const of = shown.peek();
  const context = new OffscreenCanvas(1, 1).getContext("2d");
  if (!of || !context) return "";
  const { width, height } = size.peek();
  context.drawImage(of.bitmap, -Math.floor((at.x * of.width) / width), -Math.floor((at.y * of.height) / height));
  const [red, green, blue] = context.getImageData(0, 0, 1, 1).data;
  return `: red ${red}, green ${green}, blue ${blue}`;
}

const AsJob = () => html`<${Button} press=${() => openPanel("jobs")}>As a job<//>`;

/** What is wrong, over the last good picture. */
function Trouble() {
  const [first] = problems.value;
  if (status.value.word === "failed") return html`<p class="trouble" role="alert"><${Icon} name="warning" />${status.value.detail}${status.value.job && html` <${AsJob} />`}</p>`;
  if (!first || status.value.word !== "invalid") return null;
  if (!isOfText(first)) return html`<p class="trouble"><${Icon} name="warning" />${wordsOf(first)} <${LeaveOut} problem=${first} /></p>`;
  const line = lineOf(text.value, rangeOf(text.value, syntax.value, first).from);
  return html`<p class="trouble"><${Icon} name="warning" /><button type="button" class="trouble-link" onClick=${() => reveal(first.pointer)}>Line ${line}</button> ${first.detail}</p>`;
}

/** A picture that takes long is offered, not started. */
function Offer() {
  if (offer.value === null) return null;
  const isTooLong = limits.value && offer.value > 1000 * limits.value.timeout_s;
  return html`<div class="offer" role="region" aria-label="A longer render">The whole picture should take ${duration(offer.value)}${isTooLong ? ", longer than one answer may" : ""}.
    ${!isTooLong && html`<${Button} kind="main" keys="Control+Enter" press=${renderNow}>Render it<//>`}<${AsJob} /></div>`;
}

export function PicturePane() {
  return html`<section class="picture" aria-label="Picture" data-pane-focus>
    <${Viewport} />
    ${panels.value.map(({ id, Overlay }) => Overlay && html`<${Overlay} key=${id} />`)}
    ${!shown.value && status.value.word !== "failed" && html`<p class="first">The first picture is on its way.</p>`}
    <${Trouble} />
    <${Offer} />
    <${Readout} />
    <${Told} />
    <${Tools} />
  </section>`;
}
