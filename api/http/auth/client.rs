//! Where a request comes from. This tells clients of the same tenant apart.

use super::tenant::Tenant;
use axum::http::{Extensions, Request};
use std::net::IpAddr;

/// The addresses of a connection.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ends {
    /// That of the client, or of a proxy before the service.
    pub(crate) client: IpAddr,
    /// The address of the service that the client connected to.
    pub(crate) service: IpAddr,
}

/// A tenant's client.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct Client {
    tenant: String,
    address: Option<IpAddr>,
}

impl Client {
    /// The client of a request.
    pub(crate) fn of(extensions: &Extensions) -> Self {
        let address = extensions.get::<Ends>().map(|ends| ends.client);
        Self { tenant: Tenant::of(extensions).name.clone(), address }
    }
}

/// Puts the addresses into a request's extensions.
pub(crate) fn arrived<B>(ends: Ends, mut request: Request<B>) -> Request<B> {
    request.extensions_mut().insert(ends);
    request
}
