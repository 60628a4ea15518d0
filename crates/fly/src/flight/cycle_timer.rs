//! Timing of the loop's cycles.

use std::fmt;

use hovernav::time::Time;

use crate::DurationHistogram;

/// Measures the work of each cycle and the delay of each timed wake-up.
///
/// The work of a cycle is the time from one sample to the next without waits. The bytes of one packet may wake the
/// loop several times.
pub struct CycleTimer {
    /// Longest work of a cycle, s.
    cycle_s: f64,
    /// End of the last wait.
    wait_ended: Time,
    /// Start of the last wait.
    wait_began: Time,
    /// Work since the last complete cycle, s.
    work_s: f64,
    complete: bool,
    /// Longest delay of the present cycle's start, s, if more than half a cycle; otherwise zero.
    late_s: f64,
    /// Whether the loop ran a cycle by the clock since the last packet, because the next one did not arrive in
    /// time.
    ran_by_clock: bool,
    /// Work of each cycle.
    pub work: DurationHistogram,
    /// Delay of timed wake-ups.
    pub wake_latency: DurationHistogram,
    /// Number of cycles that missed their deadline because of the loop.
    pub missed_deadlines: u64,
}

/// Timing of a complete cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CycleTiming {
    /// Duration of the cycle's work, s.
    pub work_s: f64,
    /// Delay of the cycle's start, s, if more than half a cycle; otherwise zero.
    pub late_s: f64,
    /// Whether the cycle met its deadline.
    pub on_time: bool,
}

impl fmt::Display for CycleTiming {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (work_ms, late_ms) = (1e3 * self.work_s, 1e3 * self.late_s);
        if late_ms > 0.0 {
            write!(f, "a cycle began {late_ms:.0} ms late and took {work_ms:.1} ms")
        } else {
            write!(f, "a cycle took {work_ms:.1} ms of work")
        }
    }
}

impl CycleTimer {
    pub fn new(cycle_s: f64, start: Time) -> Self {
        Self {
            cycle_s,
            wait_ended: start,
            wait_began: start,
            work_s: 0.0,
            complete: false,
            late_s: 0.0,
            ran_by_clock: false,
            work: DurationHistogram::default(),
            wake_latency: DurationHistogram::default(),
            missed_deadlines: 0,
        }
    }

    /// Reports that this cycle's packet was delayed by `behind_s` more than the previous packet, from sending to
    /// arrival. The delay counts as a late wake-up of the loop, with one exception. If the loop ran a cycle by the
    /// clock in between and found no packet, the line delayed the packet.
    pub fn packet_behind(&mut self, behind_s: f64) {
        if !std::mem::take(&mut self.ran_by_clock) {
            self.begins_late(behind_s);
        }
    }

    /// Reports a cycle by the clock, because a packet did not arrive in time.
    pub fn run_by_clock(&mut self) {
        self.ran_by_clock = true;
    }

    /// Marks the cycle as complete at the next wait.
    pub fn complete_cycle(&mut self) {
        self.complete = true;
    }

    /// Reports the start of a wait; returns the timing of the cycle that ends here, if any.
    pub fn begin_wait(&mut self, now: Time) -> Option<CycleTiming> {
        self.work_s += now - self.wait_ended;
        self.wait_began = now;
        if !std::mem::take(&mut self.complete) {
            return None;
        }
        let work_s = std::mem::take(&mut self.work_s);
        let late_s = std::mem::take(&mut self.late_s);
        let on_time = late_s == 0.0 && work_s <= self.cycle_s;
        self.missed_deadlines += u64::from(!on_time);
        self.work.add(work_s);
        Some(CycleTiming { work_s, late_s, on_time })
    }

    /// Reports the end of a wait: bytes arrived (`None`), or the `requested` time came.
    pub fn end_wait(&mut self, now: Time, requested: Option<Time>) {
        self.wait_ended = now;
        if let Some(requested) = requested {
            // If the requested time is before the wait, the delay counts from the start of the wait.
            let late_s = now - requested.max(self.wait_began);
            self.wake_latency.add(late_s);
            self.begins_late(late_s);
        }
    }

    fn begins_late(&mut self, late_s: f64) {
        if late_s > 0.5 * self.cycle_s {
            self.late_s = self.late_s.max(late_s);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    fn at(milliseconds: i64) -> Time {
        Time::from_nanoseconds(milliseconds * 1_000_000)
    }

    #[test]
    fn the_work_of_a_cycle_is_the_time_between_samples_without_waits() {
        let mut timer = CycleTimer::new(0.03, at(0));
        assert_eq!(timer.begin_wait(at(2)), None);
        timer.end_wait(at(20), None);
        timer.complete_cycle();
        let cycle = timer.begin_wait(at(25)).unwrap();
        assert_abs_diff_eq!(cycle.work_s, 0.007, epsilon = 1e-12);
        assert!(cycle.on_time);
    }

    #[test]
    fn long_work_and_a_late_wake_up_miss_the_deadline_and_a_past_request_does_not() {
        let mut timer = CycleTimer::new(0.03, at(0));
        timer.complete_cycle();
        assert!(!timer.begin_wait(at(31)).unwrap().on_time);

        timer.end_wait(at(60), Some(at(40)));
        timer.complete_cycle();
        let cycle = timer.begin_wait(at(61)).unwrap();
        assert!(cycle.late_s > 0.0 && !cycle.on_time);

        timer.end_wait(at(62), Some(at(10)));
        timer.complete_cycle();
        assert!(timer.begin_wait(at(63)).unwrap().on_time);
        assert_eq!((timer.missed_deadlines, timer.work.count()), (2, 3));

        timer.end_wait(at(120), None);
        timer.packet_behind(0.02);
        timer.complete_cycle();
        assert!(!timer.begin_wait(at(121)).unwrap().on_time);
        assert_abs_diff_eq!(timer.wake_latency.longest_s(), 0.02, epsilon = 1e-12);
    }

    /// The IMU's line is cut, and the loop runs by the clock, on time.
    #[test]
    fn a_packet_delayed_by_the_line_is_not_a_missed_deadline() {
        let mut timer = CycleTimer::new(0.03, at(0));
        for wake in [45, 90, 135] {
            assert_eq!(timer.begin_wait(at(wake - 44)), None);
            timer.end_wait(at(wake), Some(at(wake)));
            timer.run_by_clock();
        }
        timer.begin_wait(at(136));
        timer.end_wait(at(160), None);
        timer.packet_behind(0.1);
        timer.complete_cycle();
        assert!(timer.begin_wait(at(161)).unwrap().on_time);
        // The next delay is caused by the loop.
        timer.end_wait(at(220), None);
        timer.packet_behind(0.03);
        timer.complete_cycle();
        assert!(!timer.begin_wait(at(221)).unwrap().on_time);
        // A late timed wake-up is caused by the loop, too.
        timer.end_wait(at(290), Some(at(265)));
        timer.run_by_clock();
        timer.begin_wait(at(291));
        timer.end_wait(at(292), None);
        timer.packet_behind(0.04);
        timer.complete_cycle();
        assert!(!timer.begin_wait(at(293)).unwrap().on_time);
    }
}
