//! What the flight computer measured of a flight.

use std::fmt;

use super::downlink::DownlinkCounts;
use crate::DurationHistogram;
use crate::serial::{Dropped, PortCounts};
use hovernav::gps;
use hovernav_log::record;

/// What the flight computer measured of a flight. Its `Display` is a few lines for a terminal.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct FlightReport {
    /// From start to end, s.
    pub duration_s: f64,
    /// Inertial samples the estimator took, each a cycle of the loop.
    pub cycles: u64,
    /// Fixes the estimator was given.
    pub fixes: u64,
    /// Busy time of each cycle: all the loop does between two waits, from one sample to the next.
    pub work: DurationHistogram,
    /// From reading the last byte of an inertial packet to the servos having their command: decoding,
    /// estimator, autopilot and the writing of it, without the waking of the loop.
    pub turnaround: DurationHistogram,
    /// Between two packets' arrivals, less the time between their samples by the unit's own timer.
    pub jitter: DurationHistogram,
    /// How late the loop woke where it had asked to be woken at a time.
    pub wake_latency: DurationHistogram,
    /// Cycles whose work took longer than a cycle lasts, or that began more than half a cycle late
    /// because the loop woke late: deadlines missed by the loop's own fault.
    pub missed_deadlines: u64,
    /// Times the inertial unit's link started over.
    pub dmu_restarts: u64,
    /// Packets the unit's line lost: asked for and not come.
    pub dmu_packets_missing: u64,
    /// The unit's port.
    pub dmu_port: PortCounts,
    /// The receiver's port.
    pub gps_port: PortCounts,
    /// The receiver's messages.
    pub gps_messages: gps::MessageCounts,
    /// What the receiver sent and the loop did not take in time.
    pub gps_dropped: Dropped,
    /// Telemetry in packed frames.
    pub telemetry: DownlinkCounts,
    /// Telemetry in MAVLink.
    pub mavlink: DownlinkCounts,
    /// The record.
    pub record: record::Status,
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
            "  inertial unit     {} bytes, {} packets missing, link started over {} times, port lost {} \
             times",
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
    fn what_was_not_measured_is_none_and_not_0() {
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
