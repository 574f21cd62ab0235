import assert from "node:assert/strict";
import { test } from "node:test";
import { Ladder } from "../app/ladder.js";

/** A ladder, and the actions of a list of events without those to wake. */
const ladder = () => new Ladder();
const sent = (actions) => actions.filter(({ type }) => type === "send").map(({ rung, version }) => [rung, version]);
const types = (actions) => actions.map(({ type }) => type);
const fast = { base: 1, perPixel: 1e-5 };
const picture = (rung, version, now, more = {}) => ({ type: "answer", outcome: "picture", rung, version, now, ...more });

test("an edit is answered at once, then in full size after a rest, then as the scene says", () => {
  const it = ladder();
  assert.deepEqual(sent(it.next({ type: "edit", now: 0 })), [[0, 1]]);
  const first = it.next(picture(0, 1, 10, fast));
  assert.deepEqual(types(first), ["show", "wake"]);
  assert.equal(first[1].at, 140);
  const second = it.next({ type: "tick", now: 140 });
  assert.deepEqual(types(second), ["ask", "send"]);
  assert.deepEqual(sent(second), [[1, 1]]);
  assert.deepEqual(sent(it.next({ type: "predicted", version: 1, now: 145, ms: 300 })), []);
  assert.deepEqual(sent(it.next(picture(1, 1, 190))), [[2, 1]]);
  assert.deepEqual(types(it.next(picture(2, 1, 400))), ["show"]);
  assert.equal(it.done, 2);
});

test("the quick answer is never aborted, and of the texts behind it only the newest is asked for", () => {
  const it = ladder();
  it.next({ type: "edit", now: 0 });
  for (const now of [1, 2, 3, 4]) assert.deepEqual(it.next({ type: "edit", now }), []);
  const after = it.next(picture(0, 1, 20, fast));
  assert.deepEqual(types(after), ["show", "send"]);
  assert.deepEqual(sent(after), [[0, 5]]);
});

test("slow rungs are aborted by newer texts", () => {
  const it = ladder();
  it.next({ type: "edit", now: 0 });
  it.next(picture(0, 1, 10, fast));
  it.next({ type: "tick", now: 140 });
  assert.deepEqual(it.next({ type: "edit", now: 150 }).map(({ type, rung }) => [type, rung]), [["abort", 1], ["send", 0]]);
});

test("no older picture replaces a newer one, in whatever order they come", () => {
  let seed = 7;
  const random = (below) => (seed = (seed * 48271) % 2147483647) % below;
  for (let round = 0; round < 200; round += 1) {
    const it = ladder();
    const flying = [];
    let shown = [0, -1];
    const take = (actions) => {
      for (const action of actions) {
        if (action.type === "send") flying.push(action);
        if (action.type === "show") {
          const next = [action.version, action.rung];
          assert.ok(next[0] > shown[0] || (next[0] === shown[0] && next[1] > shown[1]), `${shown} was replaced by ${next}`);
          shown = next;
        }
      }
    };
    for (let now = 0; now < 2000; now += 1 + random(40)) {
      const choice = random(4);
      if (choice === 0) take(it.next({ type: "edit", now }));
      else if (choice === 1 && flying.length > 0) {
        const [{ rung, version }] = flying.splice(random(flying.length), 1);
        take(it.next(picture(rung, version, now, rung === 0 ? fast : {})));
      } else if (choice === 2) take(it.next({ type: "predicted", version: it.version, now, ms: random(3000) }));
      else take(it.next({ type: "tick", now }));
      assert.ok(flying.filter(({ rung }) => rung === 0).length <= 1, "one quick request at a time");
    }
    // All that is on its way comes, nothing is edited any more: the end is the newest text.
    for (let now = 3000; flying.length > 0 || it.done < 1; now += 100) {
      const next = flying.shift();
      take(next ? it.next(picture(next.rung, next.version, now, next.rung === 0 ? fast : {})) : it.next({ type: "tick", now }));
      assert.ok(now < 10_000, "it ends");
    }
    assert.equal(shown[0], it.version);
  }
});

test("the size of the quick answer follows what the scene takes", () => {
  const it = ladder();
  const [first] = it.next({ type: "edit", now: 0 });
  assert.deepEqual([first.width, first.height, first.ceiling], [160, 90, 0]);
  it.next(picture(0, 1, 10, { base: 1, perPixel: 1e-4 }));
  const [second] = it.next({ type: "edit", now: 20 });
  assert.deepEqual([second.width, second.height, second.ceiling], [480, 270, 0]);
  it.next(picture(0, 2, 30, { base: 1, perPixel: 1e-3 }));
  const [third] = it.next({ type: "edit", now: 40 });
  assert.deepEqual([third.width, third.ceiling], [160, 0], "a slow answer counts at once");
});

