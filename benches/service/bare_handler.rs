//! The least that axum can do: answers that lie in memory, and nothing around them. `load.py` measures strahl beside it.
//!
//! `bare_handler FILE...` takes a free port, prints it, and answers each request to `/0`, `/1` ... with that file, once it
//! has read the request's body, and each to `/unchanged` with 304.
#![allow(clippy::print_stdout, reason = "whoever started it learns the address from it")]

use axum::Router;
use axum::body::Bytes;
use axum::http::{StatusCode, header};
use axum::routing::{any, get};
use std::error::Error;
use tokio::net::TcpListener;

/// As many as strahl has for its sockets.
#[tokio::main(worker_threads = 2)]
async fn main() -> Result<(), Box<dyn Error>> {
    let mut routes = Router::new().route("/unchanged", get(|| async { StatusCode::NOT_MODIFIED }));
    for (number, path) in std::env::args().skip(1).enumerate() {
        let file = Bytes::from(std::fs::read(path)?);
        let answer = move |_: Bytes| async move { ([(header::CONTENT_TYPE, "image/png")], file) };
        routes = routes.route(&format!("/{number}"), any(answer));
    }
    let listener = TcpListener::bind("127.0.0.1:0").await?;
    println!("http://{}", listener.local_addr()?);
    axum::serve(listener, routes).await?;
    Ok(())
}
