//! Conversion of inertial samples of any form to mean rates.

use hovernav::imu::{ClippedAxes, ImuSample, Motion};
use hovernav::time::Time;

/// A sample as mean rates since the previous one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rates {
    pub time: Time,
    /// Time since the previous sample, s; zero for the first.
    pub interval_s: f64,
    /// Angular rate, rad/s.
    pub turn_radps: [f64; 3],
    /// Specific force, m/s².
    pub force_mps2: [f64; 3],
    /// The inertial unit's own full-scale marks.
    pub clipped: ClippedAxes,
}

/// Each sample with its angular rate and specific force. Increments are divided by their interval. The first increment
/// has no rates, because its interval is unknown.
pub(crate) fn with_rates(
    samples: impl IntoIterator<Item = ImuSample>,
) -> impl Iterator<Item = (ImuSample, Option<Rates>)> {
    let mut before: Option<Time> = None;
    samples.into_iter().map(move |sample| {
        let interval_s = before.replace(sample.time).map(|before| sample.time - before);
        // The interval of the first increment is unknown.
        let is_known = interval_s.is_some() || matches!(sample.motion, Motion::Rates { .. });
        let interval_s = interval_s.unwrap_or_default();
        let rates = is_known.then(|| {
            let mean = sample.motion.mean_rates(interval_s);
            Rates {
                time: sample.time,
                interval_s,
                turn_radps: mean.angular_rate_radps.to_array(),
                force_mps2: mean.specific_force_mps2.to_array(),
                clipped: sample.clipped,
            }
        });
        (sample, rates)
    })
}

/// The rates of [`with_rates`], in memory.
pub(crate) fn rates(samples: impl IntoIterator<Item = ImuSample>) -> Vec<Rates> {
    with_rates(samples).filter_map(|(_, rates)| rates).collect()
}
