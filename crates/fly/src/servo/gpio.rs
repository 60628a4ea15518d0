//! Pulses on GPIO lines, timed by the kernel's interrupt handler.

use std::path::{Path, PathBuf};

use gpiocdev::Request;
use gpiocdev::line::{EdgeDetection, EdgeEvent, EdgeKind, EventClock};

use hovernav::controls::{Channel, Channels};
use hovernav::servo::{EdgeTimer, Paired, PilotPulses, PulseCapture};
use hovernav::time::Time;

/// Largest number of edges per call: six channels make 18 to 24 in a cycle of 30 ms.
const MAX_EDGES: usize = 128;
/// Size of the kernel's edge buffer.
const KERNEL_EDGES: u32 = 512;
/// Increase of the clock offset, ns, that indicates a step of the flight clock.
const CLOCK_STEP_NS: i64 = 1_000_000_000;

/// Reasons why pulses cannot be captured.
#[derive(Debug, thiserror::Error)]
pub enum GpioError {
    /// The lines cannot be opened.
    #[error("{}: cannot monitor lines {lines:?}: {source}", chip.display())]
    Open {
        /// The chip.
        chip: PathBuf,
        /// Numbers of the lines on the chip.
        lines: Vec<u32>,
        /// Error of the operating system.
        source: gpiocdev::Error,
    },
    /// Two channels use the same line.
    #[error("{first} and {second} are both on line {line}")]
    SameLine {
        /// The first channel.
        first: Channel,
        /// The second channel.
        second: Channel,
        /// The line's number.
        line: u32,
    },
    /// A channel and aux use the same line.
    #[error("{channel} and aux are both on line {line}")]
    AuxLine {
        /// The channel.
        channel: Channel,
        /// The line's number.
        line: u32,
    },
    /// The edges cannot be read.
    #[error("{}: cannot read edges: {source}", chip.display())]
    Read {
        /// The chip.
        chip: PathBuf,
        /// Error of the operating system.
        source: gpiocdev::Error,
    },
}

/// The pilot's pulses on five lines of one GPIO chip, and aux on an optional sixth.
///
/// A width is the difference of two interrupt times of the kernel, so it does not depend on the timing of the loop.
/// Times of the kernel's clock, CLOCK_MONOTONIC, are converted to the flight clock with the smallest delay observed
/// between an edge and its reading. Both clocks must run at the same rate, as with [`Time`] from
/// `std::time::Instant`.
#[derive(Debug)]
pub struct GpioCapture {
    chip: PathBuf,
    request: Request,
    raw: Vec<u64>,
    edges: Edges,
}

impl GpioCapture {
    /// Monitors `lines` and the line `aux` of the chip at `chip`, such as `/dev/gpiochip0`.
    ///
    /// # Errors
    /// [`GpioError::SameLine`], [`GpioError::AuxLine`]; [`GpioError::Open`] where the chip or a line cannot be
    /// opened.
    pub fn open(chip: &Path, lines: &Channels<u32>, aux: Option<u32>) -> Result<Self, GpioError> {
        check(lines, aux)?;
        let numbers: Vec<u32> = lines.to_array().into_iter().chain(aux).collect();
        let request = Request::builder()
            .on_chip(chip)
            .with_consumer("hovernav")
            .with_lines(&numbers)
            .as_input()
            .with_edge_detection(EdgeDetection::BothEdges)
            .with_event_clock(EventClock::Monotonic)
            .with_kernel_event_buffer_size(KERNEL_EDGES)
            .request()
            .map_err(|source| GpioError::Open {
                chip: chip.to_path_buf(),
                lines: numbers.clone(),
                source,
            })?;
        let raw = vec![0; MAX_EDGES * request.edge_event_u64_size()];
        Ok(Self { chip: chip.to_path_buf(), request, raw, edges: Edges::new(*lines, aux) })
    }

