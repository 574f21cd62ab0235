import assert from "node:assert/strict";
import test from "node:test";

globalThis.document = { baseURI: "http://127.0.0.1/studio" };
const { EventParser, eventsOf, follow } = await import("../app/sse.js");

const STREAM = 'retry: 50\n\nevent: snapshot\ndata: {"seq":2}\nid: 2\n\n: a comment\n\ndata: two\ndata: lines\nid: 3\n\nevent: tile\ndata:{"x":64}\nid: 4\n\n';
const EXPECTED = [
  { event: "snapshot", data: { seq: 2 }, id: "2" },
  { event: "message", data: "two\nlines", id: "3" },
  { event: "tile", data: { x: 64 }, id: "4" },
];

test("events come the same however the stream is cut, and with any end of lines", () => {
  for (const end of ["\n", "\r\n"]) {
    const stream = STREAM.replaceAll("\n", end);
    for (let size = 1; size < stream.length; size += 1) {
      const parser = new EventParser();
      const events = [];
      for (let at = 0; at < stream.length; at += size) events.push(...parser.take(stream.slice(at, at + size)));
      assert.deepEqual(events, EXPECTED, `in pieces of ${size}`);
      assert.equal(parser.retry, 50);
    }
  }
});

test("an event that the stream breaks off is not an event", () => {
  assert.deepEqual(new EventParser().take('event: done\ndata: {"seq":2}\n'), []);
});

test("letters that lie across two pieces stay whole", async () => {
  const bytes = new TextEncoder().encode('data: "Glas für März"\n\n');
  const body = new ReadableStream({
    start(stream) {
      for (const byte of bytes) stream.enqueue(Uint8Array.of(byte));
      stream.close();
    },
  });
  const events = [];
  for await (const event of eventsOf(new Response(body))) events.push(event.data);
  assert.deepEqual(events, ["Glas für März"]);
});

test("a broken stream goes on after its last event, and ends when the service has no more to say", async () => {
  const asked = [];
  const answers = [new Response("retry: 1\n\ndata: 1\nid: 7\n\ndata: lo"), new Response("data: 2\nid: 8\n\n"), new Response(null, { status: 204 })];
  globalThis.fetch = async (_, { headers }) => (asked.push(headers.get("last-event-id")), answers.shift());
  const taken = [];
  await follow("v1/events", { signal: new AbortController().signal, take: ({ data }) => taken.push(data) });
  assert.deepEqual(taken, [1, 2]);
  assert.deepEqual(asked, [null, "7", "8"]);
});

test("a stream that is refused says why", async () => {
  globalThis.fetch = async () => Response.json({ detail: "no such job" }, { status: 404 });
  await assert.rejects(follow("v1/events", { signal: new AbortController().signal, take() {} }), /no such job/);
});
