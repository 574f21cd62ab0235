/** @typedef {import("../types/contract.js").components["schemas"]} Schemas */
/**
 * A scene: an object, its JSON text, or a file, in bytes or as a `Blob`. The type of a `Blob` says whether it is
 * `application/json`, `text/x-nff`, `application/gzip` or a model (`model/gltf-binary`); models in bytes need none. Or a
 * variation of a scene that the service knows, by a merge patch (RFC 7396).
 * @typedef {Schemas["Scene"] | { base: string, patch: object } | string | BufferSource | Blob} Scene
 */
/** @typedef {string | { scene: Scene, settings?: Settings }} ImageLike an image id, or a scene with settings or without */
/** @typedef {Schemas["Overrides"]} Settings settings over the scene's */
/** @typedef {{ format?: Schemas["PictureOutput"]["format"], bits?: 8 | 16, quality?: number }} Output how a picture is written */
/** @typedef {{ layers?: string }} Layers further layers of an EXR; streams and jobs have none */
/** @typedef {{ signal?: AbortSignal }} Given `signal` gives a request up; the service cancels its work. */
/**
 * A service.
 *
 * Requests to a service that is busy (429, 503) or away are sent again, up to `retries` times, when `Retry-After` says.
 */
export class Client {
    /**
     * @param {string} [url] `http://127.0.0.1:8080` by default
     * @param {{ key?: string, timeout?: number, retries?: number, fetch?: typeof fetch }} [options] `timeout` is in seconds,
     *   for each request, and `Infinity` is no limit; a stream is asked for again if it is silent so long
     */
    constructor(url?: string, { key, timeout, retries, fetch: own }?: {
        key?: string;
        timeout?: number;
        retries?: number;
        fetch?: typeof fetch;
    });
    jobs: Jobs;
    assets: Assets;
    /**
     * The picture of a scene.
     * @param {Scene} scene
     * @param {Settings & Output & Layers} [options]
     * @param {Given} [given]
     */
    render(scene: Scene, options?: Settings & Output & Layers, given?: Given): Promise<import("./picture.js").Picture>;
    /**
     * Pictures from all around a scene or a model, as an animation, or on a sheet of columns and rows. A GIF has 256 colors a frame, and
     * the warnings say how far they are off.
     * @param {Scene} scene
     * @param {Settings & { count?: number, format?: "png" | "webp" | "gif", sheet?: readonly [columns: number, rows: number] }} [options]
     * @param {Given} [given]
     * @returns {Promise<import("./picture.js").Picture>}
     */
    turntable(scene: Scene, { count, format, sheet, ...settings }?: Settings & {
        count?: number;
        format?: "png" | "webp" | "gif";
        sheet?: readonly [columns: number, rows: number];
    }, given?: Given): Promise<import("./picture.js").Picture>;
    /**
     * A region of the picture: the same bytes as in the whole.
     * @param {Scene} scene
     * @param {readonly [x: number, y: number, width: number, height: number]} region
     * @param {Settings & Output & Layers} [options]
     * @param {Given} [given]
     */
    tile(scene: Scene, [x, y, w, h]: readonly [x: number, y: number, width: number, height: number], options?: Settings & Output & Layers, given?: Given): Promise<import("./picture.js").Picture>;
    /**
     * The picture from coarse to fine; the last pass is the picture itself. Who stops listening cancels the render.
     * @param {Scene} scene
     * @param {Settings & Output} [options]
     * @param {Given} [given]
     * @returns {AsyncGenerator<import("./parts.js").Pass, void>}
     */
    stream(scene: Scene, options?: Settings & Output, { signal }?: Given): AsyncGenerator<import("./parts.js").Pass, void>;
    /**
     * The plan: effects, why, and what they should cost.
     * @param {Scene} scene
     * @param {Settings} [options]
     * @param {Given} [given]
     * @returns {Promise<Schemas["Plan"]>}
     */
    explain(scene: Scene, options?: Settings, given?: Given): Promise<Schemas["Plan"]>;
    /**
     * The plan, and what the picture cost.
     * @param {Scene} scene
     * @param {Settings} [options]
     * @param {Given} [given]
     * @returns {Promise<Schemas["Analyzed"]>}
     */
    analyze(scene: Scene, options?: Settings, given?: Given): Promise<Schemas["Analyzed"]>;
    /**
     * The plan, and what the picture should cost with each of up to 32 settings.
     * @param {Scene} scene
     * @param {Settings[]} settings
     * @param {Given} [given]
     * @returns {Promise<Schemas["SettingsEstimates"]>}
     */
    explainEach(scene: Scene, settings: Settings[], { signal }?: Given): Promise<Schemas["SettingsEstimates"]>;
    /**
     * How far b is from a, in codes and as people see it.
     * @param {ImageLike} a
     * @param {ImageLike} b
     * @param {Given} [given]
     * @returns {Promise<Schemas["PictureDifference"]>}
     */
    compare(a: ImageLike, b: ImageLike, { signal }?: Given): Promise<Schemas["PictureDifference"]>;
    /**
     * A picture of how far b is from a: `png` (codes times `gain`), `pfm` (light of b less that of a), `flip`.
     * @param {ImageLike} a
     * @param {ImageLike} b
     * @param {{ format?: "png" | "pfm" | "flip", gain?: number }} [options]
     * @param {Given} [given]
     */
    difference(a: ImageLike, b: ImageLike, { format, gain }?: {
        format?: "png" | "pfm" | "flip";
        gain?: number;
    }, { signal }?: Given): Promise<import("./picture.js").Picture>;
    /**
     * What accuracy costs, measured in so many seconds.
     * @param {Scene} scene
     * @param {Settings & { seconds?: number }} [options]
     * @param {Given} [given]
     * @returns {Promise<Schemas["Tradeoff"]>}
     */
    tradeoff(scene: Scene, options?: Settings & {
        seconds?: number;
    }, given?: Given): Promise<Schemas["Tradeoff"]>;
    /**
     * Warnings about a scene. One with mistakes rejects with a `Problem` that has all of them in `mistakes`.
     * @param {Scene} scene
     * @param {Settings} [options]
     * @param {Given} [given]
     * @returns {Promise<Schemas["SceneProblem"][]>}
     */
    validate(scene: Scene, options?: Settings, given?: Given): Promise<Schemas["SceneProblem"][]>;
    /**
     * A map of the picture: `proved`, `rays`, `time`, `depth`, `samples` of each pixel.
     * @param {Scene} scene
     * @param {string} of
     * @param {Settings & { format?: "png" | "pfm" | "exr", step?: number }} [options]
     * @param {Given} [given]
     */
    map(scene: Scene, of: string, options?: Settings & {
        format?: "png" | "pfm" | "exr";
        step?: number;
    }, given?: Given): Promise<import("./picture.js").Picture>;
    /**
     * The rays behind a pixel.
     * @param {Scene} scene
     * @param {number} x
     * @param {number} y
     * @param {Settings & { all_samples?: boolean }} [options]
     * @param {Given} [given]
     * @returns {Promise<Schemas["RayTree"]>}
     */
    tree(scene: Scene, x: number, y: number, options?: Settings & {
        all_samples?: boolean;
    }, given?: Given): Promise<Schemas["RayTree"]>;
    /**
     * What rays hit.
     * @param {Scene} scene
     * @param {Schemas["RayQuery"][]} queries
     * @param {Settings} [options]
     * @param {Given} [given]
     * @returns {Promise<Schemas["RayAnswer"][]>}
     */
    rays(scene: Scene, queries: Schemas["RayQuery"][], options?: Settings, { signal }?: Given): Promise<Schemas["RayAnswer"][]>;
    /**
     * Stores a scene. The answer has its ids, and the addresses of its picture and tiles.
     * @param {Scene} scene
     * @param {Settings & { zoom?: number }} [options]
     * @param {Given} [given]
     * @returns {Promise<Schemas["KnownScene"]>}
     */
    addScene(scene: Scene, options?: Settings & {
        zoom?: number;
    }, given?: Given): Promise<Schemas["KnownScene"]>;
    /**
     * The picture of an image id.
     * @param {string} id
     * @param {Output} [options]
     * @param {Given} [given]
     */
    image(id: string, { format, ...query }?: Output, { signal }?: Given): Promise<import("./picture.js").Picture>;
    /**
     * A prefix of paths with which pages can read one job, picture or scene without a key.
     * @param {Schemas["CapabilityRequest"]} of
     * @param {Given} [given]
     * @returns {Promise<Schemas["Capability"]>}
     */
    capability(of: Schemas["CapabilityRequest"], { signal }?: Given): Promise<Schemas["Capability"]>;
    /**
     * The text of a stored scene as you have sent it.
     * @param {string} id
     * @param {Given} [given]
     */
    source(id: string, { signal }?: Given): Promise<string>;
    /**
     * Whose key it is, what it may do, and what is left of its limits.
     * @param {Given} [given]
     * @returns {Promise<Schemas["KeyInfo"]>}
     */
    me({ signal }?: Given): Promise<Schemas["KeyInfo"]>;
    /**
     * Who has the renderer and waits for it.
     * @param {Given} [given]
     * @returns {Promise<Schemas["QueueStatus"]>}
     */
    queue({ signal }?: Given): Promise<Schemas["QueueStatus"]>;
    /**
     * What a request may ask for.
     * @param {Given} [given]
     * @returns {Promise<Schemas["AllLimits"]>}
     */
    limits({ signal }?: Given): Promise<Schemas["AllLimits"]>;
    /**
     * The service's version.
     * @param {Given} [given]
     * @returns {Promise<Schemas["Version"]>}
     */
    version({ signal }?: Given): Promise<Schemas["Version"]>;
    #private;
}
export type Schemas = import("../types/contract.js").components["schemas"];
/**
 * A scene: an object, its JSON text, or a file, in bytes or as a `Blob`. The type of a `Blob` says whether it is
 * `application/json`, `text/x-nff`, `application/gzip` or a model (`model/gltf-binary`); models in bytes need none. Or a
 * variation of a scene that the service knows, by a merge patch (RFC 7396).
 */
export type Scene = Schemas["Scene"] | {
    base: string;
    patch: object;
} | string | BufferSource | Blob;
/**
 * an image id, or a scene with settings or without
 */
export type ImageLike = string | {
    scene: Scene;
    settings?: Settings;
};
/**
 * settings over the scene's
 */
export type Settings = Schemas["Overrides"];
/**
 * how a picture is written
 */
export type Output = {
    format?: Schemas["PictureOutput"]["format"];
    bits?: 8 | 16;
    quality?: number;
};
/**
 * further layers of an EXR; streams and jobs have none
 */
export type Layers = {
    layers?: string;
};
/**
 * `signal` gives a request up; the service cancels its work.
 */
export type Given = {
    signal?: AbortSignal;
};
import { Jobs } from "./jobs.js";
import { Assets } from "./assets.js";
