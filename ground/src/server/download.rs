//! Files: a stretch as CSV, and the pages that an evaluation made.

use std::path::{Component, Path as FilePath};
use std::sync::PoisonError;

use axum::extract::{Path, Query, State};
use axum::http::header::{CONTENT_DISPOSITION, CONTENT_SECURITY_POLICY, CONTENT_TYPE};
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse as _, Response};
use serde::Deserialize;

use super::Server;
use super::request::channels;
use crate::channel::Id;
use crate::csv;
use crate::link::lock;

/// A greater page is not served, bytes.
const LARGEST: u64 = 64 << 20;

/// What of which source, and the token.
#[derive(Deserialize)]
pub struct Stretch {
    token: Option<String>,
    /// A record's name; without, the vehicle.
    record: Option<String>,
    /// Names with commas between; without, all channels.
    channels: Option<String>,
    from: f64,
    to: f64,
}

pub async fn csv(
    State(server): super::State,
    Query(stretch): Query<Stretch>,
    headers: HeaderMap,
) -> Response {
    if let Err(refusal) = server.access.check(&headers, stretch.token.as_deref()) {
        return refusal.into_response();
    }
    match tokio::task::block_in_place(|| exported(&server, &stretch)) {
        Ok(text) => {
            let kind = (CONTENT_TYPE, "text/csv; charset=utf-8");
            let file = (CONTENT_DISPOSITION, "attachment; filename=\"hovernav.csv\"");
            ([kind, file], text).into_response()
        }
        Err(why) => (StatusCode::BAD_REQUEST, why).into_response(),
    }
}

fn exported(server: &Server, stretch: &Stretch) -> Result<String, String> {
    let channels = match &stretch.channels {
        Some(names) => channels(names.split(',').take(Id::COUNT + 1))?,
        None => Id::all().collect(),
    };
    let (from, to) = (stretch.from, stretch.to);
    if !(from.is_finite() && to.is_finite() && from <= to) {
        return Err(format!("found {from} to {to} s, expected a stretch"));
    }
    let _alone = server.exports.lock().unwrap_or_else(PoisonError::into_inner);
    let columns = match &stretch.record {
        Some(name) => csv::columns(&server.shared.load(name)?.store, &channels, from, to),
        // The vehicle is heard on while the text is written.
        None => csv::columns(&lock(&server.shared.station).store, &channels, from, to),
    };
    csv::table(columns)
        .ok_or_else(|| format!("found more than {} rows, expected a shorter stretch", csv::LONGEST))
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
    if let Err(refusal) = server.access.check(&headers, ticket.token.as_deref()) {
        return refusal.into_response();
    }
    let nothing = || (StatusCode::NOT_FOUND, "found nothing of that name").into_response();
    let Ok(root) = server.shared.folder.results(&record) else { return nothing() };
    let inside = FilePath::new(&path);
    let plain = |part| matches!(part, Component::Normal(_));
    if inside.extension().is_none_or(|extension| extension != "html")
        || !inside.components().all(plain)
    {
        return nothing();
    }
    let file = root.join(inside);
    // A link that somebody put there may lead anywhere.
    let is_inside = |file: &FilePath| {
        let (file, root) = (file.canonicalize().ok()?, root.canonicalize().ok()?);
        file.starts_with(root).then_some(())
    };
    let page = tokio::task::block_in_place(|| {
        is_inside(&file)?;
        let size = std::fs::metadata(&file).ok()?.len();
        if size > LARGEST { None } else { std::fs::read(&file).ok() }
    });
    match page {
        // A page of its own, which cannot ask this server for anything.
        Some(page) => {
            let policy = "sandbox allow-scripts allow-downloads; default-src 'none'; \
                          script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:";
            let kind = (CONTENT_TYPE, "text/html; charset=utf-8");
            ([kind, (CONTENT_SECURITY_POLICY, policy)], page).into_response()
        }
        None => nothing(),
    }
}
