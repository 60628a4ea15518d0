//! The page and its scripts, embedded in the program.

use axum::extract::{Path, State};
use axum::http::header::CONTENT_TYPE;
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse as _, Response};

const HTML: &str = "text/html; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";

macro_rules! files {
    ($($name:literal $kind:ident),* $(,)?) => {
        &[$(($name, $kind, include_str!(concat!("../../assets/", $name)))),*]
    };
}

/// The served files: name, content type, text.
const FILES: &[(&str, &str, &str)] = files![
    "index.html" HTML,
    "style.css" STYLE,
    "main.js" SCRIPT,
    "station.js" SCRIPT,
    "plots.js" SCRIPT,
    "chooser.js" SCRIPT,
    "canvas.js" SCRIPT,
    "instruments.js" SCRIPT,
    "map.js" SCRIPT,
    "tiles.js" SCRIPT,
    "panels.js" SCRIPT,
    "warning.js" SCRIPT,
    "records.js" SCRIPT,
    "uPlot.iife.min.js" SCRIPT,
    "uPlot.min.css" STYLE,
];

fn served(name: &str) -> Response {
    match FILES.iter().find(|(own, ..)| *own == name) {
        Some((_, kind, text)) => ([(CONTENT_TYPE, *kind)], *text).into_response(),
        None => (StatusCode::NOT_FOUND, "found no file of that name").into_response(),
    }
}

pub async fn page(State(server): super::State, headers: HeaderMap) -> Response {
    match server.shared.config.access.check_host(&headers) {
        Ok(()) => served("index.html"),
        Err(refusal) => refusal.into_response(),
    }
}

pub async fn file(Path(name): Path<String>) -> Response {
    served(&name)
}
