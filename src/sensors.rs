//! Events for the estimator from the bytes of two serial lines.
//!
//! [`Sensors`] runs the protocols of the inertial unit and the receiver in a flight. It performs no input or output
//! itself. It takes the bytes received on a serial line, with their arrival time. It returns the measurements in the
//! bytes, and the bytes to write. The same bytes at the same times give the same events, bit for bit, so a record of
//! the bytes replays the flight.

use crate::dmu::{
    Calibration, ClockFault, Command, Flow, Link, LinkAction, LinkFault, Measurement, Mode,
    Plausibility, PlausibilityFault, Received, SampleClock,
};
use crate::event::Event;
use crate::gps::quality::{Failures, Limits, QualityCheck};
#[cfg(feature = "tsip")]
use crate::gps::tsip;
#[cfg(feature = "ubx")]
use crate::gps::ubx;
use crate::gps::{AntennaHeading, MessageCounts, Protocol, Receiver, ReceiverFix, ReceiverHeading};
use crate::time::Time;

/// Settings of the inertial unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DmuConfig {
    /// Packet type that the inertial unit sends; voltage mode gives no samples.
    pub mode: Mode,
    /// Source of the packet rate: polled or continuous.
    pub flow: Flow,
    /// Ranges and signs of the inertial unit.
    pub calibration: Calibration,
    /// Latency from the moment of a sample to the arrival of its packet's last byte, s: see [`SampleClock::new`].
    pub latency_s: f64,
}

/// Settings of the GPS receiver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GpsConfig {
    /// Protocol of the receiver.
    pub protocol: Protocol,
    /// Fix rate of a u-blox receiver, Hz, 1 to 10. A Trimble receiver is set to the required reports, at its own rate.
    /// `None` leaves the receiver unchanged.
    pub rate_hz: Option<u8>,
    /// Latency from the validity of a fix to its arrival, s.
    pub latency_s: f64,
    /// The geoid's height above the ellipsoid at the site, m, for a receiver that does not send it.
    pub geoid_separation_m: Option<f64>,
    /// Limits that a fix must meet.
    pub limits: Limits,
}

/// A result of received bytes: a command to write, a measurement, a fault or an event.
#[derive(Clone, Copy, Debug, PartialEq)]
// Only one value is on the stack at a time, and there is no heap for the large variant.
#[allow(clippy::large_enum_variant)]
pub enum SensorOutput {
    /// Write the command's byte to the inertial unit.
    WriteDmu(Command),
    /// Write these bytes to the receiver.
    WriteGps(GpsCommand),
    /// A packet in physical units, with the time of its sample; `None` if the sample has no usable time.
    Measured(Option<Time>, Measurement),
    /// The link to the inertial unit failed and restarts.
    DmuLost(Time, LinkFault),
    /// A packet has impossible or suspect values. An invalid packet gives no sample. A stuck sensor is reported each
    /// time the number of equal packets is a power of two.
    DmuImplausible(Time, PlausibilityFault),
    /// The sample of a packet has no usable time and is dropped.
    DmuClockFault(Time, ClockFault),
    /// A fix of the receiver, and the failed checks, which are empty for a good fix. A fix with failed checks does not
    /// go to the estimator.
    Fix(ReceiverFix, Failures),
    /// A good fix without a height above the ellipsoid. It is not used; configure the geoid separation to use such
    /// fixes.
    FixWithoutHeight(Time),
    /// An event for the estimator.
    Event(Event),
}

/// A command to the receiver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GpsCommand {
    /// Command to a Trimble receiver.
    #[cfg(feature = "tsip")]
    Tsip(tsip::Frame),
    /// Command to a u-blox receiver.
    #[cfg(feature = "ubx")]
    Ubx(ubx::Message),
}

impl GpsCommand {
    /// The bytes to write.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        match *self {
            #[cfg(feature = "tsip")]
            Self::Tsip(ref frame) => frame.as_bytes(),
            #[cfg(feature = "ubx")]
            Self::Ubx(ref message) => message.as_bytes(),
        }
    }
}

