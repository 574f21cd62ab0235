/**
 * A signal that aborts after so many seconds, if they have an end.
 * @param {number} seconds
 */
export function limitOf(seconds: number): AbortSignal | undefined;
/**
 * A signal that aborts with the first of several.
 * @param {(AbortSignal | undefined)[]} signals
 */
export function first(...signals: (AbortSignal | undefined)[]): AbortSignal | undefined;
/**
 * The answer of a service that speaks JSON, which is always an object.
 * @param {Response} answer
 * @returns {Promise<any>}
 */
export function json(answer: Response): Promise<any>;
/**
 * Text for a header, which is checked here: `fetch` would show it in its error.
 * @param {string} what
 * @param {string} text
 */
export function headerValue(what: string, text: string): string;
/** Longest wait that the service may ask for, in seconds. */
export const PATIENCE: 120;
/** When something is tried again: as the service says, else twice as long each time. */
export class Backoff {
    /**
     * @param {number} retries
     * @param {boolean} [following] Whether a job is followed: what a gateway says of a service that it cannot reach is a break then.
     */
    constructor(retries: number, following?: boolean);
    retries: number;
    following: boolean;
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
 * @property {boolean} [following] It follows a job, which goes on whatever a gateway says.
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
    host: string;
    retries: number;
    timeout: number;
    fetch: typeof fetch;
    /** @type {Record<string, string>} */
    headers: Record<string, string>;
    /**
     * Sends a request once. The answer is a success, and no page.
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
     * Sends a request once whose answer comes in parts, of the type that it accepts. The service may be silent for so many seconds:
     * before the answer that is a `TimeoutError`, and within it a `ConnectionError`. Who stops listening closes the connection.
     * @param {string} path
     * @param {Asked & { headers: { accept: string } }} asked
     * @param {number} seconds
     * @returns {Promise<AsyncIterable<Uint8Array> | undefined>} undefined if the answer is empty (204)
     */
    open(path: string, asked: Asked & {
        headers: {
            accept: string;
        };
    }, seconds: number): Promise<AsyncIterable<Uint8Array> | undefined>;
    /**
     * An error of the platform as one of this package.
     * @param {unknown} cause
     */
    shown(cause: unknown): unknown;
}
export function withList(name: string): (answer: Response) => Promise<any>;
export function hexOf(bytes: Uint8Array): string;
export function isObject(value: unknown): boolean;
export function kindOf(answer: Response): string;
export function foreign(answer: Response, wanted: string, cause?: unknown): DamagedError;
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
     * It follows a job, which goes on whatever a gateway says.
     */
    following?: boolean | undefined;
    /**
     * Seconds that the service may take beyond the usual.
     */
    patience?: number | undefined;
    signal?: AbortSignal | undefined;
};
import { DamagedError } from "./problems.js";
