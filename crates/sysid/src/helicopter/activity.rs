//! Movement of the sticks in a flight, and the models that it can identify.

use nalgebra::DMatrix;
use serde::Serialize;

use super::bandwidth::{STILL, bands_hz};
use super::flight_condition::FlightCondition;
use super::model_structure::ModelStructure;
use crate::record::{STICKS, find_test_points, travels};
use hovernav::time::Time;

/// Movement of one stick in a flight.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StickActivity {
    /// The stick, or the axis of another recorded input.
    pub stick: &'static str,
    /// Range without outliers, in the unit of the record.
    pub travel: f64,
    /// Total time in which the stick moves, s. The stick moves in a window if it changes by more than a tenth of its
    /// travel. A window has a second, or more for slow records.
    pub moved_s: f64,
    /// First and last frequency of its movement, Hz. 5 % of the power is below the first, 5 % above the last. `None`
    /// for a stick that does not move, and for a record that is too short or too long for spectra.
    pub band_hz: Option<[f64; 2]>,
    /// Number of test points: steps of this stick alone.
    pub test_points: usize,
}

/// Movement of all sticks in a flight, and the models that it can identify.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Activity {
    /// Lateral, longitudinal, collective, pedal.
    pub sticks: Vec<StickActivity>,
    /// Names of the built-in structures of hover whose sticks all move. Without fixes these are structures of rates.
    pub models: Vec<String>,
}

/// Smallest change of a moving stick within a window, as a fraction of its travel.
const MOVED: f64 = 0.1;
/// Shortest movement of a stick from which a model is identified, s.
const MIN_MOVED_S: f64 = 3.0;
/// Smallest window in which movement is searched: length, s, and number of rows.
const WINDOW: (f64, f64) = (1.0, 3.0);
/// Shortest and longest sample period of the spectra, s.
const PERIOD_S: [f64; 2] = [0.01, 0.1];

/// Largest number of samples of the spectra: a day at the shortest period. A longer record has a wrong clock.
const MAX_SAMPLES: usize = 8_640_000;

impl Activity {
    /// The movement of the sticks in `controls`, whose rows contain the four sticks in time order. `has_fixes` is
    /// whether the log has velocities.
    #[must_use]
    pub fn of(controls: &[(Time, [f64; 4])], has_fixes: bool) -> Self {
        let travels = travels(controls);
        let largest = travels.into_iter().fold(0.0, f64::max);
        let moves = travels.map(|travel| travel > STILL * largest);
        let usual_s = usual_interval_s(controls);
        let bands = bands(controls, usual_s);
        let points = find_test_points(controls);
        let window_s = WINDOW.0.max(WINDOW.1 * usual_s);
        let sticks = STICKS.into_iter().enumerate().map(|(index, stick)| StickActivity {
            stick,
            travel: travels[index],
            moved_s: if moves[index] {
                moved_s(controls, (index, MOVED * travels[index]), window_s)
            } else {
                0.0
            },
            band_hz: bands.get(index).copied().flatten().filter(|_| moves[index]),
            test_points: points.iter().filter(|point| point.stick == Some(index)).count(),
        });
        let sticks: Vec<StickActivity> = sticks.collect();
        let is_moved =
            |stick: &str| sticks.iter().any(|own| own.stick == stick && own.moved_s >= MIN_MOVED_S);
        let models = ModelStructure::all().filter(|model| {
            let equations = &model.equations;
            // A model of one stick needs only that stick.
            let is_excited = match model.own_delay() {
                Some((stick, _)) => is_moved(stick),
                None => equations.inputs_of_pilot().all(is_moved),
            };
            is_excited
                && model.condition == FlightCondition::HOVER
                && (has_fixes || model.has_rates_alone())
        });
        let models = models.map(|model| model.name().to_owned()).collect();
        Self { models, sticks }
    }
}

