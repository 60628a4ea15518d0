//! Closed-loop response to stationary gusts.

use nalgebra::DMatrix;

use super::closed_loop::{self, FlightMode, Parts};
use super::config::HoverDesign;
use super::plant::places;
use crate::reachability::gramian;
use crate::{DISTURBED, DesignError, Loop};
use hovernav::autopilot::Gains;
use hovernav_model::linalg::Stein;
use hovernav_model::{Signal, StateSpace, TimeDomain};

/// Stationary Dryden gusts, with the air passing along the vehicle's x axis.
///
/// # Source
/// MIL-F-8785C, 3.7.2.1, in the form of equation (W4) of docs/equations.md.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gusts {
    /// One sigma along each horizontal axis and vertically, m/s.
    pub sigma_mps: [f64; 2],
    /// Length scales, horizontal and vertical, m.
    pub length_m: [f64; 2],
    /// Speed of the passing air, m/s.
    pub passing_mps: f64,
}

impl Default for Gusts {
    /// Default gusts of `hovernav-sim`: 1.5 m/s horizontally and 0.8 m/s vertically, with lengths of 67 and 10 m, in 3
    /// m/s of wind.
    fn default() -> Self {
        Self { sigma_mps: [1.5, 0.8], length_m: [67.0, 10.0], passing_mps: 3.0 }
    }
}

/// Response of a vehicle in closed loop to gusts: standard deviations about trim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GustResponse {
    /// Standard deviations of the states, in the order of [`DISTURBED`]: rad/s, rad, m/s.
    pub states: [f64; 9],
    /// Standard deviations of lateral, longitudinal, collective, pedal; full travel to one side is 1.
    pub sticks: [f64; 4],
}

/// States of the gusts: one along x, two each for the other axes.
const GUST_STATES: [&str; 5] = ["gust_x", "gust_y1", "gust_y2", "gust_z1", "gust_z2"];

/// Standard deviations at the samples in the steady state.
///
/// # Source
/// Equation (L21) of docs/equations.md.
pub(super) fn respond(
    design: &HoverDesign,
    whole: &StateSpace,
    gains: &Gains,
    mode: FlightMode,
    gusts: &Gusts,
) -> Result<GustResponse, DesignError> {
    let positive = |name, value: f64| match value > 0.0 && value.is_finite() {
        true => Ok(()),
        false => Err(DesignError::Range { name, value, expected: "a number above 0" }),
    };
    for (sigma_mps, length_m) in gusts.sigma_mps.into_iter().zip(gusts.length_m) {
        positive("sigma_mps", sigma_mps)?;
        positive("length_m", length_m)?;
    }
    positive("passing_mps", gusts.passing_mps)?;
    let (blown, white) = in_air(whole, gusts)?;
    let Parts { plant, controller } = closed_loop::parts(design, &blown, gains, mode)?;
    let closed = Loop::at_plant_input(&plant, &controller)?;
    let (open, size) = (closed.open(), closed.open().states().len());
    let sticks = -open.c();
    let step = open.a() + open.b() * &sticks;
    let Some(equation) = Stein::new(&step) else {
        let pole = closed.closed_poles()?.into_iter().max_by(|a, b| a.norm().total_cmp(&b.norm()));
        let pole = pole.unwrap_or_default();
        return Err(DesignError::UnstableLoop { re: pole.re, im: pole.im });
    };
    // Covariance that the white noise of the gusts adds over one sample. The states of vehicle and gusts are the first
    // states of the closed loop.
    let flown = closed_loop::flown(&blown, mode)?;
    let white = white.resize_vertically(flown.states().len(), 0.0);
    let added = gramian(flown.a(), &white, TimeDomain::Continuous, design.period_s);
    let mut noise = DMatrix::zeros(size, size);
    noise.view_mut((0, 0), added.shape()).copy_from(&added);
    let covariance = equation.solve(noise);
    let of_sticks = &sticks * &covariance * sticks.transpose();
    let at = places(&flown, DISTURBED)?;
    Ok(GustResponse {
        states: at.map(|index| covariance[(index, index)].max(0.0).sqrt()),
        sticks: std::array::from_fn(|stick| of_sticks[(stick, stick)].max(0.0).sqrt()),
    })
}

