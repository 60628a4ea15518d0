//! Motion from the gyros alone, of a log without GPS: on a test stand or indoors.

use super::model_structure::ModelStructure;
use hovernav::earth::Geodetic;
use hovernav::ekf::Solution;
use hovernav::imu::ImuSample;
use hovernav_dataset::Dataset;

/// The `smoothed` solutions of a log, or solutions from its gyros. The gyros are used for a log without fixes. They are
/// also used where `smoothed` is empty, because no heading was found, and `structure` has rates alone.
#[must_use]
pub fn solutions_for(
    dataset: &Dataset,
    structure: Option<&ModelStructure>,
    smoothed: Vec<Solution>,
) -> Vec<Solution> {
    let has_rates_alone = structure.is_some_and(ModelStructure::has_rates_alone);
    if dataset.fixes.is_empty() || (smoothed.is_empty() && has_rates_alone) {
        gyro_solutions(dataset)
    } else {
        smoothed
    }
}

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
