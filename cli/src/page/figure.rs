//! What a figure draws, as the page's script reads it: rows of series above one abscissa.

use serde::Serialize;

use super::fact::digits;
use super::series::Series;
use super::verdict::Level;

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

    /// What it draws, for who cannot see it: the title of its section, its own, and each row with its
    /// extent.
    pub fn described(&self, title: &str) -> String {
        let range = |label: &str, values: &mut dyn Iterator<Item = &f64>| {
            let (low, high) = values
                .filter(|value| value.is_finite())
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                    (low.min(*value), high.max(*value))
                });
            match low <= high {
                true => format!("{label} from {} to {}", digits(low), digits(high)),
                false => label.to_owned(),
            }
        };
        let row = |row: &Row| {
            let mut values = row.series.iter().flat_map(|series| &series.y.values);
            let note = row.note.as_ref().map_or(String::new(), |note| format!(", {note}"));
            range(&row.label, &mut values) + &note
        };
        let mut rows: Vec<String> = self.rows.iter().map(row).collect();
        if self.abscissa == Abscissa::EastM {
            let series = self.rows.iter().flat_map(|row| &row.series);
            rows.push(range("East, m", &mut series.flat_map(|series| &series.x.values)));
        }
        let caption = self.caption.as_ref().map_or(String::new(), |caption| format!(", {caption}"));
        format!("{title}{caption}: {}", rows.join("; "))
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
    /// How the note is to be taken, where it judges.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub judged: Option<Level>,
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

#[cfg(test)]
mod tests {
    use super::super::series::Role;
    use super::*;

    #[test]
    fn a_row_takes_no_series_that_has_nothing_to_draw() {
        let row = Row::new("North", "m")
            .with(Series::line(Role::Reference, &[0.0, 1.0], &[f64::NAN, f64::NAN], None))
            .with(Series::line(Role::Estimate, &[], &[], Some(&[])))
            .with(Series::bound(&[0.0], &[f64::NAN]))
            .with(Series::points(Role::Gps, std::iter::empty()));
        assert!(row.series.is_empty());
        assert!(Figure::against_time([row]).rows.is_empty());
    }
}
