//! Quantity, unit and origin of a column, from its name.

use super::axis_names::{axis, quaternion};
use super::quantity::Quantity;
use super::sigma_names;
use super::unit_names::{trailing_unit, unit};
use super::words::{bracketed, words};
use crate::text::HeightAbove;

/// Words for errors and their statistics. Columns with such words are no readings.
const OF_ERRORS: [&str; 13] = [
    "std",
    "stdev",
    "stddev",
    "sigma",
    "var",
    "variance",
    "cov",
    "covariance",
    "bias",
    "unc",
    "uncertainty",
    "err",
    "error",
];

/// The meaning of a column's name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Meaning {
    pub quantity: Quantity,
    /// The unit, spelt as in mappings, in lower case.
    pub unit: Option<&'static str>,
    /// Whether an estimator computed the values; otherwise a sensor measured them.
    pub estimated: bool,
}

/// The meaning of the column `name`. `below` is the text under the name, which is often the unit. `None` if the name is
/// not recognised.
pub(crate) fn meaning(name: &str, below: &str) -> Option<Meaning> {
    let (plain, bracket) = bracketed(name);
    let parts: Vec<&str> = plain.split(['/', '.', ':']).filter(|part| !part.is_empty()).collect();
    // The last words of a path can be a name: `/gps/fix/latitude`, `GNSS1::PosLla::latitude`.
    (0..parts.len().max(1)).find_map(|from| {
        let part = parts.get(from..).map_or(plain.to_owned(), |parts| parts.join(" "));
        of_words(words(&part), &bracket, below, from > 0)
    })
}

/// The meaning of the words of a name. If `is_part`, the words may be only the last part of a name; a single letter is
/// no such part.
fn of_words(mut words: Vec<String>, bracket: &str, below: &str, is_part: bool) -> Option<Meaning> {
    let below = below.trim_matches(['[', ']', '(', ')', '#', ' ']);
    let bracket_unit = unit(bracket)
        .or_else(|| unit(below))
        .or_else(|| unit(below.split_whitespace().next().unwrap_or_default()));
    let trailing_unit = bracket_unit.is_none().then(|| trailing_unit(&mut words)).flatten();
    let is = |known: &[&str]| words.iter().any(|word| known.contains(&word.as_str()));
    if is(&["ref", "reference", "truth", "true", "gt", "groundtruth", "ecef"]) {
        return None;
    }
    let estimated = is(&["est", "estimated", "ekf", "ekf2", "filter", "filtered", "fused", "kf"]);
    const NOISE: [&str; 21] = [
        "field",
        "imu",
        "gps",
        "gnss",
        "sensor",
        "sensors",
        "raw",
        "ins",
        "data",
        "body",
        "frd",
        "flu",
        "meas",
        "measured",
        "cal",
        "calibrated",
        "est",
        "ekf",
        "estimated",
        "filtered",
        "fused",
    ];
    let is_kept = |(index, word): &(usize, &str)| {
        // One of several sensors may be numbered: `gps1_lat` and `gps_1_lat`. A number at the end denotes an axis.
        let plain = word.trim_end_matches(|letter: char| letter.is_ascii_digit());
        !NOISE.contains(&plain) && (!plain.is_empty() || index + 1 == words.len())
    };
    let kept = words.iter().map(String::as_str).enumerate().filter(is_kept);
    let kept: Vec<&str> = kept.map(|(_, word)| word).collect();
    let joined = match kept[..] {
        [] => words.concat(),
        // EuRoC names frames between a quantity and its axis: `w_RS_S_x`.
        [first, ref frames @ .., axis @ ("x" | "y" | "z")]
            if first.len() == 1 && frames.iter().all(|frame| frame.len() < 3) =>
        {
            format!("{first}{axis}")
        }
        _ => kept.concat(),
    };
    if is_part && joined.len() < 2 {
        return None;
    }
    let of_errors =
        is(&OF_ERRORS) || ["bias", "sigma", "covar"].iter().any(|part| joined.contains(part));
    let reading = || {
        Some(scalar(&joined).or_else(|| axis(&joined))?)
            .filter(|found| !of_errors || found.is_sigma())
    };
    let quantity = sigma_names::per_axis(&joined).or_else(reading)?;
    if quantity == Quantity::FixType && is(&["imu", "ins"]) {
        return None;
    }
    let unit = bracket_unit.or(trailing_unit);
    let quantity = match (quantity, unit) {
        (Quantity::Pressure, Some("m" | "cm" | "ft")) => Quantity::BaroHeight,
        _ => quantity,
    };
    // Engines and rotors turn in revolutions per minute too.
    let is_engine = unit == Some("rpm") && !matches!(quantity, Quantity::Gyro(_));
    (!is_engine).then_some(Meaning { quantity, unit, estimated })
}

