//! Solutions, reference and fixes as columns of numbers, in the page's units and time.

use std::collections::HashSet;

use hovernav::earth::{Geodetic, LocalEarth};
use hovernav::ekf::{Channel, Innovation, Solution, Verdict};
use hovernav::gps::Fix;
use hovernav::time::Time;
use hovernav_dataset::ReferenceMoment;
use hovernav_findings::Finding;
use hovernav_formats::Onboard;

use super::data::FlightData;
use crate::document::{FAR_S, time_label};
use crate::{Mark, TimeAxis};

/// The time axis of the page, s. A log with large clock values, such as GPS or Unix time, is shown relative to its
/// first whole second; the axis label states that second.
#[derive(Clone, Copy)]
pub struct Clock {
    zero: Time,
}

impl Clock {
    pub fn of(flight: &FlightData<'_>) -> Self {
        const SECOND_NS: i64 = 1_000_000_000;
        let start = flight.span().map_or(Time::ZERO, |(start, _)| start);
        let is_far = start.seconds().abs() >= FAR_S;
        let whole_s = if is_far { start.nanoseconds().div_euclid(SECOND_NS) } else { 0 };
        Self { zero: Time::from_nanoseconds(whole_s.saturating_mul(SECOND_NS)) }
    }

    /// The page's time of `time`, s.
    pub fn seconds(self, time: Time) -> f64 {
        time - self.zero
    }

    /// The warnings as spans on the page: the most harmful ones, up to a readable number.
    fn marks(self, flight: &FlightData<'_>) -> Vec<Mark> {
        const MAX: usize = 60;
        let mut warnings: Vec<&Finding> =
            flight.findings.iter().filter(|finding| finding.is_warning()).collect();
        warnings.sort_by(|a, b| a.by_harm(b));
        warnings.truncate(MAX);
        warnings.sort_by(|a, b| a.start_s.total_cmp(&b.start_s));
        let zero_s = self.zero.seconds();
        warnings
            .iter()
            .map(|finding| Mark {
                span: [finding.start_s - zero_s, finding.end_s - zero_s],
                words: finding.words.clone(),
            })
            .collect()
    }

    pub fn axis(self, flight: &FlightData<'_>) -> TimeAxis {
        let label = time_label(self.zero.seconds());
        let (start, end) = flight.span().unwrap_or((self.zero, self.zero));
        let outages = flight.outages.iter().filter(|outage| outage.duration_s.is_finite());
        TimeAxis {
            label,
            span: [self.seconds(start), self.seconds(end)],
            outages: outages
                .map(|outage| [outage.start, outage.start + outage.duration_s])
                .map(|ends| ends.map(|end| self.seconds(end)))
                .collect(),
            marks: self.marks(flight),
        }
    }
}

/// Three components of a quantity, one series each.
pub type Columns = [Vec<f64>; 3];

pub fn columns<T>(items: &[T], components: impl Fn(&T) -> [f64; 3]) -> Columns {
    let mut columns = [(); 3].map(|()| Vec::with_capacity(items.len()));
    for item in items {
        for (column, value) in columns.iter_mut().zip(components(item)) {
            column.push(value);
        }
    }
    columns
}

/// The rows of `columns` in which all values are known. The messages of an onboard estimator have different times, so
/// each row has the values of one message.
pub fn known<const N: usize>(columns: [&[f64]; N]) -> [Vec<f64>; N] {
    let rows = columns.iter().map(|column| column.len()).min().unwrap_or(0);
    let is_known = |row: &usize| columns.iter().all(|column| column[*row].is_finite());
    let rows: Vec<usize> = (0..rows).filter(is_known).collect();
    columns.map(|column| rows.iter().map(|&row| column[row]).collect())
}

/// The motion from an estimate or a reference, in the page's units; unknown values are NaN.
pub struct Motion {
    pub time: Vec<f64>,
    pub position_m: Columns,
    pub velocity_mps: Columns,
    pub body_velocity_mps: Columns,
    pub attitude_deg: Columns,
}

impl Motion {
    pub fn of_solutions(solutions: &[Solution], clock: Clock, origin: &Geodetic) -> Self {
        let local = LocalEarth::at(origin);
        Self {
            time: solutions.iter().map(|s| clock.seconds(s.time)).collect(),
            position_m: columns(solutions, |s| local.displacement(origin, &s.position).to_array()),
            velocity_mps: columns(solutions, |s| s.velocity_mps.to_array()),
            body_velocity_mps: columns(solutions, |s| s.velocity_body_mps().to_array()),
            attitude_deg: columns(solutions, |s| s.body_to_ned.euler().to_degrees()),
        }
    }

