//! Measurements other than fixes: equations (M8) to (M13) and (M19).

use hovernav::ekf::layout::{ATTITUDE, GYRO_BIAS, Layout, POSITION, VELOCITY};
use hovernav::ekf::{AntennaHeadingModel, Channel, Learned, Rangefinder};
use hovernav::event::RangeReading;
use hovernav::gps::AntennaHeading;
use hovernav::time::Time;
use nalgebra::UnitQuaternion;

use crate::filter::Filter;
use crate::mechanization::{Earth, Vector, wrapped};
use crate::update::Row;

/// Heading error, rad, above which the tilt of an attitude reference would be resolved about the wrong axes.
const FAR_RAD: f64 = 0.35;
/// Airspeed error of the barometer as a fraction of the dynamic pressure.
const WIND_SHARE: f64 = 0.1;
/// Correlation time of the airspeed error, s.
const WIND_TIME_S: f64 = 5.0;
/// Standard gravity, m/s².
const STANDARD_GRAVITY_MPS2: f64 = 9.80665;

/// Azimuth of a vector's horizontal part from north.
fn azimuth_rad(v: &Vector) -> f64 {
    v.y.atan2(v.x)
}

impl<L: Layout<N>, const N: usize> Filter<L, N> {
    /// The larger of the two tilt variances, rad².
    fn tilt_variance(&self) -> f64 {
        self.covariance[(ATTITUDE, ATTITUDE)].max(self.covariance[(ATTITUDE + 1, ATTITUDE + 1)])
    }

    /// (M8): attitude of a reference, used `since_s` after the last one. `after` contains its swing including this
    /// reading. The heading row is absent unless `trusts_heading`.
    pub fn attitude_rows(
        &self,
        reference: &UnitQuaternion<f64>,
        since_s: f64,
        after: &Learned,
        trusts_heading: bool,
    ) -> Vec<Row<N>> {
        let Some(first) = L::ATTITUDE_REFERENCE else { return Vec::new() };
        let wander = self.block(first);
        let own = self.nominal.attitude;
        let mut off = (reference * own.inverse()).scaled_axis() - wander;
        let heading = |attitude: &UnitQuaternion<f64>| azimuth_rad(&(attitude * Vector::x()));
        if off.z.abs() > FAR_RAD || !trusts_heading {
            // Tilt is compared at the filter's heading; heading is compared separately.
            let heading_off = wrapped(heading(reference) - heading(&own));
            let back = UnitQuaternion::from_scaled_axis(Vector::new(0.0, 0.0, -heading_off));
            off = (back * reference * own.inverse()).scaled_axis() - wander;
            off.z = heading_off - wander.z;
        }
        let (sine, cosine) = heading(&own).sin_cos();
        let axes = [
            (Channel::Roll, Vector::new(cosine, sine, 0.0)),
            (Channel::Pitch, Vector::new(-sine, cosine, 0.0)),
            (Channel::Yaw, Vector::z()),
        ];
        let model = &self.config.attitude;
        // The shipped filter uses single precision here.
        let usual = 1.5 * (model.noise_rad * model.noise_rad) as f32;
        let alike = (2.0 / since_s.min(1.0) as f32).max(1.0);
        let excess =
            after.attitude_swing.map(|swing| f64::from(alike * (swing as f32 - usual).max(0.0)));
        axes.into_iter()
            .take(if trusts_heading { 3 } else { 2 })
            .enumerate()
            .map(|(index, (channel, axis))| {
                let noise = model.noise_rad.powi(2) + excess[usize::from(index == 2)];
                Row::new(channel, off.dot(&axis), noise)
                    .sees_block(ATTITUDE, axis.into())
                    .sees_block(first, axis.into())
            })
            .collect()
    }

    /// (M9): magnetic field, gauss, and declination.
    pub fn magnetic_rows(&self, field_gauss: &Vector, declination_rad: f64) -> Vec<Row<N>> {
        let Some(first) = L::ATTITUDE_REFERENCE else { return Vec::new() };
        let field = self.nominal.attitude * field_gauss;
        let off = wrapped(declination_rad - azimuth_rad(&field));
        let off = wrapped(off - self.parameters[first + 2]);
        let row = Row::new(Channel::Yaw, off, self.config.magnetometer.noise_rad.powi(2))
            .sees(ATTITUDE + 2, 1.0)
            .sees(first + 2, 1.0);
        vec![row]
    }

    /// (M10) and (M18): barometric height, m, `since_s` after the last one used.
    pub fn baro_rows(&self, height_m: f64, since_s: f64, after: &Learned) -> Vec<Row<N>> {
        let Some(state) = L::BARO else { return Vec::new() };
        let (level_m, white) = after.baro;
        let innovation = height_m - level_m - self.nominal.place.height_m - self.parameters[state];
        let unknown: f64 =
            (VELOCITY..VELOCITY + 3).map(|state| self.covariance[(state, state)]).sum();
        let squared = (self.nominal.velocity_mps.norm_squared() - unknown).max(0.0);
        let head_m = squared / (2.0 * STANDARD_GRAVITY_MPS2);
        let wind = (WIND_SHARE * head_m).powi(2);
        let noise = white + wind * 2.0 * WIND_TIME_S / since_s.clamp(0.01, WIND_TIME_S);
        let row = Row::new(Channel::BaroHeight, innovation, noise)
            .sees(POSITION + 2, -1.0)
            .sees(state, 1.0);
        vec![row]
    }

