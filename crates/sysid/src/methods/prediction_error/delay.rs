//! Delay of an input, estimated from the deliberate steps of a pilot on it.
//!
//! Deduced steps contain part of the pilot's response to gusts. They give the delay, not the strength of a stick.
//!
//! A pilot or controller in hover responds to gusts, and perceives them before noisy measurements show them. The stick
//! is therefore correlated with later innovations. The likelihood assumes that the controller learns of a gust from the
//! innovations as well, and overestimates the delay. The injected signal is independent of gusts. At the true delay the
//! innovations are uncorrelated with every response to the injected signal alone.
//!
//! # Source
//! Söderström and Stoica (1983), *Instrumental Variable Methods for System Identification*, chapter 4; in
//! a closed loop Gilson and Van den Hof (2005), *Automatica* 41(2). Equation (I36) of docs/equations.md.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::error::PredictionErrorError;
use super::estimates::Status;
use super::identified::Identified;
use super::identify::{problem, records};
use super::problem::Problem;
use super::settings::Settings;
use super::statistics::{correlated_scatter, projected};
use crate::record::Experiment;

/// Number of parts of a sample, between whose ends the innovations are interpolated.
const PARTS: usize = 4;
/// Number of trial delays within a part.
const TRIALS: u32 = 5;

/// `found` with the delay of the input `input` estimated from the signal `injected`. The signal is an input of the
/// experiments, not of the structure. All other parameters keep their values. `None` where the delay was not estimated
/// or nothing was injected.
///
/// # Errors
/// See [`PredictionErrorError`].
pub fn delay_from_injected(
    found: &Identified,
    (input, injected): (&str, &str),
    experiments: &[Experiment],
    settings: &Settings,
) -> Result<Option<Identified>, PredictionErrorError> {
    let structure = &found.structure;
    let column = structure.inputs.iter().position(|name| name == input);
    let Some(delay) = column.and_then(|column| structure.delays[column]) else { return Ok(None) };
    let free = &found.estimates.free;
    let Some(place) = free.iter().position(|&index| index == delay) else { return Ok(None) };
    let alone = experiments.iter().map(|own| alone(own, input, injected));
    let Some(alone) = alone.collect::<Option<Vec<_>>>() else { return Ok(None) };
    let (flown, injected) = (records(structure, experiments)?, records(structure, &alone)?);
    let mut flown = problem(structure, &flown, experiments, settings)?;
    let mut injected = problem(structure, &injected, &alone, settings)?;
    flown.base.clone_from(&found.theta);
    injected.base.clone_from(&found.theta);
    let Some(solved) = Indicated::of(&mut flown, &mut injected, delay) else { return Ok(None) };
    let lags = (settings.residual_correlation_s / flown.period_s).round() as usize;
    flown.free.clone_from(free);
    Ok(solved.put_into(found, &mut flown, (place, lags), settings.widened))
}

/// `experiment` with the signal `injected` as `input` and all other signals zero.
fn alone(experiment: &Experiment, input: &str, injected: &str) -> Option<Experiment> {
    let place = |name: &str| experiment.input_names.iter().position(|own| own == name);
    let (from, to) = (place(injected)?, place(input)?);
    let signal = experiment.inputs.column(from).into_owned();
    let mut alone = experiment.clone();
    alone.inputs.fill(0.0);
    alone.outputs.fill(0.0);
    alone.inputs.set_column(to, &signal);
    Some(alone)
}

/// Delay estimated from the injected signal.
struct Indicated {
    delay_s: f64,
    /// Trial delays over the whole range, each with the squared projection of the innovations on the instruments.
    left: Vec<(f64, f64)>,
    /// Change of each record's innovations with the delay of the injected signal.
    instruments: Vec<DVector<f64>>,
}