test("a scene of which not even a small picture is quick has a ceiling", () => {
  const it = ladder();
  it.next({ type: "edit", now: 0 });
  it.next(picture(0, 1, 300, { base: 150, perPixel: 1e-4 }));
  const next = it.next({ type: "edit", now: 400 }).find(({ type }) => type === "send");
  assert.deepEqual([next.width, next.ceiling], [240, 25]);
  let now = 400;
  for (let edit = 2; edit < 20; edit += 1) {
    it.next(picture(0, edit, (now += 30)));
    it.next({ type: "edit", now: (now += 10) });
  }
  assert.ok(it.rate.base < 20, "it is tried again");
});

test("after a ceiling rung 1 tells how fast the scene is", () => {
  const it = ladder();
  it.next({ type: "edit", now: 0 });
  it.next(picture(0, 1, 30));
  it.next({ type: "tick", now: 140 });
  it.next(picture(1, 1, 180, { base: 1, perPixel: 1e-5 }));
  const [next] = it.next({ type: "edit", now: 200 });
  assert.deepEqual([next.width, next.ceiling], [960, 0]);
});

test("a long render is offered, not started, until it is asked for", () => {
  const it = ladder();
  it.next({ type: "edit", now: 0 });
  it.next(picture(0, 1, 10, fast));
  it.next({ type: "tick", now: 140 });
  it.next(picture(1, 1, 200));
  const offer = it.next({ type: "predicted", version: 1, now: 201, ms: 9000 });
  assert.deepEqual(types(offer), ["offer"]);
  assert.deepEqual(it.next({ type: "tick", now: 250 }), [], "it is offered once");
  assert.deepEqual(sent(it.next({ type: "force", now: 300 })), [[2, 1]]);
});

test("paused, it renders only when asked to", () => {
  const it = ladder();
  it.next({ type: "live", on: false, now: 0 });
  assert.deepEqual(it.next({ type: "edit", now: 1 }), []);
  assert.deepEqual(sent(it.next({ type: "force", now: 2 })), [[0, 1]]);
});

test("a refused text waits for the next one", () => {
  const it = ladder();
  it.next({ type: "edit", now: 0 });
  assert.deepEqual(it.next({ type: "answer", rung: 0, version: 1, now: 5, outcome: "invalid" }), []);
  assert.deepEqual(it.next({ type: "tick", now: 500 }), []);
  assert.deepEqual(sent(it.next({ type: "edit", now: 600 })), [[0, 2]]);
});

test("a busy service is asked again when it says", () => {
  const it = ladder();
  it.next({ type: "edit", now: 0 });
  const [wait] = it.next({ type: "busy", rung: 0, version: 1, now: 10, seconds: 2 });
  assert.deepEqual(wait, { type: "wake", at: 2010 });
  assert.deepEqual(sent(it.next({ type: "tick", now: 2010 })), [[0, 1]]);
});

test("a text whose picture is still here asks only for its plan", () => {
  const it = ladder();
  assert.deepEqual(types(it.next({ type: "known", now: 0 })), ["ask"]);
});

test("a service that is back is asked again for what failed, but not for what was only offered", () => {
  const it = ladder();
  it.next({ type: "edit", now: 0 });
  assert.deepEqual(it.next({ type: "answer", rung: 0, version: 1, now: 5, outcome: "failed" }), []);
  assert.deepEqual(sent(it.next({ type: "again", now: 600 })), [[0, 1]]);
  it.next(picture(0, 1, 610, fast));
  assert.deepEqual(sent(it.next(picture(1, 1, 700))), []);
  // The plan was lost, too.
  assert.deepEqual(types(it.next({ type: "again", now: 800 })), ["ask"]);
  assert.deepEqual(types(it.next({ type: "predicted", version: 1, now: 900, ms: 60_000 })), ["offer"]);
  assert.deepEqual(it.next({ type: "again", now: 1000 }), []);
});

test("who asks by hand does not wait for a busy service", () => {
  const it = ladder();
  it.next({ type: "edit", now: 0 });
  it.next({ type: "busy", rung: 0, version: 1, now: 10, seconds: 3600 });
  assert.deepEqual(sent(it.next({ type: "force", now: 1000 })), [[0, 1]]);
});
