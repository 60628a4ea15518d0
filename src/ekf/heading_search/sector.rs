//! What is a sector's own.

use super::super::covariance::{Covariance, PackedCovariance};
use super::super::excess::Excess;
use super::super::gate::GpsGates;
use super::super::history::RecentMotion;
use super::super::layout::{ATTITUDE, GYRO_BIAS};
use super::super::measurement::BiasShift;
use super::super::own::Own;
use super::super::scalar::Scalar;
use super::super::solution::{Estimate, Solution};
use super::{STATES, SectorEkf};
use crate::frames::Vector;
use crate::ins::{Mounting, NavState};

/// One filter of the bank, while another uses what they share.
#[derive(Clone, Debug)]
pub(super) struct Sector<T> {
    pub weight: f64,
    state: NavState<T>,
    /// Biases, and the error of the barometer's level.
    parameters: [T; STATES - GYRO_BIAS],
    covariance: PackedCovariance,
    pub gates: GpsGates,
    pub own: Own<T>,
    recent: RecentMotion<T>,
}

impl<T: Scalar> Sector<T> {
    /// A sector of this weight, to be [`store`](Self::store)d into.
    pub const fn new(weight: f64) -> Self {
        Self {
            weight,
            state: NavState::ORIGIN,
            parameters: [T::ZERO; STATES - GYRO_BIAS],
            covariance: PackedCovariance::ZERO,
            gates: GpsGates::NONE,
            own: Own::START,
            recent: RecentMotion::NONE,
        }
    }

    /// Makes the shared filter this sector's.
    pub fn load(&self, filter: &mut SectorEkf<T>) {
        filter.state = self.state;
        for (parameter, kept) in filter.parameters.iter_mut().skip(GYRO_BIAS).zip(self.parameters) {
            *parameter = kept;
        }
        self.covariance.unpack(&mut filter.covariance);
        filter.gates.set_gps(&self.gates);
        filter.own = self.own;
        // A wrong heading makes innovations alike as well.
        filter.excess = Excess::NONE;
        filter.bias_shift = BiasShift::UNKNOWN;
        filter.history.set_recent(&self.recent);
    }

    /// Keeps what the shared filter has become.
    pub fn store(&mut self, filter: &SectorEkf<T>) {
        self.state = filter.state;
        for (kept, &parameter) in
            self.parameters.iter_mut().zip(filter.parameters.iter().skip(GYRO_BIAS))
        {
            *kept = parameter;
        }
        self.covariance.pack(&filter.covariance);
        self.gates = filter.gates.gps();
        self.own = filter.own;
        self.recent = filter.history.recent();
    }

    /// Lets the shared filter be this sector's for `work` that takes no time.
    pub fn lend<R>(
        &mut self,
        filter: &mut SectorEkf<T>,
        work: impl FnOnce(&mut SectorEkf<T>) -> R,
    ) -> R {
        self.load(filter);
        let result = work(filter);
        self.store(filter);
        result
    }

    /// Where it is, how fast and which way up.
    pub fn state(&self) -> &NavState<T> {
        &self.state
    }

    /// Heading, rad.
    pub fn heading_rad(&self) -> T {
        self.state.body_to_ned.heading_rad()
    }

    /// Its variance, rad².
    pub fn heading_variance(&self) -> f64 {
        self.covariance.variance(ATTITUDE + 2)
    }

    /// The solution of this sector's filter.
    // Its frame need not stand beneath a fix.
    #[inline(never)]
    pub fn solution(&self, mounting: &Mounting) -> Solution<T> {
        let mut covariance = Covariance::<T, STATES>::zero();
        self.covariance.unpack(&mut covariance);
        let [p, q, r, x, y, z, _] = self.parameters;
        let estimate = Estimate {
            state: &self.state,
            covariance: &covariance,
            angular_rate_radps: self.own.angular_rate_radps,
            heading_revision_rad: T::ZERO,
            gyro_bias_radps: Vector::new(p, q, r),
            accel_bias_mps2: Vector::new(x, y, z),
        };
        estimate.solution(mounting)
    }
}
