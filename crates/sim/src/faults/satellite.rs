//! Faults of the GPS receiver.

use std::f64::consts::TAU;

use super::catalogue::Kind;
use super::fault::Fault;
use super::table::Table;
use super::window::Window;
use crate::noise::Noise;

const VELOCITY: [&str; 3] = ["vn_mps", "ve_mps", "vd_mps"];

/// Metres in a degree of latitude, to what a glitch needs (the ellipsoid's differs by under 0.6 %).
const M_PER_DEG: f64 = 111_320.0;

/// `gps.csv` with its columns found.
pub(super) struct Satellite<'a> {
    table: &'a mut Table,
    time: usize,
    position: [usize; 3],
}

impl<'a> Satellite<'a> {
    /// `None` where the table has no positions.
    pub fn of(table: &'a mut Table) -> Option<Self> {
        let time = table.column("t_s")?;
        let position = table.columns(["lat_deg", "lon_deg", "height_m"])?;
        Some(Self { table, time, position })
    }

    /// Makes `fault`; false where it is none of the receiver's.
    pub fn make(&mut self, fault: &Fault, window: Window, noise: &mut Noise) -> bool {
        let rows = self.table.rows_in(window);
        let number = fault.number;
        let (sin, cos) = (TAU * noise.uniform()).sin_cos();
        let since = |time_s: f64| time_s - window.start_s;
        match fault.kind {
            Kind::GpsTime => {
                for row in rows {
                    self.table
                        .change(row, self.time, |time_s| ((time_s + number) * 1e9).round() * 1e-9);
                }
            }
            Kind::Outage => rows.iter().for_each(|row| self.table.drop_row(*row)),
            Kind::GlitchStep => self.displace(&rows, [cos, sin], |_| (number, 0.0)),
            Kind::GlitchRamp => self.displace(&rows, [cos, sin], |t| (number * since(t), 0.0)),
            Kind::GlitchFollow => {
                // Out for half the time, and back.
                let half_s = 0.5 * window.duration_s;
                self.displace(&rows, [cos, sin], |t| {
                    let since_s = since(t);
                    if since_s < half_s || !half_s.is_finite() {
                        (number * since_s, number)
                    } else {
                        (number * (2.0 * half_s - since_s), -number)
                    }
                });
            }
            Kind::FrozenFix => {
                self.hold(&rows, &["lat_deg", "lon_deg", "height_m"]);
                self.hold(&rows, &VELOCITY);
            }
            Kind::NoVelocity => self.empty(&rows, &VELOCITY),
            Kind::HeightHeld => self.hold(&rows, &["height_m"]),
            Kind::HeightEmpty => self.empty(&rows, &["height_m"]),
            Kind::SwapLatLon => {
                let [lat, lon, _] = self.position;
                for row in rows {
                    let (latitude, longitude) =
                        (self.table.get(row, lat), self.table.get(row, lon));
                    self.table.change(row, lat, |_| longitude);
                    self.table.change(row, lon, |_| latitude);
                }
            }
            Kind::Radians => {
                let [lat, lon, _] = self.position;
                for row in rows {
                    self.table.change(row, lat, f64::to_radians);
                    self.table.change(row, lon, f64::to_radians);
                }
            }
            _ => return false,
        }
        true
    }

    /// Displaces the positions towards `[north, east]` by what `by` says of the time, m, and the
    /// velocities, m/s.
    fn displace(
        &mut self,
        rows: &[usize],
        [north, east]: [f64; 2],
        by: impl Fn(f64) -> (f64, f64),
    ) {
        let [lat, lon, _] = self.position;
        for &row in rows {
            let (metres, mps) = by(self.table.get(row, self.time));
            let narrowing = self.table.get(row, lat).to_radians().cos();
            self.table.change(row, lat, |value| value + metres * north / M_PER_DEG);
            self.table.change(row, lon, |value| value + metres * east / (M_PER_DEG * narrowing));
            for (name, part) in VELOCITY.into_iter().zip([north, east]) {
                if let Some(column) = self.table.column(name).filter(|_| mps != 0.0) {
                    self.table.change(row, column, |value| value + mps * part);
                }
            }
        }
    }

    /// Repeats what `names` held in the row before the first of `rows`.
    fn hold(&mut self, rows: &[usize], names: &[&str]) {
        let Some(last) = rows.first().map(|first| first.saturating_sub(1)) else { return };
        for column in names.iter().filter_map(|name| self.table.column(name)).collect::<Vec<_>>() {
            let held = self.table.get(last, column);
            for &row in rows {
                self.table.change(row, column, |_| held);
            }
        }
    }

    fn empty(&mut self, rows: &[usize], names: &[&str]) {
        for column in names.iter().filter_map(|name| self.table.column(name)).collect::<Vec<_>>() {
            for &row in rows {
                self.table.set(row, column, f64::NAN);
            }
        }
    }
}
