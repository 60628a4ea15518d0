//! The closed loop: what was designed flies, with sensors, estimator, servos and wind inside.

use hovernav::autopilot::{HoverConfig, Mode, SetPoint};
use hovernav::design::hover::HoverDesign;
use hovernav::frames::Vector;
use hovernav::model::shipped;
use hovernav::sim::*;

fn autopilot() -> HoverConfig {
    let design = HoverDesign::default();
    HoverConfig::new(design.period_s, design.synthesise(&shipped::raptor60()).unwrap())
}

fn print_margins(design: &HoverDesign, model: &hovernav::model::StateSpace) {
    let gains = design.synthesise(model).unwrap();
    let closed = design.close(model, &gains).unwrap();
    println!("{}: {:?}", model.name(), closed.closed_poles().map(|p| p.iter().map(|p| p.norm()).fold(0.0, f64::max)));
    match closed.margins() {
        Err(e) => println!("{e}"),
        Ok(m) => for c in &m.channels {
            println!("  {}: up {:?} down {:?} pm {:?} at {:?}", c.name, c.gain_up.map(|g| 20.0*g.margin.log10()), c.gain_down.map(|g| -20.0*g.margin.log10()),
              c.phase.map(|p| p.margin.to_degrees()), c.phase.map(|p| p.frequency_radps));
        }
    }
}

#[test]
fn explore() {
    print_margins(&HoverDesign::default(), &shipped::raptor60());
    print_margins(&HoverDesign::thesis(), &shipped::thesis());
    let still = SetPoint::Velocity { forward_mps: 0.0, right_mps: 0.0, down_mps: 0.0, yaw_rate_radps: 0.0 };
    for (name, disturbance) in [
        ("none", Disturbance::default()),
        ("phi", Disturbance { attitude_rad: [0.5, 0.0, 0.0], ..Disturbance::default() }),
        ("theta", Disturbance { attitude_rad: [0.0, 0.5, 0.0], ..Disturbance::default() }),
        ("psi", Disturbance { attitude_rad: [0.0, 0.0, 0.3], ..Disturbance::default() }),
        ("p", Disturbance { rate_radps: Vector::new(1.0, 0.0, 0.0), ..Disturbance::default() }),
        ("q", Disturbance { rate_radps: Vector::new(0.0, 1.0, 0.0), ..Disturbance::default() }),
        ("r", Disturbance { rate_radps: Vector::new(0.0, 0.0, 1.0), ..Disturbance::default() }),
        ("u", Disturbance { velocity_mps: Vector::new(2.0, 0.0, 0.0), ..Disturbance::default() }),
        ("v", Disturbance { velocity_mps: Vector::new(0.0, 2.0, 0.0), ..Disturbance::default() }),
        ("w", Disturbance { velocity_mps: Vector::new(0.0, 0.0, 2.0), ..Disturbance::default() }),
    ] {
        let config = FlightConfig {
            feedback: Feedback::Truth,
            wind: WindConfig::calm(),
            engage_s: 0.0,
            duration_s: 25.0,
            orders: vec![(0.1, Order::Go(still)), (10.0, Order::Disturb(disturbance))],
            ..FlightConfig::new(autopilot())
        };
        let flight = config.fly().unwrap();
        let trim = flight.moments.iter().take_while(|m| m.truth.time.seconds() < 9.9).last().unwrap().truth;
        let states = |m: &Moment| {
            let e = m.truth.body_to_ned.euler();
            let e0 = trim.body_to_ned.euler();
            let vb = (m.truth.body_to_ned.inverse() * m.truth.velocity_mps).to_array();
            let w = m.truth.angular_rate_radps.to_array();
            [w[0], w[1], w[2], e.roll_rad - e0.roll_rad, e.pitch_rad - e0.pitch_rad, e.yaw_rad - e0.yaw_rad, vb[0], vb[1], vb[2]]
        };
        let sizes = [1.0, 1.0, 1.0, 0.5, 0.5, 0.3, 2.0, 2.0, 2.0];
        let settle: Vec<f64> = (0..9).map(|i| {
            flight.moments.iter().filter(|m| states(m)[i].abs() > 0.02 * sizes[i]).map(|m| m.truth.time.seconds() - 10.0).last().unwrap_or(-10.0)
        }).collect();
        println!("{name}: crashed {:?} p {:.2} q {:.2} r {:.2} phi {:.2} theta {:.2} psi {:.2} u {:.2} v {:.2} w {:.2}",
            flight.crashed_s, settle[0], settle[1], settle[2], settle[3], settle[4], settle[5], settle[6], settle[7], settle[8]);
    }
    for seed in 1..6 {
        let config = FlightConfig { seed, ..FlightConfig::new(autopilot()) };
        let start = std::time::Instant::now();
        let flight = config.fly().unwrap();
        println!("{seed}: {:?} crashed {:?} {:?}\n {:?}", start.elapsed(), flight.crashed_s, flight.transitions, flight.statistics(30.0));
        let _ = Mode::Manual;
    }
}
