//! Entries from the loop to the recorder: plain values, copied, without heap allocation.

use core::fmt::{self, Write as _};

use hovernav::autopilot::Mode;
use hovernav::controls::Sticks;
use hovernav::ekf::{Notice, Solution};
use hovernav::frames::{Ned, Vector};
use hovernav::sensors::SensorOutput;
use hovernav::time::Time;

/// A line whose raw bytes are recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Line {
    /// Line of the inertial unit.
    Dmu,
    /// Line of the GPS receiver.
    Gps,
    /// Line of the servo pulses.
    Servo,
}

/// Bytes passed to the sensors in one call, or a part of these bytes: see [`Recorder::raw`](crate::Recorder::raw).
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct RawBytes {
    pub(super) line: Line,
    /// Whether the next entry of the line continues the same call.
    pub(super) goes_on: bool,
    length: u16,
    bytes: [u8; Self::CAPACITY],
}

impl RawBytes {
    /// Largest number of bytes in one entry; a longer call needs several entries.
    pub const CAPACITY: usize = 256;

    /// Entry with the first bytes of a call, and the bytes left for the next entries.
    pub(super) fn first_of(line: Line, call: &[u8]) -> (Self, &[u8]) {
        let (now, rest) = call.split_at(call.len().min(Self::CAPACITY));
        let mut bytes = [0; Self::CAPACITY];
        bytes[..now.len()].copy_from_slice(now);
        (Self { line, goes_on: !rest.is_empty(), length: now.len() as u16, bytes }, rest)
    }

    pub(super) fn as_bytes(&self) -> &[u8] {
        &self.bytes[..usize::from(self.length)]
    }
}

impl fmt::Debug for RawBytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?} {:02x?}", self.line, self.as_bytes())
    }
}

/// Severity of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Normal operation.
    Info,
    /// The flight continues, with reduced quality.
    Warning,
    /// A function is lost.
    Error,
    /// Immediate action is necessary.
    Critical,
}

impl Level {
    /// Name for programs.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Info => "info",
            Self::Warning => "warning",
            Self::Error => "error",
            Self::Critical => "critical",
        }
    }
}

/// Sensor or part of the vehicle that caused an event or is at fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The inertial unit, its line included.
    InertialUnit,
    /// The GPS receiver, its line included.
    Receiver,
    /// The pilot's transmitter, receiver and line.
    Pilot,
    /// The servos and the line to them.
    Servos,
    /// The estimator.
    Estimator,
    /// The autopilot.
    Autopilot,
    /// The loop's computer.
    Computer,
    /// The record and its disk.
    Record,
}

impl Part {
    /// Name in messages.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::InertialUnit => "inertial unit",
            Self::Receiver => "GPS receiver",
            Self::Pilot => "pilot's signal",
            Self::Servos => "servos",
            Self::Estimator => "estimator",
            Self::Autopilot => "autopilot",
            Self::Computer => "computer",
            Self::Record => "record",
        }
    }

    /// Sensor or function at fault for events of this `kind`; [`Estimator`](Self::Estimator) for all other kinds.
    #[must_use]
    pub fn of_kind(kind: &str) -> Self {
        match kind {
            "dmu_lost" | "dmu_implausible" | "dmu_clock" | "dmu_port" | "dmu_command"
            | "imu_fault" | "imu_setup" | "imu_suspect" | "samples lost" | "vibration"
            | "set-up" => Self::InertialUnit,
            "gps_port" | "gps_command" | "gps_fixes" | "fix_refused" | "fix_without_height"
            | "fix_unusable" | "gps_setup" | "antenna_elsewhere" | "contradicts_itself"
            | "place_walks" | "utc" => Self::Receiver,
            "pilot_signal" | "servo_port" => Self::Pilot,
            "servos" => Self::Servos,
            "deadline_missed" | "priority" | "ground_port" | "clock rate" => Self::Computer,
            "record" | "entries_lost" => Self::Record,
            "autopilot" | "not_ready" | "untried_gains" => Self::Autopilot,
            _ => Self::Estimator,
        }
    }
}

/// A line of text of at most 160 bytes; longer text is cut.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct ShortText {
    length: u8,
    bytes: [u8; Self::CAPACITY],
}

impl ShortText {
    const CAPACITY: usize = 160;

    /// The text of `text`'s `Display`, cut to fit.
    #[must_use]
    pub fn new(text: impl fmt::Display) -> Self {
        let mut short = Self { length: 0, bytes: [0; Self::CAPACITY] };
        // An error from the formatter means that the text was cut.
        let _ = write!(short, "{text}");
        short
    }

    /// The text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        str::from_utf8(&self.bytes[..usize::from(self.length)]).unwrap_or_default()
    }
}

impl fmt::Write for ShortText {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let length = usize::from(self.length);
        let room = text.len().min(Self::CAPACITY - length);
        let fits = (0..=room).rev().find(|&end| text.is_char_boundary(end)).unwrap_or(0);
        self.bytes[length..length + fits].copy_from_slice(&text.as_bytes()[..fits]);
        self.length = (length + fits) as u8;
        if fits < text.len() { Err(fmt::Error) } else { Ok(()) }
    }
}

impl fmt::Display for ShortText {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

impl fmt::Debug for ShortText {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self.as_str(), f)
    }
}

