import assert from "node:assert/strict";
import { test } from "node:test";
import { cameraOf, dollied, length, orbited, trucked } from "../app/camera.js";

const camera = () => cameraOf({ camera: { pinhole: { eye: [0, 0, 5], look_at: [0, 0, 0], vfov_deg: 90 } } });
const near = (a, b) => assert.ok(a.every((of, i) => Math.abs(of - b[i]) < 1e-9), `${a} is not ${b}`);

test("a drag to the right turns the scene to the right, a drag down shows it from above", () => {
  assert.ok(orbited(camera(), 0.1, 0).eye[0] < 0);
  assert.ok(orbited(camera(), 0, 0.1).eye[1] > 0);
  near([length(orbited(camera(), 1, 0.7).eye)], [5]);
});

test("the eye stops short of the poles", () => {
  const { eye } = orbited(camera(), 0, 99);
  assert.ok(eye[1] < 5 && eye[1] > 4.9);
  assert.ok(length([eye[0], 0, eye[2]]) > 0.1);
});

test("a truck by the whole height moves the target across the picture", () => {
  const moved = trucked(camera(), 1, 0);
  near(moved.look_at, [-10, 0, 0]);
  near(moved.eye, [-10, 0, 5]);
  near(dollied(camera(), 2).eye, [0, 0, 10]);
});

test("what has no place is no camera", () => {
  assert.equal(cameraOf({ camera: { pinhole: { eye: "x" } } }), null);
  assert.equal(cameraOf({}), null);
});