/// The protocols of both sensors of a flight: inertial unit and receiver.
///
/// ```
/// use hovernav::dmu::{AnglePacket, Calibration, Flow, Mode};
/// use hovernav::event::Event;
/// use hovernav::gps::Protocol;
/// use hovernav::gps::quality::Limits;
/// use hovernav::sensors::{DmuConfig, GpsConfig, SensorOutput, Sensors};
/// use hovernav::time::Time;
///
/// let dmu = DmuConfig {
///     mode: Mode::Angle,
///     flow: Flow::Polled { cycle_s: 0.0303 },
///     calibration: Calibration::new(200.0, 4.0)?,
///     latency_s: Mode::Angle.transfer_time_s(),
/// };
/// let gps = GpsConfig {
///     protocol: Protocol::Nmea,
///     rate_hz: None,
///     latency_s: 0.12,
///     geoid_separation_m: None,
///     limits: Limits::default(),
/// };
/// let mut now = Time::ZERO;
/// let mut sensors = Sensors::new(dmu, gps, now);
/// let (mut reply, mut samples, mut timer) = (Vec::new(), 0, 0u16);
/// while samples < 3 {
///     // A simulated unit that always answers at once replaces the serial port.
///     let read = std::mem::take(&mut reply);
///     let next = sensors.dmu(&read, now, |output| match output {
///         SensorOutput::WriteDmu(command) if command.byte() == b'G' => {
///             timer = timer.wrapping_sub(38_000);
///             reply.extend(AnglePacket { timer, ..Default::default() }.encode());
///         }
///         SensorOutput::WriteDmu(command) => reply.extend(command.reply()),
///         SensorOutput::Event(Event::Imu(_)) => samples += 1,
///         _ => {}
///     });
///     now = if reply.is_empty() { next } else { now + 0.008 };
/// }
/// # Ok::<(), hovernav::dmu::RangeError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Sensors {
    link: Link,
    plausibility: Plausibility,
    calibration: Calibration,
    clock: SampleClock,
    receiver: Receiver,
    receiver_set_up: ReceiverSetUp,
    quality: QualityCheck,
    gps: GpsConfig,
}

/// The commands that configure the receiver for the required messages.
#[derive(Clone, Copy, Debug)]
enum ReceiverSetUp {
    None,
    #[cfg(feature = "tsip")]
    Tsip(tsip::Startup),
    #[cfg(feature = "ubx")]
    Ubx(ubx::Configuration),
}

/// Largest number of link actions at one moment. The link has at most four. At the largest [`Time`] there is no later
/// time to wait for, so this limit ends the loop.
const MAX_ACTIONS: usize = 8;

impl Sensors {
    /// Creates the protocols for sensors in any state; the set-up of the sensors begins `now`.
    #[must_use]
    pub fn new(dmu: DmuConfig, gps: GpsConfig, now: Time) -> Self {
        Self {
            link: Link::new(dmu.mode, dmu.flow, now),
            plausibility: Plausibility::default(),
            calibration: dmu.calibration,
            clock: SampleClock::new(dmu.latency_s),
            receiver: Receiver::new(gps.protocol),
            receiver_set_up: ReceiverSetUp::with(&gps),
            quality: QualityCheck::new(gps.limits),
            gps,
        }
    }

    /// Processes `bytes` read from the inertial unit's line; the last byte arrived `now`. Returns the time until which
    /// the caller waits for bytes. If no byte arrives until this time, call again without bytes.
    pub fn dmu(&mut self, mut bytes: &[u8], now: Time, mut emit: impl FnMut(SensorOutput)) -> Time {
        // Iterations: at most one for each stored or new byte, because each iteration takes a packet.
        while let Some(received) = self.link.next_packet(&mut bytes, now) {
            self.packet(&received, now, &mut emit);
        }
        for _ in 0..MAX_ACTIONS {
            match self.link.next_action(now) {
                LinkAction::Write(command) => emit(SensorOutput::WriteDmu(command)),
                LinkAction::Lost(fault) => emit(SensorOutput::DmuLost(now, fault)),
                LinkAction::ReadUntil(until) => return until,
            }
        }
        now
    }