impl Indicated {
    /// The delay that minimises the projection of the innovations on the instruments. The instruments are the responses
    /// to the injected signal at every delay of whole samples.
    fn of(flown: &mut Problem<'_>, injected: &mut Problem<'_>, delay: usize) -> Option<Self> {
        let period_s = flown.period_s;
        let first = (flown.lower[delay] / period_s).floor();
        let count = (flown.upper[delay] / period_s - first).ceil() as usize + 1;
        let part_s = period_s / PARTS as f64;
        let at = |part: usize| first * period_s + part as f64 * part_s;
        injected.free = vec![delay];
        let (_, _, alone) = injected.pass(&[at(0)], true)?;
        let earliest = alone.normals.iter().map(|normal| Some(projected(normal, 1)?.transpose()));
        let p = flown.structure.outputs.len();
        let instruments: Vec<DMatrix<f64>> = earliest
            .map(|earliest| {
                let earliest = earliest?;
                Some(DMatrix::from_fn(earliest.len(), count, |row, later| {
                    row.checked_sub(later * p).map_or(0.0, |row| earliest[row])
                }))
            })
            .collect::<Option<_>>()?;
        let own: DMatrix<f64> = instruments.iter().map(|own| own.tr_mul(own)).sum();
        let root = Cholesky::new(own)?.unpack();
        flown.free.clear();
        let in_space = (0..=PARTS * (count - 1)).map(|part| {
            flown.base[delay] = at(part);
            let (_, _, passed) = flown.pass(&[], true)?;
            let errors = passed.normals.iter().zip(&instruments).map(|(normal, instruments)| {
                instruments.tr_mul(&DVector::from_column_slice(&normal.whitened))
            });
            root.solve_lower_triangular(&errors.sum::<DVector<f64>>())
        });
        let in_space: Vec<DVector<f64>> = in_space.collect::<Option<_>>()?;
        let pairs = || in_space.windows(2).map(|pair| (&pair[0], &pair[1] - &pair[0])).enumerate();
        let delay_at = |part: usize, share: f64| at(part) + share * part_s;
        let between = pairs().map(|(part, (from, change))| {
            let share = (-from.dot(&change) / change.norm_squared()).clamp(0.0, 1.0);
            ((from + &change * share).norm_squared(), delay_at(part, share), change)
        });
        let (_, delay_s, change) = between
            .filter(|(left, ..)| left.is_finite())
            .min_by(|one, other| one.0.total_cmp(&other.0))?;
        let left = pairs().flat_map(|(part, (from, change))| {
            (0..TRIALS).map(move |trial| {
                let share = f64::from(trial) / f64::from(TRIALS);
                (delay_at(part, share), (from + &change * share).norm_squared())
            })
        });
        let left = left.collect();
        let delay_s = delay_s.max(flown.lower[delay]).min(flown.upper[delay]);
        let weights = root.transpose().solve_upper_triangular(&(change / part_s))?;
        let instruments = instruments.iter().map(|own| own * &weights).collect();
        Some(Self { delay_s, left, instruments })
    }

    /// Mean square distance, s², of other delays from this delay, weighted by their likelihood. The logarithm of the
    /// likelihood is divided by the factor `overstated`. A delay one sample away can be nearly as likely: a velocity from
    /// momentary readings is a trapezoid, which contains nothing at half the sample rate. The modelled response contains
    /// nothing there at a single delay within each sample, and the innovations prefer these delays.
    ///
    /// # Source
    /// Chernozhukov and Hong (2003), *Journal of Econometrics* 115(2).
    fn spread(&self, overstated: f64) -> f64 {
        let least = self.left.iter().map(|(_, left)| *left).fold(f64::INFINITY, f64::min);
        let (mut weights, mut squares) = (0.0, 0.0);
        for (delay_s, left) in &self.left {
            let weight = (0.5 * (least - left) / overstated).exp();
            weights += weight;
            squares += weight * (delay_s - self.delay_s).powi(2);
        }
        squares / weights
    }

