//! Motion from the gyros alone, of a log without GPS: on a test stand or indoors.

use hovernav::earth::Geodetic;
use hovernav::ekf::Solution;
use hovernav::imu::ImuSample;
use hovernav_log::Dataset;

/// Solutions at rest with the angular rates of the gyros, for models of p, q and r. A gyro's bias is an offset of the
/// model.
#[must_use]
pub fn gyro_solutions(dataset: &Dataset) -> Vec<Solution> {
    let mut before = None;
    let of = |sample: ImuSample| {
        let interval_s = sample.time - before.replace(sample.time)?;
        let rates = sample.motion.mean_rates(interval_s);
        let at_rest = Solution::at_rest(sample.time, Geodetic::from_degrees(0.0, 0.0, 0.0)?);
        Some(Solution { angular_rate_radps: rates.angular_rate_radps, ..at_rest })
    };
    dataset.samples().filter_map(of).collect()
}
