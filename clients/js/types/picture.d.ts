/**
 * The picture of an answer. What is none is refused, and a file that was damaged on its way, where the platform can tell.
 * @param {Response} answer
 */
export function pictureOf(answer: Response): Promise<Picture>;
/**
 * Refuses an empty file, and compares with a `Repr-Digest` (RFC 9530), if there is one.
 * @param {Uint8Array<ArrayBuffer>} bytes
 * @param {string | null | undefined} header
 */
export function checkDigest(bytes: Uint8Array<ArrayBuffer>, header: string | null | undefined): Promise<void>;
/**
 * How far a picture may be from recursion without end, in codes: steps of an 8-bit channel.
 * @typedef {object} PictureError
 * @property {number | null} proved It is proved that no pixel is further off. Null: nothing is proved, and `why` says why.
 * @property {number | null} identical Share of the pixels that are proved to be identical.
 * @property {number | null} depth The depth of the recursion that it was compared with; null for recursion without end.
 * @property {number | null} estimated Estimated error of sampling.
 * @property {string | null} why
 */
/** A picture as the service sent it. */
export class Picture {
    /**
     * @param {Uint8Array<ArrayBuffer>} bytes
     * @param {Headers} headers
     */
    constructor(bytes: Uint8Array<ArrayBuffer>, headers: Headers);
    /** The file. */
    bytes: Uint8Array<ArrayBuffer>;
    mediaType: string;
    /** @type {PictureError} */
    error: PictureError;
    /** Rays by kind. @type {Record<string, number>} */
    rays: Record<string, number>;
    /** Milliseconds of each phase; empty if the picture existed already. @type {Record<string, number>} */
    timing: Record<string, number>;
    /** The effects that were simulated. */
    effects: string[];
    warnings: string[];
    etag: string | null;
    /** Its id, by which `Client.image` gets it again. */
    imageId: string | null;
    /** Whether the service had it already. */
    cached: boolean;
    /** The file for a page: `URL.createObjectURL(picture.blob())`. */
    blob(): Blob;
    /**
     * The linear light of a PFM, rows from the top. Other formats are for `createImageBitmap(picture.blob())`.
     * @returns {{ width: number, height: number, channels: number, data: Float32Array }}
     */
    floats(): {
        width: number;
        height: number;
        channels: number;
        data: Float32Array;
    };
}
/**
 * How far a picture may be from recursion without end, in codes: steps of an 8-bit channel.
 */
export type PictureError = {
    /**
     * It is proved that no pixel is further off. Null: nothing is proved, and `why` says why.
     */
    proved: number | null;
    /**
     * Share of the pixels that are proved to be identical.
     */
    identical: number | null;
    /**
     * The depth of the recursion that it was compared with; null for recursion without end.
     */
    depth: number | null;
    /**
     * Estimated error of sampling.
     */
    estimated: number | null;
    why: string | null;
};
