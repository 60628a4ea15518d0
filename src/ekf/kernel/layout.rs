//! Error states of a filter, chosen by type: an absent state costs nothing.
//!
//! Every layout has the first fifteen states, three each:
//!
//! - attitude ψ, rad, NED: the small rotation that takes the estimated to the true NED-resolved body axes
//! - velocity δv, m/s, NED
//! - position δp, m, NED
//! - gyro bias δb_g, rad/s, body
//! - accelerometer bias δb_a, m/s², body
//!
//! All are true minus estimated. A layout appends blocks to them and pads to an even length, so that rows fill the
//! processor's vector registers.

/// Index of the first attitude error.
pub const ATTITUDE: usize = 0;
/// Index of the first velocity error.
pub const VELOCITY: usize = 3;
/// Index of the first position error.
pub const POSITION: usize = 6;
/// Index of the first gyro bias error.
pub const GYRO_BIAS: usize = 9;
/// Index of the first accelerometer bias error.
pub const ACCEL_BIAS: usize = 12;
/// Number of states common to all layouts.
pub const BASE: usize = 15;

/// A set of error states; `N` is the padded length of its state vector, even.
///
/// Sealed: the layouts are those of this module. A layout must have an even `N`, and blocks that overlap neither each
/// other nor the base and end within `N`. Otherwise its filter does not compile.
pub trait Layout<const N: usize>:
    Copy + Default + core::fmt::Debug + Send + Sync + sealed::Sealed + 'static
{
    /// Index of the correlated error of the GPS position, m, north, then east and down. `None` if the layout has no
    /// such states.
    const GPS_POSITION: Option<usize> = None;
    /// Index of the correlated error of the GPS velocity, m/s, north, then east and down. `None` if the layout has no
    /// such states.
    const GPS_VELOCITY: Option<usize> = None;
    /// Index of the slow error of an attitude reference, rad, about north, then east and down. `None` if the layout has
    /// no such states.
    const ATTITUDE_REFERENCE: Option<usize> = None;
    /// Index of the additional age of the GPS position relative to the velocity of the same fix, s. `None` if the
    /// layout has no such state. Receivers derive velocity from the displacement since the previous fix, or smooth it,
    /// so the two are valid at different times.
    const LATENCY: Option<usize> = None;
    /// Index of the slow error of the barometric height, m; `None` if the layout has no such state.
    const BARO: Option<usize> = None;
    /// Index of the age of a fix at its time stamp, beyond the declared latency, s. `None` if the layout has no such
    /// state.
    const GPS_DELAY: Option<usize> = None;
    /// Index of the error of the ground height below the vehicle, m, up; `None` if the layout has no such state. A
    /// rangefinder needs this state.
    const GROUND: Option<usize> = None;
    /// Whether the filter assumes, while fixes are absent, that a vehicle on wheels moves only along its road.
    const WHEELS: bool = false;
}

mod sealed {
    pub trait Sealed {}
}

/// Whether a layout follows the rules of [`Layout`].
#[allow(clippy::indexing_slicing, reason = "evaluated by the compiler, where a panic is an error")]
pub(in crate::ekf) const fn is_sound<L: Layout<N>, const N: usize>() -> bool {
    let blocks = [
        (L::GPS_POSITION, 3),
        (L::GPS_VELOCITY, 3),
        (L::ATTITUDE_REFERENCE, 3),
        (L::LATENCY, 1),
        (L::BARO, 1),
        (L::GPS_DELAY, 1),
        (L::GROUND, 1),
    ];
    let mut taken = [false; N];
    let mut block = 0;
    // Iterations: one a block; while the program is built.
    while block < blocks.len() {
        if let (Some(first), length) = blocks[block] {
            let mut state = first;
            // Iterations: at most three, the states of a block; while the program is built.
            while state < first + length {
                if state < BASE || state >= N || taken[state] {
                    return false;
                }
                taken[state] = true;
                state += 1;
            }
        }
        block += 1;
    }
    N > BASE && N.is_multiple_of(2)
}

macro_rules! layout {
    ($(#[$doc:meta])* $name:ident, $n:literal $(, $block:ident = $first:literal)* $(; $flag:ident)?) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub struct $name;
        impl sealed::Sealed for $name {}
        impl Layout<$n> for $name {
            $(const $block: Option<usize> = Some($first);)*
            $(const $flag: bool = true;)?
        }
    };
}

layout! {
    /// Layout of the fifteen base states alone.
    Base, 16
}

layout! {
    /// The layout of the command line. In addition to the base, it has the slow errors of GPS, attitude reference and
    /// barometer. It also has the latency between GPS position and velocity, the delay of both, the ground height, and
    /// the wheel constraint.
    Full, 28, GPS_POSITION = 15, GPS_VELOCITY = 18, ATTITUDE_REFERENCE = 21, LATENCY = 24, BARO = 25, GPS_DELAY = 26,
    GROUND = 27; WHEELS
}

layout! {
    /// [`Full`] without the states of barometer and rangefinder, for vehicles with neither; a filter with it rejects
    /// their readings. All other results equal those of [`Full`] to the bit. It saves 2 % of the time of a sample, 6 %
    /// of a fix and 7 % of an attitude.
    WithoutHeightAids, 26, GPS_POSITION = 15, GPS_VELOCITY = 18, ATTITUDE_REFERENCE = 21, LATENCY = 24, GPS_DELAY = 25
}

#[cfg(test)]
mod tests {
    use super::*;

    layout!(Odd, 17, BARO = 15);
    layout!(Overlapping, 22, ATTITUDE_REFERENCE = 15, GPS_POSITION = 17);
    layout!(OverBase, 18, GPS_VELOCITY = 13);
    layout!(BeyondEnd, 16, GPS_POSITION = 15);
    layout!(WithoutPadding, 18, GPS_POSITION = 15);

    #[test]
    fn a_layout_has_an_even_length_and_blocks_of_its_own_within_it() {
        assert!(is_sound::<Base, 16>());
        assert!(is_sound::<Full, 28>() && is_sound::<WithoutPadding, 18>());
        assert!(!is_sound::<Odd, 17>());
        assert!(!is_sound::<Overlapping, 22>());
        assert!(!is_sound::<OverBase, 18>());
        assert!(!is_sound::<BeyondEnd, 16>());
    }
}