    fn packet(&mut self, received: &Received, now: Time, emit: &mut impl FnMut(SensorOutput)) {
        let packet = &received.packet;
        let mut valid = true;
        for reason in self.plausibility.check(packet) {
            valid &= !reason.invalidates_packet();
            let is_repeated = matches!(reason, PlausibilityFault::Stuck { packets, .. } if !packets.is_power_of_two());
            if !is_repeated {
                emit(SensorOutput::DmuImplausible(now, reason));
            }
        }
        let Some(measurement) = self.calibration.measure(packet).filter(|_| valid) else {
            return;
        };
        match self.clock.stamp(packet.timer(), received.sequence, now) {
            Ok(stamp) => {
                emit(SensorOutput::Measured(Some(stamp.time), measurement));
                emit(SensorOutput::Event(Event::Imu(measurement.at(stamp.time))));
            }
            Err(fault) => {
                emit(SensorOutput::Measured(None, measurement));
                emit(SensorOutput::DmuClockFault(now, fault));
            }
        }
    }

    /// Processes `bytes` read from the receiver's line, which arrived at `arrival`. Pass no bytes once the line is
    /// silent after an epoch: this ends the epoch.
    pub fn gps(&mut self, mut bytes: &[u8], arrival: Time, mut emit: impl FnMut(SensorOutput)) {
        if bytes.is_empty()
            && let Some(fix) = self.receiver.flush()
        {
            self.fix(fix, &mut emit);
        }
        // Iterations: at most one for each stored or new byte, and one for a fix that was ready.
        while let Some(fix) = self.receiver.read(&mut bytes, arrival) {
            self.fix(fix, &mut emit);
        }
        if let Some(ReceiverHeading { heading, .. }) = self.receiver.take_antenna_heading() {
            let time = heading.time.offset_by(-self.gps.latency_s);
            emit(SensorOutput::Event(Event::AntennaHeading(AntennaHeading { time, ..heading })));
        }
        if let Some(command) = self.receiver_set_up.poll(&mut self.receiver, arrival) {
            emit(SensorOutput::WriteGps(command));
        }
    }

    fn fix(&mut self, fix: ReceiverFix, emit: &mut impl FnMut(SensorOutput)) {
        let fix = match self.gps.geoid_separation_m {
            Some(separation_m) => fix.with_geoid_separation(separation_m),
            None => fix,
        };
        let failures = self.quality.check(&fix);
        emit(SensorOutput::Fix(fix, failures));
        if failures.is_empty() {
            let valid = fix.arrival.offset_by(-self.gps.latency_s);
            emit(fix.at(valid).map_or(SensorOutput::FixWithoutHeight(fix.arrival), |fix| {
                SensorOutput::Event(Event::Gps(fix))
            }));
        }
    }

    /// Sets the receiver up again after its line was lost and restored: the receiver may have lost power.
    pub fn restart_gps(&mut self) {
        self.receiver_set_up = ReceiverSetUp::with(&self.gps);
    }

    /// The link to the inertial unit.
    #[must_use]
    pub const fn link(&self) -> &Link {
        &self.link
    }

    /// Counts of the receiver's messages since the start.
    #[must_use]
    pub fn gps_counts(&self) -> MessageCounts {
        self.receiver.counts()
    }
}

impl ReceiverSetUp {
    fn with(gps: &GpsConfig) -> Self {
        match (gps.protocol, gps.rate_hz) {
            #[cfg(feature = "tsip")]
            (Protocol::Tsip, Some(_)) => Self::Tsip(tsip::Startup::default()),
            #[cfg(feature = "ubx")]
            (Protocol::Ubx, Some(rate_hz)) => {
                ubx::Configuration::new(rate_hz).map_or(Self::None, Self::Ubx)
            }
            _ => Self::None,
        }
    }

    #[cfg_attr(
        not(any(feature = "tsip", feature = "ubx")),
        expect(unused_variables, reason = "a receiver of NMEA is not set up")
    )]
    fn poll(&mut self, receiver: &mut Receiver, now: Time) -> Option<GpsCommand> {
        match (self, receiver) {
            #[cfg(feature = "tsip")]
            (Self::Tsip(startup), Receiver::Tsip(decoder)) => {
                startup.poll(decoder, now).map(GpsCommand::Tsip)
            }
            #[cfg(feature = "ubx")]
            (Self::Ubx(configuration), Receiver::Ubx(decoder)) => {
                configuration.poll(decoder, now).map(GpsCommand::Ubx)
            }
            _ => None,
        }
    }
}