/// Inputs and results of flight control in a cycle, other than pulses and estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cycle {
    /// Whether an inertial sample began the cycle, instead of the clock.
    pub has_sample: bool,
    /// Whether the servos accepted the previous command.
    pub servos_good: bool,
    /// Number of successive late cycles.
    pub late_cycles: u8,
    /// Computing time of the previous cycle, s.
    pub work_s: Option<f64>,
    /// Time in the previous cycle from reading the inertial packet to the command at the servos, s.
    pub turnaround_s: Option<f64>,
    /// Mode of the autopilot.
    pub mode: Mode,
    /// Whether the pilot's switch is closed.
    pub switch_on: bool,
    /// Failed checks that prevent engagement: see
    /// [`Readiness::failed_bits`](hovernav::autopilot::Readiness::failed_bits).
    pub failed_checks: u16,
    /// The pilot's sticks.
    pub pilot: Option<Sticks>,
    /// Sticks of the pilot or the autopilot, whichever flies.
    pub sticks: Option<Sticks>,
    /// Test input that is contained in `sticks`.
    pub injected: Sticks,
    /// Commanded velocity of the loops, m/s.
    pub asked_velocity_mps: Vector<Ned>,
    /// Commanded heading of the loops, rad.
    pub asked_heading_rad: f64,
}

/// An item to record. Each entry contains its own time of validity; the time at which the loop received it is recorded
/// as well.
#[derive(Clone, Copy, Debug, PartialEq)]
// All entries are in one preallocated ring; a box would allocate in the loop.
#[allow(clippy::large_enum_variant)]
pub enum Entry {
    /// Bytes of a line: use [`Recorder::raw`](crate::Recorder::raw).
    Raw(RawBytes),
    /// [`Sensors::restart_gps`](hovernav::sensors::Sensors::restart_gps) was called.
    GpsRestarted,
    /// Output of a sensor's driver. Commands, and events for the estimator, are not recorded: they follow from the raw
    /// bytes.
    Sensor(SensorOutput),
    /// Notice of the estimator.
    Notice(Notice),
    /// The solution after an inertial sample.
    Solution(Solution),
    /// Servo pulses: lateral, longitudinal, collective, pedal, and the fifth channel.
    Servo {
        /// Received widths, ms.
        captured_ms: [f32; 5],
        /// Commanded widths, ms.
        commanded_ms: [f32; 5],
    },
    /// Lateral, longitudinal, collective, pedal, each −1…1 about trim.
    Controls([f64; 4]),
    /// Inputs and results of flight control in a cycle.
    Cycle(Cycle),
    /// Any other event: a lost port, an overrun, a change of mode.
    Event {
        /// Severity.
        level: Level,
        /// Kind, for programs: lower case, words joined by `_`.
        kind: &'static str,
        /// Sensor or part of the vehicle.
        part: Part,
        /// Text for people.
        text: ShortText,
    },
    /// Numbers of entries dropped from the full queue since the previous `Lost` entry. The recorder adds this entry
    /// itself.
    Lost {
        /// Number of dropped raw-byte entries and restarts, which a replay needs.
        raw: u32,
        /// Number of all other dropped entries.
        decoded: u32,
    },
}

impl Entry {
    /// An event with the text of `text`; `kind` determines the sensor or function.
    #[must_use]
    pub fn event(level: Level, kind: &'static str, text: impl fmt::Display) -> Self {
        Self::Event { level, kind, part: Part::of_kind(kind), text: ShortText::new(text) }
    }

    /// Whether a replay needs the entry.
    pub(super) const fn is_raw(&self) -> bool {
        matches!(self, Self::Raw(_) | Self::GpsRestarted)
    }

    /// Whether any part of the entry goes into the record.
    pub(super) const fn is_recorded(&self) -> bool {
        match self {
            Self::Sensor(
                SensorOutput::WriteDmu(_)
                | SensorOutput::WriteGps(_)
                | SensorOutput::Event(_)
                | SensorOutput::Measured(None, _),
            ) => false,
            // Measurements that are skipped because they arrive too often are not an event.
            Self::Notice(Notice::NotUsed { reason, .. }) => reason.is_fault(),
            _ => true,
        }
    }
}

impl From<SensorOutput> for Entry {
    fn from(report: SensorOutput) -> Self {
        Self::Sensor(report)
    }
}

impl From<Notice> for Entry {
    fn from(notice: Notice) -> Self {
        Self::Notice(notice)
    }
}

impl From<Solution> for Entry {
    fn from(solution: Solution) -> Self {
        Self::Solution(solution)
    }
}

/// An entry on its way to the writer.
#[derive(Clone, Copy, Debug)]
pub(super) struct Queued {
    /// Number of the entry, lost ones included: a missing number is a loss.
    pub sequence: u32,
    /// Time at which the loop received it.
    pub now: Time,
    pub entry: Entry,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_text_is_cut_between_characters() {
        let text = ShortText::new(format_args!("{}{}", "x".repeat(159), "äöü"));
        assert_eq!(text.as_str(), "x".repeat(159));
        assert_eq!(ShortText::new("port lost").as_str(), "port lost");
    }

    #[test]
    fn bytes_of_a_long_call_come_back_whole() {
        let call: Vec<u8> = (0..700).map(|index| index as u8).collect();
        let (mut rest, mut joined, mut goes_on) = (&call[..], Vec::new(), true);
        while goes_on {
            let (part, left) = RawBytes::first_of(Line::Gps, rest);
            joined.extend_from_slice(part.as_bytes());
            (rest, goes_on) = (left, part.goes_on);
        }
        assert_eq!(joined, call);
        let (empty, _) = RawBytes::first_of(Line::Dmu, &[]);
        assert!(empty.as_bytes().is_empty() && !empty.goes_on);
    }
}
