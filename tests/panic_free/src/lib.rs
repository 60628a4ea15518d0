//! Entry points into flight code, for the proof by linking that none of them can panic.
//!
//! The panic handler calls a function without a definition. `.ci/panic-free` links each entry by itself and discards
//! unreachable code: a reachable panic fails the link.
#![no_std]

use core::panic::PanicInfo;

use hovernav::autopilot::{HoverAutopilot, Inputs, Outputs, SetPoint};
use hovernav::health::{Health, HealthMonitor};
use hovernav::controls::{Channels, Sticks};
use hovernav::dmu::{
    Calibration, Link, LinkAction, Measurement, Packet, Plausibility, Received, SampleClock,
};
use hovernav::ekf::layout::{Base, Full, Layout, WithoutHeightAids};
use hovernav::ekf::{
    Estimator, HeadingSearch, NoHeadingSearch, Notice, Report, Solution, SteplessSolution, Unusable,
};
use hovernav::event::Event;
use hovernav::flight_control::{ControlInputs, ControlNotice, ControlOutputs, FlightControl};
use hovernav::gps::quality::{Failures, QualityCheck};
use hovernav::gps::{ReceiverFix, nmea, tsip, ubx};
use hovernav::imu::{ImuSample, Notch};
use hovernav::scalar::Scalar;
use hovernav::sensors::{SensorOutput, Sensors};
use hovernav::servo::packet::{self, PacketCapture, ServoPacket};
use hovernav::servo::{Captured, ChannelConfig, Limited, Limiter, Swashplate, Switch};
use hovernav::telemetry::{Flow, Severity, Snapshot, Supplement, Text, frame};
use hovernav::time::Time;

unsafe extern "C" {
    /// A function without a definition.
    fn a_panic_is_reachable() -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    unsafe { a_panic_is_reachable() }
}

/// A test of the check: the index is not known to be in range. This function must not link.
#[unsafe(no_mangle)]
pub fn deliberate_panic(values: &[f64; 15], index: usize) -> f64 {
    values[index]
}

/// A test of the check for recursion: Ackermann's function, which no optimiser turns into loops. The check must find
/// its recursion.
#[unsafe(no_mangle)]
pub fn deliberate_recursion(m: u32, n: u32) -> u32 {
    match (m, n) {
        (0, _) => n.wrapping_add(1),
        (_, 0) => deliberate_recursion(m.wrapping_sub(1), 1),
        _ => deliberate_recursion(m.wrapping_sub(1), deliberate_recursion(m, n.wrapping_sub(1))),
    }
}

#[unsafe(no_mangle)]
pub fn estimator_push(estimator: &mut Estimator, event: &Event, notify: &mut dyn FnMut(Notice)) {
    estimator.push(event, notify);
}

#[unsafe(no_mangle)]
pub fn estimator_without_search_push(
    estimator: &mut Estimator<Full, 28, f64, NoHeadingSearch>,
    event: &Event,
    notify: &mut dyn FnMut(Notice),
) {
    estimator.push(event, notify);
}

#[unsafe(no_mangle)]
pub fn estimator_single_push(
    estimator: &mut Estimator<Full, 28, f32, HeadingSearch<f32>>,
    event: &Event,
    notify: &mut dyn FnMut(Notice),
) {
    estimator.push(event, notify);
}

#[unsafe(no_mangle)]
pub fn estimator_small_push(
    estimator: &mut Estimator<Base, 16, f32, NoHeadingSearch>,
    event: &Event,
    notify: &mut dyn FnMut(Notice),
) {
    estimator.push(event, notify);
}

/// A user's own sensor, whose code is that of the caller.
#[unsafe(no_mangle)]
pub fn estimator_update(
    estimator: &mut Estimator,
    measurement: &dyn hovernav::ekf::Measurement,
    time: Time,
) -> Result<Report, Unusable> {
    estimator.update(measurement, time)
}

/// The update by a user's own sensor in single precision, with the fewest states.
#[unsafe(no_mangle)]
pub fn estimator_small_update(
    estimator: &mut Estimator<Base, 16, f32, NoHeadingSearch>,
    measurement: &dyn hovernav::ekf::Measurement,
    time: Time,
) -> Result<Report, Unusable> {
    estimator.update(measurement, time)
}

