//! Finds the topic with the receiver's own velocity. Odometry, filters and controllers also send
//! `geometry_msgs/TwistStamped`; these are not measurements.

use super::topic::Topic;

/// Parts of the names of a receiver's topics and frames, as in `nmea_navsat_driver`, `ublox_gps` and MAVROS.
const OF_RECEIVERS: [&str; 6] = ["gps", "gnss", "navsat", "ublox", "septentrio", "fix"];

/// Parts of the names of body frames, in which no receiver measures.
const OF_VEHICLES: [&str; 4] = ["base", "body", "odom", "imu"];

/// Rank, 0 the best, and reason why `topic` is the velocity of the receiver of `fixes`; `None` without a reason.
pub(super) fn reason(topic: &Topic, fixes: &Topic) -> Option<(u8, &'static str)> {
    let has = |name: &str, parts: &[&str]| {
        let name = name.to_ascii_lowercase();
        parts.iter().any(|part| name.contains(part))
    };
    let (messages, epochs) = (topic.stamps.messages, fixes.stamps.messages);
    if has(&topic.name, &["cmd", "setpoint", "target"]) {
        // The topic is a command, not a measurement.
        None
    } else if has(&topic.name, &OF_RECEIVERS) {
        Some((0, "its name denotes a receiver"))
    } else if has(&topic.frame, &OF_RECEIVERS) {
        Some((1, "its frame denotes a receiver"))
    } else if has(&topic.frame, &OF_VEHICLES) {
        None
    } else if !topic.frame.is_empty() && topic.frame == fixes.frame {
        Some((2, "it has the frame of the fixes"))
    } else if 10 * messages.abs_diff(epochs) <= epochs {
        Some((3, "it has one message per fix"))
    } else {
        None
    }
}