    /// (M11): rest.
    pub fn rest_rows(&self, learned: &Learned) -> Vec<Row<N>> {
        const RATES: [Channel; 3] = [Channel::RestRateX, Channel::RestRateY, Channel::RestRateZ];
        const VELOCITIES: [Channel; 3] =
            [Channel::RestVelocityNorth, Channel::RestVelocityEast, Channel::RestVelocityDown];
        let Some(rate_radps) = learned.resting_rate_radps.map(Vector::from) else {
            return Vec::new();
        };
        let earth = Earth::at(&self.nominal.place).rate_radps;
        let off = rate_radps - self.nominal.attitude.inverse() * earth - self.block(GYRO_BIAS);
        let rates = (0..3).map(|axis| {
            Row::new(RATES[axis], off[axis], 0.003f64.powi(2)).sees(GYRO_BIAS + axis, 1.0)
        });
        let velocities = (0..3).map(|axis| {
            let noise = 0.1f64.powi(2) + f64::from(learned.resting_fixes_mps[axis]).powi(2);
            let innovation = -self.nominal.velocity_mps[axis];
            Row::new(VELOCITIES[axis], innovation, noise).sees(VELOCITY + axis, 1.0)
        });
        rates.chain(velocities).collect()
    }

    /// (M12): distance to the ground.
    pub fn range_rows(
        &self,
        reading: &RangeReading,
        rangefinder: &Rangefinder,
        after: &Learned,
    ) -> Vec<Row<N>> {
        let Some((state, ground_m)) = L::GROUND.zip(after.ground_height_m) else {
            return Vec::new();
        };
        let (model, nominal) = (&rangefinder.model, &self.nominal);
        let arm_m = rangefinder.lever_arm_m - self.mounting.imu_lever_arm_m;
        let beam = nominal.attitude * Vector::from(rangefinder.beam.to_array());
        let hit_m = nominal.attitude * Vector::from(arm_m.to_array()) + beam * reading.range_m;
        let age_s = nominal.time - reading.time;
        let height_m = nominal.place.height_m + nominal.velocity_mps.z * age_s;
        let white_m = reading.sigma_m.unwrap_or(model.noise_m).max(0.005);
        let noise = white_m.powi(2) + (model.noise_share * reading.range_m).powi(2);
        let innovation = (hit_m.z - height_m + ground_m + self.parameters[state]) / beam.z;
        let row = Row::new(Channel::Range, innovation, noise)
            .sees(ATTITUDE, -hit_m.y / beam.z)
            .sees(ATTITUDE + 1, hit_m.x / beam.z)
            .sees(POSITION + 2, -1.0 / beam.z)
            .sees(state, -1.0 / beam.z);
        vec![row]
    }

    /// (M13): heading of the baseline between two antennas, used `since_s` after the last one.
    pub fn antenna_heading_rows(
        &self,
        reading: &AntennaHeading,
        baseline_m: &Vector,
        model: &AntennaHeadingModel,
        since_s: f64,
    ) -> Vec<Row<N>> {
        let attitude = self.nominal.attitude;
        let baseline = attitude * baseline_m;
        let age_s: f64 = self.nominal.time - reading.time;
        let turned_rad = (attitude * self.rate_radps).z * age_s;
        let off = wrapped(reading.heading_rad + turned_rad - azimuth_rad(&baseline));
        let sigma = reading.sigma_rad.unwrap_or(model.sigma_rad).max(model.floor_rad);
        let leaning = (baseline.z / baseline.xy().norm()).powi(2) * self.tilt_variance();
        let others = leaning + (0.1 * turned_rad).powi(2);
        let own = self.covariance[(ATTITUDE + 2, ATTITUDE + 2)];
        // A reading beyond the gate has the weight of an uncorrelated reading, because the gate is the same for all
        // readings.
        let one = sigma * sigma + others;
        let jumps = off * off > self.config.gate.sigmas.powi(2) * (own + one);
        let in_common = (2.0 * model.wander_time_s / since_s).max(1.0);
        let weight = 1.0 + model.wander_share.powi(2) * (in_common - 1.0);
        let noise = if jumps { one } else { weight * sigma * sigma + others };
        vec![Row::new(Channel::BaselineHeading, off, noise).sees(ATTITUDE + 2, 1.0)]
    }

    /// (M19): vertical velocity of a vehicle without height measurements.
    pub fn climb_rows(&self) -> Vec<Row<N>> {
        let innovation = -self.nominal.velocity_mps.z;
        vec![Row::new(Channel::RestVelocityDown, innovation, 25.0).sees(VELOCITY + 2, 1.0)]
    }

    /// Time since the last use, s; infinite before the first.
    pub fn since_s(time: Time, used: Option<Time>) -> f64 {
        used.map_or(f64::INFINITY, |used| time - used)
    }
}
