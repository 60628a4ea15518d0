//! Sample times on the clock of the flight, computed from the inertial unit's timer.
//!
//! Packets arrive with the jitter of a serial line, a scheduler and perhaps a USB adapter. The timer in the packets is
//! exact to 0.79 µs. It wraps every 51.8 ms, has no zero, and its quartz has an unknown error. [`SampleClock`] takes
//! the intervals from the timer, and only their long-term mean from the arrivals.

use core::fmt;

use crate::time::Time;

/// Nominal length of a timer tick, s; the manual gives it with two digits.
/// Source: Crossbow, *AHRS Series User's Manual*, 7430-0004-01, page 16.
const NOMINAL_TICK_S: f64 = 0.79e-6;

/// Number of ticks in one wrap of the 16-bit timer.
const TURN_TICKS: f64 = 65_536.0;

/// One-sigma of the relative error of the nominal tick. The manual rounds the tick to 0.79 µs, an error of up to ±0.6
/// %.
const TICK_SIGMA: f64 = 4e-3;

/// Largest relative error of the nominal tick that is accepted.
const TICK_ERROR_MAX: f64 = 1e-2;

/// One-sigma of the jitter of an arrival about its expected time, s.
const JITTER_SIGMA_S: f64 = 2e-3;

/// One-sigma of the jitter of the first arrival, s.
const ANCHOR_SIGMA_S: f64 = 5e-3;

/// Random walk of the tick's relative error, 1/√s: a quartz during warm-up.
const TICK_WALK_PER_SQRT_S: f64 = 1e-6;

/// Largest difference between actual and expected arrival, s, with which the clock's filter uses the arrival.
const GATE_S: f64 = 5e-3;

/// Number of consecutive packets of similar lateness after which the expected arrival counts as too early.
const LATE_IN_A_ROW: u32 = 16;

/// Largest difference, s, between two latenesses that count as similar: a quarter of the timer's wrap. It is less than
/// the 14 ms between packets. The lateness of queued packets falls by 14 ms from packet to packet, so these latenesses
/// are not similar.
const ALIKE_S: f64 = 13e-3;

/// Longest gap across which timer wraps are counted, s. Over 2 s, a tick error of 0.6 % causes an error of a quarter of
/// a wrap.
const LONGEST_GAP_S: f64 = 2.0;

/// Source of the interval to the previous sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Basis {
    /// The timer, exact to one tick.
    Timer,
    /// The timer; the number of its wraps during a gap comes from the arrival times.
    TimerAcrossGap {
        /// Number of whole timer wraps added to the interval, of 51.8 ms each.
        turns: u32,
    },
    /// The arrival alone: after the start, after a long gap, or after a correction of several milliseconds.
    Arrival,
}

/// Sample time of a packet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stamp {
    /// Time of the sample on the clock of the arrivals; later than the time of any earlier stamp.
    pub time: Time,
    /// Lateness of the packet relative to its expected arrival, s; negative if early. The expected arrival follows the
    /// mean, so the lateness is the jitter of line and scheduler.
    pub late_s: f64,
    /// Source of the interval to the previous stamp.
    pub basis: Basis,
}

/// Reason why a packet has no sample time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClockFault {
    /// The timer has not changed since the previous packet: the packet is a repetition.
    TimerStopped {
        /// The timer's count.
        timer: u16,
    },
    /// The packet arrived so early that the times of the previous samples must be too late. The time of this sample
    /// would be before theirs. The clock is corrected. Samples are valid again once their times are after the last
    /// stamp. This is common when packets that queued before the start are read at once.
    NotAfterPrevious {
        /// The time that the sample would have.
        time: Time,
        /// The time of the last stamp.
        previous: Time,
    },
}

impl fmt::Display for ClockFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TimerStopped { timer } => write!(f, "the timer stays at {timer}"),
            Self::NotAfterPrevious { time, previous } => {
                write!(f, "sampled at {time}, not after the sample before at {previous}")
            }
        }
    }
}

impl core::error::Error for ClockFault {}

