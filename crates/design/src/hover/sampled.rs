//! Robustness of a design on vehicles drawn from the uncertainty of its model: stability and margins.

use nalgebra::{DMatrix, DVector};

use super::closed_loop::{self, FlightMode};
use super::config::HoverDesign;
use super::evolution::{Random, side_by_side};
use super::plant::normalised;
use super::proven::{ProvenRadius, UncertainLoop};
use super::required::growth_per_s;
use super::uncertainty::Uncertainty;
use crate::{DesignError, Loop};
use hovernav::autopilot::Gains;
use hovernav_model::StateSpace;

/// Number of frequencies for the margins of a vehicle.
const FREQUENCIES: usize = 90;
/// Seed of the draw of the vehicles.
const SEED: u64 = 20_050_614;

/// Robustness of a design on vehicles drawn from the covariance of its model's parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct SampledRobustness {
    /// Number of vehicles drawn.
    pub of: usize,
    /// Number of vehicles that are stable in every flight mode.
    pub stable: usize,
    /// Number of uncertain directions: the number of linearly independent parameters.
    pub directions: usize,
    /// Number of vehicles within the radius of proven stability in every mode.
    pub within_proven: usize,
    /// Results for each mode.
    pub modes: Vec<SampledMode>,
}

/// Robustness in one mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampledMode {
    /// The mode.
    pub mode: FlightMode,
    /// Number of vehicles that are stable in the mode.
    pub stable: usize,
    /// Fifth percentile over the vehicles of the smallest gain margin, dB, and phase margin, °, of any loop. An
    /// unstable vehicle counts with margins of zero.
    pub twentieth: (f64, f64),
    /// Smallest gain margin, dB, and phase margin, °, of all vehicles.
    pub worst: (f64, f64),
    /// Simultaneous parameter errors for which the loops are certainly stable. `None` where the nominal loops are
    /// unstable, or the loops with an error of one sigma cannot be computed.
    pub proven: Option<ProvenRadius>,
}

impl SampledRobustness {
    /// Number of vehicles drawn.
    pub const OF: usize = 500;

    /// Robustness of `gains` on 500 vehicles drawn from the covariance of `model`. `None` where the model lacks the
    /// covariance or the slopes of its parameters. The search uses other vehicles.
    ///
    /// Parameters are normal, with the correlations of the identification, and change the matrices along their slopes.
    /// An error of a stick's delay and lag changes the lag of its servo.
    ///
    /// # Errors
    /// [`DesignError`] where the loops cannot be closed around `model`.
    pub fn of(
        design: &HoverDesign,
        model: &StateSpace,
        gains: &Gains,
    ) -> Result<Option<Self>, DesignError> {
        let Some(uncertainty) = Uncertainty::of(model) else { return Ok(None) };
        let whole = normalised(model)?;
        let mut random = Random(SEED);
        let draws: Vec<DVector<f64>> =
            (0..Self::OF).map(|_| uncertainty.draw(&mut random)).collect();
        let mut is_stable = vec![true; draws.len()];
        let mut modes = Vec::with_capacity(FlightMode::ALL.len());
        for mode in FlightMode::ALL {
            let controller = closed_loop::controller(design, whole.inputs(), gains, mode)?;
            let flown = Flown { design, uncertainty: &uncertainty, controller, mode };
            let found = side_by_side(&draws, |sigmas| flown.weakest(sigmas));
            for (own, found) in is_stable.iter_mut().zip(&found) {
                *own &= found.is_some();
            }
            let sorted = |of: fn((f64, f64)) -> f64| {
                let mut values: Vec<f64> =
                    found.iter().map(|margins| margins.map_or(0.0, of)).collect();
                values.sort_by(f64::total_cmp);
                values
            };
            let (gains_db, phases_deg) = (sorted(|(gain, _)| gain), sorted(|(_, phase)| phase));
            modes.push(SampledMode {
                mode,
                stable: found.iter().flatten().count(),
                twentieth: (gains_db[Self::OF / 20], phases_deg[Self::OF / 20]),
                worst: (gains_db[0], phases_deg[0]),
                proven: flown.proven()?,
            });
        }
        let radius = modes.iter().map(|own| own.proven.map_or(0.0, |proven| proven.sigmas));
        let radius = radius.fold(f64::INFINITY, f64::min);
        Ok(Some(Self {
            of: Self::OF,
            stable: is_stable.iter().filter(|stable| **stable).count(),
            directions: uncertainty.directions(),
            within_proven: draws.iter().filter(|sigmas| sigmas.norm() < radius).count(),
            modes,
        }))
    }
}

/// The autopilot in one mode, and the drawn vehicles.
struct Flown<'a> {
    design: &'a HoverDesign,
    uncertainty: &'a Uncertainty<'a>,
    controller: StateSpace,
    mode: FlightMode,
}

