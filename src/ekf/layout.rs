//! Which error states a filter carries, chosen by type: what is absent costs nothing.
//!
//! The first fifteen are always there, three each: attitude ψ (rad, NED: the small rotation that
//! takes the estimated to the true NED-resolved body axes), velocity δv (m/s, NED), position δp (m,
//! NED), gyro bias δb_g (rad/s, body) and accelerometer bias δb_a (m/s², body). All are true less
//! estimated. A layout appends blocks to them and pads to an even length, so that rows fill the
//! processor's vector registers.

/// Where attitude errors start.
pub const ATTITUDE: usize = 0;
/// Where velocity errors start.
pub const VELOCITY: usize = 3;
/// Where position errors start.
pub const POSITION: usize = 6;
/// Where gyro bias errors start.
pub const GYRO_BIAS: usize = 9;
/// Where accelerometer bias errors start.
pub const ACCEL_BIAS: usize = 12;
/// How many states every layout has.
pub const BASE: usize = 15;

/// A set of error states; `N` is the padded length of its state vector.
pub trait Layout<const N: usize>:
    Copy + Default + core::fmt::Debug + Send + Sync + 'static
{
    /// Scale factor errors of the three gyros.
    const GYRO_SCALE: Option<usize> = None;
    /// Scale factor errors of the three accelerometers.
    const ACCEL_SCALE: Option<usize> = None;
    /// Correlated error of the GPS position, m, north, east, down.
    const GPS_POSITION: Option<usize> = None;
    /// Correlated error of the GPS velocity, m/s, north, east, down.
    const GPS_VELOCITY: Option<usize> = None;
    /// Slowly wandering error of an attitude reference, rad, about north, east, down.
    const ATTITUDE_REFERENCE: Option<usize> = None;
    /// How much later the GPS position holds than the velocity of the same fix, s. Receivers take
    /// velocity from the way since the fix before, or smooth it, so the two hold at different times.
    const LATENCY: Option<usize> = None;
    /// Slowly wandering error of the barometric height, m.
    const BARO: Option<usize> = None;
}

/// The fifteen base states.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Base;

impl Layout<16> for Base {}

/// The base and the scale factors of gyros and accelerometers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WithScaleFactors;

impl Layout<22> for WithScaleFactors {
    const GYRO_SCALE: Option<usize> = Some(15);
    const ACCEL_SCALE: Option<usize> = Some(18);
}

/// What the command line runs: the base, the slow errors of GPS, attitude reference and barometer,
/// and the latency between GPS position and velocity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Full;

impl Layout<26> for Full {
    const GPS_POSITION: Option<usize> = Some(15);
    const GPS_VELOCITY: Option<usize> = Some(18);
    const ATTITUDE_REFERENCE: Option<usize> = Some(21);
    const LATENCY: Option<usize> = Some(24);
    const BARO: Option<usize> = Some(25);
}