/// Sample times from timer counts and arrivals.
///
/// A two-state Kalman filter estimates the offset and the rate of the inertial unit's timer against the arrivals. It
/// ignores arrivals more than 5 ms from their expected time. Late arrivals are due to the scheduler; only 16 similarly
/// late arrivals in a row mean that the clock lost wraps of the timer. An early arrival proves that the clock is wrong,
/// because no packet arrives before it is sent. The clock is then corrected at once.
///
/// ```
/// use hovernav::dmu::{Basis, SampleClock};
/// use hovernav::time::Time;
/// let mut clock = SampleClock::new(0.0078);
/// let first = clock.stamp(20_000, 0, Time::from_nanoseconds(1_000_000_000))?;
/// // 30.3 ms later the timer has counted down through zero; this packet arrived 4 ms late.
/// let second = clock.stamp(47_182, 1, Time::from_nanoseconds(1_034_300_000))?;
/// assert_eq!(second.basis, Basis::Timer);
/// assert!((second.time - first.time - 0.0303).abs() < 4e-3);
/// # Ok::<(), hovernav::dmu::ClockFault>(())
/// ```
#[derive(Clone, Debug)]
pub struct SampleClock {
    latency_s: f64,
    line: Option<Line>,
}

/// Linear relation between the timer and the clock of the flight.
#[derive(Clone, Copy, Debug)]
struct Line {
    /// Zero of `sample_s`.
    origin: Time,
    /// Timer of the last packet.
    timer: u16,
    /// Number of the last packet.
    sequence: u64,
    /// Time of the last packet's sample, s since `origin`.
    sample_s: f64,
    /// Relative error of the nominal tick.
    tick_error: f64,
    /// Variance of `sample_s`, s²; covariance of `sample_s` and `tick_error`, s; variance of `tick_error`.
    covariance: [f64; 3],
    /// Number of consecutive packets of similar lateness.
    late_in_a_row: u32,
    /// Smallest lateness of these packets, s.
    min_late_s: f64,
    /// The last stamp.
    stamped: Time,
}

impl SampleClock {
    /// A clock for packets whose last byte arrives `latency_s` after they were sampled. This latency is the time on the
    /// line, [`Mode::transfer_time_s`](super::Mode::transfer_time_s), plus the delay in the inertial unit, up to one
    /// internal cycle. A latency that is not finite counts as 0.
    #[must_use]
    pub const fn new(latency_s: f64) -> Self {
        Self { latency_s: if latency_s.is_finite() { latency_s } else { 0.0 }, line: None }
    }

    /// Sample time of the packet with this `timer` and `sequence`, as in [`Received`](super::Received). `arrival` is
    /// the arrival of its last byte, on a clock that does not run backwards. Packets of consecutive numbers must be
    /// less than 51.8 ms apart. Skipped packets, lost or rejected, form a gap.
    ///
    /// # Errors
    /// [`ClockFault`] for a timer that has not changed, or a sample time that is not after the previous one.
    pub fn stamp(&mut self, timer: u16, sequence: u64, arrival: Time) -> Result<Stamp, ClockFault> {
        let Some(line) = &mut self.line else {
            let time = arrival + -self.latency_s;
            self.line = Some(Line::through(time, timer, sequence));
            return Ok(Stamp { time, late_s: 0.0, basis: Basis::Arrival });
        };
        let contiguous = sequence == line.sequence.wrapping_add(1);
        line.sequence = sequence;
        let arrived_s = (arrival - line.origin) - self.latency_s;
        let (late_s, basis) = line.advance(timer, arrived_s, contiguous)?;
        let time = line.origin + line.sample_s;
        let previous = line.stamped;
        if time <= previous {
            return Err(ClockFault::NotAfterPrevious { time, previous });
        }
        line.stamped = time;
        Ok(Stamp { time, late_s, basis })
    }

    /// Length of a timer tick on the clock of the flight, s.
    #[must_use]
    pub fn tick_s(&self) -> f64 {
        self.line.as_ref().map_or(NOMINAL_TICK_S, Line::tick_s)
    }
}

impl Line {
    const fn through(time: Time, timer: u16, sequence: u64) -> Self {
        Self {
            origin: time,
            timer,
            sequence,
            sample_s: 0.0,
            tick_error: 0.0,
            covariance: [ANCHOR_SIGMA_S * ANCHOR_SIGMA_S, 0.0, TICK_SIGMA * TICK_SIGMA],
            late_in_a_row: 0,
            min_late_s: f64::INFINITY,
            stamped: time,
        }
    }

