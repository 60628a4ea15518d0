//! Which topic has the receiver's own velocity. `geometry_msgs/TwistStamped` is also what odometry, filters
//! and whoever steers a vehicle send, and none of those may be taken for a measurement.

use super::topic::Topic;

/// What names of a receiver's topics and frames have in them: `nmea_navsat_driver`, `ublox_gps`, MAVROS and
/// others.
const OF_RECEIVERS: [&str; 6] = ["gps", "gnss", "navsat", "ublox", "septentrio", "fix"];

/// What frames of a vehicle's own axes have in their names: a receiver measures in none of them.
const OF_VEHICLES: [&str; 4] = ["base", "body", "odom", "imu"];

/// Why `topic` counts as the velocity of the receiver whose fixes are `fixes`, behind how good a reason that
/// is, 0 the best; nothing where there is none.
pub(super) fn reason(topic: &Topic, fixes: &Topic) -> Option<(u8, &'static str)> {
    let has = |name: &str, parts: &[&str]| {
        let name = name.to_ascii_lowercase();
        parts.iter().any(|part| name.contains(part))
    };
    let (messages, epochs) = (topic.stamps.messages, fixes.stamps.messages);
    if has(&topic.name, &["cmd", "setpoint", "target"]) {
        // What is asked of a vehicle, not measured.
        None
    } else if has(&topic.name, &OF_RECEIVERS) {
        Some((0, "its name is a receiver's"))
    } else if has(&topic.frame, &OF_RECEIVERS) {
        Some((1, "its frame is a receiver's"))
    } else if has(&topic.frame, &OF_VEHICLES) {
        None
    } else if !topic.frame.is_empty() && topic.frame == fixes.frame {
        Some((2, "its frame is that of the fixes"))
    } else if 10 * messages.abs_diff(epochs) <= epochs {
        Some((3, "it has a message for each fix"))
    } else {
        None
    }
}
