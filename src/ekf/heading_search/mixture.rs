//! What all sectors together say: the solution while the heading is searched, and how unsure it is.

use super::super::config::GpsModel;
use super::super::scalar::Scalar;
use super::super::solution::Solution;
use super::super::square;
use super::sector::Sector;
use super::{HeadingSearch, UNPROVEN_RAD};
use crate::earth::Local;
use crate::frames::{Vector, wrap_angle};

/// One-sigma of the slow errors of a receiver, level and downwards: a filter that takes them for noise averages them
/// away, though not in truth.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wander {
    position_m: [f32; 2],
    velocity_mps: [f32; 2],
}

impl Wander {
    /// Of no receiver.
    pub const NONE: Self = Self { position_m: [0.0; 2], velocity_mps: [0.0; 2] };

    /// Of the one whose fixes have these one-sigmas of position, m, and velocity, m/s, NED.
    pub fn of((position_m, velocity_mps): ([f64; 3], [f64; 3]), gps: &GpsModel) -> Self {
        let of = |share: f64, [north, east, down]: [f64; 3]| {
            [north.max(east), down].map(|sigma| (share * sigma) as f32)
        };
        Self {
            position_m: of(gps.position_wander_share, position_m),
            velocity_mps: of(gps.velocity_wander_share, velocity_mps),
        }
    }

    /// One-sigmas: position level and vertical, m, and velocity, m/s.
    pub fn sigmas(&self) -> [f64; 4] {
        let ([level_m, vertical_m], [level_mps, vertical_mps]) =
            (self.position_m, self.velocity_mps);
        [level_m, vertical_m, level_mps, vertical_mps].map(f64::from)
    }
}

/// How far apart the sectors are, by their weights and from the best one: variances of where down is in the body, of
/// velocity and of position.
struct Spread<T> {
    tilt: T,
    velocity: [T; 3],
    position: [T; 3],
}

impl<T: Scalar> HeadingSearch<T> {
    /// One-sigma of heading over all filters left, rad.
    ///
    /// # Source
    /// Equation (H4) of docs/equations.md.
    pub(super) fn heading_sigma_rad(&self) -> f64 {
        let Some(best) = self.best() else { return core::f64::consts::PI };
        let middle = best.heading_rad();
        let (mut weights, mut variance) = (0.0, 0.0);
        for sector in self.sectors.iter().flatten() {
            let off = wrap_angle(sector.heading_rad() - middle);
            variance += sector.weight * (sector.heading_variance() + square(off.wide()));
            weights += sector.weight;
        }
        Scalar::sqrt(variance / weights).min(core::f64::consts::PI)
    }

    /// How far apart the sectors are: without a heading each makes another motion of the same samples, and of a vehicle
    /// that started in a turn each has a tilt of its own.
    ///
    /// # Source
    /// Equation (H4) of docs/equations.md.
    #[inline(never)]
    fn spread(&self, best: &Sector<T>) -> Spread<T> {
        let here = best.state();
        let earth = Local::about(&here.position);
        let [.., down] = here.body_to_ned.rows();
        let mut spread = Spread { tilt: T::ZERO, velocity: [T::ZERO; 3], position: [T::ZERO; 3] };
        let mut weights = T::ZERO;
        for sector in self.sectors.iter().flatten() {
            let there = sector.state();
            let weight = T::of(sector.weight);
            let [.., own] = there.body_to_ned.rows();
            let tilts = own.into_iter().zip(down).map(|(own, down)| square(own - down));
            spread.tilt += weight * tilts.fold(T::ZERO, |sum, tilt| sum + tilt);
            let velocity = there.velocity_mps - here.velocity_mps;
            let position = earth.displacement(&here.position, &there.position);
            let apart = [velocity, position].map(Vector::to_array);
            for (sums, apart) in [&mut spread.velocity, &mut spread.position].into_iter().zip(apart)
            {
                for (sum, apart) in sums.iter_mut().zip(apart) {
                    *sum += weight * square(apart);
                }
            }
            weights += weight;
        }
        spread.tilt = spread.tilt / weights;
        for sum in spread.velocity.iter_mut().chain(&mut spread.position) {
            *sum = *sum / weights;
        }
        spread
    }

    /// The best filter's solution, as unsure as all filters together are, and no surer than the motion so far and the
    /// slow errors of the receiver allow.
    pub(in super::super) fn solution(&self) -> Option<Solution<T>> {
        self.best().map(|best| {
            let mut solution = best.solution(&self.filter.mounting);
            let least_rad = if self.is_proven() { 0.0 } else { UNPROVEN_RAD };
            let spread = self.spread(best);
            let [roll, pitch, heading] = &mut solution.attitude_sigma_rad;
            for tilt in [roll, pitch] {
                *tilt = (square(*tilt) + spread.tilt).sqrt();
            }
            *heading = heading.max(T::of(self.heading_sigma_rad().max(least_rad)));
            let wander = &self.wander;
            for (sigma, apart, [level, down]) in [
                (&mut solution.velocity_sigma_mps, spread.velocity, wander.velocity_mps),
                (&mut solution.position_sigma_m, spread.position, wander.position_m),
            ] {
                let slow = [level, level, down].map(|sigma| T::of(f64::from(sigma)));
                let mut wider = sigma.to_array();
                for ((own, apart), slow) in wider.iter_mut().zip(apart).zip(slow) {
                    *own = (square(*own) + apart + square(slow)).sqrt();
                }
                *sigma = wider.into();
            }
            solution
        })
    }
}
