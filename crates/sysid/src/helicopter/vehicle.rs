//! Results for other tools: the vehicle as a model, and its poles with their uncertainty.

use std::f64::consts::TAU;

use nalgebra::{Complex, DMatrix, Matrix2};

use crate::methods::prediction_error::{Estimate, Identified};
use crate::record::STICKS;
use hovernav_model::hover::unit_of;
use hovernav_model::linalg::eigenvalues;
use hovernav_model::{LinearModel, ModelError, Parameter, Signal, Slope, StateSpace, TimeDomain};

/// An eigenvalue of an identified vehicle, with its uncertainty due to the parameters' bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pole {
    /// The eigenvalue in continuous time, 1/s.
    pub value: Complex<f64>,
    /// Covariance of the real and imaginary part, 1/s². For a pole that stays real the imaginary part has zero
    /// variance.
    pub covariance: Matrix2<f64>,
}

impl Pole {
    /// Outline of the 95 % confidence region of the pole, to first order, 1/s. It is a closed ellipse of `points`
    /// points for a complex pole, and both ends of an interval for a real one.
    #[must_use]
    pub fn region_95(&self, points: usize) -> Vec<Complex<f64>> {
        // 95 % quantile of χ² with two degrees of freedom.
        const TWO: f64 = 5.991;
        // 95 % quantile of χ² with one degree of freedom.
        const ONE: f64 = 3.841;
        let spread = self.covariance.symmetric_eigen();
        let sigmas = spread.eigenvalues.map(|variance| variance.max(0.0).sqrt());
        let axis = |index: usize, scale: f64| {
            let direction = spread.eigenvectors.column(index);
            Complex::new(direction[0], direction[1]) * scale * sigmas[index]
        };
        if self.value.im == 0.0 && self.covariance[(1, 1)] == 0.0 {
            let half = self.covariance[(0, 0)].max(0.0).sqrt() * ONE.sqrt();
            return vec![self.value - half, self.value + half];
        }
        let (one, other) = (axis(0, TWO.sqrt()), axis(1, TWO.sqrt()));
        let last = points.max(2) - 1;
        let angles = (0..=last).map(|point| TAU * point as f64 / last as f64);
        angles.map(|angle| self.value + one * angle.cos() + other * angle.sin()).collect()
    }
}

impl Identified {
    /// The vehicle alone, continuous in time, without the models of gusts and measurements. Outputs are the states;
    /// sticks are in units of −1…1 about trim. The result includes the parameters, their covariance, and the slopes of
    /// the matrices with respect to the estimated parameters. Fixed and dropped parameters have no covariance.
    /// Transport delays are parameters, not part of the matrices.
    ///
    /// # Errors
    /// [`ModelError::NotFinite`] where a parameter is not finite.
    pub fn vehicle(&self) -> Result<StateSpace, ModelError> {
        let structure = &self.structure;
        let kept = self.vehicle_states();
        let signal = |name: &String| Signal::new(name, unit_of(name));
        let states = kept.iter().map(|&state| signal(&structure.states[state])).collect();
        let inputs = structure.inputs_of_pilot().map(|name| Signal::new(name, "stick")).collect();
        let time = TimeDomain::Continuous;
        let LinearModel { a, b, .. } = self.vehicle_at(&self.values(), &kept);
        let count = structure.parameters.len();
        let parameters = self.estimates.list.iter().take(count).map(|estimate| Parameter {
            name: estimate.name.clone(),
            value: estimate.value,
            unit: estimate.unit.clone(),
        });
        let mut covariance = DMatrix::zeros(count, count);
        for (row, column, value) in self.parameter_covariance() {
            covariance[(row, column)] = value;
        }
        StateSpace::new(&structure.name, time, states, inputs, a, b)?
            .with_parameters(parameters.collect(), Some(covariance))?
            .with_slopes(self.slopes(&kept))
    }

