//! Uncertainty of an identified model.

use nalgebra::{DMatrix, DVector};

use super::closed_loop::{self, FlightMode};
use super::config::HoverDesign;
use super::evolution::Random;
use super::plant::normalised;
use crate::DesignError;
use hovernav_model::StateSpace;

/// Abbreviations of the sticks in the names of delays and lags, in the order of the controls.
const STICKS: [&str; 4] = ["lat", "lon", "col", "ped"];
/// Lower limit of a servo lag, s, for a vehicle whose stick delay is smaller than identified.
const SHORTEST_S: f64 = 1e-3;
/// Eigenvalue of the correlation matrix, divided by the number of parameters, below which a direction is only rounding.
const ROUNDING: f64 = 1e-12;

/// Vehicles consistent with a model: its parameters change along the principal axes of their covariance.
pub(super) struct Uncertainty<'a> {
    model: &'a StateSpace,
    /// Change of each parameter for one sigma along each direction, parameters × directions. The product with its
    /// transpose is the covariance.
    axes: DMatrix<f64>,
}

impl<'a> Uncertainty<'a> {
    /// Uncertainty of `model`; `None` where the model lacks the covariance or the slopes of its parameters. Parameters
    /// that affect neither the matrices nor a stick's delay or lag are omitted.
    pub fn of(model: &'a StateSpace) -> Option<Self> {
        let covariance = model.covariance().filter(|_| !model.slopes().is_empty())?;
        let parameters = model.parameters();
        let moves = |name: &str| {
            model.slopes().iter().any(|slope| slope.parameter == name)
                || STICKS.iter().any(|stick| {
                    [format!("tau_{stick}"), format!("lag_{stick}")].iter().any(|late| late == name)
                })
        };
        let known: Vec<usize> = (0..parameters.len())
            .filter(|&at| covariance[(at, at)] > 0.0 && moves(&parameters[at].name))
            .collect();
        if known.is_empty() {
            return None;
        }
        let sigmas: Vec<f64> = known.iter().map(|&at| covariance[(at, at)].sqrt()).collect();
        let correlations = DMatrix::from_fn(known.len(), known.len(), |row, column| {
            covariance[(known[row], known[column])] / sigmas[row] / sigmas[column]
        });
        let principal = correlations.symmetric_eigen();
        let directions: Vec<usize> = (0..known.len())
            .filter(|&at| principal.eigenvalues[at] > ROUNDING * known.len() as f64)
            .collect();
        let mut axes = DMatrix::zeros(parameters.len(), directions.len());
        for (column, &direction) in directions.iter().enumerate() {
            let length = principal.eigenvalues[direction].sqrt();
            for (row, (&parameter, sigma)) in known.iter().zip(&sigmas).enumerate() {
                axes[(parameter, column)] =
                    sigma * length * principal.eigenvectors[(row, direction)];
            }
        }
        (!directions.is_empty()).then_some(Self { model, axes })
    }

    /// Number of directions: the number of linearly independent parameters.
    pub fn directions(&self) -> usize {
        self.axes.ncols()
    }

    /// A random vehicle, as the number of sigmas along each direction.
    ///
    /// # Source
    /// Equation (L23) of docs/equations.md.
    pub fn draw(&self, random: &mut Random) -> DVector<f64> {
        DVector::from_fn(self.directions(), |_, _| random.normal())
    }

    /// The vehicle whose parameters differ from those of the model by `sigmas` along the directions.
    pub fn vehicle(&self, sigmas: &DVector<f64>) -> Result<Vehicle, DesignError> {
        let off = &self.axes * sigmas;
        let parameters = self.model.parameters();
        let later_s = STICKS.map(|stick| {
            let late = [format!("tau_{stick}"), format!("lag_{stick}")];
            let own = parameters.iter().zip(&off).filter(|(known, _)| late.contains(&known.name));
            own.map(|(_, off)| off).sum()
        });
        let moved = self.model.moved(off.as_slice())?;
        Ok(Vehicle { whole: normalised(&moved)?, later_s })
    }
}

/// A vehicle that differs from its model.
pub(super) struct Vehicle {
    /// The vehicle in the form of [`normalised`].
    whole: StateSpace,
    /// Additional delay of each stick compared with the model, s.
    later_s: [f64; 4],
}

