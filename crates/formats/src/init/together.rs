//! Compares the rotation of attitude and magnetic field with that of the gyro.

use crate::text::Axes;
use hovernav::imu::ImuSample;
use hovernav_dataset::Dataset;

/// Length of a comparison window, s: long enough for rotation to exceed noise, short enough to stay below a full
/// turn.
const WINDOW_S: f64 = 0.5;
/// Smallest correlation that counts as evidence.
const MIN_CORRELATION: f64 = 0.4;

/// Rotation within one window.
pub(crate) struct Step {
    /// Angle turned by the gyro about each body axis, rad.
    turned_rad: [f64; 3],
    /// Change of roll, pitch and yaw, rad.
    attitude_rad: Option<[f64; 3]>,
}

/// Rotation in each window of `imu`, the gyro converted with `axes`.
pub(crate) fn steps(imu: &[ImuSample], axes: Axes) -> Vec<Step> {
    windows(imu)
        .map(|window| {
            let (first, last) = (&window[0], &window[window.len() - 1]);
            let attitudes = first.attitude.zip(last.attitude);
            Step {
                turned_rad: turned(window, axes),
                attitude_rad: attitudes.map(|(before, after)| {
                    [
                        after.roll_rad - before.roll_rad,
                        after.pitch_rad - before.pitch_rad,
                        after.yaw_rad - before.yaw_rad,
                    ]
                    .map(hovernav::frames::wrap_angle)
                }),
            }
        })
        .collect()
}

/// Consecutive stretches of samples, each about [`WINDOW_S`] long.
fn windows(imu: &[ImuSample]) -> impl Iterator<Item = &[ImuSample]> {
    let mut rest = imu;
    std::iter::from_fn(move || {
        let first = rest.first()?;
        let length = rest.iter().take_while(|s| s.time - first.time <= WINDOW_S).count();
        let window = &rest[..length];
        rest = &rest[(length - 1).max(1)..];
        Some(window)
    })
    .filter(|window| {
        window.len() > 2 && window[window.len() - 1].time - window[0].time > 0.5 * WINDOW_S
    })
}

fn turned(window: &[ImuSample], axes: Axes) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for pair in window.windows(2) {
        let interval_s = pair[1].time - pair[0].time;
        let rates = pair[1].motion.mean_rates(interval_s).angular_rate_radps.to_array();
        sum.iter_mut().zip(axes.turned(rates)).for_each(|(sum, rate)| *sum += rate * interval_s);
    }
    sum
}

/// The signs with which roll, pitch and yaw agree with the gyro. `None` without an attitude; 1 if the rotation is too
/// small to decide.
pub(crate) fn attitude_signs(steps: &[Step]) -> Option<[f64; 3]> {
    steps.iter().any(|step| step.attitude_rad.is_some()).then(|| {
        std::array::from_fn(|axis| {
            let pairs = steps
                .iter()
                .filter_map(|step| Some((step.turned_rad[axis], step.attitude_rad?[axis])));
            if correlation(pairs) < -MIN_CORRELATION { -1.0 } else { 1.0 }
        })
    })
}

/// Ratio of the attitude's rotation to the gyro's: 1 if the units agree, 57 if rad/s were read as °/s. `None` if the
/// rotation is too small to decide.
pub(crate) fn attitude_ratio(steps: &[Step]) -> Option<f64> {
    let mut best: Option<(f64, f64)> = None;
    for axis in 0..3 {
        let pairs = || {
            steps.iter().filter_map(|step| Some((step.turned_rad[axis], step.attitude_rad?[axis])))
        };
        let correlation = correlation(pairs()).abs();
        let square = |sum: f64, value: f64| sum + value * value;
        let gyro = pairs().map(|pair| pair.0).fold(0.0, square);
        let attitude = pairs().map(|pair| pair.1).fold(0.0, square);
        if correlation > 0.8 && best.is_none_or(|(highest, _)| correlation > highest) {
            best = Some((correlation, (attitude / gyro).sqrt()));
        }
    }
    best.map(|(_, ratio)| ratio)
}

pub(super) fn correlation(pairs: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (mut xy, mut xx, mut yy) = (0.0, 0.0, 0.0);
    for (x, y) in pairs {
        xy += x * y;
        xx += x * x;
        yy += y * y;
    }
    if xx > 0.0 && yy > 0.0 { xy / (xx * yy).sqrt() } else { 0.0 }
}

/// Magnetometer axes, among all 48 assignments, with which the field rotates as the gyro measures. The gyro's axes are
/// kept unless the misfit of other axes is less than half. `None` without a magnetometer.
pub(crate) fn mag_axes(dataset: &Dataset, gyro: Axes) -> Option<Axes> {
    // Field at the start and end of each window, and the angle turned between them.
    let field_at = |sample: &ImuSample| sample.magnetic_field_gauss.map(|field| field.to_array());
    let mut steps: Vec<([f64; 3], [f64; 3], [f64; 3])> = Vec::new();
    for window in windows(&dataset.imu) {
        let (first, last) = (&window[0], &window[window.len() - 1]);
        let fields = field_at(first).zip(field_at(last)).or_else(|| {
            let near = |sample: &ImuSample| {
                let index = dataset.magnetometer.partition_point(|row| row.0 < sample.time);
                let row = dataset.magnetometer.get(index)?;
                (row.0 - sample.time < 0.1).then(|| row.1.to_array())
            };
            near(first).zip(near(last))
        });
        if let Some((before, after)) = fields {
            steps.push((before, after, turned(window, gyro)));
        }
    }
    if steps.is_empty() {
        return None;
    }
    let misfit = |axes: Axes| -> f64 {
        steps
            .iter()
            .map(|(before, after, turned)| {
                let (before, after) = (axes.turned(*before), axes.turned(*after));
                let middle: [f64; 3] = std::array::from_fn(|i| 0.5 * (before[i] + after[i]));
                // In body axes, a field fixed to the Earth rotates opposite to the vehicle.
                (0..3)
                    .map(|i| {
                        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                        let expected = middle[j] * turned[k] - middle[k] * turned[j];
                        (after[i] - before[i] - expected).powi(2)
                    })
                    .sum::<f64>()
            })
            .sum()
    };
    let own = misfit(gyro);
    let best =
        all_axes().into_iter().map(|axes| (misfit(axes), axes)).min_by(|a, b| a.0.total_cmp(&b.0));
    match best {
        Some((least, axes)) if least < 0.5 * own => Some(axes),
        _ => Some(gyro),
    }
}

/// All 48 assignments of three axes, right-handed ones first.
fn all_axes() -> Vec<Axes> {
    let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let signs =
        (0..8).map(|bits| [0, 1, 2].map(|bit| if bits >> bit & 1 == 1 { -1.0 } else { 1.0 }));
    let signs: Vec<[f64; 3]> = signs.collect();
    let pairs = orders.into_iter().flat_map(|order| signs.iter().map(move |signs| (order, *signs)));
    let mut all: Vec<Axes> =
        pairs.map(|(order, signs)| Axes(std::array::from_fn(|i| (order[i], signs[i])))).collect();
    all.sort_by_key(|axes| !is_right_handed(*axes));
    all
}

fn is_right_handed(Axes([(x, x_sign), (y, y_sign), (_, z_sign)]): Axes) -> bool {
    let even = (x + 1) % 3 == y;
    (x_sign * y_sign * z_sign > 0.0) == even
}
