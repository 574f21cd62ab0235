/** Longest wait that the service may ask for, in seconds. */
export const PATIENCE: 120;
/** When something is tried again: as the service says, else twice as long each time. */
export class Backoff {
    /** @param {number} retries */
    constructor(retries: number);
    retries: number;
    /**
     * Seconds until the next try; undefined if there is none.
     * @param {unknown} error
     */
    next(error: unknown): number | undefined;
    #private;
}
export function pause(seconds: number, signal?: AbortSignal): Promise<void>;
/**
 * A request.
 * @typedef {object} Asked
 * @property {string} [method]
 * @property {Record<string, unknown>} [query] what is null or undefined is left out
 * @property {Record<string, string>} [headers]
 * @property {BodyInit} [body]
 * @property {boolean} [once] It must not be sent again if it may have been received.
 * @property {number} [patience] Seconds that the service may take beyond the usual.
 * @property {AbortSignal} [signal]
 */
/** How a service is asked. */
export class Connection {
    /**
     * @param {string} url
     * @param {{ key?: string, timeout: number, retries: number, fetch: typeof fetch }} options
     */
    constructor(url: string, { key, timeout, retries, fetch }: {
        key?: string;
        timeout: number;
        retries: number;
        fetch: typeof globalThis.fetch;
    });
    url: string;
    retries: number;
    timeout: number;
    fetch: typeof fetch;
    /** @type {Record<string, string>} */
    headers: Record<string, string>;
    /**
     * Sends a request once. The answer is a success.
     * @param {string} path
     * @param {Asked} asked
     * @param {AbortSignal} [signal]
     */
    send(path: string, { method, query, headers, body }: Asked, signal?: AbortSignal): Promise<Response>;
    /**
     * Asks, again if the service is busy or away, and reads the answer.
     * @template T
     * @param {string} path
     * @param {Asked} asked
     * @param {(answer: Response) => Promise<T>} read
     * @returns {Promise<T>}
     */
    ask<T>(path: string, asked: Asked, read: (answer: Response) => Promise<T>): Promise<T>;
    /**
     * An error of the platform as one of this package.
     * @param {unknown} cause
     */
    shown(cause: unknown): unknown;
}
/**
 * A request.
 */
export type Asked = {
    method?: string | undefined;
    /**
     * what is null or undefined is left out
     */
    query?: Record<string, unknown> | undefined;
    headers?: Record<string, string> | undefined;
    body?: BodyInit | undefined;
    /**
     * It must not be sent again if it may have been received.
     */
    once?: boolean | undefined;
    /**
     * Seconds that the service may take beyond the usual.
     */
    patience?: number | undefined;
    signal?: AbortSignal | undefined;
};
