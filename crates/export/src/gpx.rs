//! GPX 1.1: a track with its times.
//!
//! # Source
//! GPX 1.1 schema, <https://www.topografix.com/GPX/1/1/>.

use std::io::{self, Write};

use hovernav::time::Time;

use crate::Export;
use crate::text::{Escaped, thinned, xml_date};

/// What reads GPX expects about one point a second, s.
const INTERVAL_S: f64 = 0.2;

pub fn write(export: &Export<'_>, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, r#"<?xml version="1.0" encoding="UTF-8"?>"#)?;
    writeln!(
        out,
        r#"<gpx version="1.1" creator="hovernav" xmlns="http://www.topografix.com/GPX/1/1">"#
    )?;
    writeln!(out, "<trk><name>{}</name><trkseg>", Escaped(export.name))?;
    let times: Vec<Time> = export.solutions.iter().map(|solution| solution.time).collect();
    for index in thinned(&times, INTERVAL_S) {
        let solution = &export.solutions[index];
        let place = &solution.position;
        writeln!(
            out,
            r#"<trkpt lat="{:.9}" lon="{:.9}"><ele>{:.3}</ele><time>{}</time></trkpt>"#,
            place.latitude_deg(),
            place.longitude_deg(),
            place.height_m,
            xml_date(solution.time)
        )?;
    }
    writeln!(out, "</trkseg></trk></gpx>")
}
