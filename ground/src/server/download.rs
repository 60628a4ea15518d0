//! Downloads: a time range as CSV, the pages of an evaluation, and the tiles of the map.

use std::io::{self, Read as _};
use std::path::{Component, Path as FilePath};
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};

use axum::body::Body;
use axum::extract::{Path, Query, State};
use axum::http::header::{CONTENT_DISPOSITION, CONTENT_SECURITY_POLICY, CONTENT_TYPE};
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse as _, Response};
use futures_core::Stream;
use hovernav_toml::open_file;
use serde::Deserialize;
use tokio::sync::{OwnedSemaphorePermit, mpsc};
use tokio::time::timeout;

use super::STUCK;
use super::request::channels;
use super::shared::Shared;
use crate::channel::Id;
use crate::csv::Table;
use crate::link::lock;
use crate::player::Loaded;
use crate::store::TextLevel;

/// Largest page that is served, bytes.
const LARGEST: u64 = 64 << 20;

/// The requested range of a source, and the token.
#[derive(Deserialize)]
pub struct Stretch {
    token: Option<String>,
    /// Name of a record; without it, the live vehicle.
    record: Option<String>,
    /// Channel names, separated by commas; without it, all channels.
    channels: Option<String>,
    from: f64,
    to: f64,
}

pub async fn csv(
    State(server): super::State,
    Query(stretch): Query<Stretch>,
    headers: HeaderMap,
) -> Response {
    if let Err(refusal) = server.shared.config.access.check(&headers, stretch.token.as_deref()) {
        return refusal.into_response();
    }
    let Ok(place) = Arc::clone(&server.exports).try_acquire_owned() else {
        let why = "too many exports are running";
        return (StatusCode::SERVICE_UNAVAILABLE, why).into_response();
    };
    let begun = tokio::task::block_in_place(|| begin(&stretch, &server.shared));
    match begun {
        Ok((table, record)) => {
            let (pieces, heard) = mpsc::channel(1);
            tokio::spawn(async move { write(table, record, &server.shared, &pieces, place).await });
            let kind = (CONTENT_TYPE, "text/csv; charset=utf-8");
            let file = (CONTENT_DISPOSITION, "attachment; filename=\"hovernav.csv\"");
            ([kind, file], Body::from_stream(Pieces(heard))).into_response()
        }
        Err(why) => (StatusCode::BAD_REQUEST, why).into_response(),
    }
}

/// The requested table and its record; `None` for the live vehicle.
type Begun = (Table, Option<Arc<Loaded>>);

fn begin(stretch: &Stretch, shared: &Shared) -> Result<Begun, String> {
    let channels = match &stretch.channels {
        Some(names) => channels(names.split(',').take(Id::COUNT + 1))?,
        None => Id::all().collect(),
    };
    let (from, to) = (stretch.from, stretch.to);
    if !(from.is_finite() && to.is_finite() && from <= to) {
        return Err(format!("found {from} to {to} s, expected a time range"));
    }
    let record = stretch.record.as_deref().map(|name| shared.load(name)).transpose()?;
    Ok((Table::new(channels, from, to), record))
}

/// Writes until the table is complete or the client stops reading. `place` is released before the client sees the end.
/// Between two pieces the station continues to receive telemetry.
async fn write(
    mut table: Table,
    record: Option<Arc<Loaded>>,
    shared: &Shared,
    pieces: &mpsc::Sender<Option<String>>,
    place: OwnedSemaphorePermit,
) {
    let send = async |piece| matches!(timeout(STUCK, pieces.send(piece)).await, Ok(Ok(())));
    loop {
        let piece = tokio::task::block_in_place(|| match &record {
            Some(record) => table.piece(&record.store),
            None => table.piece(&lock(&shared.station).store),
        });
        match piece {
            Ok(Some(piece)) => {
                if !send(Some(piece)).await {
                    return;
                }
            }
            Ok(None) => {
                drop(place);
                send(None).await;
                return;
            }
            Err(broken_off) => {
                drop(place);
                let note = format!("export: {broken_off}");
                {
                    let mut station = lock(&shared.station);
                    let at_s = station.now_s();
                    station.note(at_s, TextLevel::Warning, &note);
                }
                if send(Some(format!("# {broken_off}\n"))).await {
                    // If this returned an error at once, the data still in transit would be lost.
                    let _ = timeout(STUCK, pieces.closed()).await;
                }
                return;
            }
        }
    }
}

/// The pieces of a table as a response body. A stream that ends before the final `None` is an error, so that a
/// truncated table is not mistaken for a complete one.
struct Pieces(mpsc::Receiver<Option<String>>);

impl Stream for Pieces {
    type Item = io::Result<String>;

    fn poll_next(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        self.0.poll_recv(context).map(|piece| match piece {
            Some(piece) => piece.map(Ok),
            None => Some(Err(io::ErrorKind::TimedOut.into())),
        })
    }
}

/// The token.
#[derive(Deserialize)]
pub struct Ticket {
    token: Option<String>,
}

pub async fn result(
    State(server): super::State,
    Path((record, path)): Path<(String, String)>,
    Query(ticket): Query<Ticket>,
    headers: HeaderMap,
) -> Response {
    if let Err(refusal) = server.shared.config.access.check(&headers, ticket.token.as_deref()) {
        return refusal.into_response();
    }
    let nothing = || (StatusCode::NOT_FOUND, "found no page of that name").into_response();
    let Ok(root) = server.shared.config.folder.results(&record) else { return nothing() };
    let inside = FilePath::new(&path);
    let plain = |part| matches!(part, Component::Normal(_));
    if inside.extension().is_none_or(|extension| extension != "html")
        || !inside.components().all(plain)
    {
        return nothing();
    }
    let file = root.join(inside);
    // A symbolic link in the directory could point anywhere.
    let is_inside = |file: &FilePath| {
        let (file, root) = (file.canonicalize().ok()?, root.canonicalize().ok()?);
        file.starts_with(root).then_some(())
    };
    let page = tokio::task::block_in_place(|| {
        is_inside(&file)?;
        let mut page = Vec::new();
        open_file(&file, LARGEST).ok()?.take(LARGEST).read_to_end(&mut page).ok()?;
        Some(page)
    });
    match page {
        // The page is sandboxed and cannot send requests to this server.
        Some(page) => {
            let policy = "sandbox allow-scripts allow-downloads; default-src 'none'; \
                          script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:";
            let kind = (CONTENT_TYPE, "text/html; charset=utf-8");
            ([kind, (CONTENT_SECURITY_POLICY, policy)], page).into_response()
        }
        None => nothing(),
    }
}

pub async fn tile(
    State(server): super::State,
    Path([z, x, y]): Path<[String; 3]>,
    Query(ticket): Query<Ticket>,
    headers: HeaderMap,
) -> Response {
    if let Err(refusal) = server.shared.config.access.check(&headers, ticket.token.as_deref()) {
        return refusal.into_response();
    }
    let tiles = server.shared.config.tiles.as_ref();
    match tokio::task::block_in_place(|| tiles?.read(&z, &x, &y)) {
        Some(tile) => ([(CONTENT_TYPE, tile.kind)], tile.bytes).into_response(),
        None => (StatusCode::NOT_FOUND, "found no such tile").into_response(),
    }
}
