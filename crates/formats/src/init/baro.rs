//! The column of a barometer.

use super::columns::Reader;
use super::quantity::Quantity;
use crate::text::{BaroColumn, BaroUnit};

/// Largest pressure in inches of mercury; the same number of kilopascals is the pressure above 9 km.
const HIGHEST_INHG: f64 = 31.5;

impl Reader<'_> {
    /// The column of a barometer. It is a height with a barometer's name, otherwise the only height in a file with a
    /// barometer's name, otherwise a pressure. `with_place` means that the file has a receiver's position. Then an
    /// unqualified height belongs to the receiver. The second value states whether the unit is known: by name, or for a
    /// pressure by its size.
    pub(super) fn baro(
        &mut self,
        with_place: bool,
        checks: &mut Vec<String>,
    ) -> Option<(BaroColumn, bool)> {
        let named = self.known.column(Quantity::BaroHeight);
        let pressure = self.known.column(Quantity::Pressure);
        let bare = self.known.height().map(|(column, _)| column).filter(|_| !with_place);
        let file = self.file.to_lowercase();
        let is_barometers = ["baro", "press"].iter().any(|part| file.contains(part));
        let height = named.or(bare.filter(|_| is_barometers && pressure.is_none()));
        if let Some(left) = bare.filter(|left| Some(*left) != height) {
            let why = match (named.or(pressure), self.known.column(Quantity::Latitude)) {
                (Some(other), _) => format!(
                    "no position belongs to it, and {} is used as the barometer",
                    self.look.layout.names[other]
                ),
                (None, Some(_)) => "its latitude and longitude are ignored".to_owned(),
                (None, None) => {
                    "the file has no latitude, longitude or pressure; if it is from a barometer, \
                     set it as column under [table.baro]"
                        .to_owned()
                }
            };
            let name = &self.look.layout.names[left];
            checks.push(format!("{name} of {} is ignored: {why}", self.file));
        }
        let column = height.or(pressure)?;
        let largest = self.look.largest(column);
        let unit = match self.known.unit(column) {
            Some("ft") => BaroUnit::Feet,
            Some("cm") => BaroUnit::Centimetres,
            Some("hpa") => BaroUnit::Hectopascals,
            Some("kpa") => BaroUnit::Kilopascals,
            Some("inhg") => BaroUnit::InchesOfMercury,
            Some("pa") => BaroUnit::Pascals,
            Some(unit @ "mm") => {
                checks.push(format!(
                    "{} of {} is in {unit}, expected m or ft for a barometer's height: ignored",
                    self.look.layout.names[column], self.file
                ));
                return None;
            }
            _ if height.is_some() => BaroUnit::Metres,
            _ if largest > 5_000.0 => BaroUnit::Pascals,
            _ if largest > 150.0 => BaroUnit::Hectopascals,
            _ if largest < HIGHEST_INHG => {
                checks.push(format!(
                    "baro: {} reaches {largest:.2}, read as inHg; if it is in kPa, at heights above 9 km, set unit = \
                     \"kPa\" under [table.baro]",
                    self.look.layout.names[column]
                ));
                BaroUnit::InchesOfMercury
            }
            _ => BaroUnit::Kilopascals,
        };
        let is_stated = unit.is_pressure() || self.known.unit(column).is_some();
        let held = self.look.is_held(&[column]);
        Some((BaroColumn { held, column: self.name(column), unit }, is_stated))
    }
}
