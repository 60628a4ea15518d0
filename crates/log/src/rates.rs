//! Samples as mean rates, whatever form they have.

use hovernav::imu::{ClippedAxes, ImuSample, Motion};
use hovernav::time::Time;

/// A sample as mean rates since the one before.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rates {
    pub time: Time,
    /// Since the sample before, s; zero of the first.
    pub interval_s: f64,
    /// Angular rate, rad/s.
    pub turn_radps: [f64; 3],
    /// Specific force, m/s².
    pub force_mps2: [f64; 3],
    /// The unit's own marks of full scale.
    pub clipped: ClippedAxes,
}

/// Angular rate and specific force of each sample; increments over their interval, so none of the
/// first.
pub(crate) fn rates(samples: &[ImuSample]) -> Vec<Rates> {
    let mut before: Option<Time> = None;
    let mut rates = Vec::with_capacity(samples.len());
    for sample in samples {
        let interval_s = before.map(|before| sample.time - before);
        // The first increment's interval is not known.
        if interval_s.is_some() || matches!(sample.motion, Motion::Rates { .. }) {
            let mean = sample.motion.mean_rates(interval_s.unwrap_or_default());
            rates.push(Rates {
                time: sample.time,
                interval_s: interval_s.unwrap_or_default(),
                turn_radps: mean.angular_rate_radps.to_array(),
                force_mps2: mean.specific_force_mps2.to_array(),
                clipped: sample.clipped,
            });
        }
        before = Some(sample.time);
    }
    rates
}
