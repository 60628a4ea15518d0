//! The figures as the page's script reads them: rows of series above a common abscissa.

use serde::Serialize;

use crate::fact::digits;
use crate::series::Series;
use hovernav_score::Level;

/// One figure: rows stacked above a common abscissa.
#[derive(Debug, Serialize)]
pub struct Figure {
    /// Caption above the figure, if a section has several figures.
    #[serde(skip)]
    pub caption: Option<String>,
    /// The common abscissa.
    pub abscissa: Abscissa,
    /// The rows, from top to bottom.
    pub rows: Vec<Row>,
}

impl Figure {
    /// A figure against time, without empty rows.
    pub fn against_time(rows: impl IntoIterator<Item = Row>) -> Self {
        Self::new(Abscissa::Time, rows)
    }

    /// A figure against its own axis, without empty rows.
    pub fn against(axis: Axis, rows: impl IntoIterator<Item = Row>) -> Self {
        Self::new(Abscissa::Own(axis), rows)
    }

    /// A figure without empty rows.
    pub fn new(abscissa: Abscissa, rows: impl IntoIterator<Item = Row>) -> Self {
        let rows = rows.into_iter().filter(|row| !row.series.is_empty()).collect();
        Self { caption: None, abscissa, rows }
    }

    /// Sets the caption, plain text.
    pub fn captioned(self, caption: impl Into<String>) -> Self {
        Self { caption: Some(caption.into()), ..self }
    }

    /// A description for screen readers: title of the section, caption, and each row with its range.
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

    /// Height on the page, px. The space is reserved from the start, so that the page does not move when figures
    /// appear.
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

/// The abscissa of a figure.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Abscissa {
    /// The page's time axis, common to all figures against time.
    Time,
    /// Metres east, to the scale of the ordinate.
    EastM,
    /// An axis of this figure alone.
    Own(Axis),
}

/// The abscissa of one figure.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Axis {
    /// The quantity, with its unit.
    label: String,
    unit: &'static str,
    logarithmic: bool,
    /// Whether the abscissa has the same scale as the ordinate.
    to_scale: bool,
    /// The initial limits; `None` shows all data.
    limits: Option<[f64; 2]>,
}

impl Axis {
    /// An axis for `quantity` in `unit`.
    pub fn linear(quantity: &str, unit: &'static str) -> Self {
        let label = labelled(quantity, unit);
        Self { label, unit, logarithmic: false, to_scale: false, limits: None }
    }

    /// A logarithmic axis for `quantity` in `unit`, for positive values.
    pub fn logarithmic(quantity: &str, unit: &'static str) -> Self {
        Self { logarithmic: true, ..Self::linear(quantity, unit) }
    }

    /// The abscissa of a plane with equal scales: poles, responses.
    pub fn plane(quantity: &str, unit: &'static str) -> Self {
        Self { to_scale: true, ..Self::linear(quantity, unit) }
    }

    /// Sets the initial limits.
    pub fn within(self, limits: [f64; 2]) -> Self {
        Self { limits: Some(limits), ..self }
    }
}

/// The label of an axis.
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
    /// Whether positive values point down the page.
    pub reversed: bool,
    /// Initial limits of the ordinate, even if a band is wider.
    pub limits: Option<[f64; 2]>,
    /// Whether the ordinate is logarithmic.
    pub logarithmic: bool,
    /// A short result in the corner of the row.
    pub note: Option<String>,
    /// The level of the note, if it is a judgement.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub judged: Option<Level>,
    /// The series, in drawing order.
    pub series: Vec<Series>,
}

impl Row {
    /// An empty row for `quantity` in `unit`.
    pub fn new(quantity: &str, unit: &'static str) -> Self {
        Self { label: labelled(quantity, unit), unit, ..Self::default() }
    }

    /// Adds a series, unless it is empty.
    pub fn with(mut self, series: Series) -> Self {
        if series.x.values.iter().any(|value| value.is_finite()) {
            self.series.push(series);
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::series::Role;

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
