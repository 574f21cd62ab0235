//! Where a request comes from. Of tenants whose clients are many, or of the anonymous, one is told from another by that.

use super::tenant::Tenant;
use axum::http::{Extensions, Request};
use std::net::IpAddr;

/// The addresses of a connection.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ends {
    /// The client's, or that of the proxy before it.
    pub(crate) client: IpAddr,
    /// The one by which it has reached the service.
    pub(crate) service: IpAddr,
}

/// A tenant's client.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct Client {
    tenant: String,
    address: Option<IpAddr>,
}

impl Client {
    /// Whose request this is, and where it comes from.
    pub(crate) fn of(extensions: &Extensions) -> Self {
        let address = extensions.get::<Ends>().map(|ends| ends.client);
        Self { tenant: Tenant::of(extensions).name.clone(), address }
    }
}

/// Notes on a request where it comes from.
pub(crate) fn arrived<B>(ends: Ends, mut request: Request<B>) -> Request<B> {
    request.extensions_mut().insert(ends);
    request
}
