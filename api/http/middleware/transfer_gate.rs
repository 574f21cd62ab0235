//! Refuses bodies in transfer codings that the service does not read (RFC 9112 section 6.1).

use crate::http::problem::{Kind, Problem};
use axum::extract::Request;
use axum::http::header;
use axum::middleware::Next;
use axum::response::Response;

/// Refuses a request with another transfer coding than `chunked`. hyper looks only at the last one, and would give handlers a body
/// that is still coded.
pub(crate) async fn check_transfer(request: Request, next: Next) -> Result<Response, Problem> {
    let lines = request.headers().get_all(header::TRANSFER_ENCODING).iter();
    let codings = lines.flat_map(|line| line.as_bytes().split(|byte| *byte == b',')).map(<[u8]>::trim_ascii);
    let codings: Vec<&[u8]> = codings.filter(|coding| !coding.is_empty()).collect();
    if codings.len() > 1 || codings.iter().any(|coding| !coding.eq_ignore_ascii_case(b"chunked")) {
        let detail = "the only transfer coding is chunked: compressed bodies have Content-Encoding: gzip";
        return Err(Problem::new(Kind::NotImplemented, detail));
    }
    Ok(next.run(request).await)
}
