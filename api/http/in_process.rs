//! The service without sockets, for fuzz targets, which ask much more often than sockets allow.

use super::auth::{capability, client, client::Ends};
use super::settings::HttpSettings;
use super::{routes, start};
use crate::service::error::StartError;
use crate::service::limits::Settings;
use crate::service::requests::folders::Folders;
use axum::Router;
use axum::body::{Body, to_bytes};
use axum::extract::Request;
use axum::http::Response;
use clap::Parser;
use std::net::{IpAddr, Ipv4Addr};
use tokio::runtime::Runtime;
use tower::ServiceExt;

/// Both ends of a connection that is none.
const HOME: IpAddr = IpAddr::V4(Ipv4Addr::LOCALHOST);
/// Bytes of an answer.
const MOST: usize = 16 << 20;

#[derive(Debug, Parser)]
struct Flags {
    #[command(flatten)]
    http: HttpSettings,
    #[command(flatten)]
    service: Settings,
}

/// A service, as the client at the other end of a connection sees it.
#[derive(Debug)]
pub(crate) struct InProcess {
    router: Router,
    runtime: Runtime,
    _folders: Folders,
}

impl InProcess {
    /// Starts it with the flags of `strahl serve`.
    pub(crate) fn start(flags: &[&str]) -> Result<Self, StartError> {
        let flags = Flags::parse_from([&["serve"], flags].concat());
        let mut folders = Folders::open(&flags.service)?;
        let app = start::open(Some(1), &flags.http, &flags.service, None, None, &mut folders)?;
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("it starts");
        Ok(Self { router: routes::router(app), runtime, _folders: folders })
    }

    /// Status, headers and body of an answer, as soon as all of it is there.
    pub(crate) fn ask(&self, request: Request<Body>) -> Response<Vec<u8>> {
        let request = client::arrived(Ends { client: HOME, service: HOME }, capability::strip(request));
        self.runtime.block_on(async {
            let Ok(answer) = self.router.clone().oneshot(request).await;
            let (head, body) = answer.into_parts();
            let body = to_bytes(body, MOST).await.expect("all of the answer comes");
            Response::from_parts(head, body.to_vec())
        })
    }
}
