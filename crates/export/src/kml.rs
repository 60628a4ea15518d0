//! KML: the track with its times and attitude.
//!
//! # Source
//! OGC KML 2.2 (07-147r2); Google's extension namespace 2.2, `gx:Track`.

use std::io::Write as _;

use hovernav::earth::Geodetic;
use hovernav::ekf::Solution;
use hovernav::time::Time;

use crate::text::{Escaped, Thinning, xml_date};
use crate::{ExportError, Out, Sink};

/// Interval of the points, s: Google Earth shows at most five a second.
const INTERVAL_S: f64 = 0.2;

/// A point of the track. The file has all times, then all positions, then all attitudes, so the points are stored until
/// its end.
struct Point {
    time: Time,
    position: Geodetic,
    /// Roll, pitch and yaw, °.
    attitude_deg: [f64; 3],
}

pub struct Kml<'w> {
    out: Out<'w>,
    thinning: Thinning,
    points: Vec<Point>,
}

impl<'w> Kml<'w> {
    pub fn new(name: &str, mut out: Out<'w>) -> Result<Self, ExportError> {
        let name = Escaped(name);
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
        // Ellipsoidal heights shown as heights above the sea are off the ground by the height of the geoid.
        writeln!(
            out,
            "<Placemark><name>{name}</name><description>Heights are above the ellipsoid.</description>"
        )?;
        writeln!(out, "<styleUrl>#track</styleUrl>")?;
        writeln!(out, "<gx:Track><altitudeMode>absolute</altitudeMode>")?;
        Ok(Self { out, thinning: Thinning::to(INTERVAL_S), points: Vec::new() })
    }

    fn keep(&mut self, solution: &Solution) {
        let &Solution { time, position, body_to_ned, .. } = solution;
        self.points.push(Point { time, position, attitude_deg: body_to_ned.euler().to_degrees() });
    }
}

impl Sink for Kml<'_> {
    fn push(&mut self, solution: &Solution) -> Result<(), ExportError> {
        if self.thinning.takes(solution) {
            self.keep(solution);
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<(), ExportError> {
        if let Some(last) = self.thinning.rest() {
            self.keep(&last);
        }
        let Self { mut out, points, .. } = *self;
        for point in &points {
            writeln!(out, "<when>{}</when>", xml_date(point.time))?;
        }
        for Point { position, .. } in &points {
            let (longitude, latitude) = (position.longitude_deg(), position.latitude_deg());
            writeln!(
                out,
                "<gx:coord>{longitude:.8} {latitude:.8} {:.3}</gx:coord>",
                position.height_m
            )?;
        }
        for Point { attitude_deg: [roll, pitch, yaw], .. } in points {
            // KML's tilt is positive nose up, its roll positive to the left.
            let (heading, roll) = (yaw.rem_euclid(360.0), -roll);
            writeln!(out, "<gx:angles>{heading:.3} {pitch:.3} {roll:.3}</gx:angles>")?;
        }
        writeln!(out, "</gx:Track></Placemark></Document></kml>")?;
        Ok(out.flush()?)
    }
}
