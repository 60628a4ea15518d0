//! Summary of an identification: fit, bounds and strong correlations.

use super::identify::Identification;
use crate::methods::prediction_error::{Estimate, Fit, Status};
use hovernav_model::{IDENTIFIED, ModelError, StateSpace};

/// Uncertainty of the estimated parameters: Cramér–Rao bounds, one sigma, in percent of the values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundSummary<'a> {
    /// Median over the parameters; the upper of the two middle values for an even number.
    pub median_percent: f64,
    /// Largest bound.
    pub worst_percent: f64,
    /// Parameter with the largest bound.
    pub worst: &'a str,
}

impl Identification {
    /// Text of the key `source` in `model.toml`: identification from a flight of the vehicle `name`.
    #[must_use]
    pub fn source(&self, name: &str) -> String {
        let inputs = self.identified.structure.inputs.iter();
        let delays = inputs.filter_map(|input| Some(&*self.identified.delay(input)?.name));
        let mut delays: Vec<&str> = delays.collect();
        delays.dedup();
        format!(
            "{IDENTIFIED} from {:.0} s of {name} near {}, sampled every {:.4} s; \
             derivatives in SI per full stick, continuous in time; the sticks' delays are parameters \
             ({}) and not in the matrices; a parameter without variance was held or dropped",
            self.estimated_s,
            self.condition,
            self.identified.period_s,
            delays.join(", ")
        )
    }

    /// The vehicle alone, as [`Identified::vehicle`](crate::methods::prediction_error::Identified::vehicle). A model of
    /// forward flight also contains the kinematics of its trim: its velocity turns with the body.
    ///
    /// # Errors
    /// [`ModelError::NotFinite`] where a parameter is not finite.
    pub fn vehicle(&self) -> Result<StateSpace, ModelError> {
        let vehicle = self.identified.vehicle()?;
        if self.condition.speed_mps == 0.0 {
            return Ok(vehicle);
        }
        // Where the equations have a kinematic term, the identification has used it as a known input.
        let inputs = &self.identified.structure.inputs;
        let turning = [("ku", "u"), ("kv", "v"), ("kw", "w")].into_iter();
        let turning = turning.filter(|(term, _)| inputs.iter().any(|input| input == term));
        let rows: Vec<&str> = turning.map(|(_, row)| row).collect();
        vehicle.in_motion(self.trim_velocity_mps, &rows)
    }

    /// Fit by which the model is judged: over the validation test points if any, else over the estimation test points.
    #[must_use]
    pub fn fit(&self) -> &Fit {
        self.validation.as_ref().unwrap_or(&self.estimation)
    }

    /// Test points of [`fit`](Self::fit): indices into `test_points`.
    #[must_use]
    pub fn fit_points(&self) -> &[usize] {
        match self.validation {
            Some(_) => &self.validation_points,
            None => &self.estimation_points,
        }
    }

    /// The parameters of the structure, without its noises.
    #[must_use]
    pub fn parameters(&self) -> &[Estimate] {
        let list = &self.identified.estimates.list;
        list.get(..self.identified.structure.parameters.len()).unwrap_or(list)
    }

    /// Bounds of the estimated parameters, without those that ended on a limit of their search range. `None` where
    /// nothing was estimated. A fit without its bounds is meaningless.
    #[must_use]
    pub fn bounds(&self) -> Option<BoundSummary<'_>> {
        let estimated = self.parameters().iter().filter(|own| own.status == Status::Free);
        let mut bounds: Vec<(f64, &str)> =
            estimated.map(|estimate| (estimate.bound_percent(), &*estimate.name)).collect();
        bounds.sort_by(|one, other| one.0.total_cmp(&other.0));
        let &(median_percent, _) = bounds.get(bounds.len() / 2)?;
        let &(worst_percent, worst) = bounds.last()?;
        Some(BoundSummary { median_percent, worst_percent, worst })
    }

    /// Pairs of parameters whose correlation exceeds `least` in size, strongest first. Correlations with noises are
    /// omitted.
    #[must_use]
    pub fn strong_correlations(&self, least: f64) -> Vec<(&str, &str, f64)> {
        let structure = &self.identified.structure;
        let mut pairs = self.identified.estimates.strong_correlations(least);
        pairs.retain(|(one, other, _)| {
            [one, other].iter().all(|name| structure.parameter(name).is_some())
        });
        pairs
    }
}
