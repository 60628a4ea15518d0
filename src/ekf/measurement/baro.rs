//! Barometric height.

use super::update::ScalarMeasurement;
use crate::earth::STANDARD_GRAVITY_MPS2;
use crate::ekf::filter::Ekf;
use crate::ekf::kernel::covariance::Sensitivity;
use crate::ekf::kernel::layout::{Layout, POSITION, VELOCITY};
use crate::ekf::kernel::trace::Trace;
use crate::ekf::outcome::group::Group;
use crate::ekf::outcome::innovation::Channel;
use crate::ekf::outcome::report::{Report, Unusable};
use crate::ekf::watch::OUTLIER_SIGMAS;
use crate::event::is_possible_height;
use crate::matrix::square;
use crate::scalar::Scalar;
use crate::time::Time;

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// Fuses a barometric height, m, above any fixed level: the first one sets the level.
    ///
    /// # Errors
    /// [`Unusable`] if the height cannot be compared, or repeats the previous reading.
    ///
    /// # Source
    /// Equation (M10) of docs/equations.md.
    // Not inlined, so that its stack frame is not part of a caller's that updates several sensors.
    #[inline(never)]
    pub fn update_baro(
        &mut self,
        time: Time,
        height_m: f64,
        trace: &mut impl Trace<T, N>,
    ) -> Result<Report, Unusable> {
        let state = L::BARO.ok_or(Unusable::NoState)?;
        if !is_possible_height(height_m) {
            return Err(Unusable::NotFinite);
        }
        let elapsed_s = self.memory.gates.since_accepted_s(Group::Baro, time);
        if self.memory.barometer.repeats(height_m, elapsed_s) {
            return Err(Unusable::RepeatedReading);
        }
        self.relax(trace);
        let elapsed_s = elapsed_s.clamp(MIN_S, WIND_TIME_S);
        let noise_m = self.config.baro.noise_m;
        if !self.memory.barometer.has_reading() {
            self.memory.barometer.start(height_m - self.state.position.height_m, noise_m);
        }
        let innovation = self.baro_innovation(state, height_m).wide();
        let moved = 0.5 * self.covariance.variance(VELOCITY + 2) * square(elapsed_s);
        let explained = self.wind_variance().wide() * (elapsed_s / WIND_TIME_S) + moved;
        let scatter = self.memory.barometer.scatter(innovation, elapsed_s, explained, noise_m);
        let learns = self.config.mechanisms.barometer_scatter;
        let noise = if learns { scatter } else { square(noise_m) };
        let report = self.compare_baro(state, time, height_m, [noise, elapsed_s], trace);
        self.memory.barometer.compared(self.baro_innovation(state, height_m).wide());
        Ok(report)
    }

    /// Innovation of a height, m.
    fn baro_innovation(&self, state: usize, height_m: f64) -> T {
        let read_m = height_m - self.memory.barometer.level_m();
        T::of(read_m - self.state.position.height_m) - self.estimate(state)
    }

    /// Compares a height of the variance `noise`, m², `elapsed_s` after the previous one.
    fn compare_baro(
        &mut self,
        state: usize,
        time: Time,
        height_m: f64,
        [noise, elapsed_s]: [f64; 2],
        trace: &mut impl Trace<T, N>,
    ) -> Report {
        let (innovation, noise) = (self.baro_innovation(state, height_m), T::of(noise));
        let wind = self.wind_variance();
        let sensitivity = Sensitivity::default().with(POSITION + 2, -T::ONE).with(state, T::ONE);
        // The check uses the airflow error itself. Its enlarged variance as white noise would hide a wrong reading.
        let [height, both, slow] =
            [(POSITION + 2, POSITION + 2), (POSITION + 2, state), (state, state)]
                .map(|(row, column)| self.covariance.value(row, column));
        let own = slow - both - (both - height);
        let likely = square(T::of(OUTLIER_SIGMAS)) * (own + noise + wind);
        self.memory.gates.baro_disagrees = square(innovation) > likely;
        let noise = noise + wind * T::of(2.0 * WIND_TIME_S / elapsed_s);
        let height = ScalarMeasurement::new(Channel::BaroHeight, innovation, noise, sensitivity);
        self.update_one(time, Some(height), trace)
    }

    /// Variance of the barometer error caused by the airflow at the vehicle's speed, m². A speed within the filter's
    /// own error counts as zero.
    fn wind_variance(&self) -> T {
        if !self.config.mechanisms.barometer_wind {
            return T::ZERO;
        }
        let velocity_mps = self.state.velocity_mps;
        let unknown = (VELOCITY..VELOCITY + 3)
            .fold(T::ZERO, |sum, state| sum + self.covariance.value(state, state));
        let squared = (velocity_mps.dot(velocity_mps) - unknown).max(T::ZERO);
        square(T::of(WIND_SHARE * 0.5 / STANDARD_GRAVITY_MPS2) * squared)
    }
}

/// One-sigma of the pressure error of a static port without a probe of its own, as a fraction of the dynamic pressure.
/// Assumed, and compared only with two flights of model aircraft.
const WIND_SHARE: f64 = 0.1;
/// Correlation time, s, of the pressure error from airflow: the direction of the airflow is constant for about this
/// time. Assumed, and compared only with two flights of model aircraft.
const WIND_TIME_S: f64 = 5.0;
/// Minimum interval between two readings that counts, s.
const MIN_S: f64 = 0.01;
