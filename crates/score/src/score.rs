//! Scores: errors of a solution against the reference.

use serde::Serialize;

use hovernav::earth::Geodetic;
use hovernav::ekf::Solution;
use hovernav::frames::{Vector, wrap_angle};
use hovernav::ins::LeverArm;
use hovernav::time::Time;
use hovernav_dataset::statistics::{quantile, thin_to_extremes, within};
use hovernav_dataset::{Reference, ReferenceMoment};

/// A scored quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Axis {
    /// Position north.
    North,
    /// Position east.
    East,
    /// Position down.
    Down,
    /// Horizontal distance.
    Horizontal,
    /// Velocity north.
    VelocityNorth,
    /// Velocity east.
    VelocityEast,
    /// Velocity down.
    VelocityDown,
    /// Velocity forward.
    U,
    /// Velocity to the right.
    V,
    /// Velocity down through the vehicle.
    W,
    /// Roll.
    Roll,
    /// Pitch.
    Pitch,
    /// Yaw.
    Yaw,
}

impl Axis {
    /// All axes, in the order of [`Score::axes`].
    pub const ALL: [Self; 13] = [
        Self::North,
        Self::East,
        Self::Down,
        Self::Horizontal,
        Self::VelocityNorth,
        Self::VelocityEast,
        Self::VelocityDown,
        Self::U,
        Self::V,
        Self::W,
        Self::Roll,
        Self::Pitch,
        Self::Yaw,
    ];

    /// Name in `summary.json`, which ends in the unit.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::North => "north_m",
            Self::East => "east_m",
            Self::Down => "down_m",
            Self::Horizontal => "horizontal_m",
            Self::VelocityNorth => "vn_mps",
            Self::VelocityEast => "ve_mps",
            Self::VelocityDown => "vd_mps",
            Self::U => "u_mps",
            Self::V => "v_mps",
            Self::W => "w_mps",
            Self::Roll => "roll_deg",
            Self::Pitch => "pitch_deg",
            Self::Yaw => "yaw_deg",
        }
    }

    /// One-sigma of `reference` itself in this axis, in the unit of [`name`](Self::name).
    #[must_use]
    pub const fn own_sigma(self, reference: &Reference) -> f64 {
        match self {
            Self::North | Self::East | Self::Down | Self::Horizontal => reference.position_sigma_m,
            Self::Roll | Self::Pitch | Self::Yaw => reference.attitude_sigma_deg,
            _ => reference.velocity_sigma_mps,
        }
    }
}

/// Errors of a solution against the reference, axis by axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Score {
    /// Start of scoring; earlier times appear only in the series.
    pub from: Time,
    /// Time at which the heading was first known, if after [`from`](Self::from): the one-sigma of the solution is at
    /// most 15°. Attitude is scored from then on.
    pub heading_known: Option<Time>,
    /// The axes in the reference, in the order of [`Axis::ALL`].
    pub axes: Vec<AxisScore>,
}

/// Errors of a solution against the reference in one axis.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisScore {
    /// The axis.
    pub axis: Axis,
    /// Statistics of the error, in the unit of [`Axis::name`].
    pub statistics: Statistics,
    /// Number of samples compared.
    pub samples: usize,
    /// Fraction of samples whose error is within three sigmas: 0.997 for a consistent filter. `None` if the filter
    /// gives no sigma. The variance is the sum of the variances of filter and reference.
    pub within_3_sigma: Option<f64>,
    /// Root mean square of error over sigma, with the sigma of `within_3_sigma`: 1 for a consistent filter. `None` if a
    /// sigma is zero.
    pub error_over_sigma: Option<f64>,
    /// The error over time, thinned to at most 2 000 points that keep its peaks.
    pub series: Vec<ErrorPoint>,
}

/// Error at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorPoint {
    /// Time.
    pub time: Time,
    /// Solution less reference.
    pub error: f64,
    /// The filter's own one-sigma, if it gives one.
    pub sigma: Option<f64>,
}

/// Statistics of a set of errors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Statistics {
    /// Root of the mean square.
    pub rmse: f64,
    /// Median of the absolute error.
    pub median: f64,
    /// 95 % quantile of the absolute error.
    pub p95: f64,
    /// Largest absolute error.
    pub max: f64,
}

/// Largest number of points in an error series.
const SERIES_POINTS: usize = 2000;

