//! What every request passes on its way to a handler: CORS, the log, the checks of its transfer coding and its host, authorization.

pub(crate) mod auth_gate;
pub(crate) mod cors;
pub(crate) mod host_gate;
pub(crate) mod request_log;
pub(crate) mod transfer_gate;
