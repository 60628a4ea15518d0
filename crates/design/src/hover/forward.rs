//! Margins of the gains in forward flight.

use super::closed_loop::FlightMode;
use super::config::HoverDesign;
use super::plant::normalised;
use crate::{DesignError, Margins, ZONE};
use hovernav::autopilot::Gains;
use hovernav_model::StateSpace;

/// Number of interpolated models between two neighbouring given models.
const BETWEEN: usize = 3;

/// Margins of one set of gains from hover to the fastest given model.
///
/// The gains do not change with speed. Each given model is linear about a trim at its speed. Between two neighbours
/// every derivative is interpolated if both have the same states; otherwise there are no points between them.
#[derive(Clone, Debug)]
pub struct ForwardFlight {
    /// The points, in order of their speeds; negative backwards.
    pub points: Vec<ForwardPoint>,
    /// Largest speed forwards and backwards, m/s, up to which every point from hover on has the margins of [`ZONE`] in
    /// every flight mode, rounded to 0.1 m/s. It is 0 where hover lacks them. `None` for a direction without a model.
    pub fastest_mps: [Option<f64>; 2],
    /// Pairs of neighbouring speeds, m/s, whose models have different states, so that no points lie between them.
    pub apart_mps: Vec<[f64; 2]>,
}

/// Margins at one speed.
#[derive(Clone, Debug)]
pub struct ForwardPoint {
    /// Forward speed, m/s.
    pub speed_mps: f64,
    /// Whether a model was given for this speed; otherwise the model is interpolated.
    pub is_given: bool,
    /// Margins in each flight mode, with the loops broken at the actuators; `None` where the mode is unstable.
    pub modes: Vec<(FlightMode, Option<Margins>)>,
}

/// Rejects a model of forward flight, for which no gains are designed.
///
/// # Errors
/// [`DesignError::At`].
pub(super) fn require_hover(model: &StateSpace) -> Result<(), DesignError> {
    match model.trim_speed_mps() {
        0.0 => Ok(()),
        value => Err(at(model, of_speed(value, "0, a model of hover"))),
    }
}

/// A model in the form of [`normalised`], with the lags of its sticks.
#[derive(Clone, Debug)]
pub(super) struct FlownModel {
    pub model: StateSpace,
    /// Delay and lag minus one sample, s, of cyclic and collective and of the pedal.
    late_s: [f64; 2],
}

impl FlownModel {
    /// `design` with the lags of this vehicle where they are larger.
    pub fn flown_by(&self, design: &HoverDesign) -> HoverDesign {
        design.as_late_as(self.late_s)
    }

    fn speed_mps(&self) -> f64 {
        self.model.trim_speed_mps()
    }

    fn between(&self, other: &Self, share: f64) -> Option<Self> {
        let model = self.model.between(&other.model, share)?;
        let late_s = [0, 1].map(|stick| self.late_s[stick].max(other.late_s[stick]));
        Some(Self { model, late_s })
    }
}

/// The models of a design: that of hover, then those at other speeds.
///
/// # Errors
/// [`DesignError::At`] for a first model that is not of hover, for two of the same speed, and for one at a speed that
/// cannot be used; [`DesignError`] for a model of hover that cannot be used.
pub(super) fn models(
    design: &HoverDesign,
    hover: &StateSpace,
    at_speed: &[StateSpace],
) -> Result<Vec<FlownModel>, DesignError> {
    require_hover(hover)?;
    let of = |model: &StateSpace| -> Result<FlownModel, DesignError> {
        Ok(FlownModel { model: normalised(model)?, late_s: design.late_s(model) })
    };
    let mut models = vec![of(hover)?];
    for model in at_speed {
        let speed_mps = model.trim_speed_mps();
        if models.iter().any(|own| own.speed_mps() == speed_mps) {
            let expected = "another speed than those of the other models";
            return Err(at(model, of_speed(speed_mps, expected)));
        }
        models.push(of(model).map_err(|source| at(model, source))?);
    }
    Ok(models)
}

fn of_speed(value: f64, expected: &'static str) -> DesignError {
    DesignError::Range { name: "trim_speed_mps", value, expected }
}

fn at(model: &StateSpace, source: DesignError) -> DesignError {
    DesignError::At { model: model.name().into(), source: Box::new(source) }
}

