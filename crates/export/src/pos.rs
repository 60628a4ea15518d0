//! RTKLIB's solution file.
//!
//! # Source
//! RTKLIB 2.4.2 manual, appendix B.1: latitude, longitude, height, quality, and standard deviations north, east, up.
//! Quality 5, a solution from a single receiver, is the closest to the solution of an inertial filter. The covariances,
//! in the form of signed roots, are written as zero.

use std::io::Write as _;

use hovernav::ekf::Solution;

use crate::text::date;
use crate::{ExportError, Out, Sink};

pub struct Pos<'w>(Out<'w>);

impl<'w> Pos<'w> {
    pub fn new(mut out: Out<'w>) -> Result<Self, ExportError> {
        writeln!(out, "% program   : hovernav")?;
        writeln!(
            out,
            "% (lat/lon/height=WGS84/ellipsoidal,Q=1:fix,2:float,3:sbas,4:dgps,5:single,6:ppp,ns=# of satellites)"
        )?;
        writeln!(
            out,
            "%  UTC                   latitude(deg) longitude(deg)  height(m)   Q  ns   sdn(m)   sde(m)   \
         sdu(m)  sdne(m)  sdeu(m)  sdun(m) age(s)  ratio"
        )?;
        Ok(Self(out))
    }
}

impl Sink for Pos<'_> {
    fn push(&mut self, solution: &Solution) -> Result<(), ExportError> {
        let place = &solution.position;
        let [north, east, down] = solution.position_sigma_m.to_array();
        writeln!(
            self.0,
            "{} {:14.9} {:14.9} {:10.4} {:3} {:3} {north:8.4} {east:8.4} {down:8.4} {:8.4} {:8.4} {:8.4} \
             {:6.2} {:6.1}",
            date(solution.time).format("%Y/%m/%d %H:%M:%S%.3f"),
            place.latitude_deg(),
            place.longitude_deg(),
            place.height_m,
            5,
            0,
            0.0,
            0.0,
            0.0,
            0.0,
            0.0
        )?;
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<(), ExportError> {
        Ok(self.0.flush()?)
    }
}