impl Vehicle {
    /// The vehicle's plant for the autopilot in `mode`; an additional delay of a stick counts as a longer lag of its
    /// servo.
    pub fn plant(&self, design: &HoverDesign, mode: FlightMode) -> Result<StateSpace, DesignError> {
        let mut servos_s = closed_loop::servos_s(design);
        for (servo_s, later_s) in servos_s.iter_mut().zip(self.later_s) {
            *servo_s = (*servo_s + later_s).max(SHORTEST_S);
        }
        closed_loop::plant_behind(design, servos_s, &self.whole, mode)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use hovernav_model::{Parameter, Slope, shipped};

    /// The 60-class helicopter whose damping, control derivatives and delays have the relative one-sigma `share`. The
    /// two derivatives of roll are correlated.
    pub(in super::super) fn known_to(share: f64) -> StateSpace {
        let model = shipped::raptor60();
        let entries = [
            ("p", "b"),
            ("b", "lateral"),
            ("q", "a"),
            ("a", "longitudinal"),
            ("w", "w"),
            ("w", "collective"),
            ("r", "r"),
            ("r", "pedal"),
        ];
        let mut parameters = Vec::new();
        let mut slopes = Vec::new();
        for (row, column) in entries {
            let at = model.state(row).unwrap();
            let value = match model.state(column) {
                Ok(column) => model.a()[(at, column)],
                Err(_) => model.b()[(at, model.input(column).unwrap())],
            };
            let name = format!("{row}_{column}");
            parameters.push(Parameter { name: name.clone(), value, unit: String::new() });
            let [row, column] = [row, column].map(str::to_owned);
            slopes.push(Slope { parameter: name, row, column, slope: 1.0 });
        }
        for name in ["tau_ped", "tau_gust"] {
            parameters.push(Parameter { name: name.into(), value: 0.03, unit: "s".into() });
        }
        let sigmas: Vec<f64> = parameters.iter().map(|own| share * own.value.abs()).collect();
        let covariance = DMatrix::from_fn(sigmas.len(), sigmas.len(), |row, column| {
            let correlation = match (row.min(column), row.max(column)) {
                (0, 1) => -0.8,
                _ if row == column => 1.0,
                _ => 0.0,
            };
            correlation * sigmas[row] * sigmas[column]
        });
        let model = model.with_parameters(parameters, Some(covariance)).unwrap();
        model.with_slopes(slopes).unwrap()
    }

    #[test]
    fn vehicles_are_drawn_as_the_covariance_has_them() {
        let model = known_to(0.1);
        let uncertainty = Uncertainty::of(&model).unwrap();
        // The time constant of the gusts affects no entry.
        assert_eq!(uncertainty.directions(), 9);
        let mut random = Random(1);
        let drawn: Vec<DVector<f64>> =
            (0..8000).map(|_| &uncertainty.axes * uncertainty.draw(&mut random)).collect();
        let expected = model.covariance().unwrap();
        for row in 0..9 {
            for column in 0..9 {
                let products = drawn.iter().map(|off| off[row] * off[column]);
                let found = products.sum::<f64>() / drawn.len() as f64;
                let scale = (expected[(row, row)] * expected[(column, column)]).sqrt();
                let off = (found - expected[(row, column)]) / scale;
                assert!(off.abs() < 0.06, "{row} {column}: {off}");
            }
        }
        assert!(drawn.iter().all(|off| off[9] == 0.0));
    }

    #[test]
    fn a_later_stick_is_a_slower_servo() {
        let model = known_to(0.1);
        let uncertainty = Uncertainty::of(&model).unwrap();
        // A combination of the directions changes the pedal's delay.
        let off = uncertainty.axes.row(8).transpose();
        let vehicle = uncertainty.vehicle(&off).unwrap();
        let later_s = (&uncertainty.axes * &off)[8];
        assert!(later_s > 0.0);
        assert_abs_diff_eq!(vehicle.later_s[3], later_s, epsilon = 1e-12);
        let design = HoverDesign::default();
        let slower = HoverDesign { tail_servo_s: design.tail_servo_s + later_s, ..design.clone() };
        let expected = closed_loop::plant(&slower, &vehicle.whole, FlightMode::Velocity).unwrap();
        assert_eq!(vehicle.plant(&design, FlightMode::Velocity).unwrap(), expected);
    }

    #[test]
    fn a_model_that_does_not_tell_where_its_parameters_stand_has_none() {
        let model = known_to(0.1);
        let without_slopes = model.clone().with_slopes(Vec::new()).unwrap();
        let parameters = model.parameters().to_vec();
        let exact = DMatrix::zeros(parameters.len(), parameters.len());
        let exact = model.clone().with_parameters(parameters, Some(exact)).unwrap();
        for model in [shipped::raptor60(), without_slopes, exact] {
            assert!(Uncertainty::of(&model).is_none());
        }
    }
}
