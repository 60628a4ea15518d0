//! The raw inertial samples, thinned for the page in one pass.

use hovernav::ekf::Notice;
use hovernav::imu::{ImuSample, Motion};
use hovernav::time::Time;
use hovernav_dataset::Dataset;
use hovernav_dataset::statistics::Extremes;

use super::motion::Clock;
use super::spectrum::Density;

/// A point of a figure: page time, s, and value.
type Point = (f64, f64);

/// The inertial data that a page shows.
pub struct Raw {
    /// Angular rates x, y, z, °/s, then specific forces, m/s².
    pub components: [Vec<Point>; 6],
    /// Samples at the end of the range, per component.
    pub clipped: [Vec<Point>; 6],
    /// Spectrum per component: Hz, unit/√Hz.
    pub spectra: [Vec<Point>; 6],
    /// Interval between successive samples, ms.
    pub intervals: Vec<Point>,
    /// Roll, pitch and yaw from the inertial unit itself, °.
    pub attitude: [Vec<Point>; 3],
    /// Median interval, s.
    pub interval_s: f64,
}

impl Raw {
    /// Reads the samples of `dataset`; `notices` identify clipped samples. `None` without samples.
    pub fn of(dataset: &Dataset, notices: &[Notice], clock: Clock) -> Option<Self> {
        let first = dataset.samples().next()?;
        // The interval of the first increment is unknown.
        let is_first_known = matches!(first.motion, Motion::Rates { .. });
        let known = dataset.sample_count() - usize::from(!is_first_known);
        let mut components: [Component; 6] = std::array::from_fn(|_| Component::of(known));
        let (mut intervals, mut attitude) = (Extremes::default(), <[Extremes; 3]>::default());
        let mut suspects = suspects(notices, clock).peekable();
        let mut before: Option<Time> = None;
        for sample in dataset.samples() {
            let time = clock.seconds(sample.time);
            let interval_s = before.replace(sample.time).map(|before| sample.time - before);
            if let Some(interval_s) = interval_s.filter(|interval_s| *interval_s > 0.0) {
                intervals.push((time, 1e3 * interval_s));
            }
            if let Some(angles) = sample.attitude {
                let degrees = angles.to_degrees();
                attitude.iter_mut().zip(degrees).for_each(|(all, angle)| all.push((time, angle)));
            }
            if interval_s.is_none() && !is_first_known {
                continue;
            }
            let values = values(&sample, interval_s.unwrap_or_default());
            for (component, value) in components.iter_mut().zip(values) {
                component.line.push((time, value));
                component.density.push(value);
            }
            while let Some((at, axes)) = suspects.next_if(|(at, _)| at - 1e-9 <= time) {
                for ((component, value), _) in
                    components.iter_mut().zip(values).zip(axes).filter(|(_, clipped)| *clipped)
                {
                    component.clipped.push((at, value));
                }
            }
        }
        let interval_s = dataset.sample_interval_s().unwrap_or(0.0);
        let mut raw = Self {
            components: Default::default(),
            clipped: Default::default(),
            spectra: Default::default(),
            intervals: intervals.finish(),
            attitude: attitude.map(Extremes::finish),
            interval_s,
        };
        for (index, Component { line, clipped, density }) in components.into_iter().enumerate() {
            raw.components[index] = line.finish();
            raw.clipped[index] = clipped;
            raw.spectra[index] = density.finish(interval_s).unwrap_or_default();
        }
        Some(raw)
    }
}

/// One component during the pass over the samples.
struct Component {
    line: Extremes,
    clipped: Vec<Point>,
    density: Density,
}

impl Component {
    fn of(count: usize) -> Self {
        Self { line: Extremes::default(), clipped: Vec::new(), density: Density::of(count) }
    }
}

/// Rates, °/s, and specific forces, m/s², of a sample.
fn values(sample: &ImuSample, interval_s: f64) -> [f64; 6] {
    let mean = sample.motion.mean_rates(interval_s);
    let [p, q, r] = mean.angular_rate_radps.to_array().map(f64::to_degrees);
    let [x, y, z] = mean.specific_force_mps2.to_array();
    [p, q, r, x, y, z]
}

/// The times of samples at the end of the range, with the affected components.
fn suspects(notices: &[Notice], clock: Clock) -> impl Iterator<Item = (f64, [bool; 6])> {
    notices.iter().filter_map(move |notice| match notice {
        Notice::SampleSuspect { time, suspicion } => {
            let ([p, q, r], [x, y, z]) = (suspicion.clipped.gyro, suspicion.clipped.accel);
            Some((clock.seconds(*time), [p, q, r, x, y, z]))
        }
        _ => None,
    })
}
