//! Catalogue of faults.

use std::fmt::Write as _;

/// A kind of fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize)]
#[allow(missing_docs)] // CATALOGUE describes each.
pub enum Kind {
    Vibration,
    ClipAccel,
    ClipGyro,
    ClipBurst,
    Stuck,
    Gap,
    Interpolated,
    PacketLoss,
    Jitter,
    GyroBias,
    AccelBias,
    AccelScale,
    AccelSign,
    GyroSign,
    SwapAxes,
    Unit,
    GpsTime,
    Outage,
    GlitchStep,
    GlitchRamp,
    GlitchFollow,
    FrozenFix,
    GpsGarbage,
    NoVelocity,
    HeightHeld,
    HeightEmpty,
    SwapLatLon,
    Radians,
    MagHeading,
    MagHeadingOnly,
    MagVector,
    MagVectorOnly,
    LeverArm,
    LeverSign,
    RangeStuck,
    RangeOutliers,
    RangeStep,
    RangeGone,
    HeadingTurn,
    HeadingGone,
    AttitudeFrozen,
    AttitudeLate,
}

/// Allowed values of a fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Values {
    /// A number from the first to the last value; the middle value is the default.
    Number(f64, f64, f64),
    /// One of the words; the first is the default.
    Words(&'static [&'static str]),
    /// No value.
    None,
}

/// Default duration of a fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lasts {
    /// The fault lasts for the whole log.
    Throughout,
    /// The fault lasts from a time on to the end of the log.
    Onwards,
    /// The fault lasts for this duration, s.
    For(f64),
    /// The fault lasts for its value, s.
    ItsValue,
}

/// Description of a kind of fault.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// The kind.
    pub kind: Kind,
    /// Name on the command line.
    pub name: &'static str,
    /// Allowed values.
    pub values: Values,
    /// Unit of the fault's number.
    pub unit: &'static str,
    /// Default duration.
    pub lasts: Lasts,
    /// Effect of the fault.
    pub does: &'static str,
    /// Words that identify the fault in a warning, in lower case. A warning names the fault if it contains one of them,
    /// or all of those joined by a +. They describe the fault and its sensor. A warning that reports only an
    /// inconsistency does not name the fault.
    pub named_by: &'static [&'static str],
}

const fn entry(
    kind: Kind,
    name: &'static str,
    (values, unit): (Values, &'static str),
    lasts: Lasts,
    does: &'static str,
    named_by: &'static [&'static str],
) -> Entry {
    Entry { kind, name, values, unit, lasts, does, named_by }
}

use Lasts::{For, ItsValue, Onwards, Throughout};
use Values::{Number, Words};

const STUCK: &[&str] = &["all", "gyro", "accel", "gx", "gy", "gz", "ax", "ay", "az"];
const SIGNS: &[&str] = &["xyz", "x", "y", "z", "xy", "yz", "xz"];
const PAIRS: &[&str] = &["xy", "yz", "xz"];
const CLIPPED: &[&str] = &["full scale", "saturat", "clipp"];
const GYRO_SIGN: &[&str] = &["gyro+wrong sign", "axes forward, left, up"];
const ACCEL_SIGN: &[&str] =
    &["accelerometer+wrong sign", "axes forward, left, up", "specific force points"];
const AXES: &[&str] = &["swapped", "specific force points", "axes right, forward, up"];
const GLITCH: &[&str] = &["gps+glitch", "gps+jump"];
const GARBAGE: &[&str] = &["gps+glitch", "gps+jump", "gps+contradict"];
const RANGE: &[&str] = &["rangefinder"];
const ANTENNAS: &[&str] = &["second antenna"];
const ATTITUDE: &[&str] = &["attitude"];
const MAGNETIC: &[&str] = &["magnet", "unit's own heading"];