    /// Derivatives of the vehicle's matrices for the states `kept` with respect to each estimated parameter.
    fn slopes(&self, kept: &[usize]) -> Vec<Slope> {
        let (structure, values) = (&self.structure, self.values());
        let n = structure.states.len();
        let sticks = structure.inputs.iter().enumerate();
        let sticks = sticks.filter(|(_, input)| STICKS.contains(&input.as_str()));
        let columns: Vec<(usize, &String)> = kept
            .iter()
            .map(|&state| (state, &structure.states[state]))
            .chain(sticks.map(|(input, name)| (n + input, name)))
            .collect();
        let mut slopes = Vec::new();
        for parameter in self.free_parameters() {
            let by = structure.slope(&values, parameter);
            for &row in kept {
                for &(column, name) in &columns {
                    let slope = by[(row, column)];
                    if slope != 0.0 {
                        slopes.push(Slope {
                            parameter: structure.parameters[parameter].name.clone(),
                            row: structure.states[row].clone(),
                            column: name.clone(),
                            slope,
                        });
                    }
                }
            }
        }
        slopes
    }

    /// Model from the sticks to the states `kept` of the structure, all of them outputs, with parameters `values`.
    pub(super) fn vehicle_at(&self, values: &[f64], kept: &[usize]) -> LinearModel {
        let sticks: Vec<usize> = (0..self.structure.inputs.len())
            .filter(|&input| STICKS.contains(&self.structure.inputs[input].as_str()))
            .collect();
        let LinearModel { a, b, time, .. } = self.structure.at(values);
        let a = a.select_rows(kept).select_columns(kept);
        let b = b.select_rows(kept).select_columns(&sticks);
        LinearModel::of_states(time, a, b)
    }

    /// The vehicle's poles in order of rising real part. In a pair the pole with positive imaginary part comes first.
    /// Their covariance follows from that of the parameters through central differences.
    ///
    /// # Errors
    /// [`ModelError::Eigenvalues`] where the computation does not converge.
    pub fn poles(&self) -> Result<Vec<Pole>, ModelError> {
        let kept = self.vehicle_states();
        let values = self.values();
        let at = |values: &[f64]| {
            let a = self.structure.at(values).a;
            eigenvalues(&a.select_rows(&kept).select_columns(&kept))
        };
        let mut poles = at(&values)?;
        poles.sort_by(|one, other| one.re.total_cmp(&other.re).then(other.im.total_cmp(&one.im)));
        let free: Vec<usize> = self.free_parameters().collect();
        let mut slopes = vec![vec![Complex::new(0.0, 0.0); free.len()]; poles.len()];
        for (column, &parameter) in free.iter().enumerate() {
            let step = STEP * self.estimates.list[parameter].bound;
            if !(step > 0.0 && step.is_finite()) {
                continue;
            }
            let moved = |by: f64| {
                let mut moved = values.clone();
                moved[parameter] += by;
                at(&moved)
            };
            let (above, below) = (moved(step)?, moved(-step)?);
            for (slopes, pole) in slopes.iter_mut().zip(&poles) {
                slopes[column] = (nearest(&above, *pole) - nearest(&below, *pole)) / (2.0 * step);
            }
        }
        let place = |parameter: usize| free.iter().position(|&known| known == parameter);
        let spread = |slopes: &[Complex<f64>]| {
            let mut covariance = Matrix2::zeros();
            for (row, column, value) in self.parameter_covariance() {
                let (Some(row), Some(column)) = (place(row), place(column)) else { continue };
                let (one, other) = (slopes[row], slopes[column]);
                covariance += value
                    * Matrix2::new(
                        one.re * other.re,
                        one.re * other.im,
                        one.im * other.re,
                        one.im * other.im,
                    );
            }
            covariance
        };
        let poles = poles.into_iter().zip(&slopes);
        Ok(poles.map(|(value, slopes)| Pole { value, covariance: spread(slopes) }).collect())
    }

    /// Transport delay of `input`, s; `None` where the structure contains no delay of this input.
    #[must_use]
    pub fn delay(&self, input: &str) -> Option<&Estimate> {
        let place = self.structure.inputs.iter().position(|name| name == input)?;
        let parameter = self.structure.delays.get(place).copied().flatten()?;
        self.estimates.list.get(parameter)
    }

