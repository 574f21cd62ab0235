// Dialogs: examples, all commands, the key, help.
import { html, useEffect, useRef, useSignal } from "../vendor/preact.js";
import { Problem, address, askBlob, askJson, askText } from "./api.js";
import { commands, letters } from "./commands.js";
import { examples, loadExamples, openExample, openFiles } from "./scenes.js";
import { Share } from "./share.js";
import { bitmaps, dialog, key, limits, say } from "./state.js";
import { Button, Dialog } from "./ui.js";

const close = () => (dialog.value = "");

/** Thumbnails are rendered, two at a time. */
const THUMB = { width: "240", height: "135", accuracy: "fixed", samples: "4" };
const thumbs = /** @type {Map<string, Promise<ImageBitmap | null>>} */ (new Map());
let turn = /** @type {Promise<any>[]} */ ([Promise.resolve(), Promise.resolve()]);

/** @param {string} href */
function thumb(href) {
  let known = thumbs.get(href);
  if (!known) {
    const make = async () => {
      try {
        const body = await askText(href);
        const blob = await askBlob("v1/render", { body, type: "application/json", query: THUMB, accept: "image/png", priority: "low" });
        bitmaps.made += 1;
        return await createImageBitmap(blob);
      } catch {
        thumbs.delete(href);
        return null;
      }
    };
    known = turn[0].then(make);
    turn = [turn[1], known];
    thumbs.set(href, known);
  }
  return known;
}

/** @param {{ href: string }} props */
function Thumb({ href }) {
  const canvas = useRef(/** @type {HTMLCanvasElement | null} */ (null));
  useEffect(() => {
    thumb(href).then((bitmap) => bitmap && canvas.current?.getContext("2d")?.drawImage(bitmap, 0, 0, 240, 135));
  }, [href]);
  return html`<canvas ref=${canvas} width="240" height="135" aria-hidden="true"></canvas>`;
}

function Examples() {
  const file = useRef(/** @type {HTMLInputElement | null} */ (null));
  useEffect(() => {
    loadExamples().catch((error) => say(error.message));
  }, []);
  const choose = (/** @type {string} */ id) => {
    close();
    openExample(id).catch((error) => say(error.message));
  };
  return html`<${Dialog} title="Begin with" wide close=${close}>
    <ul class="examples">${examples.value.map(({ id, title, about, href }) => html`<li key=${id}>
      <button type="button" class="example" onClick=${() => choose(id)}><${Thumb} href=${href} /><strong>${title}</strong><span class="quiet">${about}</span></button>
    </li>`)}</ul>
    <p class="row"><${Button} icon="plus" press=${() => file.current?.click()}>Open a file<//><span class="quiet">or drop one anywhere: a scene (JSON, NFF) or a model (.glb, .gltf, .obj, .stl, .ply) with the files that it names.</span></p>
    <input ref=${file} type="file" hidden multiple onChange=${(/** @type {any} */ event) => {
      const { files } = event.currentTarget;
      if (files.length > 0) openFiles(files).then(close);
    }} />
  <//>`;
}

function Palette() {
  const typed = useSignal("");
  const at = useSignal(0);
  const words = typed.value.toLowerCase().split(/\s+/);
  const found = commands().filter(({ title }) => words.every((word) => title.toLowerCase().includes(word)));
  const chosen = Math.min(at.value, found.length - 1);
  const run = (/** @type {import("./commands.js").Command | undefined} */ of) => {
    if (!of) return;
    close();
    // After the dialog has given the focus back.
    setTimeout(of.run);
  };
  const move = (/** @type {KeyboardEvent} */ event) => {
    const to = { ArrowDown: chosen + 1, ArrowUp: chosen - 1 + found.length, Home: 0, End: found.length - 1 }[event.key];
    if (event.key === "Enter") run(found[chosen]);
    else if (to === undefined || found.length === 0) return;
    else {
      at.value = to % found.length;
      document.getElementById(`command-${at.value}`)?.scrollIntoView({ block: "nearest" });
    }
    event.preventDefault();
  };
  return html`<${Dialog} title="All commands" close=${close}>
    <input class="field" type="text" role="combobox" aria-label="Search commands" aria-expanded="true" aria-controls="commands" placeholder="What do you want to do?" autofocus
      aria-activedescendant=${found.length > 0 ? `command-${chosen}` : undefined} onKeyDown=${move}
      value=${typed.value} onInput=${(/** @type {any} */ event) => ((typed.value = event.currentTarget.value), (at.value = 0))} />
    <ul class="commands" role="listbox" id="commands" aria-label="Commands">${found.map((of, index) => html`<li key=${of.title} id=${`command-${index}`} role="option" class="command"
      aria-selected=${String(index === chosen)} onClick=${() => run(of)}><span>${of.title}</span>${of.keys && html`<kbd>${of.keys}</kbd>`}</li>`)}</ul>
    ${found.length === 0 && html`<p class="quiet">No command has these words.</p>`}
  <//>`;
}

