//! Consistency of sensors and estimator, measured by the innovations.

use crate::ekf::{Channel, Innovation, Verdict};

/// The largest innovation of each kind since the last snapshot, divided by its predicted one-sigma; `None` without an
/// innovation of this kind.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Innovations {
    /// GPS position.
    pub position: Option<f64>,
    /// GPS velocity.
    pub velocity: Option<f64>,
    /// Roll and pitch of the inertial unit's own attitude.
    pub attitude: Option<f64>,
    /// Heading.
    pub heading: Option<f64>,
    /// Barometric height.
    pub baro: Option<f64>,
    /// Number of rejected updates since the start.
    pub rejected: u32,
}

impl Innovations {
    /// Counts a rejection, and updates the largest innovation of its kind. An innovation of NaN is ignored.
    pub fn note(&mut self, innovation: &Innovation) {
        let size = libm::fabs(innovation.normalised());
        let largest = match innovation.channel {
            Channel::PositionNorth | Channel::PositionEast | Channel::PositionDown => {
                Some(&mut self.position)
            }
            Channel::VelocityNorth | Channel::VelocityEast | Channel::VelocityDown => {
                Some(&mut self.velocity)
            }
            Channel::Roll | Channel::Pitch => Some(&mut self.attitude),
            Channel::Yaw | Channel::BaselineHeading => Some(&mut self.heading),
            Channel::BaroHeight => Some(&mut self.baro),
            // The frame has no field for the others.
            _ => None,
        };
        if let Some(largest) = largest.filter(|_| !size.is_nan()) {
            *largest = Some(largest.map_or(size, |before| before.max(size)));
        }
        self.rejected =
            self.rejected.saturating_add(u32::from(innovation.verdict == Verdict::Rejected));
    }

    /// Resets the innovations for the next snapshot; the count since the start stays.
    pub fn clear(&mut self) {
        *self = Self { rejected: self.rejected, ..Self::default() };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::time::Time;

    #[test]
    fn the_largest_innovation_of_each_kind_is_reported_and_refusals_add_up() {
        let mut summary = Innovations::default();
        let mut note = |channel, innovation, verdict| {
            let time = Time::ZERO;
            summary.note(&Innovation { time, channel, innovation, sigma: 2.0, verdict });
        };
        note(Channel::PositionNorth, -3.0, Verdict::Accepted);
        note(Channel::PositionDown, 1.0, Verdict::Accepted);
        note(Channel::Yaw, f64::NAN, Verdict::Rejected);
        note(Channel::VelocityEast, 20.0, Verdict::Rejected);
        note(Channel::Range, 20.0, Verdict::Rejected);
        assert_eq!((summary.position, summary.velocity), (Some(1.5), Some(10.0)));
        assert_eq!((summary.heading, summary.baro, summary.rejected), (None, None, 3));
        summary.clear();
        assert_eq!(summary, Innovations { rejected: 3, ..Innovations::default() });
    }
}
