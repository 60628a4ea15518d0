//! Frequencies that the sticks excite.

use nalgebra::DMatrix;

use super::flight::{INJECTED, STEPPED};
use crate::methods::frequency::{Band, SpectrumSettings, Window, spectra};
use crate::record::{Experiment, STICKS};

/// Fraction of a stick's power that lies below the end of its band. The same fraction lies above its start.
const WITHIN: f64 = 0.95;
/// Length of the windows of the spectra, s.
const WINDOW_S: f64 = 10.0;
/// First frequency of the spectra, Hz.
const FIRST_HZ: f64 = 0.1;
/// Number of frequencies of the spectra.
const POINTS: usize = 300;
/// Highest bandwidth, Hz. At higher frequencies a vehicle does not respond as a rigid body.
const MAX_HZ: f64 = 20.0;
/// Smallest number of samples in one period of the bandwidth frequency.
const SAMPLES: f64 = 6.0;
/// Longest sample period for identification, s.
pub(super) const LONGEST_PERIOD_S: f64 = 0.045;
/// Fraction of the largest span of all signals below which a signal counts as still.
pub(super) const STILL: f64 = 0.05;

/// Inputs among `names` that move: their span is more than a twentieth of the largest span.
pub(super) fn moving<'a>(record: &Experiment, names: &[&'a str]) -> Vec<&'a str> {
    let span = |name: &&str| record.signal(name).map_or(0.0, |own| own.max() - own.min());
    let largest = names.iter().map(span).fold(0.0, f64::max);
    let moves = |name: &&&str| span(name) > STILL * largest;
    names.iter().filter(moves).copied().collect()
}

/// Bandwidth of the excitation, Hz: that of the injected movement, else of the steps of test points, else of the
/// sticks.
pub(super) fn bandwidth_hz(record: &Experiment) -> f64 {
    let tests = [&INJECTED, &STEPPED, &STICKS].map(|names| moving(record, names));
    let Some(names) = tests.into_iter().find(|names| !names.is_empty()) else { return 0.0 };
    let signals: Vec<_> = names.iter().filter_map(|name| record.signal(name).ok()).collect();
    let bands = bands_hz(DMatrix::from_columns(&signals), record.period_s);
    bands.into_iter().flatten().map(|[_, last_hz]| last_hz).fold(0.0, f64::max)
}

/// First and last frequency, Hz, of the band that contains most of the power of each column of `signals`, sampled every
/// `period_s`. `None` without power, or for a record too short for spectra.
pub(super) fn bands_hz(mut signals: DMatrix<f64>, period_s: f64) -> Vec<Option<[f64; 2]>> {
    signals.column_iter_mut().for_each(|mut column| column.add_scalar_mut(-column.mean()));
    let last_hz = MAX_HZ.min(0.45 / period_s);
    let settings = SpectrumSettings {
        window_s: WINDOW_S.min(signals.nrows() as f64 * period_s),
        overlap: 0.5,
        window: Window::Hann,
        band: Band { first_hz: FIRST_HZ, last_hz, points: POINTS },
    };
    let Ok(found) = spectra(&[&signals], period_s, &settings) else {
        return vec![None; signals.ncols()];
    };
    let frequencies = settings.band.frequencies_hz();
    let of = |column: usize| {
        let power = || found.densities.iter().map(|density| density[(column, column)].re);
        let whole = power().sum::<f64>();
        let place = |part: f64| {
            let mut sum = 0.0;
            power().position(|own| {
                sum += own;
                sum >= part * whole
            })
        };
        let ends = place(1.0 - WITHIN).zip(place(WITHIN)).filter(|_| whole > 0.0);
        ends.map(|(first, last)| [frequencies[first], frequencies[last]])
    };
    (0..signals.ncols()).map(of).collect()
}

/// Longest sample period for identification, s. The sample rate is well above the frequencies that sticks and gusts
/// excite.
pub(super) fn longest_period_s(record: &Experiment) -> f64 {
    LONGEST_PERIOD_S.min((SAMPLES * bandwidth_hz(record)).recip())
}
