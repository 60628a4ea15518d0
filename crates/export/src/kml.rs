//! KML: the track with its times and attitude.
//!
//! # Source
//! OGC KML 2.2 (07-147r2); Google's extension namespace 2.2, `gx:Track`.

use std::io::{self, Write};

use hovernav::ekf::Solution;
use hovernav::time::Time;

use crate::Export;
use crate::text::{Escaped, thinned, xml_date};

/// Google Earth shows no more of a track than this many a second, s.
const INTERVAL_S: f64 = 0.2;

pub fn write(export: &Export<'_>, out: &mut impl Write) -> io::Result<()> {
    let name = Escaped(export.name);
    writeln!(out, r#"<?xml version="1.0" encoding="UTF-8"?>"#)?;
    writeln!(
        out,
        r#"<kml xmlns="http://www.opengis.net/kml/2.2" xmlns:gx="http://www.google.com/kml/ext/2.2">"#
    )?;
    writeln!(out, "<Document><name>{name}</name>")?;
    writeln!(
        out,
        "<Style id=\"track\"><LineStyle><color>ffb27200</color><width>3</width></LineStyle></Style>"
    )?;
    writeln!(out, "<Placemark><name>{name}</name><styleUrl>#track</styleUrl>")?;
    // Ellipsoidal heights taken for heights above the sea lie by the geoid's height off the ground.
    writeln!(out, "<description>Heights are above the ellipsoid.</description>")?;
    writeln!(out, "<gx:Track><altitudeMode>absolute</altitudeMode>")?;
    let times: Vec<Time> = export.solutions.iter().map(|solution| solution.time).collect();
    let shown: Vec<&Solution> =
        thinned(&times, INTERVAL_S).map(|index| &export.solutions[index]).collect();
    for solution in &shown {
        writeln!(out, "<when>{}</when>", xml_date(solution.time))?;
    }
    for Solution { position, .. } in &shown {
        let (longitude, latitude) = (position.longitude_deg(), position.latitude_deg());
        writeln!(
            out,
            "<gx:coord>{longitude:.8} {latitude:.8} {:.3}</gx:coord>",
            position.height_m
        )?;
    }
    for solution in &shown {
        let [roll, pitch, yaw] = solution.body_to_ned.euler().to_degrees();
        // KML's tilt is positive nose up, its roll positive to the left.
        let (heading, roll) = (yaw.rem_euclid(360.0), -roll);
        writeln!(out, "<gx:angles>{heading:.3} {pitch:.3} {roll:.3}</gx:angles>")?;
    }
    writeln!(out, "</gx:Track></Placemark></Document></kml>")
}
