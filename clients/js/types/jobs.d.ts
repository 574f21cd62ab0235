/**
 * An id as a part of a path, whatever it is.
 * @param {string} id
 */
export function checked(id: string): string;
/**
 * Refuses what the types have not, before a scene is sent for nothing.
 * @param {string} what
 * @param {object} options
 */
export function checkLayers(what: string, options: object): void;
/**
 * The file that a scene is, if it is one: a `Blob`, or the bytes of a buffer or of a view of one.
 * @param {unknown} scene
 */
export function fileOf(scene: unknown): Uint8Array<ArrayBuffer> | Blob | undefined;
/**
 * The media type of a scene or a model.
 * @param {import("./client.js").Scene} scene
 */
export function typeOf(scene: import("./client.js").Scene): Promise<string>;
/**
 * The text of a scene in JSON.
 * @param {import("./client.js").Scene} scene
 */
export function textOf(scene: import("./client.js").Scene): Promise<string>;
/** @typedef {import("../types/contract.js").components["schemas"]} Schemas */
/**
 * What has happened to a job. `name`: snapshot, queued, started, preview, tile, progress, succeeded, failed, canceled.
 * @typedef {{ name: string, id: string, data: Record<string, any> }} JobEvent
 */
/**
 * How far a job is.
 * @typedef {object} Progress
 * @property {string} state
 * @property {number} fraction From 0 to 1.
 * @property {number} tilesDone
 * @property {number} tilesTotal
 * @property {number | null} etaMs Milliseconds until the end, estimated.
 */
