//! A series of points, each with a role: estimate, reference, limit.
//!
//! The roles carry the meaning; colour, line and symbol belong to `figures.js`.

use std::iter;

use hovernav_log::statistics::thin_to_extremes;
use serde::Serialize;

use super::numbers::Numbers;

/// Most points a series keeps, more than a figure has pixels across.
pub(super) const MOST_POINTS: usize = 1800;

/// What a series is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    Estimate,
    Smoothed,
    Reference,
    /// What the estimator on board said: never the truth.
    Onboard,
    Gps,
    GpsRejected,
    /// What a sensor said by itself, apart from the receiver: attitude of the unit, barometer.
    Sensor,
    /// Samples as they came.
    Raw,
    /// Samples at the end of a sensor's range.
    Clipped,
    /// Where a point may be, about a track.
    Ellipse,
    Start,
    End,
    Error,
    /// Where an error or innovation ought to stay.
    Bound,
    Innovation,
    /// Of the estimator on board.
    OnboardInnovation,
    Rejected,
    Reopened,
    /// A normalised innovation squared.
    Test,
    TestRefused,
    /// Where a test ought to fall, 95 times of 100.
    Interval,
    Mean,
    /// What a vehicle did, against which a model is held.
    Flight,
    /// What a model says of it.
    Model,
    /// What was put in: held from one point to the next.
    Input,
    /// Flight less model.
    Residual,
    /// A value not to be passed.
    Limit,
    /// The same of one component alone, of as many as have one of their own.
    FirstLimit,
    SecondLimit,
    ThirdLimit,
    Pole,
    /// A pole of the other model.
    AlternativePole,
    /// Outlines of where a point may be.
    Region,
    AlternativeRegion,
    /// The components of one quantity, in their order.
    First,
    Second,
    Third,
    Fourth,
}

/// The shaded range that goes with a series.
#[derive(Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Band {
    /// This far above and below the series itself.
    Around(Numbers),
    /// This far above and below zero.
    AboutZero(Numbers),
    /// From the first to the second.
    Between(Numbers, Numbers),
}

/// Points of one role.
#[derive(Debug, Serialize)]
pub struct Series {
    pub role: Role,
    /// Its name in the legend, where the role's own does not do.
    pub name: Option<String>,
    pub x: Numbers,
    pub y: Numbers,
    pub band: Option<Band>,
    /// Time of each point, where the abscissa is not time.
    pub time: Option<Numbers>,
}

impl Series {
    /// A line, with a band of `half_width` about it if there is one, broken where samples are
    /// missing or unknown.
    pub fn line(role: Role, x: &[f64], y: &[f64], half_width: Option<&[f64]>) -> Self {
        let channels: Vec<&[f64]> = iter::once(y).chain(half_width).collect();
        Self::through(role, x, y, half_width, &line_indices(x, &channels))
    }

    /// A line of an angle in degrees that jumps at ±180: broken there too.
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

    /// The ground track of a line.
    pub fn track(role: Role, time: &[f64], [north, east]: [&[f64]; 2]) -> Self {
        let picked = line_indices(time, &[north, east]);
        Self {
            time: Some(gather(time, &picked)),
            ..Self::new(role, gather(east, &picked), gather(north, &picked))
        }
    }

    /// A shaded range alone, `half_width` to either side of zero.
    pub fn bound(x: &[f64], half_width: &[f64]) -> Self {
        let picked = line_indices(x, &[half_width]);
        let band = Some(Band::AboutZero(gather(half_width, &picked)));
        Self { band, ..Self::new(Role::Bound, gather(x, &picked), Numbers::new(Vec::new())) }
    }

    /// A shaded range alone.
    pub fn range(role: Role, x: &[f64], low: &[f64], high: &[f64]) -> Self {
        let picked = line_indices(x, &[low, high]);
        let between = Band::Between(gather(low, &picked), gather(high, &picked));
        Self {
            band: Some(between),
            ..Self::new(role, gather(x, &picked), Numbers::new(Vec::new()))
        }
    }

    /// A curve through points in the order given, such as a locus, a response or an outline; broken
    /// where a coordinate is not finite. Each number keeps five digits of its own.
    pub fn curve(role: Role, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let broken = |(x, y): (f64, f64)| {
            if x.is_finite() && y.is_finite() { (x, y) } else { (f64::NAN, f64::NAN) }
        };
        let (x, y) = points.into_iter().map(broken).unzip();
        Self::new(role, Numbers::with_digits_of_each(x), Numbers::with_digits_of_each(y))
    }

    /// The same under another name in the legend.
    pub fn named(self, name: impl Into<String>) -> Self {
        Self { name: Some(name.into()), ..self }
    }

    /// Separate points; those that are unknown are left out.
    pub fn points(role: Role, points: impl Iterator<Item = (f64, f64)>) -> Self {
        let (x, y): (Vec<f64>, Vec<f64>) =
            points.filter(|(x, y)| x.is_finite() && y.is_finite()).unzip();
        let picked = thin_to_extremes(&[&y], MOST_POINTS);
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
        Self { role, name: None, x, y, band: None, time: None }
    }
}

/// The samples that draw a line against `x`, and `None` where it must break: where the channels are
/// not all finite, or `x` steps more than ten times as far as it does on average.
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
    for index in thin_to_extremes(channels, MOST_POINTS) {
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

/// The samples picked, not a number where the line breaks.
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
        assert!(line.x.values.len() <= MOST_POINTS + 1);
    }

    #[test]
    fn a_heading_through_south_is_not_drawn_as_a_full_turn() {
        let x: Vec<f64> = (0..100).map(f64::from).collect();
        let y: Vec<f64> = x.iter().map(|t| if *t < 50.0 { 179.0 } else { -179.0 }).collect();
        let line = Series::heading(Role::Estimate, &x, &y, None);
        assert!(line.y.values[50].is_nan() && line.y.values.len() == 101);
    }
}
