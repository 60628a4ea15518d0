//! Margins of the gains in forward flight.

use super::closed_loop::{Cut, FlightMode};
use super::config::HoverDesign;
use crate::{DesignError, Margins, ZONE};
use hovernav::autopilot::Gains;
use hovernav_model::StateSpace;

/// Number of models between two neighbouring given ones.
const BETWEEN: usize = 3;

/// Margins of one set of gains from hover to the fastest given model.
///
/// The gains do not change with speed. Given models are those of a trim at their speed; between two of them every
/// derivative is interpolated.
#[derive(Clone, Debug)]
pub struct ForwardFlight {
    /// The points, in order of their speeds.
    pub points: Vec<ForwardPoint>,
    /// Largest speed, m/s, up to which every point from hover on has 6 dB and 45° in every flight mode; 0 where not even
    /// hover has.
    pub fastest_mps: f64,
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

impl ForwardFlight {
    /// The margins of `gains`, designed for the `hover` model, with it, with the models `ahead` at other speeds, and with
    /// three models between each two neighbours.
    ///
    /// # Errors
    /// [`DesignError`], also where a model of `ahead` lacks a state of `hover`, and [`DesignError::Range`] where two models
    /// have the same speed.
    pub(crate) fn of(
        design: &HoverDesign,
        hover: &StateSpace,
        gains: &Gains,
        ahead: &[StateSpace],
    ) -> Result<Self, DesignError> {
        let mut given: Vec<&StateSpace> = ahead.iter().chain([hover]).collect();
        given.sort_by(|one, other| one.trim_speed_mps().total_cmp(&other.trim_speed_mps()));
        let mut points = Vec::new();
        for pair in given.windows(2) {
            let (slow, fast) = (pair[0], pair[1]);
            if slow.trim_speed_mps() == fast.trim_speed_mps() {
                return Err(DesignError::Range {
                    name: "trim_speed_mps of a model",
                    value: fast.trim_speed_mps(),
                    expected: "another speed than those of the other models",
                });
            }
            points.push(ForwardPoint::of(design, gains, slow, true)?);
            for step in 1..=BETWEEN {
                let share = step as f64 / (BETWEEN + 1) as f64;
                points.push(ForwardPoint::of(design, gains, &slow.between(fast, share)?, false)?);
            }
        }
        if let Some(fastest) = given.last() {
            points.push(ForwardPoint::of(design, gains, fastest, true)?);
        }
        let ahead = points.iter().filter(|point| point.speed_mps >= 0.0);
        let sound = ahead.take_while(|point| point.has_margins());
        let fastest_mps = sound.map(|point| point.speed_mps).fold(0.0, f64::max);
        Ok(Self { points, fastest_mps })
    }
}

impl ForwardPoint {
    fn of(
        design: &HoverDesign,
        gains: &Gains,
        model: &StateSpace,
        is_given: bool,
    ) -> Result<Self, DesignError> {
        let in_mode = |mode| -> Result<_, DesignError> {
            Ok((mode, design.close_in(model, gains, mode, Cut::Actuators)?.margins().ok()))
        };
        Ok(Self {
            speed_mps: model.trim_speed_mps(),
            is_given,
            modes: FlightMode::ALL.into_iter().map(in_mode).collect::<Result<_, _>>()?,
        })
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

    /// Whether every loop has 6 dB and 45° in every flight mode.
    #[must_use]
    pub fn has_margins(&self) -> bool {
        self.weakest()
            .is_some_and(|[gain_db, phase_deg, _]| gain_db >= ZONE.0 && phase_deg >= ZONE.1)
    }
}