/// Usual interval of `controls`, s; 0 with fewer than two rows.
fn usual_interval_s(controls: &[(Time, [f64; 4])]) -> f64 {
    let mut intervals: Vec<f64> = controls.windows(2).map(|pair| pair[1].0 - pair[0].0).collect();
    intervals.sort_by(f64::total_cmp);
    intervals.get(intervals.len() / 2).copied().unwrap_or(0.0)
}

/// Total length, s, of the windows of `window_s` in which the stick `index` changes by more than `least`.
fn moved_s(controls: &[(Time, [f64; 4])], (index, least): (usize, f64), window_s: f64) -> f64 {
    let window = |row: &(Time, [f64; 4])| (row.0.seconds() / window_s).floor();
    let moved = controls.chunk_by(|one, other| window(one) == window(other)).filter(|rows| {
        let values = || rows.iter().map(|row| row.1[index]).filter(|value| value.is_finite());
        values().fold(f64::MIN, f64::max) - values().fold(f64::MAX, f64::min) > least
    });
    moved.count() as f64 * window_s
}

/// Band of each stick in `controls`, whose rows are `usual_s` apart. The position of a stick is held from row to row.
fn bands(controls: &[(Time, [f64; 4])], usual_s: f64) -> Vec<Option<[f64; 2]>> {
    let (Some(first), Some(last)) = (controls.first(), controls.last()) else { return Vec::new() };
    let [shortest_s, longest_s] = PERIOD_S;
    let period_s = usual_s.clamp(shortest_s, longest_s);
    let samples = ((last.0 - first.0) / period_s) as usize + 1;
    if samples > MAX_SAMPLES {
        return Vec::new();
    }
    let mut row = 0;
    let mut held = DMatrix::zeros(samples, STICKS.len());
    for sample in 0..samples {
        let time = first.0 + sample as f64 * period_s;
        while controls.get(row + 1).is_some_and(|next| next.0 <= time) {
            row += 1;
        }
        for (stick, value) in controls[row].1.into_iter().enumerate() {
            held[(sample, stick)] = if value.is_finite() { value } else { 0.0 };
        }
    }
    bands_hz(held, period_s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// A minute at 50 Hz: a sine of 2 Hz on the lateral stick from 20 to 40 s, and nothing on the others.
    fn roll_alone() -> Vec<(Time, [f64; 4])> {
        let row = |sample: u32| {
            let second = f64::from(sample) / 50.0;
            let moves = (20.0..40.0).contains(&second);
            let lateral = if moves { 0.2 * (2.0 * TAU * second).sin() } else { 0.0 };
            (Time::from_seconds(second), [lateral, 0.0, 0.3, 0.0])
        };
        (0..3000).map(row).collect()
    }

    #[test]
    fn a_sine_on_one_stick_gives_its_time_its_band_and_the_models_of_this_stick() {
        let found = Activity::of(&roll_alone(), true);
        let lateral = &found.sticks[0];
        assert!((lateral.travel - 0.4).abs() < 0.01 && lateral.moved_s == 20.0, "{lateral:?}");
        let [first_hz, last_hz] = lateral.band_hz.expect("it moves");
        assert!(first_hz > 1.8 && last_hz < 2.2, "{first_hz} to {last_hz} Hz");
        assert_eq!(found.models, ["roll"]);
        for still in &found.sticks[1..] {
            assert_eq!((still.moved_s, still.band_hz), (0.0, None), "{still:?}");
        }
        assert_eq!(Activity::of(&roll_alone(), false).models, ["roll"]);
    }

    #[test]
    fn records_without_movement_give_nothing() {
        let still: Vec<_> =
            roll_alone().iter().map(|row| (row.0, [f64::NAN, 0.1, 0.0, 0.0])).collect();
        for controls in [&still[..], &still[..1], &[]] {
            let found = Activity::of(controls, true);
            assert!(found.models.is_empty(), "{found:?}");
            assert!(found.sticks.iter().all(|stick| stick.band_hz.is_none()), "{found:?}");
        }
    }
}
