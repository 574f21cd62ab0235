// The types that users see. `tsc` reads this file; nobody runs it.
import { Client, Job, Picture, Problem, type Mistake, type Progress, type Scene } from "strahl";

const client = new Client("http://127.0.0.1:8080", { key: "rk_...", timeout: 10, retries: 2 });
const scene: Scene = {
  version: 1,
  camera: { pinhole: { eye: [0, 1, 5], look_at: [0, 0, 0] } },
  objects: [{ sphere: { center: [0, 0, 0], radius: 1 } }],
};

export async function use(signal: AbortSignal): Promise<number> {
  const picture: Picture = await client.render(scene, { max_depth: 5, format: "pfm" }, { signal });
  const proved: number | null = picture.error.proved;
  const plan = await client.analyze(scene, { precision: "double" });
  const rays: number = plan.actual.rays.camera;
  await client.tile(scene, [0, 0, 8, 8], { format: "exr", layers: "distance" }, { signal });
  await client.render(new ArrayBuffer(8));
  await client.assets.add(new DataView(new ArrayBuffer(8)));
  const job: Job = await client.jobs.submit(scene, { priority: 60, labels: ["a"], idempotencyKey: "b" });
  await job.prioritize(70, { signal });
  await job.cancel({ signal });
  await job.delete({ signal });
  for await (const { fraction, etaMs } of job.progress() satisfies AsyncIterable<Progress>) console.log(fraction, etaMs);
  try {
    await client.validate("{}");
  } catch (error) {
    if (error instanceof Problem) error.mistakes.forEach(({ pointer, line }: Mistake) => console.log(pointer, line));
  }
  // @ts-expect-error there is no such setting
  await client.render(scene, { max_dept: 5 });
  // @ts-expect-error a promise is no scene
  await client.render(Promise.resolve(scene));
  // @ts-expect-error jobs have no layers
  await client.jobs.submit(scene, { format: "exr", layers: "distance" });
  // @ts-expect-error streams have no layers
  client.stream(scene, { format: "exr", layers: "distance" });
  // @ts-expect-error a job has no such state
  client.jobs.list({ state: "done" });
  return (proved ?? 0) + rays + (await client.tree(scene, 1, 2)).value.length;
}