/// Smallest fraction of an outage that solution and reference must cover for its drift to count.
const MIN_COVERAGE: f64 = 0.9;

impl Score {
    /// The score in `axis`, if the reference has that quantity.
    #[must_use]
    pub fn axis(&self, axis: Axis) -> Option<&AxisScore> {
        self.axes.iter().find(|score| score.axis == axis)
    }
}

impl Statistics {
    /// Statistics of the absolute values of `errors`, with quantiles as in [`quantile`]. `None` without errors, or if
    /// one is NaN.
    #[must_use]
    pub fn of(errors: &[f64]) -> Option<Self> {
        let mut sizes: Vec<f64> = errors.iter().map(|error| error.abs()).collect();
        if sizes.iter().any(|size| size.is_nan()) {
            return None;
        }
        let square_sum: f64 = errors.iter().map(|error| error * error).sum();
        Some(Self {
            rmse: (square_sum / errors.len() as f64).sqrt(),
            median: quantile(&mut sizes, 0.5)?,
            p95: quantile(&mut sizes, 0.95)?,
            max: sizes.iter().copied().fold(0.0, f64::max),
        })
    }
}

/// Scores `solutions`, in time order, against `reference`. Scoring begins the reference's `skip_s` after `first_imu`,
/// the first inertial sample.
///
/// The lever arm r moves the solution to the reference's point: its position by C r, its velocity by C (ω × r). The
/// filter's sigmas are used unchanged, without the attitude's uncertainty times the arm.
#[must_use]
pub fn score(solutions: &[Solution], reference: &Reference, first_imu: Time) -> Score {
    let from = first_imu.offset_by(reference.skip_s);
    let mut columns: [Vec<ErrorPoint>; 13] = Default::default();
    for solution in solutions {
        let errors = axis_errors(solution, reference);
        let sigmas = axis_sigmas(solution);
        for ((column, error), sigma) in columns.iter_mut().zip(errors).zip(sigmas) {
            if error.is_finite() {
                column.push(ErrorPoint { time: solution.time, error, sigma });
            }
        }
    }
    let heading_known = heading_known(solutions).filter(|known| *known > from);
    let axes = Axis::ALL.into_iter().zip(columns).filter_map(|(axis, points)| {
        let is_attitude = matches!(axis, Axis::Roll | Axis::Pitch | Axis::Yaw);
        let from = if is_attitude { heading_known.unwrap_or(from) } else { from };
        score_axis(axis, &points, from, axis.own_sigma(reference))
    });
    Score { from, heading_known, axes: axes.collect() }
}

/// Largest one-sigma of a known heading, rad.
const HEADING_KNOWN_RAD: f64 = 15.0 * std::f64::consts::PI / 180.0;

/// Time at which the heading is first known; `None` if it is never known, or known from the start.
fn heading_known(solutions: &[Solution]) -> Option<Time> {
    let known = |solution: &Solution| {
        let [.., sigma_rad] = solution.attitude_sigma_rad;
        // A solution without sigmas counts as known.
        sigma_rad.is_nan() || sigma_rad <= HEADING_KNOWN_RAD
    };
    solutions.iter().find(|solution| known(solution)).map(|solution| solution.time)
}

/// Drift in an outage: largest horizontal distance from `reference` that `solutions`, in time order, reach from `start`
/// until `duration_s` later, m.
///
/// `None` unless solution and reference together cover nine tenths of that time. [`Statistics::of`] the drifts of
/// several outages gives their median and maximum.
#[must_use]
pub fn outage_drift(
    solutions: &[Solution],
    reference: &Reference,
    start: Time,
    duration_s: f64,
) -> Option<f64> {
    let end = start.offset_by(duration_s);
    let solutions = within(solutions, |solution| solution.time, start, end);
    let distances: Vec<(Time, f64)> = solutions
        .iter()
        .map(|solution| {
            (solution.time, axis_errors(solution, reference)[Axis::Horizontal as usize])
        })
        .filter(|(_, distance)| distance.is_finite())
        .collect();
    let covered_s = distances.last()?.0 - distances.first()?.0;
    let is_covered = covered_s >= MIN_COVERAGE * duration_s
        && distances.len() as f64 >= MIN_COVERAGE * solutions.len() as f64;
    is_covered.then(|| distances.iter().map(|(_, distance)| *distance).fold(0.0, f64::max))
}