    /// Reads up to [`MAX_EDGES`] pending edges.
    fn read(&mut self, now: Time) -> Result<(), gpiocdev::Error> {
        if !self.request.has_edge_event()? {
            return Ok(());
        }
        let words = self.request.read_edge_events_into_slice(&mut self.raw)?;
        let read = self.raw.get(..words).unwrap_or_default();
        for raw in read.chunks_exact(self.request.edge_event_u64_size()) {
            self.edges.take(&self.request.edge_event_from_slice(raw)?, now);
        }
        Ok(())
    }
}

impl PulseCapture for GpioCapture {
    type Error = GpioError;

    fn poll(&mut self, now: Time) -> Result<&PilotPulses, GpioError> {
        match self.read(now) {
            Ok(()) => Ok(&self.edges.pulses),
            Err(source) => Err(GpioError::Read { chip: self.chip.clone(), source }),
        }
    }
}

fn check(lines: &Channels<u32>, aux: Option<u32>) -> Result<(), GpioError> {
    if let Some((channel, line)) = lines.iter().find(|(_, line)| Some(**line) == aux) {
        return Err(GpioError::AuxLine { channel, line: *line });
    }
    for (first, line) in lines.iter() {
        let other = lines.iter().find(|(second, other)| *second != first && *other == line);
        if let Some((second, _)) = other {
            return Err(GpioError::SameLine { first, second, line: *line });
        }
    }
    Ok(())
}

/// Converts the kernel's edges to pulses on the flight clock.
#[derive(Debug)]
struct Edges {
    lines: Channels<u32>,
    aux: Option<u32>,
    timers: Channels<EdgeTimer>,
    aux_timer: EdgeTimer,
    pulses: PilotPulses,
    /// Flight clock minus kernel clock, ns.
    offset_ns: Option<i64>,
}

impl Edges {
    fn new(lines: Channels<u32>, aux: Option<u32>) -> Self {
        let (timers, aux_timer, pulses) = Default::default();
        Self { lines, aux, timers, aux_timer, pulses, offset_ns: None }
    }

    fn take(&mut self, edge: &EdgeEvent, now: Time) {
        let at = self.on_our_clock(edge.timestamp_ns, now);
        let rising = edge.kind == EdgeKind::Rising;
        let found = self.lines.iter().find(|(_, line)| **line == edge.offset);
        let (captured, timer) = match found {
            Some((channel, _)) => (&mut self.pulses.channels[channel], &mut self.timers[channel]),
            None if self.aux == Some(edge.offset) => (&mut self.pulses.aux, &mut self.aux_timer),
            None => return,
        };
        match timer.edge(rising, edge.line_seqno, edge.timestamp_ns) {
            Paired::Waiting => {}
            // A rejected width is already counted.
            Paired::Width(width_ms) => drop(captured.push(width_ms, at)),
            Paired::Broken => captured.count_error(),
        }
    }

