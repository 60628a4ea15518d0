//! What a figure draws, as the page's script reads it: rows of series, each with a role.
//!
//! The roles carry the meaning; colour, line and symbol belong to `figures.js`.

use std::iter;

use serde::{Serialize, Serializer};

use super::decimate::decimate;

/// Most points a series keeps, more than twice what a screen is wide.
const MOST_POINTS: usize = 2400;

/// One drawing: rows stacked above a shared abscissa.
#[derive(Debug, Serialize)]
pub struct Figure {
    /// What this one shows, where a section has several; stands above it.
    #[serde(skip)]
    pub caption: Option<String>,
    pub abscissa: Abscissa,
    pub rows: Vec<Row>,
}

impl Figure {
    /// A figure against time, without the rows that have nothing to draw.
    pub fn against_time(rows: impl IntoIterator<Item = Row>) -> Self {
        Self::new(Abscissa::Time, rows)
    }

    /// A figure against an axis of its own, without the rows that have nothing to draw.
    pub fn against(axis: Axis, rows: impl IntoIterator<Item = Row>) -> Self {
        Self::new(Abscissa::Own(axis), rows)
    }

    /// A figure without the rows that have nothing to draw.
    pub fn new(abscissa: Abscissa, rows: impl IntoIterator<Item = Row>) -> Self {
        let rows = rows.into_iter().filter(|row| !row.series.is_empty()).collect();
        Self { caption: None, abscissa, rows }
    }

    /// With a heading of its own, plain text.
    pub fn captioned(self, caption: impl Into<String>) -> Self {
        Self { caption: Some(caption.into()), ..self }
    }

    /// Height on the page, px: what the drawing will take is kept free from the start, so that
    /// nothing moves as figures appear.
    pub fn height_px(&self) -> usize {
        match &self.abscissa {
            Abscissa::EastM => 640,
            Abscissa::Own(axis) if axis.to_scale => 640,
            Abscissa::Time | Abscissa::Own(_) => {
                88 + self.rows.len() * if self.rows.len() > 3 { 140 } else { 165 }
            }
        }
    }
}

#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Abscissa {
    /// The page's time axis, shared with every other figure against time.
    Time,
    /// Metres east, to the scale of the ordinate.
    EastM,
    /// The figure's own.
    Own(Axis),
}

/// An abscissa that a figure has to itself.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Axis {
    /// The quantity, with its unit.
    label: String,
    unit: &'static str,
    logarithmic: bool,
    /// Whether a unit is as long on it as on the ordinate.
    to_scale: bool,
    /// What it shows at first; all there is to draw where `None`.
    limits: Option<[f64; 2]>,
}

impl Axis {
    /// `quantity` in `unit`.
    pub fn linear(quantity: &str, unit: &'static str) -> Self {
        let label = labelled(quantity, unit);
        Self { label, unit, logarithmic: false, to_scale: false, limits: None }
    }

    /// `quantity` in `unit`, above zero.
    pub fn logarithmic(quantity: &str, unit: &'static str) -> Self {
        Self { logarithmic: true, ..Self::linear(quantity, unit) }
    }

    /// The abscissa of a plane, as long per unit as the ordinate: poles, responses.
    pub fn plane(quantity: &str, unit: &'static str) -> Self {
        Self { to_scale: true, ..Self::linear(quantity, unit) }
    }

    /// Showing no more than this at first.
    pub fn within(self, limits: [f64; 2]) -> Self {
        Self { limits: Some(limits), ..self }
    }
}

/// What stands beside an axis.
fn labelled(quantity: &str, unit: &str) -> String {
    if unit.is_empty() { quantity.into() } else { format!("{quantity}, {unit}") }
}

/// One pair of axes.
#[derive(Debug, Default, Serialize)]
pub struct Row {
    /// The quantity, with its unit.
    pub label: String,
    /// Unit alone, for the values under the pointer.
    pub unit: &'static str,
    /// Whether positive points down the page.
    pub reversed: bool,
    /// What the ordinate need not go beyond at first, however wide a band is.
    pub limits: Option<[f64; 2]>,
    /// Whether the ordinate is logarithmic.
    pub logarithmic: bool,
    /// A few words of result in the corner of the row.
    pub note: Option<String>,
    pub series: Vec<Series>,
}