impl ForwardFlight {
    /// The margins of `gains`, which were designed for the `hover` model. They are computed for this model, for the
    /// models `at_speed`, and for three models between each two neighbours. Each model flies with its own delays and
    /// lags.
    ///
    /// # Errors
    /// [`DesignError::At`] for models that contradict each other or cannot be used.
    pub(crate) fn of(
        design: &HoverDesign,
        hover: &StateSpace,
        gains: &Gains,
        at_speed: &[StateSpace],
    ) -> Result<Self, DesignError> {
        let mut given = models(design, hover, at_speed)?;
        given.sort_by(|one, other| one.speed_mps().total_cmp(&other.speed_mps()));
        let (mut points, mut apart_mps) = (Vec::new(), Vec::new());
        for (index, model) in given.iter().enumerate() {
            points.push(ForwardPoint::of(design, gains, model, true)?);
            let Some(next) = given.get(index + 1) else { break };
            let shares = (1..=BETWEEN).map(|step| step as f64 / (BETWEEN + 1) as f64);
            match shares.map(|share| model.between(next, share)).collect::<Option<Vec<_>>>() {
                Some(between) => {
                    for model in &between {
                        points.push(ForwardPoint::of(design, gains, model, false)?);
                    }
                }
                None => apart_mps.push([model, next].map(FlownModel::speed_mps)),
            }
        }
        let (behind, ahead) = points.split_at(points.partition_point(|own| own.speed_mps < 0.0));
        let (hover, ahead) = ahead.split_at(ahead.len().min(1));
        let is_sound = hover.iter().all(ForwardPoint::has_margins);
        let fastest = |on: &mut dyn Iterator<Item = &ForwardPoint>| {
            let sound = on.take_while(|point| is_sound && point.has_margins()).last();
            sound.map_or(0.0, |point| point.allowed_mps())
        };
        let fastest_mps = [
            (!ahead.is_empty()).then(|| fastest(&mut ahead.iter())),
            (!behind.is_empty()).then(|| fastest(&mut behind.iter().rev())),
        ];
        Ok(Self { points, fastest_mps, apart_mps })
    }

    /// Largest speed, m/s, with the margins of [`ZONE`] in every direction for which a model was given.
    #[must_use]
    pub fn allowed_mps(&self) -> Option<f64> {
        self.fastest_mps.into_iter().flatten().reduce(f64::min)
    }
}

impl ForwardPoint {
    fn of(
        design: &HoverDesign,
        gains: &Gains,
        model: &FlownModel,
        is_given: bool,
    ) -> Result<Self, DesignError> {
        let modes = model.flown_by(design).margins_in_modes(&model.model, gains)?;
        Ok(Self { speed_mps: model.speed_mps(), is_given, modes })
    }

    /// Absolute speed, m/s, rounded to 0.1: to the nearest for a given model, down for an interpolated one. A flight at
    /// 5 m/s may give a model of 4.97 m/s.
    fn allowed_mps(&self) -> f64 {
        let tenths = 10.0 * self.speed_mps.abs();
        (if self.is_given { tenths.round() } else { tenths.floor() }) / 10.0
    }

    /// Smallest gain margin, dB, phase margin, °, and disk margin of any loop in any mode; `None` where a mode is
    /// unstable.
    #[must_use]
    pub fn weakest(&self) -> Option<[f64; 3]> {
        let modes = self.modes.iter().map(|(_, margins)| margins.as_ref());
        let margins = modes.collect::<Option<Vec<&Margins>>>()?;
        Some(margins.into_iter().fold([f64::INFINITY; 3], |[gain, phase, disk], own| {
            let channels = || own.channels.iter();
            [
                channels().map(|own| own.smallest_gain_db()).fold(gain, f64::min),
                channels().map(|own| own.phase_deg()).fold(phase, f64::min),
                disk.min(own.disk.value),
            ]
        }))
    }

    /// Whether every loop has the margins of [`ZONE`] in every flight mode.
    #[must_use]
    pub fn has_margins(&self) -> bool {
        self.weakest()
            .is_some_and(|[gain_db, phase_deg, _]| gain_db >= ZONE.0 && phase_deg >= ZONE.1)
    }
}
