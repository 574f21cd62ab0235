//! Refuses bodies in transfer codings that the service does not read (RFC 9112 section 6.1).

use crate::http::problem::{Kind, Problem};
use axum::extract::Request;
use axum::http::header;
use axum::middleware::Next;
use axum::response::Response;

/// Refuses a request with another transfer coding than `chunked`. hyper looks only at the last one, and would give handlers a body
/// that is still coded.
pub(crate) async fn check_transfer(request: Request, next: Next) -> Result<Response, Problem> {
    let mut lines = request.headers().get_all(header::TRANSFER_ENCODING).iter();
    match (lines.next(), lines.next()) {
        (None, _) => {}
        (Some(only), None) if only.as_bytes().trim_ascii().eq_ignore_ascii_case(b"chunked") => {}
        _ => {
            let detail = "the only transfer coding is chunked: compressed bodies have Content-Encoding: gzip";
            return Err(Problem::new(Kind::NotImplemented, detail));
        }
    }
    Ok(next.run(request).await)
}
