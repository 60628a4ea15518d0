//! What is a sector's own.

use super::super::covariance::{Covariance, PackedBase};
use super::super::excess::Excess;
use super::super::filter::Ekf;
use super::super::gate::GpsGates;
use super::super::history::RecentMotion;
use super::super::layout::{ATTITUDE, BASE, Base, GYRO_BIAS};
use super::super::measurement::BiasShift;
use super::super::scalar::Scalar;
use super::super::solution::{Estimate, Solution};
use crate::frames::{Body, Vector};
use crate::ins::{Mounting, NavState};

/// One filter of the bank, while another uses what they share.
#[derive(Clone, Debug)]
pub(super) struct Sector<T> {
    pub weight: f64,
    state: NavState<T>,
    biases: [T; BASE - GYRO_BIAS],
    covariance: PackedBase,
    gates: GpsGates,
    gps_learned: [f32; 3],
    angular_rate_radps: Vector<Body, T>,
    /// How long its biases have not relaxed, s.
    unrelaxed_s: T,
    recent: RecentMotion<T>,
}

impl<T: Scalar> Sector<T> {
    /// A sector of this weight, to be [`store`](Self::store)d into.
    pub const fn new(weight: f64) -> Self {
        Self {
            weight,
            state: NavState::ORIGIN,
            biases: [T::ZERO; BASE - GYRO_BIAS],
            covariance: PackedBase::ZERO,
            gates: GpsGates::NONE,
            gps_learned: [1.0; 3],
            angular_rate_radps: Vector::ZERO,
            unrelaxed_s: T::ZERO,
            recent: RecentMotion::NONE,
        }
    }

    /// Makes the shared filter this sector's.
    pub fn load(&self, filter: &mut Ekf<Base, 16, T>) {
        filter.state = self.state;
        for (parameter, bias) in filter.parameters.iter_mut().skip(GYRO_BIAS).zip(self.biases) {
            *parameter = bias;
        }
        self.covariance.unpack(&mut filter.covariance);
        filter.gates.set_gps(&self.gates);
        filter.gps_learned = self.gps_learned;
        // A wrong heading makes innovations alike as well.
        filter.excess = Excess::NONE;
        filter.bias_shift = BiasShift::UNKNOWN;
        filter.angular_rate_radps = self.angular_rate_radps;
        filter.unrelaxed_s = self.unrelaxed_s;
        filter.history.set_recent(&self.recent);
    }

    /// Keeps what the shared filter has become.
    pub fn store(&mut self, filter: &Ekf<Base, 16, T>) {
        self.state = filter.state;
        for (bias, &parameter) in
            self.biases.iter_mut().zip(filter.parameters.iter().skip(GYRO_BIAS))
        {
            *bias = parameter;
        }
        self.covariance.pack(&filter.covariance);
        self.gates = filter.gates.gps();
        self.gps_learned = filter.gps_learned;
        self.angular_rate_radps = filter.angular_rate_radps;
        self.unrelaxed_s = filter.unrelaxed_s;
        self.recent = filter.history.recent();
    }

    /// Lets the shared filter be this sector's for `work` that takes no time.
    pub fn lend<R>(
        &mut self,
        filter: &mut Ekf<Base, 16, T>,
        work: impl FnOnce(&mut Ekf<Base, 16, T>) -> R,
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
        let mut covariance = Covariance::<T, 16>::zero();
        self.covariance.unpack(&mut covariance);
        let [p, q, r, x, y, z] = self.biases;
        let estimate = Estimate {
            state: &self.state,
            covariance: &covariance,
            angular_rate_radps: self.angular_rate_radps,
            heading_revision_rad: T::ZERO,
            gyro_bias_radps: Vector::new(p, q, r),
            accel_bias_mps2: Vector::new(x, y, z),
        };
        estimate.solution(mounting)
    }
}