/// `whole` followed by the states of the gusts, and the input matrix of unit white noise, n×3.
///
/// The forces on the vehicle depend on its velocity through the air. A gust therefore enters like velocity with the
/// opposite sign. It does not enter into heading and attitude, which follow from rates alone.
fn in_air(whole: &StateSpace, gusts: &Gusts) -> Result<(StateSpace, DMatrix<f64>), DesignError> {
    let n = whole.states().len();
    let size = n + GUST_STATES.len();
    let mut a = whole.a().clone().resize(size, size, 0.0);
    let mut white = DMatrix::zeros(size, 3);
    let [horizontal_s, vertical_s] = gusts.length_m.map(|length_m| length_m / gusts.passing_mps);
    let [horizontal, vertical] = gusts.sigma_mps;
    let root3 = 3f64.sqrt();
    // Factors from the states of the gusts to the gust along each axis.
    let across = |sigma: f64| [sigma * root3 / 2f64.sqrt(), sigma * (1.0 - root3) / 2f64.sqrt()];
    let axes = [
        ("u", n, horizontal_s, vec![horizontal]),
        ("v", n + 1, horizontal_s, across(horizontal).to_vec()),
        ("w", n + 3, vertical_s, across(vertical).to_vec()),
    ];
    for (axis, (name, first, time_s, mix)) in axes.into_iter().enumerate() {
        let velocity = whole.state(name)?;
        white[(first, axis)] = (2.0 / time_s).sqrt();
        for (lag, share) in mix.into_iter().enumerate() {
            a[(first + lag, first + lag)] = -1.0 / time_s;
            if lag > 0 {
                a[(first + lag, first)] = 1.0 / time_s;
            }
            for row in 0..n {
                let is_angle = matches!(whole.states()[row].name.as_str(), "phi" | "theta" | "psi");
                if !is_angle {
                    a[(row, first + lag)] = -share * whole.a()[(row, velocity)];
                }
            }
        }
    }
    let b = whole.b().clone().resize_vertically(size, 0.0);
    let states = whole.states().iter().cloned();
    let states = states.chain(GUST_STATES.map(|name| Signal::new(name, "m/s"))).collect();
    let inputs = whole.inputs().to_vec();
    Ok((StateSpace::new(whole.name(), whole.time(), states, inputs, a, b)?, white))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hover::evolution::Random;
    use approx::assert_abs_diff_eq;
    use hovernav_model::linalg::exponential;
    use hovernav_model::shipped;

    #[test]
    fn gusts_alone_have_the_strength_that_they_are_said_to_have() {
        let gusts = Gusts::default();
        let (blown, white) =
            in_air(&super::super::plant::normalised(&shipped::raptor60()).unwrap(), &gusts)
                .unwrap();
        let first = blown.states().len() - 5;
        let own = blown.a().view((first, first), (5, 5)).into_owned();
        let drive = white.rows(first, 5).into_owned();
        let covariance = gramian(&own, &drive, TimeDomain::Continuous, 1000.0);
        // The gusts are computed from their effect on a velocity with drag only: −Xu times the gust.
        let u = blown.state("u").unwrap();
        let x = blown.a()[(u, first)] / -blown.a()[(u, u)];
        assert_abs_diff_eq!(x * x * covariance[(0, 0)], 1.5 * 1.5, epsilon = 1e-6);
        let w = blown.state("w").unwrap();
        let mix = blown.a().view((w, first + 3), (1, 2)) / -blown.a()[(w, w)];
        let z = (&mix * covariance.view((3, 3), (2, 2)) * mix.transpose())[(0, 0)];
        assert_abs_diff_eq!(z, 0.8 * 0.8, epsilon = 1e-6);
    }

    #[test]
    fn the_deviations_are_those_of_a_long_flight() {
        // The same loops driven step by step by random noise: an hour is some 160 lengths of the gusts.
        let (model, design) = (shipped::raptor60(), HoverDesign::default());
        let gains = design.synthesise(&model).unwrap();
        let gusts = Gusts { length_m: [12.0, 6.0], ..Gusts::default() };
        let found = design.in_gusts(&model, &gains, FlightMode::Velocity, &gusts).unwrap();
        let whole = super::super::plant::normalised(&model).unwrap();
        let (blown, white) = in_air(&whole, &gusts).unwrap();
        let parts = closed_loop::parts(&design, &blown, &gains, FlightMode::Velocity).unwrap();
        let closed = Loop::at_plant_input(&parts.plant, &parts.controller).unwrap();
        let open = closed.open();
        let mut random = Random(7);
        let (n, fine) = (blown.states().len(), 4);
        let small_s = design.period_s / f64::from(fine);
        let (hold, kick) = (exponential(blown.a(), small_s), white * small_s.sqrt());
        let mut x = nalgebra::DVector::zeros(open.states().len());
        let (mut sums, mut of_sticks, steps) = ([0.0; 9], [0.0; 4], 240_000);
        let at = places(&blown, DISTURBED).unwrap();
        for _ in 0..steps {
            let sticks = -open.c() * &x;
            let mut added = nalgebra::DVector::<f64>::zeros(n);
            for _ in 0..fine {
                let drawn = nalgebra::DVector::from_fn(3, |_, _| random.normal());
                added = &hold * (added + &kick * drawn);
            }
            for (sum, index) in sums.iter_mut().zip(at) {
                *sum += x[index] * x[index];
            }
            for (sum, stick) in of_sticks.iter_mut().zip(sticks.iter()) {
                *sum += stick * stick;
            }
            x = open.a() * &x + open.b() * sticks;
            let mut own = x.rows_mut(0, n);
            own += added;
        }
        let pairs = sums.iter().zip(&found.states).chain(of_sticks.iter().zip(&found.sticks));
        for (sum, expected) in pairs {
            let seen = (sum / f64::from(steps)).sqrt();
            assert!((seen / expected - 1.0).abs() < 0.08, "{seen} {expected}");
        }
    }

    #[test]
    fn twice_the_gusts_move_it_twice_as_far_and_none_are_refused() {
        let (model, design) = (shipped::raptor60(), HoverDesign::default());
        let gains = design.synthesise(&model).unwrap();
        let of = |sigma: f64| {
            let gusts = Gusts { sigma_mps: [sigma, 0.5 * sigma], ..Gusts::default() };
            design.in_gusts(&model, &gains, FlightMode::Position, &gusts)
        };
        let [one, two] = [of(1.0).unwrap(), of(2.0).unwrap()];
        for (one, two) in one.states.iter().zip(two.states) {
            assert_abs_diff_eq!(two / one, 2.0, epsilon = 1e-6);
        }
        assert!(of(0.0).is_err() && of(f64::NAN).is_err());
    }
}
