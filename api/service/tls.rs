//! The cryptography of TLS connections that the program opens: to object stores, to receivers of webhooks.

/// Names `ring` as the provider of rustls, once for the process. Clients of HTTP cannot be built without one.
pub(crate) fn install_provider() {
    // An error says that there is one already.
    let _ = rustls::crypto::ring::default_provider().install_default();
}
