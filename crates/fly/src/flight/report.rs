//! Measurements of the flight computer about a flight.

use std::fmt;

use super::downlink::DownlinkCounts;
use crate::DurationHistogram;
use crate::serial::{Dropped, PortCounts};
use hovernav::gps;
use hovernav_record::Status;

/// Measurements of the flight computer about a flight. `Display` writes a few lines for a terminal.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct FlightReport {
    /// Duration of the flight, s.
    pub duration_s: f64,
    /// Number of inertial samples that the estimator processed, one per cycle of the loop.
    pub cycles: u64,
    /// Number of fixes passed to the estimator.
    pub fixes: u64,
    /// Work of each cycle: the time from one sample to the next, without waits.
    pub work: DurationHistogram,
    /// Time from reading the last byte of an inertial packet to the output of the servo command. It contains
    /// decoding, estimator, autopilot and writing, but not the wake-up of the loop.
    pub turnaround: DurationHistogram,
    /// Difference between the interval of two packet arrivals and of their samples, from the IMU's timer.
    pub jitter: DurationHistogram,
    /// Delay of timed wake-ups of the loop.
    pub wake_latency: DurationHistogram,
    /// Number of cycles that missed the deadline: the work took longer than a cycle, or the loop woke more than half a
    /// cycle late. Delays of the line are not counted.
    pub missed_deadlines: u64,
    /// Number of restarts of the link to the IMU.
    pub dmu_restarts: u64,
    /// Number of requested packets of the IMU that did not arrive.
    pub dmu_packets_missing: u64,
    /// Port of the IMU.
    pub dmu_port: PortCounts,
    /// Port of the receiver.
    pub gps_port: PortCounts,
    /// Messages of the receiver.
    pub gps_messages: gps::MessageCounts,
    /// Data of the receiver that were dropped from a full queue.
    pub gps_dropped: Dropped,
    /// Telemetry in packed frames.
    pub telemetry: DownlinkCounts,
    /// Telemetry in MAVLink.
    pub mavlink: DownlinkCounts,
    /// The record.
    pub record: Status,
}

impl fmt::Display for FlightReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { duration_s, cycles, fixes, .. } = self;
        writeln!(f, "{duration_s:.1} s, {cycles} cycles, {fixes} fixes")?;
        writeln!(f, "  missed deadlines  {}", self.missed_deadlines)?;
        for (name, histogram) in [
            ("loop body", &self.work),
            ("packet to servos", &self.turnaround),
            ("packet jitter", &self.jitter),
            ("late wake-up", &self.wake_latency),
        ] {
            if histogram.count() == 0 {
                writeln!(f, "  {name:<16}  none")?;
                continue;
            }
            writeln!(
                f,
                "  {name:<16}  median {:.3} ms, p99 {:.3} ms, p99.9 {:.3} ms, longest {:.3} ms",
                1e3 * histogram.quantile_s(0.5),
                1e3 * histogram.quantile_s(0.99),
                1e3 * histogram.quantile_s(0.999),
                1e3 * histogram.longest_s()
            )?;
        }
        writeln!(
            f,
            "  inertial unit     {} bytes, {} packets missing, link restarted {} times, port lost \
             {} times",
            self.dmu_port.bytes_read,
            self.dmu_packets_missing,
            self.dmu_restarts,
            self.dmu_port.lost
        )?;
        writeln!(
            f,
            "  receiver          {} bytes, {} dropped, port lost {} times",
            self.gps_port.bytes_read, self.gps_dropped.bytes, self.gps_port.lost
        )?;
        for (name, counts) in [("telemetry", &self.telemetry), ("mavlink", &self.mavlink)] {
            if counts.sent + counts.dropped > 0 {
                writeln!(f, "  {name:<16}  {} sent, {} dropped", counts.sent, counts.dropped)?;
            }
        }
        let record = &self.record;
        write!(
            f,
            "  record            {} bytes, {} raw and {} other entries lost, {} bytes not written, {} \
             failed writes",
            record.bytes_written,
            record.lost_raw,
            record.lost_decoded,
            record.bytes_waiting,
            record.failed_writes
        )?;
        if let Some(number) = record.os_error {
            write!(f, " ({})", std::io::Error::from_raw_os_error(number))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_measurements_are_none_and_not_zero() {
        let mut report = FlightReport::default();
        report.work.add(0.002);
        let text = report.to_string();
        assert!(text.contains("  loop body         median "), "{text}");
        for name in ["packet to servos", "packet jitter", "late wake-up"] {
            assert!(text.contains(&format!("  {name:<16}  none\n")), "{text}");
        }
        assert!(!text.contains("0.000 ms"), "{text}");
    }
}
