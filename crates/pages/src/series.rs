//! A series of points, each with a role: estimate, reference, limit.
//!
//! The role defines the meaning. `figures.js` defines colour, line and symbol.

use std::iter;

use hovernav_dataset::statistics::thin_to_extremes;
use serde::Serialize;

use crate::numbers::Numbers;

/// Largest number of points in a series, more than a figure has pixels across.
pub(crate) const MAX_POINTS: usize = 1800;

/// The meaning of a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// The solution of the filter.
    Estimate,
    /// The solution of the smoother.
    Smoothed,
    /// The reference.
    Reference,
    /// The onboard estimator; never used as truth.
    Onboard,
    /// A fix that the filter used.
    Gps,
    /// A fix that the filter rejected.
    GpsRejected,
    /// A sensor other than the receiver: attitude of the inertial unit, barometer.
    Sensor,
    /// Raw samples.
    Raw,
    /// Samples at the end of a sensor's range.
    Clipped,
    /// The uncertainty of a point of a track.
    Ellipse,
    /// The start of a track.
    Start,
    /// The end of a track.
    End,
    /// An error against the reference.
    Error,
    /// The expected limits of an error or innovation.
    Bound,
    /// An innovation of an accepted measurement.
    Innovation,
    /// An innovation of the onboard estimator.
    OnboardInnovation,
    /// An innovation of a rejected measurement.
    Rejected,
    /// An innovation of a measurement to which the filter was reset.
    Reopened,
    /// A normalised innovation squared.
    Test,
    /// A normalised innovation squared of a rejected measurement.
    TestRefused,
    /// The 95 % interval of a test.
    Interval,
    /// A running mean.
    Mean,
    /// Flight data, for comparison with a model.
    Flight,
    /// The output of a model.
    Model,
    /// An input, held from one point to the next.
    Input,
    /// Flight minus model.
    Residual,
    /// A limit.
    Limit,
    /// The limit of the first component, if each component has its own.
    FirstLimit,
    /// The limit of the second component.
    SecondLimit,
    /// The limit of the third component.
    ThirdLimit,
    /// A pole of a model.
    Pole,
    /// A pole of the other model.
    AlternativePole,
    /// The outline of the uncertainty of a point.
    Region,
    /// The outline of the uncertainty in the other model.
    AlternativeRegion,
    /// The first of the components of one quantity.
    First,
    /// The second component.
    Second,
    /// The third component.
    Third,
    /// The fourth component.
    Fourth,
}

/// The shaded range of a series.
#[derive(Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Band {
    /// The distance above and below the series itself.
    Around(Numbers),
    /// The distance above and below zero.
    AboutZero(Numbers),
    /// The range between the first and the second numbers.
    Between(Numbers, Numbers),
}

/// Points with one role.
#[derive(Debug, Serialize)]
pub struct Series {
    /// The meaning of the points.
    pub role: Role,
    /// Name in the legend, if it differs from the name of the role.
    pub name: Option<String>,
    /// The abscissae.
    pub x: Numbers,
    /// The ordinates.
    pub y: Numbers,
    /// The shaded range, if there is one.
    pub band: Option<Band>,
    /// Time of each point, if the abscissa is not time.
    pub time: Option<Numbers>,
    /// The colour of each point, if it is not that of the role.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shade: Option<Shade>,
}

/// A quantity that colours the points of a series.
#[derive(Debug, Serialize)]
pub struct Shade {
    /// The quantity at each point.
    pub values: Numbers,
    /// Its unit.
    pub label: &'static str,
}

impl Series {
    /// A line, with an optional band of `half_width` around it, interrupted at missing or unknown samples.
    pub fn line(role: Role, x: &[f64], y: &[f64], half_width: Option<&[f64]>) -> Self {
        let channels: Vec<&[f64]> = iter::once(y).chain(half_width).collect();
        Self::through(role, x, y, half_width, &line_indices(x, &channels))
    }

    /// A line of an angle in degrees, also interrupted where the angle wraps at ±180.
    pub fn heading(role: Role, x: &[f64], y: &[f64], half_width: Option<&[f64]>) -> Self {
        let channels: Vec<&[f64]> = iter::once(y).chain(half_width).collect();
        let mut picked = Vec::new();
        for next in line_indices(x, &channels) {
            if let (Some(&Some(last)), Some(next)) = (picked.last(), next)
                && f64::abs(y[next] - y[last]) > 180.0
            {
                picked.push(None);
            }
            picked.push(next);
        }
        Self::through(role, x, y, half_width, &picked)
    }

    /// The ground track as a line, with `time` of each point.
    pub fn track(role: Role, time: &[f64], [north, east]: [&[f64]; 2]) -> Self {
        let picked = line_indices(time, &[north, east]);
        Self {
            time: Some(gather(time, &picked)),
            ..Self::new(role, gather(east, &picked), gather(north, &picked))
        }
    }

    /// A ground track whose colour is `shade`, in the unit `label`.
    pub fn shaded_track(
        role: Role,
        time: &[f64],
        [north, east]: [&[f64]; 2],
        shade: &[f64],
        label: &'static str,
    ) -> Self {
        let picked = line_indices(time, &[north, east, shade]);
        Self {
            time: Some(gather(time, &picked)),
            shade: Some(Shade { values: gather(shade, &picked), label }),
            ..Self::new(role, gather(east, &picked), gather(north, &picked))
        }
    }

    /// A shaded range only, `half_width` to either side of zero.
    pub fn bound(x: &[f64], half_width: &[f64]) -> Self {
        let picked = line_indices(x, &[half_width]);
        let band = Some(Band::AboutZero(gather(half_width, &picked)));
        Self { band, ..Self::new(Role::Bound, gather(x, &picked), Numbers::new(Vec::new())) }
    }