/// The code of a small flight computer: estimator, autopilot and one receiver.
#[unsafe(no_mangle)]
pub fn flight_computer(
    estimator: &mut Estimator<WithoutHeightAids, 26, f64, NoHeadingSearch>,
    receiver: &mut ubx::Decoder,
    autopilot: &mut HoverAutopilot,
    bytes: &mut &[u8],
    event: &Event,
    inputs: &Inputs<'_>,
) -> Outputs {
    fly(estimator, receiver, autopilot, bytes, event, inputs)
}

/// The code of a small flight computer in single precision.
#[unsafe(no_mangle)]
pub fn flight_computer_single(
    estimator: &mut Estimator<WithoutHeightAids, 26, f32, NoHeadingSearch>,
    receiver: &mut ubx::Decoder,
    autopilot: &mut HoverAutopilot<f32>,
    bytes: &mut &[u8],
    event: &Event,
    inputs: &Inputs<'_, f32>,
) -> Outputs<f32> {
    fly(estimator, receiver, autopilot, bytes, event, inputs)
}

/// The code of a flight computer with a barometer and a rangefinder, in double precision.
#[unsafe(no_mangle)]
pub fn flight_computer_with_height_aids(
    estimator: &mut Estimator<Full, 28, f64, NoHeadingSearch>,
    receiver: &mut ubx::Decoder,
    autopilot: &mut HoverAutopilot,
    bytes: &mut &[u8],
    event: &Event,
    inputs: &Inputs<'_>,
) -> Outputs {
    fly(estimator, receiver, autopilot, bytes, event, inputs)
}

fn fly<L: Layout<N>, const N: usize, T: Scalar>(
    estimator: &mut Estimator<L, N, T, NoHeadingSearch>,
    receiver: &mut ubx::Decoder,
    autopilot: &mut HoverAutopilot<T>,
    bytes: &mut &[u8],
    event: &Event,
    inputs: &Inputs<'_, T>,
) -> Outputs<T> {
    while let Some(fix) = receiver.read(bytes, inputs.now) {
        if let Some(fix) = fix.at(fix.arrival) {
            estimator.push(&Event::Gps(fix), |_| {});
        }
    }
    autopilot.observe(event);
    estimator.push(event, |notice| autopilot.observe_notice(&notice));
    let solution = estimator.solution();
    autopilot.step(&Inputs { solution: solution.as_ref(), ..*inputs })
}

#[unsafe(no_mangle)]
pub fn autopilot_step(autopilot: &mut HoverAutopilot, inputs: &Inputs<'_>) -> Outputs {
    autopilot.step(inputs)
}