impl Row {
    /// An empty row for `quantity` in `unit`.
    pub fn new(quantity: &str, unit: &'static str) -> Self {
        Self { label: labelled(quantity, unit), unit, ..Self::default() }
    }

    /// With one more series, unless it has nothing to draw.
    pub fn with(mut self, series: Series) -> Self {
        if series.x.values.iter().any(|value| value.is_finite()) {
            self.series.push(series);
        }
        self
    }
}

/// What a series is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    Estimate,
    Smoothed,
    Reference,
    Gps,
    GpsRejected,
    Start,
    End,
    Error,
    /// Where an error or innovation ought to stay.
    Bound,
    Innovation,
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
        let exact = |values| Numbers { values, digits: Digits::OfEach };
        Self::new(role, exact(x), exact(y))
    }

    /// The same under another name in the legend.
    pub fn named(self, name: impl Into<String>) -> Self {
        Self { name: Some(name.into()), ..self }
    }

    /// Separate points; those that are unknown are left out.
    pub fn points(role: Role, points: impl Iterator<Item = (f64, f64)>) -> Self {
        let (x, y): (Vec<f64>, Vec<f64>) =
            points.filter(|(x, y)| x.is_finite() && y.is_finite()).unzip();
        let picked = decimate(&[&y], MOST_POINTS);
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
    for index in decimate(channels, MOST_POINTS) {
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

fn gather(values: &[f64], picked: &[Option<usize>]) -> Numbers {
    Numbers::new(picked.iter().map(|index| index.map_or(f64::NAN, |index| values[index])).collect())
}

/// Numbers to draw; what is not finite is written as `null`, which breaks a line.
#[derive(Debug)]
pub struct Numbers {
    values: Vec<f64>,
    digits: Digits,
}

/// How exactly numbers are written.
#[derive(Debug)]
enum Digits {
    /// Five digits of the largest, but at least to a thousandth: for what is drawn to one scale.
    OfLargest,
    /// Five digits of each: for logarithmic axes.
    OfEach,
}

impl Numbers {
    fn new(values: Vec<f64>) -> Self {
        Self { values, digits: Digits::OfLargest }
    }
}

impl Serialize for Numbers {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let decimals = |size: f64| 4.0 - size.max(1e-12).log10().floor();
        let sizes = self.values.iter().filter(|value| value.is_finite()).map(|value| value.abs());
        let of_largest = decimals(sizes.fold(0.0, f64::max)).clamp(3.0, 15.0);
        serializer.collect_seq(self.values.iter().map(|value| {
            let decimals = match self.digits {
                Digits::OfLargest => of_largest,
                Digits::OfEach => decimals(value.abs()).clamp(0.0, 15.0),
            };
            let scale = 10f64.powi(decimals as i32);
            let rounded = (value * scale).round() / scale;
            rounded.is_finite().then_some(rounded)
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(values: &[f64]) -> String {
        serde_json::to_string(&Numbers::new(values.to_vec())).unwrap()
    }

    #[test]
    fn numbers_keep_five_digits_of_the_largest_and_unknown_ones_are_null() {
        assert_eq!(text(&[1.234_567_89, 0.000_001_2]), "[1.2346,0.0]");
        assert_eq!(text(&[123_456.789_12, 1.0]), "[123456.789,1.0]");
        assert_eq!(text(&[1.234_567_89e-6]), "[1.2346e-6]");
        assert_eq!(text(&[f64::NAN, f64::INFINITY, f64::NEG_INFINITY]), "[null,null,null]");
        assert_eq!(text(&[f64::MAX]), "[null]");
        assert_eq!(text(&[]), "[]");
    }

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

    #[test]
    fn a_row_takes_no_series_that_has_nothing_to_draw() {
        let row = Row::new("North", "m")
            .with(Series::line(Role::Reference, &[0.0, 1.0], &[f64::NAN, f64::NAN], None))
            .with(Series::line(Role::Estimate, &[], &[], Some(&[])))
            .with(Series::bound(&[0.0], &[f64::NAN]))
            .with(Series::points(Role::Gps, iter::empty()));
        assert!(row.series.is_empty());
        assert!(Figure::against_time([row]).rows.is_empty());
    }
}