/// All kinds of faults.
#[rustfmt::skip]
pub const CATALOGUE: [Entry; 42] = [
    entry(Kind::Vibration, "vibration", (Number(0.0, 4.0, 20.0), "×"), Throughout,
        "the vibration in rates and forces (above about 2 Hz) is multiplied by this factor: above 1 the log's own vibration from 2 to 10 s earlier is added, below 1 a part is removed", &["vibrat", "shak"]),
    entry(Kind::ClipAccel, "clip-accel", (Number(0.1, 2.0, 100.0), "g"), Throughout,
        "accelerometers saturate at this range", CLIPPED),
    entry(Kind::ClipGyro, "clip-gyro", (Number(1.0, 100.0, 5000.0), "°/s"), Throughout,
        "gyros saturate at this range", CLIPPED),
    entry(Kind::ClipBurst, "clip-burst", (Number(0.1, 3.0, 100.0), "g"), For(0.3),
        "a tone of 1.2 times this range is added to every accelerometer, which saturates at the range", &["full scale", "saturat", "clipp", "shak", "shock"]),
    entry(Kind::Stuck, "stuck", (Words(STUCK), ""), For(1.0),
        "the inertial unit, a triad or an axis repeats its last value", &["stuck", "repeat"]),
    entry(Kind::Gap, "gap", (Number(0.01, 2.0, 600.0), "s"), ItsValue,
        "no inertial samples", &["gap"]),
    entry(Kind::Interpolated, "interpolated", (Number(0.01, 1.5, 600.0), "s"), ItsValue,
        "inertial samples are interpolated linearly, as by a logger that fills gaps", &["straight line"]),
    entry(Kind::PacketLoss, "packet-loss", (Number(0.0, 25.0, 95.0), "%"), Throughout,
        "this percentage of the inertial samples is lost at random", &["gap", "lost", "missing"]),
    entry(Kind::Jitter, "jitter", (Number(0.0, 3.0, 1000.0), "ms"), Throughout,
        "time stamps of inertial samples scatter by this, one-sigma, and stay in order", &["jitter", "time stamps"]),
    entry(Kind::GyroBias, "gyro-bias", (Number(0.0, 0.5, 100.0), "°/s"), Onwards,
        "gyro bias jumps by this, in any direction", &["bias+gyro"]),
    entry(Kind::AccelBias, "accel-bias", (Number(0.0, 0.3, 50.0), "m/s²"), Onwards,
        "accelerometer bias jumps by this, in any direction", &["bias+accelerometer"]),
    entry(Kind::AccelScale, "accel-scale", (Number(0.1, 0.5, 10.0), "×"), Throughout,
        "accelerometers are multiplied by this factor, as with a wrong range", &["specific force is"]),
    entry(Kind::AccelSign, "accel-sign", (Words(SIGNS), ""), Throughout,
        "accelerometers of wrong sign", ACCEL_SIGN),
    entry(Kind::GyroSign, "gyro-sign", (Words(SIGNS), ""), Throughout,
        "gyros of wrong sign", GYRO_SIGN),
    entry(Kind::SwapAxes, "swap-axes", (Words(PAIRS), ""), Throughout,
        "two axes of the inertial unit swapped, gyros and accelerometers", AXES),
    entry(Kind::Unit, "unit", (Words(&["g", "degps"]), ""), Throughout,
        "accelerations in g, or rates in °/s", &["accelerations in g", "in °/s", "beyond any"]),
    entry(Kind::GpsTime, "gps-time", (Number(-5.0, 0.15, 5.0), "s"), Throughout,
        "time stamps of fixes are late by this, early where negative", &["time offset", "latency"]),
    entry(Kind::Outage, "outage", (Number(0.1, 30.0, 3600.0), "s"), ItsValue,
        "no fixes", &["outage"]),
    entry(Kind::GlitchStep, "glitch-step", (Number(0.0, 60.0, 1e5), "m"), For(15.0),
        "position displaced horizontally, in any direction; velocity unchanged", GLITCH),
    entry(Kind::GlitchRamp, "glitch-ramp", (Number(0.0, 1.0, 1e3), "m/s"), For(30.0),
        "position drifts horizontally and returns at the end; velocity unchanged", GLITCH),
    entry(Kind::GlitchFollow, "glitch-follow", (Number(0.0, 5.0, 1e3), "m/s"), For(12.0),
        "position moves away horizontally and back, with the corresponding velocity", GLITCH),
    entry(Kind::FrozenFix, "frozen-fix", (Values::None, ""), For(20.0),
        "position and velocity repeat the last fix", &["gps+frozen"]),
    entry(Kind::GpsGarbage, "gps-garbage", (Number(0.0, 40.0, 1e4), "m"), For(60.0),
        "position, height and velocity are random with unchanged reported accuracies: one sigma of this north and east, 2.5 times this in height, a fifth of this per second north and east, three quarters of this per second down", GARBAGE),
    entry(Kind::NoVelocity, "no-velocity", (Values::None, ""), Throughout,
        "fixes have no velocity", &["velocity absent"]),
    entry(Kind::HeightHeld, "height-held", (Values::None, ""), For(60.0),
        "height repeats, as of a 2-D fix", &["height held"]),
    entry(Kind::HeightEmpty, "height-empty", (Values::None, ""), For(60.0),
        "fixes have no height", &["without a height", "without height", "coordinate is missing"]),
    entry(Kind::SwapLatLon, "swap-latlon", (Values::None, ""), Throughout,
        "latitude and longitude swapped", &["swapped"]),
    entry(Kind::Radians, "radians", (Values::None, ""), Throughout,
        "latitude and longitude in radians", &["radians"]),
    entry(Kind::MagHeading, "mag-heading", (Number(-180.0, 30.0, 180.0), "°"), For(60.0),
        "magnetic heading is wrong by this: the field and the inertial unit's own yaw are turned", MAGNETIC),
    entry(Kind::MagHeadingOnly, "mag-heading-only", (Number(-180.0, 30.0, 180.0), "°"), For(60.0),
        "as mag-heading, with the inertial unit's own yaw unchanged", MAGNETIC),
    entry(Kind::MagVector, "mag-vector", (Number(0.0, 0.2, 10.0), "gauss"), For(60.0),
        "a field of this strength along any body direction is added; the inertial unit's own yaw follows", MAGNETIC),
    entry(Kind::MagVectorOnly, "mag-vector-only", (Number(0.0, 0.2, 10.0), "gauss"), For(60.0),
        "as mag-vector, with the inertial unit's own yaw unchanged", MAGNETIC),
    entry(Kind::LeverArm, "lever-arm", (Number(0.0, 1.0, 50.0), "m"), Throughout,
        "dataset.toml has the antenna displaced by this, in any horizontal body direction", &["lever arm"]),
    entry(Kind::LeverSign, "lever-sign", (Values::None, ""), Throughout,
        "dataset.toml has the antenna's lever arm with the wrong sign", &["lever arm"]),
    entry(Kind::RangeStuck, "range-stuck", (Values::None, ""), For(20.0),
        "the rangefinder repeats its last distance", RANGE),
    entry(Kind::RangeOutliers, "range-outliers", (Number(0.0, 20.0, 100.0), "%"), For(60.0),
        "this percentage of the distances is random, up to twice the true distance", RANGE),
    entry(Kind::RangeStep, "range-step", (Number(-100.0, -3.0, 100.0), "m"), For(15.0),
        "distances are longer by this, shorter where negative, as over a pit or a roof", RANGE),
    entry(Kind::RangeGone, "range-gone", (Values::None, ""), For(30.0),
        "no distances", RANGE),
    entry(Kind::HeadingTurn, "heading-turn", (Number(-180.0, 180.0, 180.0), "°"), For(60.0),
        "the heading of two antennas is wrong by this", ANTENNAS),
    entry(Kind::HeadingGone, "heading-gone", (Values::None, ""), For(30.0),
        "no heading of two antennas", ANTENNAS),
    entry(Kind::AttitudeFrozen, "attitude-frozen", (Values::None, ""), For(30.0),
        "the inertial unit's own attitude repeats its last value", ATTITUDE),
    entry(Kind::AttitudeLate, "attitude-late", (Number(0.0, 0.3, 10.0), "s"), Throughout,
        "the inertial unit's own attitude is late by this", ATTITUDE),
];

