//! GPX 1.1: a track with its times.
//!
//! # Source
//! GPX 1.1 schema, <https://www.topografix.com/GPX/1/1/>.

use std::io::Write as _;

use hovernav::ekf::Solution;

use crate::text::{Escaped, Thinning, xml_date};
use crate::{ExportError, Out, Sink};

/// Interval of the points, s: receivers write GPX once to five times a second, and programs expect that.
const INTERVAL_S: f64 = 0.2;

pub struct Gpx<'w> {
    out: Out<'w>,
    thinning: Thinning,
}

impl<'w> Gpx<'w> {
    pub fn new(name: &str, mut out: Out<'w>) -> Result<Self, ExportError> {
        writeln!(out, r#"<?xml version="1.0" encoding="UTF-8"?>"#)?;
        writeln!(
            out,
            r#"<gpx version="1.1" creator="hovernav" xmlns="http://www.topografix.com/GPX/1/1">"#
        )?;
        writeln!(out, "<trk><name>{}</name><trkseg>", Escaped(name))?;
        Ok(Self { out, thinning: Thinning::to(INTERVAL_S) })
    }

    fn point(&mut self, solution: &Solution) -> Result<(), ExportError> {
        let place = &solution.position;
        writeln!(
            self.out,
            r#"<trkpt lat="{:.9}" lon="{:.9}"><ele>{:.3}</ele><time>{}</time></trkpt>"#,
            place.latitude_deg(),
            place.longitude_deg(),
            place.height_m,
            xml_date(solution.time)
        )?;
        Ok(())
    }
}

impl Sink for Gpx<'_> {
    fn push(&mut self, solution: &Solution) -> Result<(), ExportError> {
        if self.thinning.takes(solution) { self.point(solution) } else { Ok(()) }
    }

    fn finish(mut self: Box<Self>) -> Result<(), ExportError> {
        if let Some(last) = self.thinning.rest() {
            self.point(&last)?;
        }
        writeln!(self.out, "</trkseg></trk></gpx>")?;
        Ok(self.out.flush()?)
    }
}
