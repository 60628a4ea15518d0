//! Sample times from a timer that wraps every 51.8 ms and from arrivals with jitter.

use approx::assert_abs_diff_eq;
use hovernav::dmu::{Basis, ClockFault, SampleClock, Stamp};
use hovernav::time::Time;
use proptest::prelude::*;

use crate::generator::Random;

const LATENCY_S: f64 = 0.0078;

/// An IMU whose timer has its own tick, and the serial line of the IMU.
struct Source {
    tick_s: f64,
    start: Time,
    random: Random,
}

impl Source {
    fn new(tick_error: f64, seed: u64) -> Self {
        let start = Time::from_nanoseconds(5_000_000_123);
        Self { tick_s: 0.79e-6 * (1.0 + tick_error), start, random: Random(seed) }
    }

    /// Timer, arrival and true sample time of a packet sampled `time_s` after the start, with a delay of `late_s`.
    fn packet(&self, time_s: f64, late_s: f64) -> (u16, Time, Time) {
        let timer = 0x1234u16.wrapping_sub((time_s / self.tick_s) as u64 as u16);
        let sampled = self.start + time_s;
        (timer, sampled + (LATENCY_S + late_s), sampled)
    }
}

fn stamp(clock: &mut SampleClock, packet: (u16, Time, Time), sequence: u64) -> (Stamp, f64) {
    let (timer, arrival, sampled) = packet;
    let stamp = clock.stamp(timer, sequence, arrival).unwrap();
    (stamp, stamp.time - sampled)
}

#[test]
fn intervals_are_those_of_the_timer_however_the_arrivals_jitter() {
    for tick_error in [-6e-3, 0.0, 6e-3] {
        let mut source = Source::new(tick_error, 1);
        let mut clock = SampleClock::new(LATENCY_S);
        let (mut previous, mut worst_s, mut worst_offset_s) = (None, 0.0f64, 0.0f64);
        for index in 0..33 * 180 {
            let time_s = f64::from(index) / 33.0;
            let jitter_s = 1e-3 + 1e-3 * source.random.unit();
            let packet = source.packet(time_s, jitter_s);
            let (stamp, error_s) = stamp(&mut clock, packet, index as u64);
            if let (Some(previous_s), true) = (previous, index > 33 * 60) {
                worst_s = worst_s.max(f64::abs(error_s - previous_s));
                worst_offset_s = worst_offset_s.max(f64::abs(error_s - 1e-3));
                assert_eq!(stamp.basis, Basis::Timer);
            }
            previous = Some(error_s);
        }
        assert!(worst_s < 8e-6, "an interval wrong by {worst_s} s");
        assert!(worst_offset_s < 0.3e-3, "a time wrong by {worst_offset_s} s");
        assert_abs_diff_eq!(clock.tick_s() / source.tick_s, 1.0, epsilon = 20e-6);
    }
}

#[test]
fn any_number_of_lost_packets_leaves_the_times_right() {
    for lost in 0..60 {
        let source = Source::new(3e-3, 2);
        let mut clock = SampleClock::new(LATENCY_S);
        for index in 0..200u32 {
            let time_s = f64::from(index + if index < 100 { 0 } else { lost }) * 0.0303;
            let sequence = u64::from(index + u32::from(index >= 100 && lost > 0));
            let (stamp, error_s) = stamp(&mut clock, source.packet(time_s, 0.0), sequence);
            assert!(error_s.abs() < 1e-3, "{lost} lost: {error_s} s");
            let expected = match index {
                0 => Basis::Arrival,
                100 if lost > 0 => {
                    Basis::TimerAcrossGap { turns: (30.3 * f64::from(lost + 1) / 51.929) as u32 }
                }
                _ => Basis::Timer,
            };
            assert_eq!(stamp.basis, expected, "{lost} lost, packet {index}");
        }
    }
}

#[test]
fn a_gap_too_long_for_the_timer_starts_again_from_the_arrival() {
    let source = Source::new(3e-3, 3);
    let mut clock = SampleClock::new(LATENCY_S);
    stamp(&mut clock, source.packet(0.0, 0.0), 0);
    let (after, error_s) = stamp(&mut clock, source.packet(7200.0, 0.0), 2);
    assert_eq!(after.basis, Basis::Arrival);
    assert!(error_s.abs() < 1e-9);
}

