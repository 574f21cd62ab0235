//! All kinds of problems, in one table. Each has a page.

use axum::http::StatusCode;

/// Makes the enum, the list of all, and their pages from one table.
macro_rules! kinds {
    ($($name:ident = $slug:literal, $status:ident, $title:literal, $advice:literal;)+) => {
        /// Kinds of problems. Each has a page at `/problems/{slug}`.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub(crate) enum Kind {
            $($name,)+
        }

        impl Kind {
            /// All kinds.
            pub(crate) const ALL: &[Self] = &[$(Self::$name,)+];

            /// Its slug, its status, its title, and what to do.
            pub(crate) fn page(self) -> (&'static str, StatusCode, &'static str, &'static str) {
                match self {
                    $(Self::$name => ($slug, StatusCode::$status, $title, $advice),)+
                }
            }
        }
    };
}

kinds! {
    InvalidJson = "invalid-json", BAD_REQUEST, "The body is not JSON",
        "`detail` and `errors` say where the text stops being JSON.";
    InvalidNff = "invalid-nff", BAD_REQUEST, "The body is not Neutral File Format",
        "`errors` says which line is wrong. A scene in JSON needs Content-Type: application/json.";
    InvalidRequest = "invalid-request", UNPROCESSABLE_ENTITY, "The request's JSON is not what is expected",
        "`detail` says what is wrong. What each request takes is described at /openapi.json.";
    InvalidParameter = "invalid-parameter", BAD_REQUEST, "A parameter is wrong",
        "`detail` says what is wrong. `errors`, if it is there, lists every parameter that is unknown, missing or out of range.";
    InvalidScene = "invalid-scene", UNPROCESSABLE_ENTITY, "The scene is not valid",
        "`errors` lists every problem with its JSON pointer, line and column. The format is described at \
         /schema/scene.json.";
    AssetsMissing = "assets-missing", UNPROCESSABLE_ENTITY, "Assets are missing",
        "Send each asset in `missing` with PUT /v1/assets/{sha256}, and then the same request again. An asset that another \
         tenant has sent has to be sent by you, too.";
    AssetMismatch = "asset-mismatch", UNPROCESSABLE_ENTITY, "The bytes have another SHA-256",
        "The hash in the path is that of the bytes before Content-Encoding. POST /v1/assets takes any bytes and says their hash.";
    InvalidRays = "invalid-rays", UNPROCESSABLE_ENTITY, "The rays are not valid",
        "The body is {\"scene\": {...}, \"rays\": [{\"origin\": [0,0,5], \"direction\": [0,0,-1]}]}.";
    UnsupportedMediaType = "unsupported-media-type", UNSUPPORTED_MEDIA_TYPE, "The body's type is not understood",
        "Send application/json, or text/x-nff, or application/gzip for a compressed NFF file. Models are model/gltf-binary, \
         model/gltf+json, model/obj, model/stl or model/ply, and those in several files multipart/form-data.";
    NotAcceptable = "not-acceptable", NOT_ACCEPTABLE, "No acceptable format",
        "`available` lists the formats there are.";
    TooLarge = "too-large", PAYLOAD_TOO_LARGE, "The request is too large",
        "`limit` names the limit. All limits are at /v1/limits. Sending the same again does not help.";
    CostLimit = "cost-limit", PAYLOAD_TOO_LARGE, "The picture is too much work for one answer",
        "`limit` names the limit. Ask for tiles (POST /v1/render/tile), a smaller picture or fewer samples, or submit a job \
         (POST /v1/jobs), which may be larger.";
    InvalidEncoding = "invalid-encoding", BAD_REQUEST, "The body cannot be decompressed",
        "A body with Content-Encoding: gzip has to be a complete gzip file.";
    MalformedRequest = "malformed-request", BAD_REQUEST, "Malformed HTTP request",
        "`detail` says what is wrong. The service speaks HTTP/1.1 without TLS.";
    MisdirectedRequest = "misdirected-request", MISDIRECTED_REQUEST, "The service does not answer under this name",
        "Ask for http://127.0.0.1 and its port. The operator can name another address with --public-url, or give keys.";
    UriTooLong = "uri-too-long", URI_TOO_LONG, "The URI is too long",
        "Scenes go into the body, not into the URI.";
    HeadersTooLarge = "headers-too-large", REQUEST_HEADER_FIELDS_TOO_LARGE, "The headers are too large",
        "Send fewer or smaller headers: at most 100, and 64 KiB together with the request line.";
    Unauthorized = "unauthorized", UNAUTHORIZED, "A key is needed",
        "Send Authorization: Bearer and a key that the operator of this service has made with `strahl key new`.";
    Forbidden = "forbidden", FORBIDDEN, "This is not allowed",
        "`detail` says what the key lacks, what the capability is for, or that the page is of another site.";
    RateLimited = "rate-limited", TOO_MANY_REQUESTS, "Too many requests",
        "Try again after the seconds in the Retry-After header. A request costs a unit, and so does each million \
         rays traced for it; the RateLimit header says how many units are left.";
    NotFound = "not-found", NOT_FOUND, "Not found",
        "Renders are at POST /v1/render.";
    BadIiifRequest = "bad-iiif-request", BAD_REQUEST, "Invalid IIIF request",
        "/iiif/3/{id}/{region}/{size}/{rotation}/{quality}.{format}, as in the IIIF Image API 3.0; info.json says \
         what there is.";
    MethodNotAllowed = "method-not-allowed", METHOD_NOT_ALLOWED, "Wrong method",
        "The Allow header lists the methods there are.";
    Gone = "gone", GONE, "No longer available",
        "Submit the job again.";
    Conflict = "conflict", CONFLICT, "Not in the present state",
        "`detail` says what it is. Jobs that have ended stay as they are, assets stay as long as a job needs them, and a request \
         whose Idempotency-Key is just being used is sent again after the seconds in Retry-After.";
    JobNotFinished = "job-not-finished", CONFLICT, "The job is not done yet",
        "Try again after the seconds in the Retry-After header, or follow the job's events.";
    JobFailed = "job-failed", CONFLICT, "The job has no picture",
        "`detail` says why; so does `problem` of the job.";
    IdempotencyKeyReused = "idempotency-key-reused", UNPROCESSABLE_ENTITY,
        "The idempotency key belongs to another request",
        "Use a new Idempotency-Key for each new job, and the same one only to send the same request again.";
    PreconditionFailed = "precondition-failed", PRECONDITION_FAILED,
        "Precondition failed",
        "A job: another client has changed it; get it again and send the change with its new ETag. A picture: only \
         GET and QUERY answer 304 to a client that has it already. An asset or a scene: nothing was done, since it is there, \
         or is not, or is another.";
    BodyTimeout = "body-timeout", REQUEST_TIMEOUT, "The body took too long to arrive",
        "Send it faster or make it smaller; NFF may be sent compressed.";
    NotImplemented = "not-implemented", NOT_IMPLEMENTED, "The body's transfer coding is not understood",
        "Send the body with Content-Length, or with Transfer-Encoding: chunked and no other coding. A body that is \
         compressed has Content-Encoding: gzip.";
    Saturated = "saturated", SERVICE_UNAVAILABLE, "The service is busy",
        "Try again after the seconds in the Retry-After header.";
    Draining = "draining", SERVICE_UNAVAILABLE, "The service is about to stop",
        "Try again after the seconds in the Retry-After header, or at another instance.";
    RenderDeadline = "render-deadline", GATEWAY_TIMEOUT, "The render took too long",
        "Ask for fewer pixels, tiles, fewer samples, or accuracy=time:MS (the best picture in MS milliseconds). A picture may \
         also be a job, which has no such limit (Prefer: respond-async).";
    Abandoned = "abandoned", INTERNAL_SERVER_ERROR, "The service ended several times while it rendered this",
        "The job may take more memory than there is. Make the picture or the scene smaller; the service's log has more.";
    Internal = "internal", INTERNAL_SERVER_ERROR, "Internal error",
        "The service failed, not the request. Its log has more under the id in `instance`.";
}

impl Kind {
    /// The kind of a name.
    pub(crate) fn by_slug(slug: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|kind| kind.page().0 == slug)
    }
}
