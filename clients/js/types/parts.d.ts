/**
 * A picture on its way. Each of its pixels stands for `scale` x `scale` of those of `region`.
 * @typedef {object} Pass
 * @property {Picture} picture
 * @property {number} scale
 * @property {[x: number, y: number, width: number, height: number] | null} region null for the picture itself
 * @property {boolean} final Whether this is the picture itself, to the bytes of `Client.render`.
 * @property {number | null} etaMs Milliseconds until the end, estimated.
 * @property {import("../types/contract.js").components["schemas"]["CostReport"] | null} report of the picture itself
 */
/**
 * The pictures in an answer of `multipart/mixed` (RFC 2046), until the last one; it may be torn before.
 * @param {AsyncIterable<Uint8Array> | Iterable<Uint8Array>} answer
 * @returns {AsyncGenerator<Pass, void>}
 */
export function passes(answer: AsyncIterable<Uint8Array> | Iterable<Uint8Array>): AsyncGenerator<Pass, void>;
/**
 * A picture on its way. Each of its pixels stands for `scale` x `scale` of those of `region`.
 */
export type Pass = {
    picture: Picture;
    scale: number;
    /**
     * null for the picture itself
     */
    region: [x: number, y: number, width: number, height: number] | null;
    /**
     * Whether this is the picture itself, to the bytes of `Client.render`.
     */
    final: boolean;
    /**
     * Milliseconds until the end, estimated.
     */
    etaMs: number | null;
    /**
     * of the picture itself
     */
    report: import("../types/contract.js").components["schemas"]["CostReport"] | null;
};
import { Picture } from "./picture.js";