    fn on_our_clock(&mut self, kernel_ns: u64, now: Time) -> Time {
        let kernel_ns = i64::try_from(kernel_ns).unwrap_or(i64::MAX);
        let seen_ns = now.nanoseconds().saturating_sub(kernel_ns);
        let offset_ns = match self.offset_ns {
            Some(min_ns) if seen_ns < min_ns.saturating_add(CLOCK_STEP_NS) => min_ns.min(seen_ns),
            _ => seen_ns,
        };
        self.offset_ns = Some(offset_ns);
        Time::from_nanoseconds(kernel_ns.saturating_add(offset_ns))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines() -> Channels<u32> {
        Channels::from([5, 6, 13, 19, 26])
    }

    fn edge(offset: u32, rising: bool, line_seqno: u32, timestamp_ns: u64) -> EdgeEvent {
        let kind = if rising { EdgeKind::Rising } else { EdgeKind::Falling };
        EdgeEvent { timestamp_ns, kind, offset, seqno: 0, line_seqno }
    }

    /// Reads frames of 20 ms on the lateral line, each `delay_ns` after its end, on a clock that is `ahead_ns`
    /// ahead of the kernel's. Returns the age of the pulse after each frame.
    fn ages_ns(edges: &mut Edges, delays_ns: &[i64], ahead_ns: i64) -> Vec<i64> {
        let mut ages = Vec::new();
        for (frame, delay_ns) in (0u32..).zip(delays_ns) {
            let start_ns = 1_000_000_000 + u64::from(frame) * 20_000_000;
            let end_ns = start_ns + 1_600_000;
            let now = Time::from_nanoseconds(end_ns as i64 + delay_ns + ahead_ns);
            edges.take(&edge(19, true, 2 * frame + 1, start_ns), now);
            edges.take(&edge(19, false, 2 * frame + 2, end_ns), now);
            let pulse = edges.pulses.channels.lateral.pulse.unwrap();
            assert_eq!(pulse.width_ms, 1.6);
            ages.push(now.nanoseconds() - pulse.at.nanoseconds());
        }
        ages
    }

    #[test]
    fn a_width_does_not_depend_on_its_reading_time_and_its_age_soon_does_not() {
        let mut edges = Edges::new(lines(), Some(21));
        let delays_ns = [9_000_000, 200_000, 25_000_000, 100_000, 3_000_000];
        let ages = ages_ns(&mut edges, &delays_ns, 77_000_000_000);
        let least = |upto: usize| *delays_ns[..=upto].iter().min().unwrap();
        for (frame, age) in ages.iter().enumerate() {
            // The age is exact except for the smallest delay until this frame.
            assert_eq!(*age, delays_ns[frame] - least(frame));
        }
        assert_eq!(edges.pulses.channels.lateral.errors, 0);
    }

    #[test]
    fn a_step_of_our_clock_is_followed() {
        let mut edges = Edges::new(lines(), Some(21));
        ages_ns(&mut edges, &[100_000], 0);
        for ahead_ns in [-5_000_000_000, 5_000_000_000] {
            assert!(ages_ns(&mut edges, &[100_000], ahead_ns).iter().all(|age| *age <= 100_000));
        }
    }

    #[test]
    fn a_lost_edge_and_a_spike_are_errors_of_their_channel() {
        let mut edges = Edges::new(lines(), Some(21));
        ages_ns(&mut edges, &[0, 0], 0);
        let now = Time::from_nanoseconds(1_100_000_000);
        edges.take(&edge(19, false, 6, 1_060_000_000), now);
        edges.take(&edge(19, true, 7, 1_080_000_000), now);
        edges.take(&edge(19, false, 8, 1_080_003_000), now);
        edges.take(&edge(99, true, 1, 1_080_003_000), now);
        edges.take(&edge(21, true, 1, 1_080_000_000), now);
        edges.take(&edge(21, false, 2, 1_081_900_000), now);
        assert_eq!(edges.pulses.aux.pulse.unwrap().width_ms, 1.9);
        assert_eq!(edges.pulses.channels.lateral.errors, 2);
        assert_eq!(edges.pulses.channels.lateral.pulse.unwrap().width_ms, 1.6);
        assert_eq!(edges.pulses.channels.pedal.errors, 0);
    }

    #[test]
    fn errors_name_a_missing_chip_and_a_line_used_twice() {
        let error = GpioCapture::open(Path::new("/dev/no-such-chip"), &lines(), None).unwrap_err();
        assert!(error.to_string().starts_with("/dev/no-such-chip: cannot monitor lines [5, 6"));
        let twice = Channels { pedal: 13, ..lines() };
        let error = GpioCapture::open(Path::new("/dev/no-such-chip"), &twice, None).unwrap_err();
        assert_eq!(error.to_string(), "longitudinal and pedal are both on line 13");
        let error =
            GpioCapture::open(Path::new("/dev/no-such-chip"), &lines(), Some(26)).unwrap_err();
        assert_eq!(error.to_string(), "pedal and aux are both on line 26");
    }
}
