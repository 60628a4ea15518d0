//! Names of sensors along axes.

use super::quantity::Quantity;

/// The quantity in a name that has an axis, x, y or z, at its end or its beginning.
pub(super) fn axis(name: &str) -> Option<Quantity> {
    /// Splits a name into the letter at one end and the rest.
    type End = fn(&str) -> Option<(char, &str)>;
    let ends: [End; 2] = [
        |name| name.chars().next_back().map(|last| (last, &name[..name.len() - last.len_utf8()])),
        |name| name.chars().next().map(|first| (first, &name[first.len_utf8()..])),
    ];
    // Accuracies belong to a heading, a height or a speed; they have no axis.
    if name.contains("accuracy") {
        return None;
    }
    ends.into_iter().find_map(|end| {
        let (letter, stem) = end(name)?;
        let axis = ['x', 'y', 'z'].iter().position(|axis| *axis == letter)?;
        let has = |parts: &[&str]| parts.iter().any(|part| stem.contains(part));
        let has_end = |ends: &[&str]| ends.iter().any(|end| stem.ends_with(end));
        Some(if has_end(&["lla"]) {
            [Quantity::Latitude, Quantity::Longitude, Quantity::Height(None)][axis]
        } else if has_end(&["twistlinear"]) {
            Quantity::Twist(axis)
        } else if has_end(&["velned"]) {
            Quantity::Velocity(axis)
        } else if has_end(&["velenu"]) {
            [Quantity::Velocity(1), Quantity::Velocity(0), Quantity::Up][axis]
        } else if has(&["dtheta", "deltatheta", "deltaangle"])
            || ["delang", "dang"].iter().any(|part| stem.starts_with(part))
            || stem == "dth"
        {
            Quantity::AngleIncrement(axis)
        } else if has(&["dvel", "deltavel", "delvel", "deltav"]) || stem == "dv" {
            Quantity::VelocityIncrement(axis)
        } else if has(&[
            "gyr",
            "angvel",
            "angularvel",
            "angularrate",
            "angrate",
            "rotationrate",
            "omega",
        ]) || ["g", "w", "rate"].contains(&stem)
        {
            Quantity::Gyro(axis)
        } else if has(&["mag", "compass"]) || ["m", "b"].contains(&stem) {
            Quantity::Mag(axis)
        } else if stem.ends_with("gravity") {
            Quantity::Gravity(axis)
        } else if has(&["acc", "specificforce"]) || ["a", "f", "gf"].contains(&stem) {
            Quantity::Accel(axis)
        } else {
            return None;
        })
    })
}

/// Index of the component of a quaternion, scalar first, that a name denotes: `q0`, `qw`, `quat_x`, `Quat_q3`,
/// `orientation.w`.
pub(super) fn quaternion(name: &str) -> Option<usize> {
    const NAMES: [&str; 3] = ["quaternion", "quat", "orientation"];
    let name = ["attitude", "att"].iter().find_map(|of| name.strip_prefix(of)).unwrap_or(name);
    let named = NAMES.iter().find_map(|begin| name.strip_prefix(begin));
    let part = match named {
        Some(rest) => rest.strip_prefix('q').unwrap_or(rest),
        None => name.strip_prefix('q')?,
    };
    Some(match part {
        "0" | "w" => 0,
        "1" | "x" => 1,
        "2" | "y" => 2,
        "3" | "z" => 3,
        _ => return None,
    })
}