impl Flown<'_> {
    fn closed(&self, sigmas: &DVector<f64>) -> Result<Loop, DesignError> {
        let plant = self.uncertainty.vehicle(sigmas)?.plant(self.design, self.mode)?;
        Loop::at_plant_input(&plant, &self.controller)
    }

    /// Smallest margins of the vehicle, dB and °; `None` where it is unstable or its step is not finite.
    fn weakest(&self, sigmas: &DVector<f64>) -> Option<(f64, f64)> {
        let closed = self.closed(sigmas).ok()?;
        let growth = growth_per_s(&closed, self.design.period_s);
        // The comparison treats a NaN as unstable.
        if growth < 0.0 { Some(closed.weakest(FREQUENCIES)) } else { None }
    }

    /// Radius of proven stability. The slope of the loop along each parameter direction is half its difference between
    /// plus and minus one sigma. `None` if the nominal loop is unstable or a slope cannot be computed.
    fn proven(&self) -> Result<Option<ProvenRadius>, DesignError> {
        let step = |sigmas: &DVector<f64>| -> Result<DMatrix<f64>, DesignError> {
            let closed = self.closed(sigmas)?;
            Ok(closed.open().a() - closed.open().b() * closed.open().c())
        };
        let directions = self.uncertainty.directions();
        let nominal = self.closed(&DVector::zeros(directions))?;
        if growth_per_s(&nominal, self.design.period_s) >= 0.0 {
            return Ok(None);
        }
        let moves = (0..directions).map(|direction| {
            let mut one = DVector::zeros(directions);
            one[direction] = 1.0;
            let (above, below) = (step(&one)?, step(&-&one)?);
            Ok((above - below) * 0.5)
        });
        let Ok(moves) = moves.collect::<Result<Vec<_>, DesignError>>() else { return Ok(None) };
        let step = step(&DVector::zeros(directions))?;
        let unmoved = ProvenRadius { sigmas: f64::INFINITY, frequency_radps: 0.0 };
        let uncertain = UncertainLoop::new(&step, &moves, self.design.period_s);
        Ok(Some(uncertain.map_or(unmoved, |own| own.radius())))
    }
}

#[cfg(test)]
mod tests {
    use super::super::uncertainty::tests::known_to;
    use super::*;
    use hovernav_model::shipped;

    #[test]
    fn what_is_known_well_is_stable_with_nearly_the_margins_of_the_model() {
        let (model, design) = (known_to(0.02), HoverDesign::default());
        let gains = design.synthesise(&model).unwrap();
        let of = |model| SampledRobustness::of(&design, model, &gains).unwrap();
        let found = of(&model).unwrap();
        assert_eq!((found.stable, found.within_proven, found.directions), (500, 500, 9));
        let own = design.close(&model, &gains).unwrap().weakest(FREQUENCIES);
        let SampledMode { twentieth, worst, .. } = found.modes[0];
        assert!(worst.0 <= twentieth.0 && twentieth.0 <= own.0 + 0.5, "{worst:?} {twentieth:?}");
        assert!(worst.1 <= twentieth.1 && twentieth.1 <= own.1 + 1.0, "{worst:?} {twentieth:?}");
        assert!(own.0 - worst.0 < 2.0 && own.1 - worst.1 < 8.0, "{worst:?} {own:?}");
        assert_eq!(of(&shipped::raptor60()), None);
    }

    /// The bound is valid: no vehicle within it is unstable, and it is not too conservative.
    #[test]
    fn no_vehicle_within_the_proven_radius_is_unstable_and_some_are_not_far_from_it() {
        let (model, design) = (known_to(0.3), HoverDesign::default());
        let gains = design.synthesise(&model).unwrap();
        let uncertainty = Uncertainty::of(&model).unwrap();
        let whole = normalised(&model).unwrap();
        let mode = FlightMode::Velocity;
        let controller = closed_loop::controller(&design, whole.inputs(), &gains, mode).unwrap();
        let flown = Flown { design: &design, uncertainty: &uncertainty, controller, mode };
        let radius = flown.proven().unwrap().unwrap().sigmas;
        let mut random = Random(2);
        // From the nominal model outwards along random directions: the distance at which stability is lost, in radii.
        let lost_at = |direction: DVector<f64>| {
            let direction = direction.normalize();
            (1..60).map(|step| 0.1 * f64::from(step)).find(|radii| {
                let sigmas = &direction * (*radii * radius);
                flown.weakest(&sigmas).is_none()
            })
        };
        let lost: Vec<Option<f64>> =
            (0..60).map(|_| lost_at(uncertainty.draw(&mut random))).collect();
        let nearest = lost.iter().flatten().copied().fold(f64::INFINITY, f64::min);
        println!(
            "proven {radius:.2} sigmas; the nearest of 60 that is lost, in radii: {nearest:.1}"
        );
        assert!(nearest > 1.0, "{nearest} radii");
        assert!(nearest < 4.0, "{nearest} radii");
    }
}
