//! Memory that a dataset directory needs.

use std::mem::size_of;
use std::path::Path;

use crate::dataset::Dataset;
use crate::sensors::{aids, auxiliary, controls, gps, imu};
use crate::table::rows_of;
use hovernav::event::RangeReading;
use hovernav::frames::{Body, Vector};
use hovernav::gps::{AntennaHeading, Fix};
use hovernav::imu::ImuSample;
use hovernav::time::Time;

/// Bytes for each row while the rows are sorted: line, time and whether the row stays.
const EXTRA_PER_ROW: usize = size_of::<u64>() + size_of::<Time>() + 1;

impl Dataset {
    /// Memory that [`open_within`](Self::open_within) needs for the dataset in the directory `dir`, bytes. The estimate
    /// uses the sizes of its files and the lengths of their first rows. Files that cannot be read count as empty.
    #[must_use]
    pub fn bytes_of(dir: &Path, most: usize) -> u64 {
        let tables = [
            (gps::FILE, size_of::<Fix>()),
            (auxiliary::BARO_FILE, size_of::<(Time, f64)>()),
            (auxiliary::MAG_FILE, size_of::<(Time, Vector<Body>)>()),
            (aids::HEADING_FILE, size_of::<AntennaHeading>()),
            (aids::RANGE_FILE, size_of::<RangeReading>()),
            (aids::ROTOR_FILE, size_of::<(Time, f64)>()),
        ];
        let bytes =
            |(file, row): (&str, usize)| rows_of(&dir.join(file)) * (row + EXTRA_PER_ROW) as u64;
        let within = |file, row: usize| rows_of(&dir.join(file)).min(most as u64) * row as u64;
        tables.into_iter().map(bytes).sum::<u64>()
            + within(imu::FILE, size_of::<ImuSample>())
            + within(controls::FILE, size_of::<(Time, [f64; 8])>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hover_flight_takes_what_its_rows_take() {
        let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../datasets/heli-hover");
        let whole = Dataset::bytes_of(&dir, usize::MAX);
        let rows = rows_of(&dir.join(imu::FILE));
        assert!((9_700..10_100).contains(&rows), "{rows}");
        let samples = rows * size_of::<ImuSample>() as u64;
        let sticks = rows_of(&dir.join(controls::FILE)) * size_of::<(Time, [f64; 8])>() as u64;
        assert_eq!(whole - Dataset::bytes_of(&dir, 0), samples + sticks);
        assert!((samples..2 * samples).contains(&whole), "{whole}");
        assert_eq!(Dataset::bytes_of(&dir.join("nowhere"), 100), 0);
    }
}