impl Kind {
    /// Whether the fault is a wrong set-up, which no filter can correct: a warning must name it.
    #[must_use]
    pub fn is_wrong_setup(self) -> bool {
        use Kind::{AccelScale, AccelSign, GyroSign, Radians, SwapAxes, SwapLatLon, Unit};
        matches!(self, AccelScale | AccelSign | GyroSign | SwapAxes | Unit | SwapLatLon | Radians)
    }

    /// Its catalogue entry.
    #[must_use]
    pub fn entry(self) -> &'static Entry {
        // The catalogue is in the order of the kinds; a test checks it.
        &CATALOGUE[self as usize]
    }
}

/// The table of faults, as text.
#[must_use]
pub fn list() -> String {
    let mut text = String::new();
    let _ = writeln!(text, "{:<18} {:<24} {:<12} effect", "fault", "value", "lasts");
    for Entry { name, values, unit, lasts, does, .. } in &CATALOGUE {
        let values = match values {
            Number(low, default, high) => format!("{low}…{high} {unit} ({default})"),
            Words(words) => words.join("|"),
            Values::None => String::new(),
        };
        let lasts = match lasts {
            Throughout => "throughout".into(),
            Onwards => "onwards".into(),
            For(seconds) => format!("{seconds} s"),
            ItsValue => "its value".into(),
        };
        let _ = writeln!(text, "{name:<18} {values:<24} {lasts:<12} {does}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_catalogue_is_in_the_order_of_the_kinds() {
        for (place, entry) in CATALOGUE.iter().enumerate() {
            assert_eq!(entry.kind as usize, place);
            assert_eq!(entry.kind.entry().name, entry.name);
        }
    }
}
