//! Differences of two filters, each quantity relative to its tolerance.

use std::collections::BTreeMap;

use hovernav::ekf::layout::{GYRO_BIAS, Layout};
use hovernav::ekf::{Channel, Innovation};

use crate::filter::Filter;
use crate::mechanization::{Earth, Vector};
use crate::shipped::Snapshot;
use crate::transition::Matrix;
use crate::update::Compared;

/// Allowed differences of the shipped filter from the oracle.
#[derive(Clone, Copy, Debug)]
pub struct Tolerance {
    /// Allowed fraction of a value, or of its one-sigma if that is larger; for covariances, of the product of both
    /// one-sigmas.
    pub relative: f64,
    /// Allowed fraction after a fix, which uses the history of steps.
    pub fix: f64,
    /// Allowed difference of two positions, m: latitude and longitude are rounded to 3 nm.
    pub place_m: f64,
    /// Fraction of the former one-sigma that serves as the unit for a state that becomes more accurate than this
    /// fraction in one update. P − K H P then loses digits by cancellation, in any order of its terms.
    pub lost: f64,
}

impl Tolerance {
    pub const DOUBLE: Self = Self { relative: 1e-9, fix: 1e-9, place_m: 2e-8, lost: 3e-3 };
    /// Tolerance for IMUs with more than 198 samples a second. Steps within 10 ms use the same entry of the history.
    /// The shipped filter combines them to second order in the rotation, the oracle exactly.
    pub const FAST: Self = Self { fix: 2e-5, place_m: 2e-4, ..Self::DOUBLE };
    /// Tolerance for single precision: 1e-7, times the cancellation within a fix's covariance.
    pub const SINGLE: Self = Self { relative: 5e-3, fix: 5e-3, place_m: 2e-3, lost: 0.05 };
}

impl Tolerance {
    fn of(&self, what: &str) -> f64 {
        if what == "fix" { self.fix } else { self.relative }
    }
}

/// Largest difference of each quantity, as a fraction of the tolerance; kept for printing.
#[derive(Clone, Debug, Default)]
pub struct Differences {
    largest: BTreeMap<(String, &'static str), f64>,
    /// Largest one-sigma of each state since the filters were last equal: rounding is relative to it.
    sigmas: Vec<f64>,
}

impl Differences {
    fn note(
        &mut self,
        what: &str,
        quantity: &'static str,
        off: f64,
        allowed: f64,
        detail: &dyn Fn() -> String,
    ) {
        let share = off / allowed;
        let largest = self.largest.entry((what.to_owned(), quantity)).or_default();
        *largest = largest.max(share);
        assert!(
            share <= 1.0,
            "{what}, {quantity}: {off:e} apart, {allowed:e} allowed; {}",
            detail()
        );
    }

    /// Compares nominal states, parameters and covariances.
    pub fn of_states<L: Layout<N>, const N: usize>(
        &mut self,
        what: &str,
        shipped: &Snapshot<N>,
        oracle: &Filter<L, N>,
        tolerance: &Tolerance,
    ) {
        let Tolerance { place_m, lost, .. } = *tolerance;
        let relative = tolerance.of(what);
        let (a, b) = (&shipped.nominal, &oracle.nominal);
        assert_eq!(a.time, b.time, "{what}: time");
        let sigmas = shipped.covariance.map_diagonal(|variance| variance.max(0.0).sqrt());
        for (largest, sigma) in self.sigmas.iter_mut().zip(&sigmas) {
            *largest = largest.max(*sigma);
        }
        let units: Vec<f64> =
            sigmas.iter().zip(&self.sigmas).map(|(sigma, most)| sigma.max(lost * most)).collect();
        let sigma = |state: usize| units[state];
        let off_m = Earth::at(&a.place).displacement(&a.place, &b.place);
        self.note(what, "position", off_m.norm(), place_m, &|| format!("{off_m:?}"));
        let off_mps: Vector = a.velocity_mps - b.velocity_mps;
        let size = a.velocity_mps.norm().max(1.0);
        self.note(what, "velocity", off_mps.norm(), relative * size, &|| format!("{off_mps:?}"));
        let off_rad = 2.0 * a.attitude.rotation_to(&b.attitude).imag().norm();
        self.note(what, "attitude", off_rad, relative, &|| String::new());
        for state in GYRO_BIAS..N {
            let (a, b) = (shipped.parameters[state], oracle.parameters[state]);
            let allowed = relative * a.abs().max(sigma(state)) + f64::MIN_POSITIVE;
            self.note(what, "parameters", (a - b).abs(), allowed, &|| {
                format!("{state}: {a:e} {b:e}")
            });
        }
        for row in 0..N {
            for column in 0..N {
                let (a, b) = (shipped.covariance[(row, column)], oracle.covariance[(row, column)]);
                let allowed = relative * sigma(row) * sigma(column) + f64::MIN_POSITIVE;
                self.note(what, "covariance", (a - b).abs(), allowed, &|| {
                    format!(
                        "{row}, {column}: {a:e} {b:e}, sigmas {:e} {:e}",
                        sigma(row),
                        sigma(column)
                    )
                });
            }
        }
    }

    /// Restarts from equal filters.
    pub fn restart<const N: usize>(&mut self, covariance: &Matrix<N>) {
        self.sigmas =
            covariance.diagonal().iter().map(|variance| variance.max(0.0).sqrt()).collect();
    }

    /// Compares an innovation and its one-sigma.
    pub fn of_innovations(
        &mut self,
        what: &str,
        shipped: &Innovation,
        oracle: &Compared,
        tolerance: &Tolerance,
    ) {
        assert_eq!(shipped.channel, oracle.channel, "{what}");
        let is_place = matches!(
            shipped.channel,
            Channel::PositionNorth | Channel::PositionEast | Channel::PositionDown
        );
        let rounding = if is_place { tolerance.place_m } else { 0.0 };
        let relative = tolerance.of(what);
        let unit = shipped.sigma.max(tolerance.lost * oracle.sigma_before);
        let size = shipped.innovation.abs().max(unit);
        let off = (shipped.innovation - oracle.innovation).abs();
        let detail = || format!("{shipped:?} {oracle:?}");
        self.note(what, "innovation", off, relative * size + rounding, &detail);
        let off = (shipped.sigma - oracle.sigma).abs();
        self.note(what, "its sigma", off, relative * unit, &detail);
    }

    pub fn print(&self, name: &str) {
        for ((what, quantity), share) in &self.largest {
            println!("{name:24} {what:24} {quantity:12} {share:.1e} of the tolerance");
        }
    }
}
