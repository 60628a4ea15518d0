//! Flight of an aerobatic aircraft, for tests of the filter.

use core::f64::consts::TAU;

use hovernav::earth::Geodetic;
use hovernav::frames::Vector;
use hovernav_sim::FlightPlan;

/// Rest for the given time, s, then circles in both directions at 25 m/s and 0.6 rad/s, banked by 57°, with a straight
/// second between them.
pub fn steep_circles(rest_s: f64, circles: u32) -> FlightPlan {
    let place = Geodetic::from_degrees(45.3, -93.2, 250.0).unwrap();
    let plan = FlightPlan::hover_at(place, 1.0).hold(rest_s);
    let plan = plan.accelerate(Vector::new(25.0, 0.0, 0.0), 4.0);
    (0..circles).fold(plan, |plan, circle| {
        let sense = if circle % 2 == 0 { 1.0 } else { -1.0 };
        plan.turn(sense * TAU, 0.6).hold(1.0)
    })
}