    /// Time constant of the first-order lag of `input`, s; `None` where the structure contains no lag of this input.
    #[must_use]
    pub fn lag(&self, input: &str) -> Option<&Estimate> {
        let place = self.structure.inputs.iter().position(|name| name == input)?;
        let parameter = self.structure.lags.get(place).copied().flatten()?;
        self.estimates.list.get(parameter)
    }

    /// Estimated values of the structure's parameters.
    pub(super) fn values(&self) -> Vec<f64> {
        let count = self.structure.parameters.len();
        self.estimates.list.iter().take(count).map(|estimate| estimate.value).collect()
    }

    /// Indices of the structure's parameters that were estimated.
    pub(super) fn free_parameters(&self) -> impl Iterator<Item = usize> {
        let count = self.structure.parameters.len();
        self.estimates.free.iter().copied().filter(move |&index| index < count)
    }

    /// Row, column and value of the parameters' covariance, symmetric, without the noises.
    fn parameter_covariance(&self) -> Vec<(usize, usize, f64)> {
        let count = self.structure.parameters.len();
        let (free, covariance) = (&self.estimates.free, &self.estimates.covariance);
        let mut entries = Vec::new();
        for (row, &one) in free.iter().enumerate().filter(|(_, one)| **one < count) {
            for (column, &other) in free.iter().enumerate().filter(|(_, other)| **other < count) {
                let value = 0.5 * (covariance[(row, column)] + covariance[(column, row)]);
                entries.push((one, other, value));
            }
        }
        entries
    }

    /// Indices of the vehicle's states: all except gusts and measurement errors. A vehicle state affects outputs or
    /// other states, and other states or inputs drive it.
    pub(super) fn vehicle_states(&self) -> Vec<usize> {
        let structure = &self.structure;
        let (n, m) = (structure.states.len(), structure.inputs.len());
        let noises = n + m..n + m + structure.noises.len();
        let a = structure.at(&self.values()).a;
        (0..n)
            .filter(|&state| {
                let mut terms = structure.dynamics.iter().filter(|term| term.row == state);
                let is_seen = structure.outputs.contains(&structure.states[state])
                    || (0..n).any(|row| row != state && a[(row, state)] != 0.0);
                is_seen && !terms.all(|term| term.column == state || noises.contains(&term.column))
            })
            .collect()
    }
}

/// Step of the central differences, as a fraction of a parameter's bound. It is small compared with the bound and large
/// compared with rounding.
const STEP: f64 = 0.02;

fn nearest(poles: &[Complex<f64>], to: Complex<f64>) -> Complex<f64> {
    let distance = |pole: &Complex<f64>| (pole - to).norm();
    let closest = poles.iter().min_by(|one, other| distance(one).total_cmp(&distance(other)));
    closest.copied().unwrap_or(to)
}

#[cfg(test)]
mod tests {
    use approx::assert_abs_diff_eq;
    use nalgebra::DMatrix;

    use super::*;
    use crate::helicopter::model_structure::{ModelStructure, built_in};
    use crate::helicopter::velocity_error::VelocityError;
    use crate::methods::prediction_error::{Settings, identify};
    use crate::record::Experiment;

    /// Textbook yaw, r' = −4 r + 25 pedal, with a little noise and exact holds.
    fn yaw() -> Identified {
        const PERIOD_S: f64 = 0.03;
        let decay = f64::exp(-4.0 * PERIOD_S);
        let pedal = |sample: usize| if (sample / 50).is_multiple_of(2) { 0.1 } else { -0.1 };
        let mut rate = 0.0;
        let outputs = DMatrix::from_fn(1000, 1, |sample, _| {
            let measured: f64 = rate + 0.01 * ((sample * sample) as f64 * 0.618).fract();
            rate = decay * rate + 25.0 / 4.0 * (1.0 - decay) * pedal(sample);
            measured
        });
        let inputs = DMatrix::from_fn(1000, 3, |sample, input| match input {
            1 => pedal(sample),
            _ => 0.0,
        });
        let names =
            (["collective", "pedal", "v"].map(str::to_owned).to_vec(), vec!["r".to_owned()]);
        let record = Experiment::new("yaw", PERIOD_S, names.0, names.1, inputs, outputs)
            .expect("finite numbers");
        let settings =
            Settings::innovations(built_in("yaw").process_sigma(&VelocityError::NONE, PERIOD_S));
        let structure = built_in("yaw").equations.with_still("collective").with_still("v");
        identify(&structure, &[record], &settings).expect("it is identifiable")
    }

