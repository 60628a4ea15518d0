//! Faults of the GPS receiver.

use std::f64::consts::TAU;

use super::catalogue::Kind;
use super::fault::Fault;
use super::table::Table;
use super::window::Window;
use crate::noise::Noise;

const VELOCITY: [&str; 3] = ["vn_mps", "ve_mps", "vd_mps"];

/// Metres per degree of latitude, accurate enough for a glitch (the ellipsoid's value differs by less than 0.6 %).
const M_PER_DEG: f64 = 111_320.0;

/// Ratio of the standard deviation of the random height to that of the random position north or east.
const GARBAGE_HEIGHT: f64 = 2.5;
/// Standard deviation of the random velocity, north, east and down, divided by that of north and east position, 1/s.
const GARBAGE_VELOCITY_PER_S: [f64; 3] = [0.2, 0.2, 0.75];
/// Correlation time of random position and height, s. Consecutive fixes of a 1 Hz receiver differ greatly, and some
/// resemble motion.
const GARBAGE_POSITION_TIME_S: f64 = 2.5;
/// Correlation time of random velocity, s.
const GARBAGE_VELOCITY_TIME_S: f64 = 0.7;

/// `gps.csv` with its columns.
pub(super) struct Satellite<'a> {
    table: &'a mut Table,
    time: usize,
    position: [usize; 3],
}

impl<'a> Satellite<'a> {
    /// The position columns of `table`; `None` where it has none.
    pub fn of(table: &'a mut Table) -> Option<Self> {
        let time = table.column("t_s")?;
        let position = table.columns(["lat_deg", "lon_deg", "height_m"])?;
        Some(Self { table, time, position })
    }

    /// Applies `fault`; false where it is not a fault of the receiver.
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
                // The position moves away during the first half of the time, then back.
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
            Kind::GpsGarbage => self.scatter(&rows, number, noise),
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

    /// Displaces the positions towards `[north, east]` by the distance `by` of the time, m, and changes the velocities,
    /// m/s.
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

    /// Adds random Gauss-Markov errors to position, height and velocity, with `size_m` as one sigma north and east.
    fn scatter(&mut self, rows: &[usize], size_m: f64, noise: &mut Noise) {
        let [lat, lon, height] = self.position;
        let mut last_s = f64::NEG_INFINITY;
        let mut value = [0.0; 6];
        for &row in rows {
            let time_s = self.table.get(row, self.time);
            for (channel, value) in value.iter_mut().enumerate() {
                let correlation_s =
                    if channel < 3 { GARBAGE_POSITION_TIME_S } else { GARBAGE_VELOCITY_TIME_S };
                let decay = (-(time_s - last_s) / correlation_s).exp().min(1.0);
                *value = *value * decay + (1.0 - decay * decay).sqrt() * noise.normal();
            }
            last_s = time_s;
            let [north, east, up, velocity @ ..] = value.map(|value| value * size_m);
            let narrowing = self.table.get(row, lat).to_radians().cos();
            self.table.change(row, lat, |value| value + north / M_PER_DEG);
            self.table.change(row, lon, |value| value + east / (M_PER_DEG * narrowing));
            self.table.change(row, height, |value| value + GARBAGE_HEIGHT * up);
            for ((name, share), part) in VELOCITY.iter().zip(GARBAGE_VELOCITY_PER_S).zip(velocity) {
                if let Some(column) = self.table.column(name) {
                    self.table.change(row, column, |value| value + share * part);
                }
            }
        }
    }

    /// Repeats the values of the columns `names` in the row before the first of `rows`.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Stream;

    const HEADER: &str = "t_s,lat_deg,lon_deg,height_m,vn_mps,ve_mps,vd_mps,sigma_h_m,sigma_v_m\n";

    /// Errors by `fault` in 4000 fixes of one position, 1 s apart: three in m, three in m/s.
    fn errors(fault: &str, seed: u64) -> Vec<[f64; 6]> {
        let rows = (0..4000).map(|second| format!("{second},0,0,50,0,0,0,1.7,3.1\n"));
        let mut table = Table::parse(&(HEADER.to_owned() + &rows.collect::<String>())).unwrap();
        let fault: Fault = fault.parse().unwrap();
        let mut noise = Noise::new(seed, Stream::Fault);
        let window = Window { start_s: 500.0, duration_s: 3000.0 };
        assert!(Satellite::of(&mut table).unwrap().make(&fault, window, &mut noise));
        let sigmas = table.columns(["sigma_h_m", "sigma_v_m"]).unwrap();
        let at = |row, name| table.get(row, table.column(name).unwrap());
        let row = |row| {
            assert_eq!(sigmas.map(|column| table.get(row, column)), [1.7, 3.1]);
            let degrees = ["lat_deg", "lon_deg"].map(|name| at(row, name) * M_PER_DEG);
            let height = at(row, "height_m") - 50.0;
            let [vn, ve, vd] = VELOCITY.map(|name| at(row, name));
            [degrees[0], degrees[1], height, vn, ve, vd]
        };
        (0..4000).map(row).collect()
    }

    #[test]
    fn garbage_has_the_one_sigmas_that_the_catalogue_lists_and_leaves_the_stated_ones_alone() {
        let errors = errors("gps-garbage=40", 3);
        let wanted = [40.0, 40.0, 100.0, 8.0, 8.0, 30.0];
        for (channel, wanted) in wanted.into_iter().enumerate() {
            let inside = errors[500..3500].iter().map(|errors| errors[channel].powi(2));
            let sigma = (inside.sum::<f64>() / 3000.0).sqrt();
            // 3000 s are 600 independent samples: the sigma is accurate to 3 %, one sigma.
            assert!((sigma / wanted - 1.0).abs() < 0.1, "{channel}: {sigma}, expected {wanted}");
            let lag = errors[500..3499].iter().zip(&errors[501..3500]);
            let product: f64 = lag.map(|(a, b)| a[channel] * b[channel]).sum::<f64>() / 2999.0;
            let expected = (-1.0 / if channel < 3 { 2.5 } else { 0.7f64 }).exp();
            assert!((product / wanted.powi(2) - expected).abs() < 0.1, "{channel}: {product}");
        }
        let outside = errors[..500].iter().chain(&errors[3500..]);
        assert!(outside.flatten().all(|error| *error == 0.0));
    }

    #[test]
    fn garbage_of_no_size_changes_nothing_and_a_seed_gives_the_same_garbage_again() {
        assert!(errors("gps-garbage=0", 1).iter().flatten().all(|error| *error == 0.0));
        assert_eq!(errors("gps-garbage=40", 5), errors("gps-garbage=40", 5));
        assert_ne!(errors("gps-garbage=40", 5), errors("gps-garbage=40", 6));
    }
}
