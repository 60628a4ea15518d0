//! Start-up from any state of the IMU, and restart after a loss.

use approx::assert_abs_diff_eq;
use hovernav::dmu::{Command, Flow, Link, LinkFault, Mode, Packet, StartupError};
use hovernav::time::Time;
use hovernav_fly::devices::Firmware;

use crate::simulated_unit::{Conversation, SimulatedUnit};

const MODES: [Mode; 3] = [Mode::Voltage, Mode::Scaled, Mode::Angle];
const POLLED: Flow = Flow::Polled { cycle_s: 0.0303 };
const MODERN: Firmware = Firmware { ping_resets: false, knows_polled: true };

fn mode_of(packet: &Packet) -> Mode {
    match packet {
        Packet::Voltage(_) => Mode::Voltage,
        Packet::Scaled(_) => Mode::Scaled,
        Packet::Angle(_) => Mode::Angle,
    }
}

fn conversation(unit: SimulatedUnit, mode: Mode, flow: Flow) -> Conversation {
    Conversation::new(Link::new(mode, flow, Time::ZERO), unit, Time::ZERO)
}

#[test]
fn from_any_state_the_unit_runs_as_asked_within_a_second() {
    for ping_resets in [false, true] {
        for knows_polled in [false, true] {
            for (was, was_continuous) in MODES.map(|mode| [(mode, false), (mode, true)]).concat() {
                for (wanted, flow) in
                    MODES.map(|mode| [(mode, POLLED), (mode, Flow::Continuous)]).concat()
                {
                    for phase in 0..9 {
                        let firmware = Firmware { ping_resets, knows_polled };
                        let unit = SimulatedUnit::new(firmware, was, was_continuous);
                        let start = Time::ZERO + (1.0 + f64::from(phase) * 1.9e-3);
                        let link = Link::new(wanted, flow, start);
                        let mut talk = Conversation::new(link, unit, start);
                        talk.run(1.0);
                        let case = format!(
                            "{firmware:?}, was {was:?} continuous {was_continuous}, wanted \
                             {wanted:?} {flow:?}, phase {phase}"
                        );
                        assert_eq!(talk.faults, [], "{case}");
                        assert!(talk.packets.len() >= 10, "{case}: {}", talk.packets.len());
                        for (_, received) in &talk.packets {
                            assert_eq!(mode_of(&received.packet), wanted, "{case}");
                            assert!(talk.unit.has_sent(&received.packet), "{case}");
                        }
                        assert_eq!(talk.link.counts().bytes_lost(), 0, "{case}");
                    }
                }
            }
        }
    }
}

#[test]
fn polled_packets_come_once_a_cycle() {
    let unit = SimulatedUnit::new(MODERN, Mode::Voltage, false);
    let mut talk = conversation(unit, Mode::Angle, POLLED);
    talk.run(10.5);
    let steps: Vec<f64> = talk.packets.windows(2).map(|pair| pair[1].0 - pair[0].0).collect();
    assert_abs_diff_eq!(steps.iter().sum::<f64>() / steps.len() as f64, 0.0303, epsilon = 1e-5);
    assert!(steps.iter().all(|step| (step - 0.0303).abs() < 4e-3), "{steps:?}");
    let last = talk.packets.last().unwrap().1.sequence;
    assert_eq!(last - talk.packets[0].1.sequence, talk.packets.len() as u64 - 1);
}

#[test]
fn a_lost_byte_costs_a_polled_link_one_cycle() {
    let unit = SimulatedUnit::new(MODERN, Mode::Angle, false);
    let mut talk = conversation(unit, Mode::Angle, POLLED);
    talk.run(1.0);
    let before = talk.packets.len();
    talk.unit.unplugged = true;
    talk.run(0.012);
    talk.unit.unplugged = false;
    talk.run(0.988);
    assert_eq!(talk.faults, []);
    let lost = 33 - (talk.packets.len() - before);
    assert!(lost <= 2, "{lost} cycles lost");
}

#[test]
fn a_missing_unit_is_reported_and_taken_up_when_it_comes() {
    let mut unit = SimulatedUnit::new(MODERN, Mode::Voltage, false);
    unit.unplugged = true;
    let mut talk = conversation(unit, Mode::Angle, Flow::Continuous);
    talk.run(5.0);
    let no_reply = LinkFault::Startup(StartupError::NoReply { command: Command::Ping });
    assert!(!talk.faults.is_empty() && talk.faults.iter().all(|(_, fault)| *fault == no_reply));
    assert!(talk.faults[0].0 - Time::ZERO < 3.0);
    assert!(!talk.link.is_running());
    talk.unit.unplugged = false;
    talk.run(1.5);
    assert!(talk.packets.len() > 20, "{}", talk.packets.len());
}