    /// A shaded range only.
    pub fn range(role: Role, x: &[f64], low: &[f64], high: &[f64]) -> Self {
        let picked = line_indices(x, &[low, high]);
        let between = Band::Between(gather(low, &picked), gather(high, &picked));
        Self {
            band: Some(between),
            ..Self::new(role, gather(x, &picked), Numbers::new(Vec::new()))
        }
    }

    /// A curve through points in the given order, such as a locus, a response or an outline. It is interrupted at
    /// coordinates that are not finite. Each number keeps five significant digits.
    pub fn curve(role: Role, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let broken = |(x, y): (f64, f64)| {
            if x.is_finite() && y.is_finite() { (x, y) } else { (f64::NAN, f64::NAN) }
        };
        let (x, y) = points.into_iter().map(broken).unzip();
        Self::new(role, Numbers::with_digits_of_each(x), Numbers::with_digits_of_each(y))
    }

    /// Sets the name in the legend.
    pub fn named(self, name: impl Into<String>) -> Self {
        Self { name: Some(name.into()), ..self }
    }

    /// Separate points, without the unknown ones.
    pub fn points(role: Role, points: impl Iterator<Item = (f64, f64)>) -> Self {
        let (x, y): (Vec<f64>, Vec<f64>) =
            points.filter(|(x, y)| x.is_finite() && y.is_finite()).unzip();
        let picked = thin_to_extremes(&[&y], MAX_POINTS);
        let take =
            |values: &[f64]| Numbers::new(picked.iter().map(|&index| values[index]).collect());
        Self::new(role, take(&x), take(&y))
    }

    fn through(
        role: Role,
        x: &[f64],
        y: &[f64],
        half_width: Option<&[f64]>,
        picked: &[Option<usize>],
    ) -> Self {
        Self {
            band: half_width.map(|half_width| Band::Around(gather(half_width, picked))),
            ..Self::new(role, gather(x, picked), gather(y, picked))
        }
    }

    fn new(role: Role, x: Numbers, y: Numbers) -> Self {
        Self { role, name: None, x, y, band: None, time: None, shade: None }
    }
}

/// The samples that draw a line against `x`, with `None` at each interruption: where a channel is not finite, or where
/// a step of `x` exceeds ten times the average step.
fn line_indices(x: &[f64], channels: &[&[f64]]) -> Vec<Option<usize>> {
    let known = |index: usize| channels.iter().all(|channel| channel[index].is_finite());
    let longest = match (x.first(), x.last()) {
        (Some(first), Some(last)) => 10.0 * (last - first).abs() / x.len() as f64,
        _ => return Vec::new(),
    };
    let breaks =
        (1..x.len()).filter(|&index| !known(index) || (x[index] - x[index - 1]).abs() > longest);
    let mut breaks = breaks.peekable();
    let mut picked: Vec<Option<usize>> = Vec::new();
    for index in thin_to_extremes(channels, MAX_POINTS) {
        let mut broken = false;
        while breaks.next_if(|&at| at <= index).is_some() {
            broken = true;
        }
        if broken && picked.last().is_some_and(Option::is_some) {
            picked.push(None);
        }
        if known(index) {
            picked.push(Some(index));
        }
    }
    picked
}

/// The picked samples, with NaN where the line is interrupted.
fn gather(values: &[f64], picked: &[Option<usize>]) -> Numbers {
    Numbers::new(picked.iter().map(|index| index.map_or(f64::NAN, |index| values[index])).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_keeps_five_digits_of_each_number() {
        let curve = Series::curve(Role::Model, [(0.012_345_67, 1e-7), (123.456_789, f64::NAN)]);
        let text = serde_json::to_string(&[curve.x, curve.y]).unwrap();
        assert_eq!(text, "[[0.012346,null],[1e-7,null]]");
    }

    #[test]
    fn a_line_breaks_where_samples_are_missing_or_unknown() {
        let mut x: Vec<f64> = (0..1000).map(|i| f64::from(i) * 0.01).collect();
        let mut y = x.clone();
        y[10] = f64::NAN;
        x[500..].iter_mut().for_each(|time| *time += 5.0);
        let line = Series::line(Role::Estimate, &x, &y, None);
        let nulls = line.y.values.iter().filter(|value| value.is_nan()).count();
        assert_eq!((nulls, line.y.values.len()), (2, 1001));
        assert!(line.y.values[10].is_nan() && line.y.values[500].is_nan());
    }

    #[test]
    fn a_gap_between_the_samples_kept_of_a_long_line_is_still_a_gap() {
        let mut x: Vec<f64> = (0..100_000).map(|i| f64::from(i) * 0.01).collect();
        x[50_001..].iter_mut().for_each(|time| *time += 60.0);
        let y: Vec<f64> = x.iter().map(|t| t.sin()).collect();
        let line = Series::line(Role::Estimate, &x, &y, Some(&vec![1.0; 100_000]));
        assert_eq!(line.x.values.iter().filter(|value| value.is_nan()).count(), 1);
        assert!(line.x.values.len() <= MAX_POINTS + 1);
    }

    #[test]
    fn a_heading_through_south_is_not_drawn_as_a_full_turn() {
        let x: Vec<f64> = (0..100).map(f64::from).collect();
        let y: Vec<f64> = x.iter().map(|t| if *t < 50.0 { 179.0 } else { -179.0 }).collect();
        let line = Series::heading(Role::Estimate, &x, &y, None);
        assert!(line.y.values[50].is_nan() && line.y.values.len() == 101);
    }
}
