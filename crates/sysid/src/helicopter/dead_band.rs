//! Dead bands of the servos.
//!
//! A servo ignores a command that differs little from its position. An autopilot sends many such commands, because the gyros
//! measure vibration. With every recorded command as a movement the sticks seem the weaker the faster they move, and the
//! identified vehicle is too slow.

use nalgebra::{Cholesky, DMatrix};
use rayon::prelude::*;

use super::flight::FlightRecord;
use super::stretches::stretches;
use crate::record::{Experiment, STICKS, Tone};

/// Trial dead bands, as fractions of a stick's travel in the flight.
const TRIALS: [f64; 9] = [0.0, 0.003, 0.006, 0.009, 0.012, 0.016, 0.02, 0.03, 0.04];
/// Response that shows the dead band of each of the [`STICKS`].
const SHOWN_BY: [&str; 4] = ["p", "q", "w", "r"];
/// Further signals of the regressions.
const OTHERS: [&str; 6] = ["p", "q", "r", "u", "v", "w"];
/// Number of earlier samples of the sticks and of the response in a regression.
const EARLIER: usize = 5;
/// Smallest decrease of −2 ln L for a dead band. White residuals would need 6.6 for one parameter at 1 %. Those of a
/// regression are correlated.
const MIN_DECREASE: f64 = 40.0;

impl FlightRecord {
    /// The record with each stick at the position of a servo with a dead band, in the stick's unit.
    pub(super) fn with_dead_bands(mut self, dead_bands: [f64; 4]) -> Self {
        for (mut column, dead_band) in self.experiment.inputs.column_iter_mut().zip(dead_bands) {
            play(column.as_mut_slice(), dead_band);
        }
        self
    }

    /// Dead band of each stick's servo, in the stick's unit; 0 where the flight shows none. The linear regression of the
    /// stick's response with the dead band is then far more likely than without.
    ///
    /// `tones` are those of the record, and `travels` the ranges of the sticks. A record that is decimated to periods of up to
    /// `longest_s` does not show a dead band, because its filter removes the small fast commands.
    pub(super) fn dead_bands(&self, tones: &[Tone], longest_s: f64, travels: [f64; 4]) -> [f64; 4] {
        let own = &self.experiment;
        if 2.0 * own.period_s <= longest_s {
            return [0.0; 4];
        }
        let names = TRIALS.iter().enumerate();
        let names = names.flat_map(|(trial, _)| STICKS.map(|stick| trial_of(stick, trial)));
        let mut inputs = DMatrix::zeros(own.samples(), STICKS.len() * TRIALS.len());
        for (trial, part) in TRIALS.iter().enumerate() {
            for (stick, travel) in travels.iter().enumerate() {
                let mut column = inputs.column_mut(trial * STICKS.len() + stick);
                column.copy_from(&own.inputs.column(stick));
                play(column.as_mut_slice(), part * travel);
            }
        }
        let experiment = Experiment { inputs, input_names: names.collect(), ..own.clone() };
        let trials = Self { experiment, ..self.clone() }.without_tones(tones, &[]);
        let pieces = stretches(&trials, &[]).unwrap_or_default();
        let of = |stick: usize| travels[stick] * likeliest(&pieces, stick).unwrap_or(0.0);
        let found: Vec<f64> = (0..STICKS.len()).into_par_iter().map(of).collect();
        std::array::from_fn(|stick| found[stick])
    }
}

/// Positions of a servo that stops where the rest of the way is `dead_band`, in place of its commands.
///
/// # Source
/// Equation (I35) of docs/equations.md.
fn play(commands: &mut [f64], dead_band: f64) {
    let Some(&first) = commands.first() else { return };
    let mut position = first;
    for command in commands {
        let off = *command - position;
        position += (off.abs() - dead_band).max(0.0).copysign(off);
        *command = position;
    }
}

fn trial_of(stick: &str, trial: usize) -> String {
    format!("{stick} {trial}")
}

/// The likeliest of the [`TRIALS`] for `stick`, if it is far more likely than none.
fn likeliest(pieces: &[Experiment], stick: usize) -> Option<f64> {
    let gram = pieces.iter().filter_map(|piece| gram(piece, stick));
    let (samples, gram) = gram.reduce(|one, other| (one.0 + other.0, one.1 + other.1))?;
    let common = gram.ncols() - EARLIER * TRIALS.len();
    let fits = (0..TRIALS.len()).filter_map(|trial| {
        let own = common + EARLIER * trial..common + EARLIER * (trial + 1);
        let used: Vec<usize> = (1..common).chain(own).collect();
        let (normal, right) =
            (gram.select_rows(&used), gram.select_rows(&used).column(0).into_owned());
        let solved = Cholesky::new(normal.select_columns(&used))?.solve(&right);
        let left = gram[(0, 0)] - right.dot(&solved);
        Some((trial, samples * left.ln()))
    });
    let fits: Vec<(usize, f64)> = fits.filter(|fit| fit.1.is_finite()).collect();
    let none = fits.iter().find(|fit| fit.0 == 0)?.1;
    let best = fits.iter().min_by(|one, other| one.1.total_cmp(&other.1))?;
    (none - best.1 > MIN_DECREASE).then_some(TRIALS[best.0])
}

/// Number of samples of a regression, and the products of its signals: the response, then the regressors common to all
/// trials, then the stick in each trial.
fn gram(piece: &Experiment, stick: usize) -> Option<(f64, DMatrix<f64>)> {
    let samples = piece.samples().checked_sub(EARLIER).filter(|samples| *samples > EARLIER)?;
    let mut columns = Vec::new();
    let mut add = |name: &str, earlier: std::ops::RangeInclusive<usize>| {
        let signal = piece.signal(name).ok()?;
        columns.extend(earlier.map(|by| {
            let mut column = signal.rows(EARLIER - by, samples).into_owned();
            column.add_scalar_mut(-column.mean());
            column
        }));
        Some(())
    };
    let response = SHOWN_BY[stick];
    add(response, 0..=EARLIER)?;
    for other in OTHERS.iter().filter(|other| **other != response) {
        add(other, 1..=1)?;
    }
    for other in STICKS.iter().filter(|other| **other != STICKS[stick]) {
        add(&trial_of(other, 0), 1..=EARLIER)?;
    }
    for trial in 0..TRIALS.len() {
        add(&trial_of(STICKS[stick], trial), 1..=EARLIER)?;
    }
    let all = DMatrix::from_columns(&columns);
    Some((samples as f64, all.tr_mul(&all)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_servo_stops_short_of_its_command_and_ignores_small_ones() {
        let mut commands = [0.0, 0.25, 1.0, 0.75, 0.5, -1.0];
        play(&mut commands, 0.5);
        assert_eq!(commands, [0.0, 0.0, 0.5, 0.5, 0.5, -0.5]);
        let mut commands = [0.25, 0.5];
        play(&mut commands, 0.0);
        assert_eq!(commands, [0.25, 0.5]);
    }
}