/** The jobs of a service. */
export class Jobs {
    /** @param {import("./connection.js").Connection} connection */
    constructor(connection: import("./connection.js").Connection);
    /**
     * Submits a job. The same `idempotencyKey` with the same request gives the same job; without one it has its own, so a
     * request that was lost is sent again and is still one job.
     * @param {import("./client.js").Scene} scene
     * @param {import("./client.js").Settings & import("./client.js").Output & { priority?: number, labels?: string[],
     *   webhook?: string, store?: string | true, idempotencyKey?: string, wait?: number, frames?: Schemas["Sequence"] }} [options] `wait`:
     *   seconds to wait for its end; `webhook`: a URL that hears of its end; `store`: the name of its picture in the service's store, or
     *   true for one of its own; `frames` makes a sequence of it, such as `{ count: 36, turntable: {} }`
     * @param {import("./client.js").Given} [given]
     */
    submit(scene: import("./client.js").Scene, options?: import("./client.js").Settings & import("./client.js").Output & {
        priority?: number;
        labels?: string[];
        webhook?: string;
        store?: string | true;
        idempotencyKey?: string;
        wait?: number;
        frames?: Schemas["Sequence"];
    }, { signal }?: import("./client.js").Given): Promise<Job>;
    /**
     * The job of an id.
     * @param {string} id
     * @param {import("./client.js").Given} [given]
     */
    get(id: string, { signal }?: import("./client.js").Given): Promise<Job>;
    /**
     * All jobs of the tenant, the newest first.
     * @param {{ state?: Schemas["JobState"], label?: string } & import("./client.js").Given} [filters]
     */
    list({ state, label, signal }?: {
        state?: Schemas["JobState"];
        label?: string;
    } & import("./client.js").Given): AsyncGenerator<Job, void, unknown>;
    /**
     * What happens to all jobs of the tenant, with `created` and `removed` as they come and go, without an end. First comes a
     * snapshot of each job that has not ended, also when the stream begins again after it broke: it cannot be continued.
     * @param {{ label?: string } & import("./client.js").Given} [filters]
     */
    events({ label, signal }?: {
        label?: string;
    } & import("./client.js").Given): AsyncGenerator<JobEvent, void, any>;
    #private;
}
/** A job. `view` is what the service last said about it. */
export class Job {
    /**
     * @param {import("./connection.js").Connection} connection
     * @param {Schemas["JobView"]} view
     */
    constructor(connection: import("./connection.js").Connection, view: Schemas["JobView"]);
    view: {
        created_at: string;
        estimate_ms: number;
        eta_ms: number | null;
        expires_at: string | null;
        finished_at: string | null;
        frames?: import("../types/contract.js").components["schemas"]["JobFrames"] | null;
        height: number;
        id: string;
        image_id: string | null;
        labels: string[];
        links: import("../types/contract.js").components["schemas"]["JobLinks"];
        position: number | null;
        priority: number;
        problem?: import("../types/contract.js").components["schemas"]["JobFailure"] | null;
        progress: import("../types/contract.js").components["schemas"]["JobProgress"];
        report?: import("../types/contract.js").components["schemas"]["CostReport"] | null;
        scene_id: string | null;
        sequence?: import("../types/contract.js").components["schemas"]["SequenceReport"] | null;
        started_at: string | null;
        state: import("../types/contract.js").components["schemas"]["JobState"];
        stats: import("../types/contract.js").components["schemas"]["JobStats"];
        store?: import("../types/contract.js").components["schemas"]["StoredView"] | null;
        tenant: string;
        tile: number;
        webhook?: import("../types/contract.js").components["schemas"]["DeliveryView"] | null;
        width: number;
    };
    get id(): string;
    get state(): "failed" | "succeeded" | "canceled" | "running" | "expired" | "queued";
    /**
     * Asks for it again.
     * @param {{ wait?: number } & import("./client.js").Given} [options] `wait`: seconds to wait for its end
     */
    refresh({ wait, signal }?: {
        wait?: number;
    } & import("./client.js").Given): Promise<this>;
    /**
     * What happens to it, until it has ended. A stream that breaks goes on after the last event.
     * @param {{ since?: string } & import("./client.js").Given} [options]
     * @returns {AsyncGenerator<JobEvent, void>}
     */
    events({ since, signal }?: {
        since?: string;
    } & import("./client.js").Given): AsyncGenerator<JobEvent, void>;
    /**
     * How far it is, until it has ended.
     * @param {import("./client.js").Given} [given]
     * @returns {AsyncGenerator<Progress, void>}
     */
    progress({ signal }?: import("./client.js").Given): AsyncGenerator<Progress, void>;
    /**
     * Waits for its end; its picture. Rejects with a `Problem` if there is none, with a `TimeoutError` after so many seconds:
     * at once after 0 or less, never after `Infinity`.
     * @param {{ timeout?: number, onProgress?: (progress: Progress) => void } & import("./client.js").Given} [options]
     */
    wait({ timeout, onProgress, signal }?: {
        timeout?: number;
        onProgress?: (progress: Progress) => void;
    } & import("./client.js").Given): Promise<import("./picture.js").Picture>;
    /**
     * Its picture, if it has succeeded.
     * @param {import("./client.js").Given} [given]
     */
    result({ signal }?: import("./client.js").Given): Promise<import("./picture.js").Picture>;
    /**
     * The finished frames of a sequence, with what each cost and how far it may be off.
     * @param {import("./client.js").Given} [given]
     * @returns {Promise<Schemas["FrameList"]>}
     */
    frames({ signal }?: import("./client.js").Given): Promise<Schemas["FrameList"]>;
    /**
     * A frame of a sequence, from 0, as soon as it is finished.
     * @param {number} number
     * @param {import("./client.js").Given} [given]
     */
    frame(number: number, { signal }?: import("./client.js").Given): Promise<import("./picture.js").Picture>;
    /**
     * All frames of a sequence that has succeeded.
     * @param {{ format?: "png" | "webp" | "gif" } & import("./client.js").Given} [options]
     */
    animation({ format, signal }?: {
        format?: "png" | "webp" | "gif";
    } & import("./client.js").Given): Promise<import("./picture.js").Picture>;
    /**
     * The finished frames of a sequence, small and side by side.
     * @param {{ columns?: number } & import("./client.js").Given} [options]
     */
    sheet({ columns, signal }?: {
        columns?: number;
    } & import("./client.js").Given): Promise<import("./picture.js").Picture>;
    /**
     * The picture so far, at most 1,024 pixels a side; waits for the first coarse one.
     * @param {import("./client.js").Given} [given]
     */
    preview({ signal }?: import("./client.js").Given): Promise<import("./picture.js").Picture>;
    /**
     * A region as soon as it is finished; it is rendered next.
     * @param {readonly [x: number, y: number, width: number, height: number]} region
     * @param {import("./client.js").Given} [given]
     */
    tile([x, y, w, h]: readonly [x: number, y: number, width: number, height: number], { signal }?: import("./client.js").Given): Promise<import("./picture.js").Picture>;
    /**
     * Stops it. One that has ended already rejects with a `Problem`, `conflict`.
     * @param {import("./client.js").Given} [given]
     */
    cancel({ signal }?: import("./client.js").Given): Promise<this>;
    /**
     * Changes its priority.
     * @param {number} priority 0 to 100
     * @param {import("./client.js").Given} [given]
     */
    prioritize(priority: number, { signal }?: import("./client.js").Given): Promise<this>;
    /**
     * Forgets it and its picture.
     * @param {import("./client.js").Given} [given]
     */
    delete({ signal }?: import("./client.js").Given): Promise<void>;
    #private;
}
export type Schemas = import("../types/contract.js").components["schemas"];
/**
 * What has happened to a job. `name`: snapshot, queued, started, preview, tile, progress, succeeded, failed, canceled.
 */
export type JobEvent = {
    name: string;
    id: string;
    data: Record<string, any>;
};
/**
 * How far a job is.
 */
export type Progress = {
    state: string;
    /**
     * From 0 to 1.
     */
    fraction: number;
    tilesDone: number;
    tilesTotal: number;
    /**
     * Milliseconds until the end, estimated.
     */
    etaMs: number | null;
};
