//! Quantities of the columns of a file, as far as the names state them.

use std::ops::Range;

use super::look::Look;
use super::names::Meaning;
use super::quantity::Quantity;
use super::unit_names::{trailing_unit, unit};
use super::words::{bracketed, words};
use crate::text::HeightAbove;

/// The unit of the columns x and y of an Earth-centred position.
pub(super) const EARTH_CENTRED: &str = "ecef";

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

    /// Removes the meaning of columns with raw readings, of accelerations without gravity, and of columns with zeros only,
    /// if another column has the same quantity.
    pub fn prefer_measured(&mut self, look: &Look, names: &[String]) {
        let is_poor = |column: usize| {
            let name = names.get(column).map_or(String::new(), |name| name.to_lowercase());
            ["raw", "uncal", "uncomp", "linear", "user"].iter().any(|part| name.contains(part))
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

    /// Removes the meaning of columns of other receivers and filters, if several sources have a position, as `GPS:Lat`
    /// and `IMU_ATTI(0):Latitude`. The source of a receiver is kept, otherwise the one with the most columns. Returns a
    /// sentence about the choice.
    pub fn keep_one_receiver(&mut self, names: &[String]) -> Option<String> {
        let of = |column: usize| self.meanings[column].map(|meaning| meaning.quantity);
        let mut sources: Vec<&str> = Vec::new();
        for (column, name) in names.iter().enumerate().take(self.meanings.len()) {
            if of(column) == Some(Quantity::Latitude) && !sources.contains(&source_of(name)) {
                sources.push(source_of(name));
            }
        }
        let has = |source: &str, is: fn(Quantity) -> bool| {
            let columns = (0..self.meanings.len()).filter(|&c| source_of(&names[c]) == source);
            columns.filter_map(of).filter(|quantity| is(*quantity)).count()
        };
        let is_height = |quantity| matches!(quantity, Quantity::Height(_));
        let rank = |source: &str| {
            let lower = source.to_lowercase();
            let is_receiver = ["gps", "gnss", "rtk"].iter().any(|part| lower.contains(part));
            let is_whole = has(source, is_height) > 0;
            (is_whole, is_receiver, has(source, Quantity::is_of_receiver))
        };
        // The first of equal ones.
        let best = sources.iter().copied().rev().max_by_key(|source| rank(source))?;
        if sources.len() < 2 {
            return None;
        }
        let has_height = has(best, is_height) > 0;
        let others: Vec<&str> = sources.iter().copied().filter(|source| *source != best).collect();
        let sentence = format!(
            "gps: {} have a position: position, {}velocity are read from {best} only",
            sources.join(" and "),
            if has_height { "height and " } else { "" }
        );
        for (column, name) in names.iter().enumerate().take(self.meanings.len()) {
            let source = source_of(name);
            let is_other = self.meanings[column].is_some_and(|meaning| match meaning.quantity {
                Quantity::Height(_) => has_height,
                Quantity::Velocity(_) | Quantity::Up | Quantity::Speed | Quantity::Course => true,
                quantity => quantity.is_of_receiver() && others.contains(&source),
            });
            if is_other && source != best {
                self.meanings[column] = None;
            }
        }
        Some(sentence)
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

    /// Reads three columns with the size of the Earth as an Earth-centred position, if no other position is known, and
    /// the velocity along the same axes.
    pub fn add_earth_centred(&mut self, look: &Look, names: &[String]) {
        /// Distances of a vehicle from the Earth's centre, m.
        const RADII_M: Range<f64> = 6.33e6..6.43e6;
        const UNITS: [(&str, f64); 3] = [("m", 1.0), ("cm", 1e-2), ("mm", 1e-3)];
        if self.column(Quantity::Latitude).is_some() {
            return;
        }
        let norms = |at: usize| {
            [look.median_norm([at, at + 1, at + 2]), look.high_norm([at, at + 1, at + 2])]
        };
        let unit_at = |at: usize| {
            let is_free = self.meanings[at..at + 3].iter().all(Option::is_none);
            let fits = |to_m: f64| norms(at).iter().all(|norm| RADII_M.contains(&(norm * to_m)));
            UNITS.into_iter().find(|(_, to_m)| is_free && fits(*to_m)).map(|(unit, _)| (at, unit))
        };
        // Near the equator or 90° of longitude one coordinate is small. Two coordinates with another column then also
        // have the size of the Earth's radius; the right three have the largest.
        let all = (0..self.meanings.len().saturating_sub(2)).filter_map(unit_at);
        let largest = all.max_by(|a, b| norms(a.0)[0].total_cmp(&norms(b.0)[0]));
        let Some((first, unit)) = largest else { return };
        let mut give = |column: usize, quantity: Quantity, unit: Option<&'static str>| {
            self.meanings[column] = Some(Meaning { quantity, unit, estimated: false });
        };
        give(first, Quantity::Latitude, Some(EARTH_CENTRED));
        give(first + 1, Quantity::Longitude, Some(EARTH_CENTRED));
        give(first + 2, Quantity::Height(Some(HeightAbove::Ellipsoid)), Some(unit));
        for (column, name) in names.iter().enumerate() {
            if let Some((axis, unit)) = earth_centred_velocity(name) {
                give(column, Quantity::Velocity(axis), unit);
            }
        }
    }

    pub fn is_estimated(&self, column: usize) -> bool {
        self.meanings[column].is_some_and(|meaning| meaning.estimated)
    }
}

/// The axis of a name such as `ecefVX` or `ecef_vel_y`, and its unit.
fn earth_centred_velocity(name: &str) -> Option<(usize, Option<&'static str>)> {
    let (plain, bracket) = bracketed(name);
    let mut words = words(plain);
    let unit = unit(&bracket).or_else(|| trailing_unit(&mut words));
    let joined = words.concat().replace("ecef", "");
    let stem = joined.trim_end_matches(['x', 'y', 'z']);
    let axis = ["x", "y", "z"].iter().position(|axis| joined.strip_prefix(stem) == Some(*axis))?;
    ["v", "vel", "velocity", "speed"].contains(&stem).then_some((axis, unit))
}

/// The part of a column's name that denotes the device or program, before a colon, point or slash: `IMU_ATTI(0)` of
/// `IMU_ATTI(0):velN`.
pub(super) fn device_of(name: &str) -> Option<&str> {
    let (device, _) = name.rsplit_once([':', '/', '.'])?;
    Some(device.trim_end_matches([':', '/', '.']))
}

/// The [device](device_of) in a name, otherwise its first word: `gps` of `gps_lat`.
fn source_of(name: &str) -> &str {
    device_of(name).or_else(|| Some(name.split_once('_')?.0)).unwrap_or_default()
}