fn score_axis(axis: Axis, points: &[ErrorPoint], from: Time, own_sigma: f64) -> Option<AxisScore> {
    let scored = &points[points.partition_point(|point| point.time < from)..];
    let errors: Vec<f64> = scored.iter().map(|point| point.error).collect();
    let with_sigma: Vec<(f64, f64)> = scored
        .iter()
        .filter_map(|point| Some((point.error, point.sigma?.hypot(own_sigma))))
        .collect();
    let samples = with_sigma.len() as f64;
    let within = with_sigma.iter().filter(|(error, sigma)| error.abs() <= 3.0 * sigma).count();
    let squares: f64 = with_sigma.iter().map(|(error, sigma)| (error / sigma).powi(2)).sum();
    let error_over_sigma = (squares / samples).sqrt();
    Some(AxisScore {
        axis,
        statistics: Statistics::of(&errors)?,
        samples: errors.len(),
        within_3_sigma: (!with_sigma.is_empty()).then(|| within as f64 / samples),
        error_over_sigma: error_over_sigma.is_finite().then_some(error_over_sigma),
        series: thinned(points),
    })
}

/// Solution minus reference in the order of [`Axis::ALL`]; NaN if the reference is unknown.
#[must_use]
pub fn axis_errors(solution: &Solution, reference: &Reference) -> [f64; 13] {
    let ReferenceMoment { position, velocity_mps, attitude_rad, body_velocity_mps } =
        reference.at(solution.time);
    let arm_m = reference.from_solution_point_m;
    let body_to_ned = solution.body_to_ned;
    // Without a lever arm the attitude may be unknown.
    let has_arm = arm_m != Vector::ZERO;
    let in_ned = |of_arm| if has_arm { body_to_ned * of_arm } else { Vector::ZERO };

    let [latitude_rad, longitude_rad, height_m] = position;
    let there = Geodetic { latitude_rad, longitude_rad, height_m };
    // An unknown height must not make north and east unknown.
    let base = Geodetic {
        height_m: if height_m.is_finite() { height_m } else { solution.position.height_m },
        ..there
    };
    let [arm_north, arm_east, arm_down] = in_ned(arm_m).to_array();
    let [north, east, _] = solution.position.displacement_from(&base).to_array();
    let (north, east) = (north + arm_north, east + arm_east);
    let down = height_m - solution.position.height_m + arm_down;

    let of_arm_mps = match has_arm {
        true => LeverArm(arm_m).relative_velocity(solution.angular_rate_radps),
        false => Vector::ZERO,
    };
    let [vn, ve, vd] = (solution.velocity_mps + in_ned(of_arm_mps)).to_array();
    let [u, v, w] = (solution.velocity_body_mps() + of_arm_mps).to_array();
    let angles = body_to_ned.euler();
    let turn_deg =
        |angle_rad: f64, reference_rad: f64| wrap_angle(angle_rad - reference_rad).to_degrees();
    [
        north,
        east,
        down,
        north.hypot(east),
        vn - velocity_mps[0],
        ve - velocity_mps[1],
        vd - velocity_mps[2],
        u - body_velocity_mps[0],
        v - body_velocity_mps[1],
        w - body_velocity_mps[2],
        turn_deg(angles.roll_rad, attitude_rad[0]),
        turn_deg(angles.pitch_rad, attitude_rad[1]),
        turn_deg(angles.yaw_rad, attitude_rad[2]),
    ]
}

/// The filter's own one-sigma in the order of [`Axis::ALL`].
#[must_use]
pub fn axis_sigmas(solution: &Solution) -> [Option<f64>; 13] {
    let [n, e, d] = solution.position_sigma_m.to_array().map(Some);
    let [vn, ve, vd] = solution.velocity_sigma_mps.to_array().map(Some);
    let [roll, pitch, yaw] = solution.attitude_sigma_rad.map(|sigma| Some(sigma.to_degrees()));
    let sigmas = [n, e, d, None, vn, ve, vd, None, None, None, roll, pitch, yaw];
    sigmas.map(|sigma| sigma.filter(|sigma| !sigma.is_nan()))
}

/// At most [`SERIES_POINTS`] of `points`, including the peaks.
fn thinned(points: &[ErrorPoint]) -> Vec<ErrorPoint> {
    let errors: Vec<f64> = points.iter().map(|point| point.error).collect();
    thin_to_extremes(&[&errors], SERIES_POINTS).into_iter().map(|index| points[index]).collect()
}