/** The first character of a key that no header can hold, if any. @param {string} words */
const strange = (words) => /[^\x21-\x7e]/u.exec(words)?.[0];

function Key() {
  const typed = useSignal("");
  const wrong = useSignal("");
  const keeps = useSignal(false);
  const take = async (/** @type {Event} */ event) => {
    event.preventDefault();
    const given = typed.value.trim();
    const wrongly = strange(given);
    if (wrongly !== undefined) return void (wrong.value = wrongly.trim() === "" ? "A key has no spaces. Copy it again." : `No key has the character ${wrongly}. Copy it again.`);
    key.value = given;
    try {
      const { tenant, scopes } = await askJson("v1/me");
      limits.value = await askJson("v1/limits");
      if (keeps.value) sessionStorage.setItem("strahl-key", key.value);
      close();
      say(`This is a key of ${tenant}, for ${scopes.join(", ")}.`);
    } catch (error) {
      wrong.value = error instanceof Problem ? error.message : "The service does not answer.";
      dialog.value = "key";
    }
  };
  const forget = () => {
    key.value = "";
    sessionStorage.removeItem("strahl-key");
    close();
    say("The key is forgotten.");
  };
  return html`<${Dialog} title="Key for the service" close=${close}>
    <form class="form" onSubmit=${take}>
      <p>This service needs a key, <code>rk_…</code>, as <code>strahl key new</code> makes it. The page keeps it in memory and sends it to this service alone.</p>
      <input type="text" name="username" autocomplete="username" value="strahl" hidden />
      <label>Key<input class="field" type="password" autocomplete="current-password" autofocus required value=${typed.value} aria-invalid=${wrong.value !== "" ? "true" : undefined}
        aria-describedby="key-wrong" onInput=${(/** @type {any} */ event) => (typed.value = event.currentTarget.value)} /></label>
      <p id="key-wrong" class="wrong" role="alert">${wrong.value}</p>
      <label class="check"><input type="checkbox" checked=${keeps.value} onChange=${(/** @type {any} */ event) => (keeps.value = event.currentTarget.checked)} /> Keep it until this tab is closed</label>
      <div class="row"><button class="button main" type="submit">Use this key</button>${key.value !== "" && html`<${Button} press=${forget}>Forget it<//>`}</div>
    </form>
  <//>`;
}

function Help() {
  const parts = [
    ["Edit", "Change the text at the left; each keystroke gives a picture. Press Ctrl-Space for the keys that may stand there, and rest on a key to read what it means."],
    ["Numbers and colors", "Hold Alt and drag a number, or press Alt-Up and Alt-Down on it. Press the square beside a color to pick one."],
    ["Look", "Drag moves the picture, the wheel zooms. Closer than its own size the service traces more detail, down to one pixel as wide as 65,536."],
    ["Camera", "Press C, then drag to orbit; Shift-drag moves sideways, the wheel goes nearer. Or hold Alt and drag at any time."],
    ["Pixels", "Click one, or move the cursor with the arrow keys: its rays show what it is made of."],
    ["Without a pointer", "F6 goes from pane to pane, Tab leaves the editor, Ctrl-K has every command."],
  ];
  return html`<${Dialog} title="Help" wide close=${close}>
    <dl class="help">${parts.map(([name, words]) => html`<div key=${name}><dt>${name}</dt><dd>${words}</dd></div>`)}</dl>
    <h3>Keys</h3>
    <ul class="keys">${commands().filter(({ keys }) => keys).map(({ title, keys }) => html`<li key=${title}><kbd>${keys}</kbd><span>${title}</span></li>`)}</ul>
    <label class="check"><input type="checkbox" checked=${letters.value} onChange=${(/** @type {any} */ event) => (letters.value = event.currentTarget.checked)} /> Single letters are commands outside of text fields</label>
    <p class="quiet">More: <a href=${String(address("docs"))}>the requests of the service</a> · <a href=${String(new URL("../vendor/LICENSES.txt", import.meta.url))}>licences of what this page contains</a></p>
  <//>`;
}

/** @type {Record<string, () => any>} */
const DIALOGS = { examples: Examples, share: Share, commands: Palette, key: Key, help: Help };

/** The open dialog, if any. */
export function Dialogs() {
  const Open = DIALOGS[dialog.value];
  return Open ? html`<${Open} key=${dialog.value} />` : null;
}