#[test]
fn a_unit_unplugged_for_two_seconds_is_back_a_second_later() {
    for flow in [POLLED, Flow::Continuous] {
        for resets in [false, true] {
            let unit = SimulatedUnit::new(MODERN, Mode::Angle, true);
            let mut talk = conversation(unit, Mode::Angle, flow);
            talk.run(2.0);
            talk.unit.unplugged = true;
            let unplugged = talk.now;
            talk.run(2.0);
            if resets {
                (talk.unit.device.mode, talk.unit.device.continuous) = (Mode::Voltage, false);
            }
            talk.unit.unplugged = false;
            let plugged = talk.now;
            talk.run(2.0);
            let (reported, fault) = talk.faults[0];
            assert_eq!(fault, LinkFault::NoData);
            assert!(reported - unplugged < 0.55);
            let first = talk.packets.iter().find(|(time, _)| *time > plugged).unwrap();
            assert!(first.0 - plugged < 1.0, "{flow:?}: back after {} s", first.0 - plugged);
            let before = talk.packets.iter().rfind(|(time, _)| *time < unplugged).unwrap();
            assert!(first.1.sequence > before.1.sequence + 1, "the gap must show");
        }
    }
}

#[test]
fn a_unit_that_falls_back_to_another_mode_is_set_right() {
    for flow in [POLLED, Flow::Continuous] {
        let unit = SimulatedUnit::new(MODERN, Mode::Angle, false);
        let mut talk = conversation(unit, Mode::Angle, flow);
        talk.run(1.0);
        talk.unit.device.mode = Mode::Voltage;
        talk.run(2.5);
        assert_eq!(talk.faults.len(), 1, "{flow:?}: {:?}", talk.faults);
        let (last, received) = talk.packets.last().unwrap();
        assert!(talk.now - *last < 0.04);
        assert_eq!(mode_of(&received.packet), Mode::Angle);
    }
}

#[test]
fn a_line_full_of_noise_is_reported_before_it_would_count_as_dead() {
    let unit = SimulatedUnit::new(MODERN, Mode::Angle, false);
    let mut talk = conversation(unit, Mode::Angle, Flow::Continuous);
    talk.run(1.0);
    talk.unit.device.continuous = false;
    talk.run(0.1);
    let silenced = talk.now;
    while talk.faults.is_empty() {
        let now = talk.now;
        talk.unit.noise(&[0x5A; 38], now);
        talk.run(0.01);
    }
    let (reported, fault) = talk.faults[0];
    assert_eq!(fault, LinkFault::Garbled);
    assert!(reported - silenced < 0.25, "after {} s", reported - silenced);
}

#[test]
fn a_line_that_never_falls_silent_is_reported() {
    let unit = SimulatedUnit::new(MODERN, Mode::Angle, false);
    let mut talk = conversation(unit, Mode::Angle, Flow::Continuous);
    for _ in 0..500 {
        let now = talk.now;
        talk.unit.noise(b"H", now);
        talk.run(0.01);
    }
    let never_quiet = LinkFault::Startup(StartupError::NeverQuiet);
    assert!(!talk.faults.is_empty() && talk.faults.iter().all(|(_, fault)| *fault == never_quiet));
    assert_eq!(talk.packets, []);
}

#[test]
fn a_stray_byte_at_any_moment_of_the_start_only_delays_it() {
    for moment in 0..400 {
        let unit = SimulatedUnit::new(MODERN, Mode::Scaled, true);
        let mut talk = conversation(unit, Mode::Angle, POLLED);
        talk.run(f64::from(moment) * 1e-3);
        let now = talk.now;
        talk.unit.noise(b"A", now);
        talk.run(2.0 - f64::from(moment) * 1e-3);
        assert_eq!(talk.faults, [], "after {moment} ms");
        assert!(talk.packets.len() > 10, "after {moment} ms: {}", talk.packets.len());
        assert!(talk.packets.iter().all(|(_, found)| talk.unit.has_sent(&found.packet)));
    }
}

#[test]
fn a_cycle_out_of_range_is_brought_into_it() {
    for (cycle_s, expected_s) in [(0.0, 1.0 / 70.0), (f64::NAN, 1.0 / 70.0), (1e9, 0.05)] {
        let unit = SimulatedUnit::new(MODERN, Mode::Angle, false);
        let mut talk = conversation(unit, Mode::Angle, Flow::Polled { cycle_s });
        talk.run(1.0);
        let before = talk.packets.len();
        talk.run(10.0);
        let count = (talk.packets.len() - before) as f64;
        assert!((count - 10.0 / expected_s).abs() < 2.0, "{cycle_s}: {count} packets");
    }
}
