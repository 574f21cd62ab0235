// Sharing: a link to what is seen, the same request for the command line, and files.
import { html, useEffect, useSignal } from "../vendor/preact.js";
import { address, askBlob } from "./api.js";
import { LONGEST_LINK, LONGEST_TEXT, curlLine, fileName, fragment, packed, programLine, tags } from "./link.js";
import { example, opened } from "./scenes.js";
import { isFitted } from "./looking.js";
import { deep, dialog, key, origin, panel, pixel, say, settings, shown, size, text, title, view } from "./state.js";
import { Button, Dialog } from "./ui.js";

/** The fragment of what is seen. Of a scene beyond `most` characters it has only the name by which this tab keeps it. @param {number} [most] @returns {Promise<string>} */
export async function seen(most = Infinity) {
  const at = view.peek();
  const frame = isFitted.peek() ? undefined : { x: (at.width / 2 - at.left) / at.scale / size.peek().width, y: (at.height / 2 - at.top) / at.scale / size.peek().height, scale: at.scale };
  const common = { type: origin.peek().type, settings: settings.peek(), panel: panel.peek(), pixel: pixel.peek() ?? undefined, frame };
  const kept = opened.peek();
  const known = example.peek();
  if (known?.text === text.peek()) return fragment({ ...common, example: known.id });
  if (text.peek().length > LONGEST_TEXT) return fragment({ ...common, kept });
  const word = await packed(text.peek());
  return fragment(word.length <= most ? { ...common, packed: word } : { ...common, kept });
}

/** @param {string} words @param {string} what */
export async function copy(words, what) {
  try {
    await navigator.clipboard.writeText(words);
    say(`${what} is copied.`);
  } catch {
    say("The browser does not let this page copy; select the text.");
  }
}

/** @param {Blob} blob @param {string} name */
export function save(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** The settings of the request that made the picture on screen. */
const asked = () => shown.value?.settings ?? settings.value;

/** @param {string} format @param {Record<string, string>} [more] */
async function download(format, more = {}) {
  try {
    save(await askBlob("v1/render", { body: text.peek(), type: origin.peek().type, query: { ...settings.peek(), ...more, format } }), `picture.${format}`);
  } catch (error) {
    say(/** @type {Error} */ (error).message);
  }
}

/** @param {{ label: string, text: string, what: string }} props */
const Copied = ({ label, text: words, what }) => html`<div class="copied">
  <label>${label}<textarea readonly rows=${words.includes("\n") || words.length > 90 ? 2 : 1} onFocus=${(/** @type {any} */ event) => event.currentTarget.select()}>${words}</textarea></label>
  <${Button} icon="copy" press=${() => copy(words, what)}>Copy<//>
</div>`;

export function Share() {
  const link = useSignal("");
  useEffect(() => {
    seen().then((words) => (link.value = `${address("studio")}#${words}`));
  }, []);
  const base = String(new URL(".", document.baseURI)).replace(/\/$/, "");
  const { type } = origin.value;
  const curl = curlLine(base, asked(), key.value !== "", type);
  const digest = shown.value?.report.digest ?? "";
  const location = shown.value?.report.location ?? "";
  const { element, picture } = tags(base, location, title.value, size.value);
  const isTooLong = text.value.length > LONGEST_TEXT;
  return html`<${Dialog} title="Share" wide close=${() => (dialog.value = "")}>
    ${isTooLong ? html`<p class="warning">This scene is too long for a link. Send it as a file.</p>`
    : html`<p class="quiet">The link holds the scene itself, after the #: it is sent to no server, and opens in any strahl${text.value.includes('"sha256:') && " that has its files, too"}.</p>
      <${Copied} label="Link to what you see" text=${link.value} what="The link" />`}
    ${link.value.length > LONGEST_LINK && html`<p class="warning">This link has ${link.value.length.toLocaleString("en")} characters; mail and chat programs may cut it. Send the scene as a file.</p>`}
    <${Copied} label=${`The request of this picture, for curl, beside ${fileName(type)}`} text=${curl} what="The line" />
    <${Copied} label="The same without a service" text=${programLine(asked(), type)} what="The line" />
    ${location !== "" && key.value === "" && html`<${Copied} label="For a page of your own, with zoom" text=${element} what="The element" />
      <${Copied} label="For a page of your own, as a plain picture" text=${picture} what="The picture" />`}
    <div class="row">
      <${Button} press=${() => save(new Blob([text.peek()], { type }), fileName(type))}>Scene<//>
      <${Button} press=${() => download("png")}>PNG<//>
      <${Button} press=${() => download("png", { bits: "16" })}>PNG, 16 bits<//>
      <${Button} press=${() => download("exr")}>EXR<//>
      <${Button} press=${() => download("pfm")}>PFM<//>
      <${Button} press=${() => download("webp")}>WebP<//>
    </div>
    ${digest !== "" && html`<p class="quiet">SHA-256 of the picture on screen: <code class="wrapped">${digest}</code>. The same request gives the same bytes on every machine${asked().accuracy?.startsWith("time:") ? ", except that this one has a time limit" : ""}.</p>`}
    ${!deep.value && html`<p class="quiet">The link opens with detail.</p>`}
  <//>`;
}
