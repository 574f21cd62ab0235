/**
 * Anything that this package throws, but for `AbortError` and `TimeoutError` of the platform, and its `TypeError` and `RangeError`
 * for an argument that cannot be sent.
 */
export class StrahlError extends Error {
}
/** The service does not answer, or its answer broke off, also when asked again. */
export class ConnectionError extends StrahlError {
}
/** What arrived is not what the service has sent. */
export class DamagedError extends StrahlError {
}
/**
 * One thing that is wrong with a request or a scene.
 * @typedef {object} Mistake
 * @property {string} code
 * @property {string} detail
 * @property {string} [pointer] Where it is in the scene: a JSON pointer, such as `/objects/3/sphere/radius`.
 * @property {string} [parameter] The query parameter that is wrong.
 * @property {number} [line] Line in the body, from 1.
 * @property {number} [column] Column in the line, from 1.
 */
/** An answer that is a problem (RFC 9457). `slug` says which kind: `/problems/{slug}` of the service explains it. */
export class Problem extends StrahlError {
    /**
     * @param {number} status
     * @param {unknown} document what the service said; an answer of a proxy may be anything
     * @param {number} [retryAfter]
     * @param {boolean} [isGateway]
     */
    constructor(status: number, document: unknown, retryAfter?: number, isGateway?: boolean);
    status: number;
    /** The whole document. */
    document: Record<string, unknown>;
    /** What kind it is, such as `invalid-scene`. */
    slug: string;
    detail: string;
    /** The request's id, which the log of the service has, too. */
    requestId: string;
    /** What is wrong, one by one. */
    mistakes: Mistake[];
    /** How many more there are. */
    more: number;
    /** The limit that was exceeded. */
    limit: {
        name: string;
        max: number;
    } | undefined;
    /** Seconds to wait before the next try. */
    retryAfter: number | undefined;
    /** Whether it is a server error of something before the service, whose own are documents. */
    isGateway: boolean;
    /** Whether the same request may do later. */
    get isBusy(): boolean;
}
/**
 * One thing that is wrong with a request or a scene.
 */
export type Mistake = {
    code: string;
    detail: string;
    /**
     * Where it is in the scene: a JSON pointer, such as `/objects/3/sphere/radius`.
     */
    pointer?: string | undefined;
    /**
     * The query parameter that is wrong.
     */
    parameter?: string | undefined;
    /**
     * Line in the body, from 1.
     */
    line?: number | undefined;
    /**
     * Column in the line, from 1.
     */
    column?: number | undefined;
};