    fn tick_s(&self) -> f64 {
        NOMINAL_TICK_S * (1.0 + self.tick_error)
    }

    /// Advances to the next packet; returns its lateness and the source of its time.
    fn advance(
        &mut self,
        timer: u16,
        arrived_s: f64,
        contiguous: bool,
    ) -> Result<(f64, Basis), ClockFault> {
        // The timer counts down.
        let ticks = f64::from(self.timer.wrapping_sub(timer));
        let gap_s = arrived_s - self.sample_s;
        if !contiguous && gap_s > LONGEST_GAP_S {
            self.timer = timer;
            self.anchor_at(arrived_s);
            return Ok((0.0, Basis::Arrival));
        }
        let turns = if contiguous { 0.0 } else { self.turns_within(gap_s, ticks) };
        let interval_s = (ticks + turns * TURN_TICKS) * self.tick_s();
        if interval_s == 0.0 {
            return Err(ClockFault::TimerStopped { timer });
        }
        self.timer = timer;
        self.predict(interval_s);
        let late_s = arrived_s - self.sample_s;
        let basis =
            if contiguous { Basis::Timer } else { Basis::TimerAcrossGap { turns: turns as u32 } };
        if late_s < -GATE_S {
            self.anchor_at(arrived_s);
            return Ok((late_s, Basis::Arrival));
        }
        if late_s <= GATE_S {
            self.correct(late_s);
            return Ok((late_s, basis));
        }
        if libm::fabs(late_s - self.min_late_s) > ALIKE_S {
            self.on_time();
        }
        self.late_in_a_row += 1;
        self.min_late_s = self.min_late_s.min(late_s);
        if self.late_in_a_row < LATE_IN_A_ROW {
            return Ok((late_s, basis));
        }
        self.anchor_at(self.sample_s + self.min_late_s);
        Ok((late_s, Basis::Arrival))
    }

    /// Number of whole timer wraps in a gap of about `gap_s`. `gap_s` may be up to 3/4 of a wrap too long or 1/4 of a
    /// wrap too short. The range is asymmetric because packets are late more often than early.
    ///
    /// # Source
    /// Equation (D3) of docs/equations.md.
    fn turns_within(&self, gap_s: f64, ticks: f64) -> f64 {
        let turn_s = TURN_TICKS * self.tick_s();
        let excess_s = gap_s - ticks * self.tick_s();
        libm::floor(excess_s / turn_s + 0.25).max(0.0)
    }

    fn anchor_at(&mut self, sample_s: f64) {
        let [_, _, tick] = self.covariance;
        self.sample_s = sample_s;
        self.covariance = [ANCHOR_SIGMA_S * ANCHOR_SIGMA_S, 0.0, tick];
        self.on_time();
    }

    fn on_time(&mut self) {
        self.late_in_a_row = 0;
        self.min_late_s = f64::INFINITY;
    }

    /// Propagates the filter over an interval: equation (D2) of docs/equations.md.
    fn predict(&mut self, interval_s: f64) {
        let [offset, cross, tick] = self.covariance;
        self.sample_s += interval_s;
        self.covariance = [
            offset + interval_s * (2.0 * cross + interval_s * tick),
            cross + interval_s * tick,
            tick + interval_s * TICK_WALK_PER_SQRT_S * TICK_WALK_PER_SQRT_S,
        ];
    }

    fn correct(&mut self, late_s: f64) {
        let [offset, cross, tick] = self.covariance;
        let variance = offset + JITTER_SIGMA_S * JITTER_SIGMA_S;
        let (offset_gain, tick_gain) = (offset / variance, cross / variance);
        self.sample_s += offset_gain * late_s;
        self.tick_error =
            (self.tick_error + tick_gain * late_s).clamp(-TICK_ERROR_MAX, TICK_ERROR_MAX);
        self.covariance =
            [offset * (1.0 - offset_gain), cross * (1.0 - offset_gain), tick - tick_gain * cross];
        self.on_time();
    }
}
