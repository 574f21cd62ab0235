//! The accept loops: a bounded number of connections, each with a deadline for its headers, until the service drains.

use super::activity::Activity;
use super::auth::capability;
use super::auth::client::{self, Ends};
use super::client_socket::ClientSocket;
use super::connection_limit::{ConnectionLimit, Place};
use super::raw_errors::RawErrors;
use super::routes;
use super::settings::HttpSettings;
use super::state::App;
use crate::service::stop_signals::StopSignals;
use axum::Router;
use axum::http::{Method, StatusCode, header};
use futures_util::TryFutureExt;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::graceful::GracefulShutdown;
use std::sync::Arc;
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::time::{sleep, timeout};
use tower::ServiceExt;

/// Bytes of a request's line and headers.
const MAX_HEADER_BYTES: usize = 64 << 10;
/// Headers of a request.
const MAX_HEADERS: usize = 100;
/// Time for the last answers to reach their clients.
const FLUSH: Duration = Duration::from_secs(2);
/// Connections of operators.
const ADMIN_CONNECTIONS: u32 = 64;

/// Serves until a signal comes and the running requests have finished or run out of time.
pub(crate) async fn serve(
    clients: TcpListener,
    admin: Option<TcpListener>,
    signals: StopSignals,
    app: App,
    settings: &HttpSettings,
) {
    // Operators are answered until the very end.
    let admin = admin.map(|listener| {
        announce(&listener, "admin listening");
        let (routes, settings) = (routes::admin(Arc::clone(&app)), settings.clone());
        tokio::spawn(async move {
            let places = Arc::new(ConnectionLimit::new(ADMIN_CONNECTIONS, Some(ADMIN_CONNECTIONS)));
            connections(listener, routes, places, &settings, std::future::pending()).await;
        })
    });
    announce(&clients, "listening");
    log_quick_start(&clients, settings, &app);
    let end = drained(&app, signals, settings.drain_timeout);
    let places = Arc::new(ConnectionLimit::new(settings.max_connections, settings.client_connections));
    connections(clients, routes::router(Arc::clone(&app)), places, settings, end).await;
    if let Some(admin) = admin {
        admin.abort();
    }
    tracing::info!("stopped");
}

fn announce(listener: &TcpListener, what: &str) {
    match listener.local_addr() {
        Ok(address) => tracing::info!("{what} on http://{address}"),
        Err(error) => tracing::warn!(%error, "{what}, but not on a known address"),
    }
}

/// Logs what to do with a service that has just started.
fn log_quick_start(listener: &TcpListener, settings: &HttpSettings, app: &App) {
    let Ok(address) = listener.local_addr() else { return };
    tracing::info!("try: {}", app.first_request(&format!("http://{address}")));
    tracing::info!("documentation: http://{address}/docs");
    if let Some(admin) = settings.admin_listen.filter(|address| !address.ip().is_loopback()) {
        tracing::warn!("other machines can reach --admin-listen {admin}, which asks for no key");
    }
    if !app.service.settings.jobs.durable {
        tracing::info!("jobs end with this process; --data DIR keeps them");
    }
}

/// Accepts connections until the service ends, then gives open ones some time to finish.
async fn connections(
    listener: TcpListener,
    router: Router,
    places: Arc<ConnectionLimit>,
    settings: &HttpSettings,
    end: impl Future<Output = ()>,
) {
    let limits = &settings.limits;
    let connections = GracefulShutdown::new();
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new())
        .header_read_timeout(limits.header_timeout)
        .max_buf_size(MAX_HEADER_BYTES)
        .max_headers(MAX_HEADERS)
        // A client that sends no more may still read: `Activity` knows whether it has gone.
        .half_close(true);

    let mut end = std::pin::pin!(end);
    loop {
        let Accepted { stream, ends, activity, place } = tokio::select! {
            accepted = next_connection(&listener, &places) => accepted,
            () = &mut end => break,
        };
        let socket = ClientSocket::new(Arc::clone(&stream), Arc::clone(&activity), limits.write_timeout);
        let service = {
            let (router, activity) = (router.clone(), Arc::clone(&activity));
            service_fn(move |request| {
                let in_flight = activity.begin(&request);
                let is_head = request.method() == Method::HEAD;
                let request = client::arrived(ends, capability::strip(request));
                router.clone().oneshot(request).map_ok(move |mut response| {
                    if is_head && response.status() == StatusCode::NOT_MODIFIED {
                        // It would be the length of what the client has (RFC 9110, 8.6), which is not 0.
                        response.headers_mut().remove(header::CONTENT_LENGTH);
                    }
                    in_flight.answer(response)
                })
            })
        };
        let connection = http.serve_connection(TokioIo::new(RawErrors::new(socket)), service);
        let connection = connections.watch(connection);
        tokio::spawn(async move {
            tokio::select! {
                served = connection => if let Err(error) = served {
                    tracing::debug!(%error, "connection ended early");
                },
                why = activity.ended(&stream) => tracing::debug!(why, "connection ended early"),
            }
            drop(place);
        });
    }
    // Connections that are still open are idle, sending their last bytes, or out of time.
    if timeout(FLUSH, connections.shutdown()).await.is_err() {
        tracing::warn!("connections were cut off");
    }
}

/// Waits for the signal, then for the requests. Connections are still accepted meanwhile, so that probes learn why.
async fn drained(app: &App, mut signals: StopSignals, patience: Duration) {
    let signal = signals.next().await;
    app.drain.begin();
    tracing::info!(signal, "draining: no new work is taken");
    app.service.jobs.close();
    let done = async {
        app.drain.idle().await;
        app.service.jobs.idle().await;
    };
    tokio::select! {
        () = done => {}
        () = sleep(patience) => tracing::warn!("requests did not finish in time and are given up"),
        signal = signals.next() => tracing::warn!(signal, "a second signal: requests are given up"),
    }
    app.drain.give_up();
}

/// A connection that has a place.
struct Accepted {
    stream: Arc<TcpStream>,
    ends: Ends,
    activity: Arc<Activity>,
    place: Place,
}

async fn next_connection(listener: &TcpListener, places: &Arc<ConnectionLimit>) -> Accepted {
    loop {
        match listener.accept().await {
            Ok((stream, peer)) => {
                let activity = Arc::default();
                let client = peer.ip().to_canonical();
                let Some(place) = places.admit(client, &activity).await else {
                    tracing::debug!(%client, "a connection was refused: its address has as many as it may have");
                    continue;
                };
                let service = stream.local_addr().map_or(client, |address| address.ip().to_canonical());
                return Accepted { stream: Arc::new(stream), ends: Ends { client, service }, activity, place };
            }
            Err(error) => {
                // Usually there are no file descriptors left, and trying again at once would only take processor time.
                tracing::warn!(%error, "a connection was not accepted");
                sleep(Duration::from_millis(50)).await;
            }
        }
    }
}
