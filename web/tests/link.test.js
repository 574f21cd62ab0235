import assert from "node:assert/strict";
import { test } from "node:test";
import { curlLine, fragment, packed, parsed, programLine, tags, unpacked } from "../app/link.js";

test("scenes go into links and come back", async () => {
  for (const text of ["", '{ "name": "größe 😀" }', "x".repeat(100_000)]) assert.equal(await unpacked(await packed(text)), text);
  assert.ok((await packed("x".repeat(100_000))).length < 400);
});

test("a link cannot unpack without end", async () => {
  const bomb = await packed("x".repeat(3 << 20));
  await assert.rejects(unpacked(bomb), /larger than 1 MB/);
  await assert.rejects(unpacked("AAAA"));
});

test("all that is seen is in the fragment", () => {
  const seen = { kept: "lx3k9f2a", packed: "abc-_", settings: { accuracy: "proved:0", width: "320" }, panel: "pixel", pixel: { x: 3, y: 4 }, frame: { x: 0.25, y: 0.5, scale: 2 } };
  assert.deepEqual(parsed(`#${fragment(seen)}`), seen);
  assert.deepEqual(parsed("#z=<script>&x=a,b&v=1,2&p=<&q.a=%E0%A4%A&s=../../etc&e=../x&k=<&nonsense"), { settings: {} });
  for (const frame of ["0,0,0", "0.5,0.5,-3", "0.5,0.5,1e999", ",,1", "NaN,0,1"]) assert.deepEqual(parsed(`#v=${frame}`), { settings: {} }, frame);
});

test("tags for other pages hold names as text", () => {
  const { element, picture } = tags("http://h", "/v1/images/i_abc_1_a.png", '"><script>&', { width: 8, height: 4 });
  assert.equal(picture, '<img src="http://h/v1/images/i_abc_1_a.png" alt="&quot;&gt;&lt;script&gt;&amp;" width="8" height="4">');
  assert.ok(element.includes('src="http://h/embed.js"') && element.includes('image="i_abc_1_a"'));
});

test("command lines", () => {
  assert.equal(curlLine("http://h", { accuracy: "proved:1" }, true, "application/json"),
    `curl -sS -H "Authorization: Bearer $STRAHL_KEY" --data-binary @scene.json 'http://h/v1/render?accuracy=proved%3A1' -o picture.png`);
  assert.equal(programLine({ max_depth: "3" }, "text/x-nff"), "strahl render scene.nff --max-depth 3 -o picture.png");
  assert.equal(programLine({ background: "#ff8800", tone: "$(id)" }, "application/json"), "strahl render scene.json --background '#ff8800' --tone '$(id)' -o picture.png");
});