    #[test]
    fn the_pole_of_yaw_is_its_damping_and_as_sure_as_that() {
        let found = yaw();
        let damping = found.estimates.get("Nr").expect("it has one");
        let poles = found.poles().expect("one number");
        assert_eq!(poles.len(), 1);
        assert!((poles[0].value.re - damping.value).abs() < 1e-9, "{poles:?}");
        assert_abs_diff_eq!(
            poles[0].covariance[(0, 0)].sqrt() / damping.bound,
            1.0,
            epsilon = 1e-6
        );
        let [low, high] = poles[0].region_95(61)[..] else { panic!("an interval") };
        assert_abs_diff_eq!((high - low).re / (2.0 * 1.96 * damping.bound), 1.0, epsilon = 1e-3);
        assert!(low.re < -4.0 && -4.0 < high.re, "{low} to {high}");
    }

    #[test]
    fn the_vehicle_has_the_parameters_in_its_matrices_and_no_gusts() {
        let vehicle = yaw().vehicle().expect("finite");
        let value = |name: &str| {
            let found = vehicle.parameters().iter().find(|parameter| parameter.name == name);
            found.expect("it is listed").value
        };
        assert_eq!(vehicle.a()[(0, 0)], value("Nr"));
        let pedal = vehicle.input("pedal").expect("it has one");
        assert_eq!(vehicle.b()[(0, pedal)], value("Nped"));
        for structure in ModelStructure::all() {
            let structure = structure.equations;
            let driven = |state: usize| {
                let own = structure.states.len() + structure.inputs.len();
                let mut terms = structure.dynamics.iter().filter(|term| term.row == state);
                terms.any(|term| term.column != state && term.column < own)
            };
            let gusts: Vec<_> =
                (0..structure.states.len()).filter(|&state| !driven(state)).collect();
            let named = |state: &usize| {
                let name = &structure.states[*state];
                name.starts_with('d') || name.starts_with('e')
            };
            assert!(gusts.iter().all(named), "{}: {gusts:?}", structure.name);
        }
    }

    #[test]
    fn the_vehicle_moves_along_its_slopes_as_its_structure_does() {
        let found = yaw();
        let (vehicle, values) = (found.vehicle().expect("finite"), found.values());
        assert!(!vehicle.slopes().is_empty());
        for parameter in found.free_parameters() {
            let by = 1e-6 * found.estimates.list[parameter].bound;
            let (mut moved, mut off) = (values.clone(), vec![0.0; values.len()]);
            (moved[parameter], off[parameter]) = (values[parameter] + by, by);
            let expected = found.vehicle_at(&moved, &found.vehicle_states());
            let own = vehicle.moved(&off).expect("finite");
            let name = &found.structure.parameters[parameter].name;
            assert!((own.a() - expected.a).amax() <= 1e-3 * by, "{name}");
            assert!((own.b() - expected.b).amax() <= 1e-3 * by, "{name}");
        }
    }

    #[test]
    fn a_region_lies_where_the_normalised_distance_is_that_of_95_of_100() {
        let covariance = Matrix2::new(0.04, 0.018, 0.018, 0.01);
        let pole = Pole { value: Complex::new(-1.0, 2.0), covariance };
        let inverse = covariance.try_inverse().expect("it is positive");
        for at in pole.region_95(31) {
            let off = nalgebra::Vector2::new(at.re + 1.0, at.im - 2.0);
            let distance = (off.transpose() * inverse * off)[(0, 0)];
            assert_abs_diff_eq!(distance, 5.991, epsilon = 1e-6);
        }
    }
}
