//! The server of the page and of its requests.

mod access;
mod assets;
mod client;
mod config;
mod download;
mod listener;
mod request;
mod seats;
mod session;
mod shared;

pub use access::Access;
pub use config::ServerConfig;
pub use request::Request;

use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use axum::Router;
use axum::http::HeaderValue;
use axum::http::header::{
    CACHE_CONTROL, CONTENT_SECURITY_POLICY, HeaderName, REFERRER_POLICY, X_CONTENT_TYPE_OPTIONS,
};
use axum::middleware::{self, Next};
use axum::response::Response;
use axum::routing::get;
use tokio::net::TcpListener;
use tokio::sync::Semaphore;

use crate::link::SharedStation;
use listener::{Limited, Peer};
use seats::Seats;
use shared::Shared;

/// Largest number of clients.
pub const CLIENTS: usize = 32;
/// Interval at which the server checks whether to stop.
const LOOK: Duration = Duration::from_millis(50);
/// Largest number of connections. Each client has one connection, and uses further connections for pages and files.
const CONNECTIONS: usize = 128;
/// Largest number of simultaneous exports.
const EXPORTS: usize = 4;
/// Time after which a client that receives nothing is disconnected.
const STUCK: Duration = Duration::from_secs(5);

/// The state shared by the handlers.
struct Server {
    shared: Arc<Shared>,
    clients: Seats,
    /// Slots for exports.
    exports: Arc<Semaphore>,
}

type State = axum::extract::State<Arc<Server>>;

/// A listening server, ready to run.
pub struct Bound {
    listener: std::net::TcpListener,
    server: Arc<Server>,
    address: SocketAddr,
}

impl Bound {
    /// Starts to listen.
    ///
    /// # Errors
    /// If the address cannot be bound.
    pub fn new(config: ServerConfig, station: SharedStation) -> io::Result<Self> {
        let listener = std::net::TcpListener::bind(config.address)?;
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        let server = Server {
            shared: Arc::new(Shared::new(station, config)),
            clients: Seats::new(CLIENTS),
            exports: Arc::new(Semaphore::new(EXPORTS)),
        };
        Ok(Self { listener, server: Arc::new(server), address })
    }

    /// The address on which the server listens.
    #[must_use]
    pub const fn address(&self) -> SocketAddr {
        self.address
    }

    /// Serves until `stop` is set.
    ///
    /// # Errors
    /// Errors of the system.
    pub fn run(self, stop: &AtomicBool) -> io::Result<()> {
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(2)
            .enable_io()
            .enable_time()
            .build()?;
        let served = runtime.block_on(async {
            let listener = TcpListener::from_std(self.listener)?;
            let app = Router::new()
                .route("/", get(assets::page))
                .route("/{file}", get(assets::file))
                .route("/socket", get(client::socket))
                .route("/export.csv", get(download::csv))
                .route("/results/{record}/{*path}", get(download::result))
                .route("/tiles/{z}/{x}/{y}", get(download::tile))
                .layer(middleware::from_fn(guarded))
                .with_state(self.server);
            let app = app.into_make_service_with_connect_info::<Peer>();
            let served = axum::serve(Limited::new(listener, CONNECTIONS), app).into_future();
            tokio::select! {
                result = served => result,
                () = set(stop) => Ok(()),
            }
        });
        // Connected clients do not delay the end.
        runtime.shutdown_background();
        served
    }
}

/// Waits until `stop` is set.
async fn set(stop: &AtomicBool) {
    while !stop.load(Ordering::Relaxed) {
        tokio::time::sleep(LOOK).await;
    }
}

/// Content security policy of a page: it may only send requests to this server.
const POLICY: &str = "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; \
                      frame-ancestors 'none'; form-action 'none'; base-uri 'none'";

/// Adds the common headers to every response.
async fn guarded(request: axum::extract::Request, next: Next) -> Response {
    let mut response = next.run(request).await;
    let headers = response.headers_mut();
    let fixed: [(HeaderName, &'static str); 3] = [
        (X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (REFERRER_POLICY, "no-referrer"),
        (CACHE_CONTROL, "no-store"),
    ];
    for (name, value) in fixed {
        headers.insert(name, HeaderValue::from_static(value));
    }
    headers.entry(CONTENT_SECURITY_POLICY).or_insert(HeaderValue::from_static(POLICY));
    response
}