    /// `found` with this delay at index `place` of the free parameters, with its bound and its covariance with the
    /// rest. Errors of the other parameters move the delay by their effect on the innovations in the instrument's
    /// direction.
    fn put_into(
        self,
        found: &Identified,
        flown: &mut Problem<'_>,
        (place, lags): (usize, usize),
        widened: f64,
    ) -> Option<Identified> {
        let delay = flown.free[place];
        let mut with = found.clone();
        with.theta[delay] = self.delay_s;
        let theta: Vec<f64> = flown.free.iter().map(|&index| with.theta[index]).collect();
        let (_, _, passed) = flown.pass(&theta, true)?;
        let mut slopes = DVector::zeros(theta.len());
        let (mut white, mut colored) = (0.0, 0.0);
        for (normal, instrument) in passed.normals.iter().zip(&self.instruments) {
            slopes += projected(normal, theta.len())? * instrument;
            white += instrument.norm_squared();
            let errors = DVector::from_column_slice(&normal.whitened);
            let shares = instrument.component_mul(&errors).transpose();
            colored += correlated_scatter(&DMatrix::from_rows(&[shares]), lags)[(0, 0)];
        }
        let estimates = &mut with.estimates;
        let own_parameters = flown.structure.parameters.len();
        for (other, slope) in slopes.iter_mut().enumerate() {
            let index = flown.free[other];
            // The estimates contain σ of the noises, the search variables ln σ.
            let scale = if index < own_parameters { 1.0 } else { estimates.list[index].value };
            *slope /= white * scale;
        }
        slopes[place] = 0.0;
        let overstated = widened * widened * (colored / white).max(1.0);
        let colored = self.spread(overstated).max(overstated / white);
        let matrices =
            [(&mut estimates.covariance, colored), (&mut estimates.white_covariance, 1.0 / white)];
        let [bound, white_bound] = matrices.map(|(matrix, noise)| {
            let across = -(&*matrix * &slopes);
            let variance = noise - slopes.dot(&across);
            matrix.set_column(place, &across);
            matrix.set_row(place, &across.transpose());
            matrix[(place, place)] = variance;
            variance.sqrt()
        });
        let estimate = &mut estimates.list[delay];
        let is_within = flown.lower[delay] < self.delay_s && self.delay_s < flown.upper[delay];
        estimate.status = if is_within { Status::Free } else { Status::OnBound };
        (estimate.value, estimate.bound, estimate.white_bound) = (self.delay_s, bound, white_bound);
        Some(with)
    }
}

#[cfg(test)]
mod tests {
    use super::super::instrument::tests::{DELAY_S, PERIOD_S, flight, structure};
    use super::*;
    use crate::methods::prediction_error::identify;

    #[test]
    fn an_injected_signal_determines_the_delay_from_wherever_the_search_ended() {
        let flight = [flight(0.1)];
        let settings = Settings::innovations(vec![0.1]);
        let mut found = identify(&structure(), &flight, &settings).expect("it is identifiable");
        let signals = ("c", "injected_c");
        for off_s in [0.0, -0.05, 0.08] {
            found.theta[2] = DELAY_S + off_s;
            let solved = delay_from_injected(&found, signals, &flight, &settings);
            let solved = solved.expect("it has a predictor").expect("something was injected");
            let delay = solved.estimates.get("tau").expect("it has one");
            assert!((delay.value - DELAY_S).abs() < 4.0 * delay.bound, "{delay:?}");
            assert!(delay.bound < 0.1 * PERIOD_S, "{delay:?}");
            assert_eq!(solved.estimates.get("Zc"), found.estimates.get("Zc"));
        }
    }

    #[test]
    fn where_nothing_was_injected_the_delay_stays() {
        let flight = [flight(0.0)];
        let settings = Settings::innovations(vec![0.1]);
        let structure = structure().with("tau", DELAY_S, false);
        let found = identify(&structure, &flight, &settings).expect("noise moves it");
        for signals in [("c", "injected_c"), ("c", "injected_d")] {
            let solved = delay_from_injected(&found, signals, &flight, &settings);
            assert!(solved.expect("it has a predictor").is_none());
        }
    }
}
