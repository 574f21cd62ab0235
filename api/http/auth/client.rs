//! Where a request comes from. Of tenants whose clients are many, or of the anonymous, one is told from another by that.

use super::tenant::Tenant;
use axum::http::{Extensions, Request};
use std::net::IpAddr;

/// The address at the other end of a connection: a client's, or that of the proxy before it.
#[derive(Debug, Clone, Copy)]
struct Peer(IpAddr);

/// A tenant's client.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct Client {
    tenant: String,
    address: Option<IpAddr>,
}

impl Client {
    /// Whose request this is, and where it comes from.
    pub(crate) fn of(extensions: &Extensions) -> Self {
        let address = extensions.get::<Peer>().map(|Peer(address)| *address);
        Self { tenant: Tenant::of(extensions).name.clone(), address }
    }
}

/// Notes on a request where it comes from.
pub(crate) fn arrived<B>(address: IpAddr, mut request: Request<B>) -> Request<B> {
    request.extensions_mut().insert(Peer(address));
    request
}
