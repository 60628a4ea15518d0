//! The connection of one client: requests in, ticks and states out.

use std::sync::Arc;
use std::time::{Duration, Instant};

use axum::body::Bytes;
use axum::extract::ws::rejection::WebSocketUpgradeRejection;
use axum::extract::ws::{Message, WebSocket, WebSocketUpgrade};
use axum::extract::{ConnectInfo, Query, State};
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse as _, Response};
use serde::Deserialize;
use serde_json::{Value, json};
use tokio::time::{MissedTickBehavior, interval, timeout};

use super::listener::Peer;
use super::request::Request;
use super::seats::Seat;
use super::session::Session;
use super::{STUCK, Server};

/// Interval of the ticks.
const TICK: Duration = Duration::from_millis(40);
/// Number of ticks per state message.
const STATES: u32 = 6;
/// Number of ticks per ping. The client's browser answers; a client that only watches sends nothing else.
const PINGS: u32 = 500;
/// Longest request, bytes.
const LONGEST: usize = 16 * 1024;
/// Allowed requests: per second on average, and in one burst.
const REQUESTS: (f64, f64) = (60.0, 240.0);

/// The token, if one is required.
#[derive(Deserialize)]
pub struct Ticket {
    token: Option<String>,
}

pub async fn socket(
    State(server): super::State,
    ConnectInfo(Peer(address)): ConnectInfo<Peer>,
    Query(ticket): Query<Ticket>,
    headers: HeaderMap,
    upgrade: Result<WebSocketUpgrade, WebSocketUpgradeRejection>,
) -> Response {
    if let Err(refusal) = server.shared.config.access.check(&headers, ticket.token.as_deref()) {
        return refusal.into_response();
    }
    let full = || {
        let why = "too many clients are connected";
        (StatusCode::SERVICE_UNAVAILABLE, why).into_response()
    };
    // A browser does not report the reason of a refusal to the page. The page therefore repeats the request without an
    // upgrade.
    let upgrade = match upgrade {
        Ok(upgrade) => upgrade,
        Err(_) if !server.clients.has_room(address.ip()) => return full(),
        Err(rejection) => return rejection.into_response(),
    };
    let Some(seat) = server.clients.take(address.ip()) else { return full() };
    upgrade
        .max_message_size(LONGEST)
        .max_frame_size(LONGEST)
        .max_write_buffer_size(8 << 20)
        .on_upgrade(move |socket| converse(socket, server, seat))
}

/// Requests that the client may still send.
struct Allowance {
    left: f64,
    at: Instant,
}

impl Allowance {
    fn spend(&mut self) -> bool {
        let now = Instant::now();
        let earned = REQUESTS.0 * now.duration_since(self.at).as_secs_f64();
        self.left = (self.left + earned).min(REQUESTS.1) - 1.0;
        self.at = now;
        self.left >= 0.0
    }
}

async fn converse(mut socket: WebSocket, server: Arc<Server>, mut seat: Seat) {
    let mut session = Session::new(Arc::clone(&server.shared));
    let mut allowance = Allowance { left: REQUESTS.1, at: Instant::now() };
    let mut ticks = interval(TICK);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let (mut count, mut before) = (0u32, Instant::now());
    if !send(&mut socket, &session.hello()).await {
        return;
    }
    loop {
        tokio::select! {
            () = seat.lost() => {
                let why = "found too many clients; this connection gave its place to another address";
                send(&mut socket, &json!({"error": why})).await;
                return;
            }
            received = socket.recv() => {
                let Some(Ok(message)) = received else { return };
                // Every message counts, also a ping, because the server must read it.
                if !allowance.spend() {
                    send(&mut socket, &json!({"error": "found too many requests; this connection is closed"})).await;
                    return;
                }
                let text = match &message {
                    Message::Text(text) => text.as_str(),
                    Message::Close(_) => return,
                    _ => continue,
                };
                let answer = match Request::parse(text) {
                    // The request may read and write files; the other threads continue during this time.
                    Ok(request) => tokio::task::block_in_place(|| session.handle(request)),
                    Err(why) => Err(why),
                };
                let answer = match answer {
                    Ok(None) => continue,
                    Ok(Some(answer)) => answer,
                    Err(why) => json!({"error": why}),
                };
                if !send(&mut socket, &answer).await {
                    return;
                }
            }
            _ = ticks.tick() => {
                let now = Instant::now();
                let elapsed_s = now.duration_since(before).as_secs_f64();
                before = now;
                if !send(&mut socket, &session.tick(elapsed_s)).await {
                    return;
                }
                if count.is_multiple_of(STATES) && !send(&mut socket, &session.state()).await {
                    return;
                }
                let pings = count % PINGS == PINGS - 1;
                if pings && !pass(&mut socket, Message::Ping(Bytes::new())).await {
                    return;
                }
                count = count.wrapping_add(1);
            }
        }
    }
}

/// Sends a message. Returns whether the client received it in time.
async fn send(socket: &mut WebSocket, message: &Value) -> bool {
    pass(socket, Message::Text(message.to_string().into())).await
}

async fn pass(socket: &mut WebSocket, message: Message) -> bool {
    matches!(timeout(STUCK, socket.send(message)).await, Ok(Ok(())))
}