/// The quantity of a name without an axis.
fn scalar(name: &str) -> Option<Quantity> {
    use Quantity as Q;
    if let Some(found) = coordinate(name).or_else(|| quaternion(name).map(Q::Quaternion)) {
        return Some(found);
    }
    let has = |parts: &[&str]| parts.iter().any(|part| name.contains(part));
    Some(match name {
        "t" | "ts" | "sec" | "secs" | "seconds" | "millis" | "micros" | "ms" | "us" | "ns"
        | "stamp" | "tow" | "itow" | "sow" | "elapsed" | "elapsedtime" | "datetime" | "utc"
        | "utctime" | "hms" | "hhmmss" | "clock" | "epoch" | "mjd" => Q::Time,
        "date" | "utcdate" | "ddmmyy" => Q::Date,
        "week" | "wk" | "wn" | "gwk" | "weekno" | "weeknumber" => Q::Week,
        "p" | "rollrate" | "rollspeed" => Q::Gyro(0),
        "q" | "pitchrate" | "pitchspeed" => Q::Gyro(1),
        "r" | "yawrate" | "yawspeed" => Q::Gyro(2),
        "roll" | "phi" | "rollangle" => Q::Attitude(0),
        "pitch" | "theta" | "pitchangle" => Q::Attitude(1),
        "yaw" | "psi" | "heading" | "hdg" | "yawangle" => Q::Attitude(2),
        "lateral" => Q::Stick(0),
        "longitudinal" => Q::Stick(1),
        "collective" => Q::Stick(2),
        "pedal" => Q::Stick(3),
        "vn" | "veln" | "velnedn" | "velnedx" | "vnedx" | "vnorth" | "velnorth"
        | "northvelocity" | "velocitynorth" | "velocityn" => Q::Velocity(0),
        "ve" | "vele" | "velnede" | "velnedy" | "vnedy" | "veast" | "veleast" | "eastvelocity"
        | "velocityeast" | "velocitye" => Q::Velocity(1),
        "vd" | "veld" | "velnedd" | "velnedz" | "vnedz" | "vdown" | "veldown" | "downvelocity"
        | "velocitydown" | "velocityd" => Q::Velocity(2),
        "vu" | "velu" | "vup" | "velup" | "upvelocity" | "velocityup" | "climb" | "climbrate"
        | "verticalspeed" | "vertspeed" | "vspeed" | "vspd" => Q::Up,
        "speed" | "gspeed" | "groundspeed" | "gndspd" | "sog" | "spd" | "vel" | "velocity" => {
            Q::Speed
        }
        "course" | "cog" | "track" | "trk" | "direction" | "crs" | "gcrs" | "headmot"
        | "courseoverground" | "groundcourse" | "bearing" => Q::Course,
        "hacc" | "eph" | "sigmah" | "horizontalaccuracy" | "accuracyhorizontal"
        | "sigmahorizontal" => Q::SigmaHorizontal,
        "vacc" | "epv" | "sigmav" | "verticalaccuracy" | "accuracyvertical" | "sigmavertical" => {
            Q::SigmaVertical
        }
        "sacc" | "speedaccuracy" | "sigmavh" | "velacc" | "sigmaspeed" => Q::SigmaSpeed,
        "sigmavv" => Q::SigmaVerticalSpeed,
        // The setting of an altimeter, and its height, in the logs of Garmin's G1000.
        "baroa" => return None,
        "altb" => Q::BaroHeight,
        "llaz" | "llhz" => Q::Height(None),
        "fix" | "fixtype" | "fixstatus" | "fixvalid" | "valid" => Q::FixType,
        "numsv" | "nsv" => Q::Satellites,
        _ if has(&["undulation", "geoidsep", "geoidheight", "geoidalsep"]) => Q::Undulation,
        _ if has(&["accuracy"]) => return None,
        _ if name.starts_with("time")
            || ["time", "timestamp", "timefine"].iter().any(|end| name.ends_with(end)) =>
        {
            Q::Time
        }
        _ if name.ends_with("date") => Q::Date,
        _ if has(&["nsat", "numsat", "satellites"]) || name == "sats" => Q::Satellites,
        _ if has(&["baro", "press"]) && has(&["alt", "height", "hgt"]) => Q::BaroHeight,
        _ if has(&["baro", "press"]) => Q::Pressure,
        _ if has(&["agl", "relalt", "relative", "std", "dop", "temp"]) => return None,
        _ if has(&["alt", "height", "hgt", "elev", "hmsl", "ellips"]) || name == "h" => {
            Q::Height(if has(&["msl", "asl", "sea", "ortho"]) {
                Some(HeightAbove::Sea)
            } else if has(&["ell", "hae", "wgs"]) {
                Some(HeightAbove::Ellipsoid)
            } else {
                None
            })
        }
        _ => return None,
    })
}