#[test]
fn packets_read_late_in_one_heap_keep_their_intervals() {
    let source = Source::new(-4e-3, 4);
    let mut clock = SampleClock::new(LATENCY_S);
    for index in 0..2000u32 {
        let time_s = f64::from(index) * 0.0303;
        // The reader sleeps for 0.6 s; then it reads all packets at once.
        let heap_s = 1000.0 * 0.0303..1020.0 * 0.0303;
        let late_s = if heap_s.contains(&time_s) { heap_s.end - time_s } else { 0.0 };
        let (stamp, error_s) = stamp(&mut clock, source.packet(time_s, late_s), index.into());
        if index > 100 {
            assert_eq!(stamp.basis, Basis::Timer);
            assert!(error_s.abs() < 0.1e-3, "packet {index}: {error_s} s");
        }
    }
}

#[test]
fn packets_heaped_up_before_the_start_are_dropped_until_the_times_are_right() {
    let source = Source::new(2e-3, 5);
    let mut clock = SampleClock::new(LATENCY_S);
    let mut last_wrong = 0;
    for index in 0..300u32 {
        let time_s = f64::from(index) * 0.0303;
        let late_s = (10.0 * 0.0303 - time_s).max(0.0);
        let (timer, arrival, sampled) = source.packet(time_s, late_s);
        match clock.stamp(timer, index.into(), arrival) {
            Ok(stamp) if (stamp.time - sampled).abs() < 6e-3 => {}
            Ok(_) | Err(ClockFault::NotAfterPrevious { .. }) => last_wrong = index,
            Err(fault) => panic!("{fault}"),
        }
    }
    assert!(last_wrong <= 10, "wrong up to packet {last_wrong}");
}

#[test]
fn a_repeated_packet_has_no_time_of_its_own() {
    let source = Source::new(0.0, 6);
    let mut clock = SampleClock::new(LATENCY_S);
    stamp(&mut clock, source.packet(0.0, 0.0), 0);
    let (timer, arrival, _) = source.packet(0.0, 0.0);
    let repeated = clock.stamp(timer, 1, arrival + 0.01);
    assert_eq!(repeated, Err(ClockFault::TimerStopped { timer }));
    let (after, error_s) = stamp(&mut clock, source.packet(0.0303, 0.0), 2);
    assert_eq!(after.basis, Basis::Timer);
    assert!(error_s.abs() < 1e-3);
}

#[test]
fn a_turn_lost_unnoticed_is_found_within_half_a_second() {
    let source = Source::new(0.0, 7);
    let mut clock = SampleClock::new(LATENCY_S);
    let mut wrong = 0;
    for index in 0..400u32 {
        let skipped_s = if index < 200 { 0.0 } else { 3.0 * 0.0303 };
        let packet = source.packet(f64::from(index) * 0.0303 + skipped_s, 0.0);
        let (_, error_s) = stamp(&mut clock, packet, index.into());
        wrong += u32::from(error_s.abs() > 5e-3);
    }
    assert!((1..17).contains(&wrong), "{wrong} wrong times");
}

#[test]
fn a_wrong_timer_spoils_only_its_own_packet() {
    for wrong_timer in (0..=u16::MAX).step_by(1021) {
        let source = Source::new(1e-3, 8);
        let mut clock = SampleClock::new(LATENCY_S);
        for index in 0..400u32 {
            let (timer, arrival, sampled) = source.packet(f64::from(index) * 0.0303, 0.0);
            let timer = if index == 200 { wrong_timer } else { timer };
            let stamp = clock.stamp(timer, index.into(), arrival);
            if !(200..=240).contains(&index) {
                assert!((stamp.unwrap().time - sampled).abs() < 1e-3, "packet {index}");
            }
        }
    }
}

proptest! {
    #[test]
    fn times_increase_whatever_comes(
        latency_s in prop_oneof![Just(f64::NAN), Just(f64::INFINITY), -1.0..1.0],
        packets in prop::collection::vec((any::<u16>(), any::<bool>(), prop_oneof![
            4 => -20_000_000i64..200_000_000,
            1 => any::<i64>(),
        ]), 0..200),
    ) {
        let mut clock = SampleClock::new(latency_s);
        let (mut arrival, mut sequence, mut last) = (0i64, 0u64, None);
        for (timer, contiguous, step) in packets {
            arrival = arrival.saturating_add(step);
            sequence += if contiguous { 1 } else { 2 };
            if let Ok(stamp) = clock.stamp(timer, sequence, Time::from_nanoseconds(arrival)) {
                prop_assert!(last.is_none_or(|last| stamp.time > last));
                prop_assert!(stamp.late_s.is_finite());
                last = Some(stamp.time);
            }
            prop_assert!((clock.tick_s() / 0.79e-6 - 1.0).abs() < 0.0101);
        }
    }
}
