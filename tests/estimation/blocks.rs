//! A drive with turns to both sides.

use core::f64::consts::FRAC_PI_2;

use hovernav::earth::Geodetic;
use hovernav::frames::Vector;
use hovernav_sim::FlightPlan;

/// A drive around this number of street corners at 8 m/s.
pub fn around_blocks(corners: u32) -> FlightPlan {
    let place = Geodetic::from_degrees(49.0, 8.4, 110.0).unwrap();
    let plan = FlightPlan::hover_at(place, 0.4).hold(5.0);
    let plan = plan.accelerate(Vector::new(8.0, 0.0, 0.0), 5.0);
    (0..corners).fold(plan, |plan, corner| {
        let sense = if corner % 5 < 3 { 1.0 } else { -1.0 };
        plan.hold(4.0).turn(sense * FRAC_PI_2, 0.5)
    })
}
