//! Map tiles: served from a folder, and drawn at their place below the track.

use std::fs;
use std::path::Path;

use crate::common::browser::{Browser, base64, chromium};
use crate::common::{cycle, get, serve, serve_with};
use hovernav_ground::tiles::Tiles;

/// A PNG of 1 by 1 pixel. Source: W3C, *Portable Network Graphics*, second edition.
const PIXEL: &str = "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg==";

fn keep(root: &Path, name: &str, bytes: &[u8]) {
    let file = root.join(name);
    fs::create_dir_all(file.parent().unwrap()).unwrap();
    fs::write(file, bytes).unwrap();
}

#[test]
fn a_tile_is_served_and_a_path_that_leads_elsewhere_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path().join("tiles");
    keep(&root, "3/5/2.png", &base64(PIXEL));
    keep(folder.path(), "secret.png", &base64(PIXEL));
    keep(&root, "3/5/3.png", b"<html>");
    let token = "0123456789abcdef";
    let served = serve_with(Some(token), Some(Tiles::open(&root).unwrap()));
    let ask = |path: &str| get(&served, &format!("{path}?token={token}"));
    let good = ask("/tiles/3/5/2");
    assert!(good.starts_with("HTTP/1.1 200") && good.contains("content-type: image/png"), "{good}");
    assert!(get(&served, "/tiles/3/5/2").starts_with("HTTP/1.1 403"));
    for path in [
        "/tiles/3/5/1",
        "/tiles/3/5/3",
        "/tiles/3/5/2.png",
        "/tiles/3/5/..%2f..%2f..%2fsecret",
        "/tiles/..%2f/./secret",
        "/tiles/%2e%2e/%2e%2e/secret.png",
        "/tiles/../secret.png",
        "/tiles/3/5/2%00",
        "/tiles/3/5//etc/passwd",
        "/tiles/99/5/2",
        "/tiles/3/-5/2",
        "/tiles/3/5/%ff",
    ] {
        assert!(ask(path).starts_with("HTTP/1.1 4"), "{path}");
    }
    assert!(get(&serve(None), "/tiles/3/5/2").starts_with("HTTP/1.1 404"));
}

/// Column and row at zoom level 19 of the centre of the test vehicle's circles, 1.35° north, 103.82° east, by
/// ⌊2¹⁹ (λ + 180°) / 360°⌋ and ⌊2¹⁸ (1 − artanh(sin φ) / π)⌋.
const COLUMN: u32 = 413_342;
/// See [`COLUMN`].
const ROW: u32 = 260_177;

#[test]
fn tiles_are_drawn_at_their_place_below_the_track() {
    let Some(chromium) = chromium() else { return };
    let folder = tempfile::tempdir().unwrap();
    keep(folder.path(), "19/0/0.png", &base64(PIXEL));
    let served = serve_with(None, Some(Tiles::open(folder.path()).unwrap()));
    for number in 0..330 {
        served.receive(&cycle(number), served.start_s + f64::from(number) / 33.0);
    }
    let mut page = Browser::open(&chromium, &format!("http://{}/", served.address), 1400, 950);
    page.wait("station.drawn.place");

    // The formulas, against the closed form and known places.
    let at = |place: &str| format!("station.tileAt({place}).map(Math.floor)");
    assert_eq!(page.eval(&at("1.35, 103.82, 19")), serde_json::json!([COLUMN, ROW]));
    assert_eq!(page.eval(&at("0, 0, 1")), serde_json::json!([1, 1]));
    assert_eq!(page.eval(&at("85.0511, -179.999, 10")), serde_json::json!([0, 0]));
    // Berlin.
    assert_eq!(page.eval(&at("52.52, 13.405, 10")), serde_json::json!([550, 335]));
    let back = "station.tileAt(...station.cornerOf(550, 335, 10), 10)";
    assert!((page.eval(back)[1].as_f64().unwrap() - 335.0).abs() < 1e-6);

    // Tiles of two colours, like a chessboard, around the south-east corner.
    for [column, row] in [[0, 0], [0, 1], [1, 0], [1, 1]].map(|[x, y]| [COLUMN + x, ROW + y]) {
        let colour = if (column + row).is_multiple_of(2) { "#f00" } else { "#00f" };
        let script = format!(
            "(() => {{ const c = document.createElement('canvas'); c.width = c.height = 256; \
             const g = c.getContext('2d'); g.fillStyle = '{colour}'; g.fillRect(0, 0, 256, 256); \
             return c.toDataURL('image/png').split(',')[1]; }})()"
        );
        let png = base64(page.eval(&script).as_str().unwrap());
        keep(folder.path(), &format!("19/{column}/{row}.png"), &png);
    }
    page.call("Page.reload", serde_json::json!({}));
    page.wait("window.station?.drawn.place");
    // All of the geofence, so that the corner of the four tiles is on the map.
    page.click("#track");
    let corner = format!("station.drawn.place(station.cornerOf({COLUMN} + 1, {ROW} + 1, 19))");
    let colour = |east: i32, south: i32| {
        format!(
            "(() => {{ const [x, y] = {corner}; const canvas = document.getElementById('track'); \
             return [...canvas.getContext('2d').getImageData(x + {east}, y + {south}, 1, 1).data]; }})()"
        )
    };
    for [east, south] in [[-3, -3], [3, -3], [-3, 3], [3, 3]] {
        let tile = [COLUMN + u32::from(east > 0), ROW + u32::from(south > 0)];
        let (full, none) = if (tile[0] + tile[1]).is_multiple_of(2) { (0, 2) } else { (2, 0) };
        let pixel = colour(east, south);
        page.wait(&format!("{pixel}[{full}] > 180 && {pixel}[{none}] < 90"));
    }
    page.keep("tiles");
}
