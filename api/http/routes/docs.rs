//! `/docs`: the contract as a page. The program contains all of it, so that it works without a network.

use crate::http::extract::accept::takes_gzip;
use crate::http::prelude::*;
use flate2::read::GzDecoder;
use std::io::Read;

pub(super) fn routes() -> Vec<Route> {
    vec![
        Route::get("/docs", page, ["docs", "service", "The contract as a page, which works without a network."])
            .answer(200, "The page", &[Content::text("text/html")]),
        Route::get("/docs/rapidoc.js", viewer, ["docsViewer", "service", "The program that `/docs` runs."]).answer(
            200,
            "JavaScript",
            &[Content::text("text/javascript")],
        ),
    ]
}

/// RapiDoc 9.3.8, MIT, from npm: `package/dist/rapidoc-min.js.gz`, unchanged. Its licence is beside it.
const VIEWER: &[u8] = include_bytes!("../../docs/rapidoc-9.3.8.min.js.gz");
/// The page may run the viewer and read the contract, and nothing else.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'unsafe-inline'; connect-src 'self'; \
                      img-src 'self' data: blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
/// The viewer changes only with the program.
const DAY: &str = "public, max-age=86400";

const PAGE: &str = r#"<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>strahl: the service</title>
<script type="module" src="/docs/rapidoc.js"></script>
</head>
<body style="margin: 0">
<rapi-doc spec-url="/openapi.json" load-fonts="false" render-style="read" schema-style="tree" show-header="false"
  allow-spec-url-load="false" allow-spec-file-load="false" theme="light"></rapi-doc>
<noscript>The contract is at <a href="/openapi.json">/openapi.json</a>.</noscript>
</body>
</html>
"#;

async fn page() -> impl IntoResponse {
    ([(header::CONTENT_TYPE, "text/html; charset=utf-8"), (header::CONTENT_SECURITY_POLICY, POLICY)], PAGE)
}

async fn viewer(headers: HeaderMap) -> Response {
    let about = [(header::CONTENT_TYPE, "text/javascript; charset=utf-8"), (header::CACHE_CONTROL, DAY)];
    let about = (about, [(header::VARY, "Accept-Encoding")]);
    if takes_gzip(&headers) {
        return (about, [(header::CONTENT_ENCODING, "gzip")], VIEWER).into_response();
    }
    let mut plain = Vec::new();
    // The bytes are part of the program; a test reads them.
    let _ = GzDecoder::new(VIEWER).read_to_end(&mut plain);
    (about, plain).into_response()
}