/// Latitude or longitude: `lat`, `lat1`, `lat_wgs84`, `locationLatitude`.
fn coordinate(name: &str) -> Option<Quantity> {
    const OF_PLACES: [&str; 6] = ["location", "position", "coordinate", "pos", "loc", "coord"];
    let name = OF_PLACES.iter().find_map(|begin| name.strip_prefix(begin)).unwrap_or(name);
    match name.trim_end_matches("wgs84").trim_end_matches(|letter: char| letter.is_ascii_digit()) {
        "lat" | "latitude" | "llax" | "llhx" => Some(Quantity::Latitude),
        "lon" | "lng" | "long" | "longitude" | "llay" | "llhy" => Some(Quantity::Longitude),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_many_loggers_are_understood() {
        use Quantity as Q;
        for (name, quantity, unit) in [
            ("t_s", Q::Time, Some("s")),
            ("Time (ms)", Q::Time, Some("ms")),
            ("timestamp", Q::Time, None),
            ("TimeUS", Q::Time, Some("us")),
            ("gyro_x_radps", Q::Gyro(0), Some("rad/s")),
            ("GyroY [deg/s]", Q::Gyro(1), Some("deg/s")),
            ("imu0_gz_dps", Q::Gyro(2), Some("deg/s")),
            ("angular_velocity.x", Q::Gyro(0), None),
            ("wx", Q::Gyro(0), None),
            ("accX", Q::Accel(0), None),
            ("acc_y_g", Q::Accel(1), Some("g")),
            ("linear_acceleration.z", Q::Accel(2), None),
            ("accel_x_mps2", Q::Accel(0), Some("m/s2")),
            ("Accel Z (m/s^2)", Q::Accel(2), Some("m/s2")),
            ("xacc", Q::Accel(0), None),
            ("dvel_x_mps", Q::VelocityIncrement(0), Some("m/s")),
            ("dtheta_z_rad", Q::AngleIncrement(2), Some("rad")),
            ("DeltaThetaX", Q::AngleIncrement(0), None),
            ("dth_x", Q::AngleIncrement(0), None),
            ("dth_z_rad", Q::AngleIncrement(2), Some("rad")),
            ("dv_y", Q::VelocityIncrement(1), None),
            ("DeltaVelocityX", Q::VelocityIncrement(0), None),
            ("bearing", Q::Course, None),
            ("verticalAccuracy", Q::SigmaVertical, None),
            ("mag_x_gauss", Q::Mag(0), Some("gauss")),
            ("magY(uT)", Q::Mag(1), Some("ut")),
            ("roll_deg", Q::Attitude(0), Some("deg")),
            ("Heading", Q::Attitude(2), None),
            ("q0", Q::Quaternion(0), None),
            ("lat_deg", Q::Latitude, Some("deg")),
            ("Longitude", Q::Longitude, None),
            ("gps_alt_m", Q::Height(None), Some("m")),
            ("alt_msl [ft]", Q::Height(Some(HeightAbove::Sea)), Some("ft")),
            ("height_m", Q::Height(None), Some("m")),
            ("velN", Q::Velocity(0), None),
            ("vd_mps", Q::Velocity(2), Some("m/s")),
            ("gSpeed", Q::Speed, None),
            ("hAcc", Q::SigmaHorizontal, None),
            ("sigma_h_m", Q::SigmaHorizontal, Some("m")),
            ("sigma_vh_mps", Q::SigmaSpeed, Some("m/s")),
            ("std_n", Q::SigmaPosition(0), None),
            ("sdu(m)", Q::SigmaPosition(2), Some("m")),
            ("lat_std [m]", Q::SigmaPosition(0), Some("m")),
            ("sigma_vd_mps", Q::SigmaVelocity(2), Some("m/s")),
            ("numSV", Q::Satellites, None),
            ("undulation (m)", Q::Undulation, Some("m")),
            ("geoidal_separation", Q::Undulation, None),
            ("VALID", Q::FixType, None),
            ("gps_valid", Q::FixType, None),
            ("baro_alt_m", Q::BaroHeight, Some("m")),
            ("pressure_hPa", Q::Pressure, Some("hpa")),
            ("IMU_ATTI:barometer:Raw[meters]", Q::BaroHeight, Some("m")),
            ("pedal", Q::Stick(3), None),
            ("lat_1e7", Q::Latitude, Some("deg1e7")),
            ("Latitude (ddmm.mmmm)", Q::Latitude, Some("ddmm")),
            ("alt_mm", Q::Height(None), Some("mm")),
            ("hacc_mm", Q::SigmaHorizontal, Some("mm")),
            ("speed_cm_s", Q::Speed, Some("cm/s")),
            ("vel_cm_s", Q::Speed, Some("cm/s")),
            ("speed [mph]", Q::Speed, Some("mph")),
            ("course_cdeg", Q::Course, Some("cdeg")),
            ("utc_time", Q::Time, None),
            ("tow_ms", Q::Time, Some("ms")),
            ("date", Q::Date, None),
            ("gps_week", Q::Week, None),
        ] {
            let found = meaning(name, "");
            let found = found.map(|meaning| (meaning.quantity, meaning.unit));
            assert_eq!(found, Some((quantity, unit)), "{name}");
        }
        for (name, quantity) in [
            ("field.angular_velocity.x", Q::Gyro(0)),
            ("field.linear_acceleration.z", Q::Accel(2)),
            ("field.header.stamp", Q::Time),
            ("field.latitude", Q::Latitude),
            ("/gps/fix/longitude", Q::Longitude),
            ("/mavros/imu/data/angular_velocity/y", Q::Gyro(1)),
            ("field.twist.linear.x", Q::Twist(0)),
            ("twist.twist.linear.z", Q::Twist(2)),
            ("GNSS1::PosLla::altitude [m]", Q::Height(None)),
            ("GNSS1::VelNed::N [m/s]", Q::Velocity(0)),
            ("IMU::UncompAccel::X [m/s^2]", Q::Accel(0)),
            ("IMU_ATTI:accel:X", Q::Accel(0)),
            ("IMU_ATTI:Longitude", Q::Longitude),
            ("local_time", Q::Time),
            ("Lcl Date", Q::Date),
            ("GndSpd", Q::Speed),
            ("GCrs", Q::Course),
            ("gFx", Q::Accel(0)),
            ("PosLla y", Q::Longitude),
            ("VelNed z", Q::Velocity(2)),
            ("locationLatitude(WGS84)", Q::Latitude),
            ("LOCATION Latitude : ", Q::Latitude),
            ("gps_position_longitude", Q::Longitude),
            ("Position_Latitude", Q::Latitude),
            ("lat_wgs84", Q::Latitude),
            ("gps1_lat", Q::Latitude),
            ("gps_1_lon", Q::Longitude),
            ("lon2", Q::Longitude),
            ("Quat_q3", Q::Quaternion(3)),
            ("SampleTimeFine", Q::Time),
            ("Zeit (s)", Q::Time),
            ("Drehrate X [°/s]", Q::Gyro(0)),
            ("speed_kmph", Q::Speed),
            ("Breitengrad (°)", Q::Latitude),
            ("Länge (°)", Q::Longitude),
            ("Höhe (m)", Q::Height(None)),
            ("Vitesse (m/s)", Q::Speed),
            ("Richtung (°)", Q::Course),
            ("Dirección (°)", Q::Course),
            ("Horizontale Genauigkeit (m)", Q::SigmaHorizontal),
            ("Précision verticale (m)", Q::SigmaVertical),
        ] {
            assert_eq!(meaning(name, "").map(|found| found.quantity), Some(quantity), "{name}");
        }
        for name in [
            "Att::YawPitchRoll::P [deg]",
            "INS::LinearAccelEcef::X [m/s^2]",
            "",
            "temperature",
            "foo",
            "true_roll",
            "hdop",
            "lateral_error",
            "bearingAccuracy",
            "gyro_std_x",
            "accel_bias_y",
            "gyroBiasZ",
            "alt_err",
            "lat_var",
            "PacketCounter",
            "imu_valid",
            "altitudeAccuracy",
        ] {
            assert_eq!(meaning(name, ""), None, "{name}");
        }
        for (name, quantity, unit) in [
            ("w_RS_S_x [rad s^-1]", Q::Gyro(0), "rad/s"),
            ("a_RS_S_z [m s^-2]", Q::Accel(2), "m/s2"),
        ] {
            let found = meaning(name, "").unwrap();
            assert_eq!((found.quantity, found.unit), (quantity, Some(unit)), "{name}");
        }
        assert_eq!(meaning("gyro_x", "[rpm]").unwrap().unit, Some("rpm"));
        assert_eq!(meaning("throttle_rpm", "").map(|found| found.quantity), None);
        assert_eq!(meaning("gyro_x", "[deg/s]").unwrap().unit, Some("deg/s"));
        assert!(meaning("ekf_roll", "").unwrap().estimated);
    }
}
