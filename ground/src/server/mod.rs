//! The server: the page, and what it asks for.

mod access;
mod assets;
mod client;
mod download;
mod listener;
mod request;
mod session;
mod shared;

pub use access::Access;
pub use request::Request;

use std::io;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

use axum::Router;
use axum::http::HeaderValue;
use axum::http::header::{
    CACHE_CONTROL, CONTENT_SECURITY_POLICY, HeaderName, REFERRER_POLICY, X_CONTENT_TYPE_OPTIONS,
};
use axum::middleware::{self, Next};
use axum::response::Response;
use axum::routing::get;
use hovernav_log::Manifest;
use tokio::net::TcpListener;
use tokio::sync::Semaphore;

use crate::folder::Folder;
use crate::link::SharedStation;
use listener::Limited;
use shared::Shared;

/// Clients that look at once.
pub const CLIENTS: usize = 32;
/// How often the server looks whether it shall end.
const LOOK: Duration = Duration::from_millis(50);
/// Connections at once: each client has one, and asks for pages and files on others.
const CONNECTIONS: usize = 128;
/// Exports at once.
const EXPORTS: usize = 4;
/// A client that takes nothing for so long is gone.
const STUCK: Duration = Duration::from_secs(5);

/// What the server is set up with.
pub struct ServerConfig {
    /// Where it listens.
    pub address: SocketAddr,
    /// Who may look.
    pub access: Access,
    /// The folder of the records.
    pub folder: Folder,
    /// The command `hovernav`, which evaluates records; `None`: nothing does.
    pub command: Option<PathBuf>,
    /// How the vehicle's sensors are mounted.
    pub manifest: Manifest,
}

/// What the handlers share.
struct Server {
    shared: Arc<Shared>,
    access: Access,
    clients: AtomicUsize,
    /// Places for exports.
    exports: Arc<Semaphore>,
}

type State = axum::extract::State<Arc<Server>>;

/// A server that listens, and is to be run.
pub struct Bound {
    listener: std::net::TcpListener,
    server: Arc<Server>,
    address: SocketAddr,
}

impl Bound {
    /// Listens.
    ///
    /// # Errors
    /// The address cannot be had.
    pub fn new(config: ServerConfig, station: SharedStation) -> io::Result<Self> {
        let listener = std::net::TcpListener::bind(config.address)?;
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        let shared = Shared::new(station, config.folder, config.command, config.manifest);
        let server = Server {
            shared: Arc::new(shared),
            access: config.access,
            clients: AtomicUsize::new(0),
            exports: Arc::new(Semaphore::new(EXPORTS)),
        };
        Ok(Self { listener, server: Arc::new(server), address })
    }

    /// Where it listens.
    #[must_use]
    pub const fn address(&self) -> SocketAddr {
        self.address
    }

    /// Serves until `stop` is set.
    ///
    /// # Errors
    /// What the system says.
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
                .layer(middleware::from_fn(guarded))
                .with_state(self.server);
            let served = axum::serve(Limited::new(listener, CONNECTIONS), app).into_future();
            tokio::select! {
                result = served => result,
                () = set(stop) => Ok(()),
            }
        });
        // Clients that look are not waited for.
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

/// What a page of this server may do: nothing but ask this server.
const POLICY: &str = "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; \
                      frame-ancestors 'none'; form-action 'none'; base-uri 'none'";

/// The headers that every answer has.
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
