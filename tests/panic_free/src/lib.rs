//! Entry points into what flies, for the proof by linking that none of them can panic.
//!
//! The panic handler calls a function that is defined nowhere. `.ci/panic-free` links each entry by
//! itself and throws away what it does not reach: where a panic can be reached, the link fails.
#![no_std]

use core::panic::PanicInfo;

use hovernav::autopilot::{HoverAutopilot, Inputs, Outputs};
use hovernav::dmu::{
    Calibration, Link, LinkAction, Measurement, Packet, Plausibility, Received, SampleClock,
};
use hovernav::ekf::{Estimator, Notice, Solution, SteplessSolution};
use hovernav::event::Event;
use hovernav::flight_control::{ControlInputs, ControlNotice, ControlOutputs, FlightControl};
use hovernav::gps::quality::{Failures, QualityCheck};
use hovernav::gps::{ReceiverFix, nmea, tsip, ubx};
use hovernav::sensors::{SensorOutput, Sensors};
use hovernav::servo::packet::{self, PacketCapture, ServoPacket};
use hovernav::telemetry::{Snapshot, frame};
use hovernav::time::Time;

unsafe extern "C" {
    /// Defined nowhere.
    fn a_panic_is_reachable() -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    unsafe { a_panic_is_reachable() }
}

/// The check of the check: an index that is not known to be in range. Must not link.
#[unsafe(no_mangle)]
pub fn deliberate_panic(values: &[f64; 15], index: usize) -> f64 {
    values[index]
}

#[unsafe(no_mangle)]
pub fn estimator_push(estimator: &mut Estimator, event: &Event, notify: &mut dyn FnMut(Notice)) {
    estimator.push(event, notify);
}

#[unsafe(no_mangle)]
pub fn autopilot_step(autopilot: &mut HoverAutopilot, inputs: &Inputs<'_>) -> Outputs {
    autopilot.step(inputs)
}

#[unsafe(no_mangle)]
pub fn flight_control_step(
    control: &mut FlightControl,
    inputs: &ControlInputs<'_>,
    notify: &mut dyn FnMut(ControlNotice),
) -> ControlOutputs {
    control.step(inputs, notify)
}

#[unsafe(no_mangle)]
pub fn stepless_solution(stepless: &mut SteplessSolution, filtered: &Solution) -> Solution {
    stepless.solution(filtered)
}

#[unsafe(no_mangle)]
pub fn dmu_packet(link: &mut Link, bytes: &mut &[u8], now: Time) -> Option<Received> {
    link.next_packet(bytes, now)
}

#[unsafe(no_mangle)]
pub fn dmu_action(link: &mut Link, now: Time) -> LinkAction {
    link.next_action(now)
}

#[unsafe(no_mangle)]
pub fn dmu_sample(
    plausibility: &mut Plausibility,
    calibration: &Calibration,
    clock: &mut SampleClock,
    received: &Received,
    now: Time,
) -> Option<(Time, Measurement)> {
    let packet: &Packet = &received.packet;
    if plausibility.check(packet).any(|reason| reason.invalidates_packet()) {
        return None;
    }
    let stamp = clock.stamp(packet.timer(), received.sequence, now).ok()?;
    Some((stamp.time, calibration.measure(packet)?))
}

#[unsafe(no_mangle)]
pub fn tsip_read(
    decoder: &mut tsip::Decoder,
    bytes: &mut &[u8],
    arrival: Time,
) -> Option<ReceiverFix> {
    decoder.read(bytes, arrival).or_else(|| decoder.flush())
}

#[unsafe(no_mangle)]
pub fn nmea_read(
    decoder: &mut nmea::Decoder,
    bytes: &mut &[u8],
    arrival: Time,
) -> Option<ReceiverFix> {
    decoder.read(bytes, arrival).or_else(|| decoder.flush())
}

#[unsafe(no_mangle)]
pub fn ubx_read(
    decoder: &mut ubx::Decoder,
    bytes: &mut &[u8],
    arrival: Time,
) -> Option<ReceiverFix> {
    decoder.read(bytes, arrival).or_else(|| decoder.flush())
}

#[unsafe(no_mangle)]
pub fn tsip_set_up(
    startup: &mut tsip::Startup,
    decoder: &tsip::Decoder,
    now: Time,
) -> Option<tsip::Frame> {
    startup.poll(decoder, now)
}

#[unsafe(no_mangle)]
pub fn ubx_set_up(
    configuration: &mut ubx::Configuration,
    decoder: &mut ubx::Decoder,
    now: Time,
) -> Option<ubx::Message> {
    configuration.poll(decoder, now)
}

#[unsafe(no_mangle)]
pub fn gps_quality(quality: &mut QualityCheck, fix: &ReceiverFix) -> Failures {
    quality.check(fix)
}

#[unsafe(no_mangle)]
pub fn sensors_dmu(
    sensors: &mut Sensors,
    bytes: &[u8],
    now: Time,
    report: &mut dyn FnMut(SensorOutput),
) -> Time {
    sensors.dmu(bytes, now, report)
}

#[unsafe(no_mangle)]
pub fn sensors_gps(
    sensors: &mut Sensors,
    bytes: &[u8],
    arrival: Time,
    report: &mut dyn FnMut(SensorOutput),
) {
    sensors.gps(bytes, arrival, report);
}

#[unsafe(no_mangle)]
pub fn telemetry_pack(snapshot: &Snapshot, sequence: u8) -> [u8; frame::LENGTH] {
    frame::pack(snapshot, sequence)
}

#[unsafe(no_mangle)]
pub fn telemetry_unpack(
    decoder: &mut frame::Decoder,
    byte: u8,
) -> Option<Result<frame::Frame, frame::FrameError>> {
    decoder.push(byte)
}

#[unsafe(no_mangle)]
pub fn servo_packet_decode(decoder: &mut packet::Decoder, byte: u8) -> Option<packet::Received> {
    decoder.push(byte)
}

#[unsafe(no_mangle)]
pub fn servo_packet_encode(packet: &ServoPacket) -> [u8; packet::LENGTH] {
    packet.encode()
}

#[unsafe(no_mangle)]
pub fn servo_capture(capture: &mut PacketCapture, bytes: &[u8], arrival: Time) {
    capture.receive(bytes, arrival);
}
