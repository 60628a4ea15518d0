//! Quantities of the columns of a file, as far as the names state them.

use super::look::Look;
use super::names::Meaning;
use super::quantity::Quantity;
use crate::text::HeightAbove;

/// The meanings of the columns; a look-up returns the first column of a quantity.
pub(crate) struct Known {
    pub meanings: Vec<Option<Meaning>>,
}

impl Known {
    pub fn column(&self, quantity: Quantity) -> Option<usize> {
        self.meanings.iter().position(|found| found.is_some_and(|m| m.quantity == quantity))
    }

    pub fn all<const N: usize>(&self, quantities: [Quantity; N]) -> Option<[usize; N]> {
        let mut columns = [0; N];
        for (column, quantity) in columns.iter_mut().zip(quantities) {
            *column = self.column(quantity)?;
        }
        Some(columns)
    }

    pub fn height(&self) -> Option<(usize, Option<HeightAbove>)> {
        let any = [Some(HeightAbove::Ellipsoid), None, Some(HeightAbove::Sea)];
        any.into_iter().find_map(|above| Some((self.column(Quantity::Height(above))?, above)))
    }

    pub fn unit(&self, column: usize) -> Option<&'static str> {
        self.meanings[column].and_then(|meaning| meaning.unit)
    }

    /// Removes the meaning of columns with raw readings, and of columns with zeros only, if another column has the same
    /// quantity.
    pub fn prefer_measured(&mut self, look: &Look, names: &[String]) {
        let is_poor = |column: usize| {
            let name = names.get(column).map_or(String::new(), |name| name.to_lowercase());
            ["raw", "uncal", "uncomp"].iter().any(|part| name.contains(part))
                || look.largest(column) == 0.0
        };
        let quantity = |meaning: &Option<Meaning>| meaning.map(|meaning| meaning.quantity);
        let quantities: Vec<Option<Quantity>> = self.meanings.iter().map(quantity).collect();
        for (column, quantity) in quantities.iter().enumerate().filter(|(at, _)| is_poor(*at)) {
            let mut others = quantities.iter().enumerate();
            if others.any(|(other, of)| of == quantity && !is_poor(other)) {
                self.meanings[column] = None;
            }
        }
    }

    /// Reads `VZ` next to `GCrs`, the course of ArduPilot's `GPS` message, as the velocity down.
    pub fn add_down_of_ardupilot(&mut self, names: &[String]) {
        let find = |wanted: &str| {
            names.iter().position(|name| name.rsplit(['.', ' ']).next() == Some(wanted))
        };
        if let (Some(_), Some(down)) = (find("GCrs"), find("VZ")) {
            let quantity = Quantity::Velocity(2);
            self.meanings[down] = Some(Meaning { quantity, unit: Some("m/s"), estimated: false });
        }
    }

    pub fn is_estimated(&self, column: usize) -> bool {
        self.meanings[column].is_some_and(|meaning| meaning.estimated)
    }
}