    /// The motion from the onboard estimator. Its body velocity needs both attitude and velocity.
    pub fn of_onboard(onboard: Option<&Onboard>, clock: Clock, origin: &Geodetic) -> Self {
        const UNKNOWN: [f64; 3] = [f64::NAN; 3];
        let moments = onboard.map_or(&[][..], |onboard| &onboard.moments);
        let local = LocalEarth::at(origin);
        Self {
            time: moments.iter().map(|moment| clock.seconds(moment.time)).collect(),
            position_m: columns(moments, |moment| {
                moment.position.map_or(UNKNOWN, |at| local.displacement(origin, &at).to_array())
            }),
            velocity_mps: columns(moments, |moment| {
                moment.velocity_mps.map_or(UNKNOWN, |velocity| velocity.to_array())
            }),
            body_velocity_mps: columns(moments, |moment| {
                let both = moment.body_to_ned.zip(moment.velocity_mps);
                both.map_or(UNKNOWN, |(attitude, velocity)| {
                    (attitude.inverse() * velocity).to_array()
                })
            }),
            attitude_deg: columns(moments, |moment| {
                moment.body_to_ned.map_or(UNKNOWN, |attitude| attitude.euler().to_degrees())
            }),
        }
    }

    pub fn of_reference(
        reference: &[(Time, ReferenceMoment)],
        clock: Clock,
        origin: &Geodetic,
    ) -> Self {
        let local = LocalEarth::at(origin);
        Self {
            time: reference.iter().map(|(time, _)| clock.seconds(*time)).collect(),
            position_m: columns(reference, |(_, moment)| {
                let [latitude_rad, longitude_rad, height_m] = moment.position;
                let place = Geodetic { latitude_rad, longitude_rad, height_m };
                local.displacement(origin, &place).to_array()
            }),
            velocity_mps: columns(reference, |(_, moment)| moment.velocity_mps),
            body_velocity_mps: columns(reference, |(_, moment)| moment.body_velocity_mps),
            attitude_deg: columns(reference, |(_, moment)| {
                moment.attitude_rad.map(f64::to_degrees)
            }),
        }
    }
}

/// The fixes in the page's units, with the filter's rejections.
pub struct Fixes {
    pub time: Vec<f64>,
    pub position_m: Columns,
    pub velocity_mps: Columns,
    /// Rejected positions for each axis; north and east are accepted or rejected together.
    pub position_rejected: [Vec<bool>; 3],
    pub velocity_rejected: [Vec<bool>; 3],
}

impl Fixes {
    pub fn of(fixes: &[Fix], innovations: &[Innovation], clock: Clock, origin: &Geodetic) -> Self {
        use Channel::{PositionDown, PositionEast, PositionNorth};
        use Channel::{VelocityDown, VelocityEast, VelocityNorth};
        let rejected = |channels: &[Channel]| -> Vec<bool> {
            let rejected = innovations.iter().filter(|innovation| {
                innovation.verdict == Verdict::Rejected && channels.contains(&innovation.channel)
            });
            let times: HashSet<Time> = rejected.map(|innovation| innovation.time).collect();
            fixes.iter().map(|fix| times.contains(&fix.time)).collect()
        };
        let local = LocalEarth::at(origin);
        Self {
            time: fixes.iter().map(|fix| clock.seconds(fix.time)).collect(),
            position_m: columns(fixes, |fix| local.displacement(origin, &fix.position).to_array()),
            velocity_mps: columns(fixes, |fix| {
                let [north, east] = fix.horizontal_velocity_mps.unwrap_or([f64::NAN; 2]);
                [north, east, fix.down_velocity_mps.unwrap_or(f64::NAN)]
            }),
            position_rejected: [
                rejected(&[PositionNorth, PositionEast]),
                rejected(&[PositionNorth, PositionEast]),
                rejected(&[PositionDown]),
            ],
            velocity_rejected: [
                rejected(&[VelocityNorth, VelocityEast]),
                rejected(&[VelocityNorth, VelocityEast]),
                rejected(&[VelocityDown]),
            ],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hovernav_dataset::Outage;

    #[test]
    fn a_clock_that_counts_from_far_away_is_shown_from_the_first_second() {
        let start = Time::from_nanoseconds(1_400_000_000_250_000_000);
        let fixes = [0.0, 9.0].map(|offset_s| {
            Fix::at(start + offset_s, Geodetic::from_degrees(47.0, 8.0, 400.0).unwrap())
        });
        let outages = [Outage { start: start + 2.0, duration_s: 3.0 }];
        let flight = FlightData { fixes: &fixes, outages: &outages, ..FlightData::default() };
        let axis = Clock::of(&flight).axis(&flight);
        assert_eq!(axis.label, "Time after 1400000000 s, s");
        assert_eq!(axis.span, [0.25, 9.25]);
        assert_eq!(axis.outages, [[2.25, 5.25]]);
    }
}