#[unsafe(no_mangle)]
pub fn autopilot_single_step(
    autopilot: &mut HoverAutopilot<f32>,
    inputs: &Inputs<'_, f32>,
) -> Outputs<f32> {
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
pub fn flight_control_single_step(
    control: &mut FlightControl<f32>,
    inputs: &ControlInputs<'_, f32>,
    notify: &mut dyn FnMut(ControlNotice),
) -> ControlOutputs {
    control.step(inputs, notify)
}

#[unsafe(no_mangle)]
pub fn stepless_solution(stepless: &mut SteplessSolution, filtered: &Solution) -> Solution {
    stepless.solution(filtered)
}

#[unsafe(no_mangle)]
pub fn stepless_single_solution(
    stepless: &mut SteplessSolution<f32>,
    filtered: &Solution<f32>,
) -> Solution<f32> {
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
pub fn telemetry_pack_supplement(
    control: &FlightControl,
    outputs: &ControlOutputs,
    solution: &Solution,
    sequence: u8,
) -> [u8; frame::SUPPLEMENT_LENGTH] {
    let supplement = Supplement::at(solution.time).with_solution(solution);
    frame::pack_supplement(&supplement.with_control(control, outputs), sequence)
}

#[unsafe(no_mangle)]
pub fn telemetry_pack_text(line: &str, now: Time, sequence: u8) -> [u8; frame::TEXT_LENGTH] {
    frame::pack_text(&Text::first_of(now, Severity::Warning, line).0, sequence)
}

#[unsafe(no_mangle)]
pub fn telemetry_unpack_message(
    decoder: &mut frame::Decoder,
    byte: u8,
) -> Option<Result<frame::Message, frame::FrameError>> {
    decoder.push_message(byte)
}

#[unsafe(no_mangle)]
pub fn telemetry_flow(flow: &mut Flow, bytes: &[u8]) {
    flow.receive(bytes);
}

#[unsafe(no_mangle)]
pub fn rotor_notch(notch: &mut Notch, sample: &ImuSample, rotor_hz: f64) -> ImuSample {
    notch.set_frequency_hz(rotor_hz);
    notch.filter(sample)
}

#[unsafe(no_mangle)]
pub fn health_assess(
    monitor: &mut HealthMonitor,
    event: &Event,
    notice: &Notice,
    solution: &Solution,
    now: Time,
) -> Health {
    monitor.observe(event);
    monitor.observe_notice(notice);
    monitor.assess(Some(solution), now)
}

#[unsafe(no_mangle)]
pub fn autopilot_set(autopilot: &mut HoverAutopilot, set_point: SetPoint) -> bool {
    autopilot.set(set_point).is_ok()
}

#[unsafe(no_mangle)]
pub fn servo_widths(
    swashplate: &Swashplate,
    channels: &Channels<ChannelConfig>,
    limiter: &mut Limiter,
    sticks: Sticks,
    now: Time,
) -> Channels<Limited> {
    limiter.apply(&swashplate.widths_ms(channels, sticks, 1.5), now)
}

#[unsafe(no_mangle)]
pub fn servo_switch(switch: &mut Switch, aux: &Captured, now: Time) -> bool {
    switch.update(aux, now, 0.1)
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

/// Statics as large as the objects of a flight computer: `.ci/sizes` reads their sizes from the symbol table. They
/// are not linked into any program.
macro_rules! objects {
    ($($name:ident: $type:ty,)*) => {
        $(
            #[unsafe(no_mangle)]
            pub static $name: [u8; size_of::<$type>()] = [0; size_of::<$type>()];
        )*
    };
}

objects! {
    OBJECT_ESTIMATOR_FULL_F64_SEARCH: Estimator<Full, 28, f64, HeadingSearch>,
    OBJECT_ESTIMATOR_FULL_F32_SEARCH: Estimator<Full, 28, f32, HeadingSearch<f32>>,
    OBJECT_ESTIMATOR_FULL_F64: Estimator<Full, 28, f64, NoHeadingSearch>,
    OBJECT_ESTIMATOR_FULL_F32: Estimator<Full, 28, f32, NoHeadingSearch>,
    OBJECT_ESTIMATOR_WITHOUT_HEIGHT_AIDS_F64: Estimator<WithoutHeightAids, 26, f64, NoHeadingSearch>,
    OBJECT_ESTIMATOR_WITHOUT_HEIGHT_AIDS_F32: Estimator<WithoutHeightAids, 26, f32, NoHeadingSearch>,
    OBJECT_ESTIMATOR_BASE_F64: Estimator<Base, 16, f64, NoHeadingSearch>,
    OBJECT_ESTIMATOR_BASE_F32: Estimator<Base, 16, f32, NoHeadingSearch>,
    OBJECT_HOVER_AUTOPILOT: HoverAutopilot,
    OBJECT_HOVER_AUTOPILOT_F32: HoverAutopilot<f32>,
    OBJECT_FLIGHT_CONTROL: FlightControl,
    OBJECT_FLIGHT_CONTROL_F32: FlightControl<f32>,
    OBJECT_SENSORS: Sensors,
    OBJECT_DMU_LINK: Link,
    OBJECT_TSIP_DECODER: tsip::Decoder,
    OBJECT_NMEA_DECODER: nmea::Decoder,
    OBJECT_UBX_DECODER: ubx::Decoder,
    OBJECT_TELEMETRY_DECODER: frame::Decoder,
    OBJECT_SOLUTION: Solution,
    OBJECT_SNAPSHOT: Snapshot,
}
