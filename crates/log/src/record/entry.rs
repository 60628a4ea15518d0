//! What the loop hands to the recorder: plain values, copied, without a heap.

use core::fmt::{self, Write as _};

use hovernav::autopilot::Mode;
use hovernav::controls::Sticks;
use hovernav::ekf::{Notice, Solution};
use hovernav::frames::{Ned, Vector};
use hovernav::sensors::SensorOutput;
use hovernav::time::Time;

/// A line whose bytes are recorded as they came.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Line {
    /// The inertial unit's.
    Dmu,
    /// The GPS receiver's.
    Gps,
    /// The servo pulses'.
    Servo,
}

/// The bytes of one call of the sensors, or a part of them: see
/// [`Recorder::raw`](super::Recorder::raw).
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct RawBytes {
    pub(super) line: Line,
    /// Whether the next entry of the line goes on with the same call.
    pub(super) goes_on: bool,
    length: u16,
    bytes: [u8; Self::CAPACITY],
}

impl RawBytes {
    /// Bytes in one entry; a call with more takes several.
    pub const CAPACITY: usize = 256;

    /// The first bytes of a call, as many as fit, and how many are left for the next entry.
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

/// How much an event matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// As it should be.
    Info,
    /// It flies on, less well.
    Warning,
    /// Something is lost.
    Error,
    /// Somebody has to act at once.
    Critical,
}

impl Level {
    /// Its name for programs.
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

/// Whose an event is: the sensor or the part of the vehicle that did it or is at fault.
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
    /// What it is called.
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

    /// Whose events of this kind are, where the kind alone tells.
    #[must_use]
    pub fn of_kind(kind: &str) -> Self {
        match kind {
            "dmu_lost" | "dmu_implausible" | "dmu_clock" | "dmu_port" | "dmu_command"
            | "imu_fault" | "imu_suspect" => Self::InertialUnit,
            "gps_port" | "gps_command" | "gps_fixes" | "fix_refused" | "fix_without_height"
            | "fix_unusable" | "antenna_elsewhere" | "contradicts_itself" | "place_walks"
            | "utc" => Self::Receiver,
            "pilot_signal" | "servo_port" => Self::Pilot,
            "servos" => Self::Servos,
            "deadline_missed" | "priority" | "ground_port" => Self::Computer,
            "record" | "entries_lost" => Self::Record,
            "autopilot" | "not_ready" | "untried_gains" => Self::Autopilot,
            _ => Self::Estimator,
        }
    }
}

/// A line of text of at most 160 bytes; what is longer is cut.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct ShortText {
    length: u8,
    bytes: [u8; Self::CAPACITY],
}

impl ShortText {
    const CAPACITY: usize = 160;

    /// What `text` displays, as much of it as fits.
    #[must_use]
    pub fn new(text: impl fmt::Display) -> Self {
        let mut short = Self { length: 0, bytes: [0; Self::CAPACITY] };
        // The text is cut by refusing the rest of it.
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

/// What flight control went by in a cycle beside the pulses and the estimate, and what it came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cycle {
    /// Whether an inertial sample began it, and not the clock.
    pub has_sample: bool,
    /// Whether the servos took what they were sent before.
    pub servos_good: bool,
    /// Cycles that were late, one after the other.
    pub late_cycles: u8,
    /// What the work of the cycle before took, s.
    pub work_s: Option<f64>,
    /// How long the cycle before took from reading its inertial packet to the servos having their command,
    /// s.
    pub turnaround_s: Option<f64>,
    /// What the autopilot is doing.
    pub mode: Mode,
    /// Whether the pilot's switch is closed.
    pub switch_on: bool,
    /// The checks that keep it from taking over: see
    /// [`Readiness::failed_bits`](hovernav::autopilot::Readiness::failed_bits).
    pub failed_checks: u16,
    /// The pilot's sticks.
    pub pilot: Option<Sticks>,
    /// The sticks of whoever flies.
    pub sticks: Option<Sticks>,
    /// What of them is a test input.
    pub injected: Sticks,
    /// Velocity that the loops were asked for, m/s.
    pub asked_velocity_mps: Vector<Ned>,
    /// Heading that the loops were asked for, rad.
    pub asked_heading_rad: f64,
}

/// Something to record. It holds the time at which it was true; the time at which the loop came to it
/// is recorded beside it.
#[derive(Clone, Copy, Debug, PartialEq)]
// All live in one ring that is made once; a box would be an allocation in the loop.
#[allow(clippy::large_enum_variant)]
pub enum Entry {
    /// Bytes of a line: use [`Recorder::raw`](super::Recorder::raw).
    Raw(RawBytes),
    /// [`Sensors::restart_gps`](hovernav::sensors::Sensors::restart_gps) was called.
    GpsRestarted,
    /// What a line's bytes came to. Commands and events for the estimator are not recorded: the raw
    /// bytes give them again.
    Sensor(SensorOutput),
    /// What the estimator reports.
    Notice(Notice),
    /// The solution after an inertial sample.
    Solution(Solution),
    /// Servo pulses: lateral, longitudinal, collective, pedal, and the fifth channel.
    Servo {
        /// Widths as the receiver sent them, ms.
        captured_ms: [f32; 5],
        /// Widths as they went out, ms.
        commanded_ms: [f32; 5],
    },
    /// Lateral, longitudinal, collective, pedal, each −1…1 about trim.
    Controls([f64; 4]),
    /// What flight control went by and came to in a cycle.
    Cycle(Cycle),
    /// Anything else that happened: a port lost, an overrun, a change of mode.
    Event {
        /// How much it matters.
        level: Level,
        /// What kind it is, for programs: lower case, words joined by `_`.
        kind: &'static str,
        /// Whose it is.
        part: Part,
        /// What happened, for people.
        text: ShortText,
    },
    /// Entries that found no room since the last such entry; the recorder puts it in itself.
    Lost {
        /// Of the raw bytes and restarts, which a replay needs.
        raw: u32,
        /// Of all others.
        decoded: u32,
    },
}

impl Entry {
    /// An event that displays as `text`, of the part that the kind tells.
    #[must_use]
    pub fn event(level: Level, kind: &'static str, text: impl fmt::Display) -> Self {
        Self::Event { level, kind, part: Part::of_kind(kind), text: ShortText::new(text) }
    }

    /// Whether a replay needs it.
    pub(super) const fn is_raw(&self) -> bool {
        matches!(self, Self::Raw(_) | Self::GpsRestarted)
    }

    /// Whether anything of it goes into the record.
    pub(super) const fn is_recorded(&self) -> bool {
        match self {
            Self::Sensor(
                SensorOutput::WriteDmu(_)
                | SensorOutput::WriteGps(_)
                | SensorOutput::Event(_)
                | SensorOutput::Measured(None, _),
            ) => false,
            // An aid that comes more often than it can be of use is no news.
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
    /// Counts every entry the loop handed over, lost ones too: a gap is a loss.
    pub sequence: u32,
    /// When the loop came to it.
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
