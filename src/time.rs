//! Time on the common clock of a flight, in whole nanoseconds.
//!
//! Integer time gives the same bits in a replay, compares exactly, and has the same resolution after any uptime. Only
//! differences are floating point.

use core::fmt;
use core::num::NonZeroU64;
use core::ops::{Add, Sub};

use crate::scalar::Scalar;

/// A moment on the clock of a data set or a flight, in nanoseconds since that clock's zero.
///
/// The range is ±292 years. The zero is that of the log or the flight: only differences have a meaning.
///
/// ```
/// use hovernav::time::Time;
/// let start = Time::from_seconds(1.25);
/// let end = Time::from_nanoseconds(1_500_000_000);
/// assert_eq!(end - start, 0.25);
/// ```
///
/// `Option<Time>` takes no more memory than `Time`. The estimator holds many of them. The earliest 64-bit number is
/// therefore not a valid time.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Time(NonZeroU64);

/// Sign bit. Toggling this bit maps the order of signed numbers to that of unsigned numbers.
const SIGN: u64 = 1 << 63;

impl Time {
    /// The clock's zero.
    pub const ZERO: Self = Self::from_nanoseconds(0);
    /// Earlier than every other time.
    pub(crate) const NEVER: Self = Self::from_nanoseconds(i64::MIN);

    /// The moment `nanoseconds` after the clock's zero. `i64::MIN` is not a valid time and is replaced by `i64::MIN +
    /// 1`.
    #[must_use]
    #[inline]
    pub const fn from_nanoseconds(nanoseconds: i64) -> Self {
        Self(match NonZeroU64::new(nanoseconds as u64 ^ SIGN) {
            Some(shifted) => shifted,
            None => NonZeroU64::MIN,
        })
    }

    /// The moment `seconds` after the clock's zero, to the nearest nanosecond.
    ///
    /// Saturates beyond ±9.2e9 s; a NaN gives the clock's zero. Filter and alignment reject and report measurements
    /// with such times. Use [`try_from_seconds`](Self::try_from_seconds) for times from files and users.
    #[must_use]
    pub const fn from_seconds(seconds: f64) -> Self {
        let nanoseconds = seconds * 1e9;
        let whole = nanoseconds as i64;
        // The difference is exact, because a number with a fractional part has fewer than 53 bits before the point.
        let rest = nanoseconds - whole as f64;
        Self::from_nanoseconds(if rest >= 0.5 {
            whole.saturating_add(1)
        } else if rest <= -0.5 {
            whole.saturating_sub(1)
        } else {
            whole
        })
    }

    /// The moment `seconds` after the clock's zero, as [`from_seconds`](Self::from_seconds), but `None` if `seconds` is
    /// not finite or beyond ±9.2e9 s.
    #[must_use]
    pub fn try_from_seconds(seconds: f64) -> Option<Self> {
        let nanoseconds = libm::round(seconds * 1e9);
        (nanoseconds.is_finite() && libm::fabs(nanoseconds) < 9.2e18)
            .then(|| Self::from_nanoseconds(nanoseconds as i64))
    }

    /// Nanoseconds since the clock's zero.
    #[must_use]
    #[inline]
    pub const fn nanoseconds(self) -> i64 {
        (self.0.get() ^ SIGN) as i64
    }

    /// Seconds since the clock's zero, correctly rounded within ±104 days of the zero: 15 s gives 15.0.
    #[must_use]
    pub fn seconds(self) -> f64 {
        f64::of_nanoseconds(self.nanoseconds())
    }

    /// Seconds since `earlier`, in any number type; negative if `earlier` is later.
    #[must_use]
    #[inline]
    pub fn seconds_since<T: Scalar>(self, earlier: Self) -> T {
        T::of_nanoseconds(self.nanoseconds().saturating_sub(earlier.nanoseconds()))
    }

    /// This moment shifted by `seconds`, which may be negative. Saturates at the ends of the range; a NaN shifts by
    /// 0.
    #[must_use]
    pub fn offset_by(self, seconds: impl Scalar) -> Self {
        Self::from_nanoseconds(self.nanoseconds().saturating_add(seconds.to_nanoseconds()))
    }
}

impl Default for Time {
    /// The clock's zero, [`Time::ZERO`].
    fn default() -> Self {
        Self::ZERO
    }
}

impl fmt::Debug for Time {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Time").field(&self.nanoseconds()).finish()
    }
}

impl Sub for Time {
    type Output = f64;

    /// Seconds from `earlier` to `self`; negative if `earlier` is later.
    fn sub(self, earlier: Self) -> f64 {
        self.seconds_since(earlier)
    }
}

impl Add<f64> for Time {
    type Output = Self;

    /// This moment shifted by `seconds`: see [`Time::offset_by`].
    fn add(self, seconds: f64) -> Self {
        self.offset_by(seconds)
    }
}

impl fmt::Display for Time {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.6} s", self.seconds())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_option_takes_no_more_memory_and_the_order_is_that_of_the_numbers() {
        assert_eq!(size_of::<Option<Time>>(), size_of::<Time>());
        let numbers = [i64::MIN + 1, -1, 0, 1, i64::MAX];
        assert!(numbers.map(Time::from_nanoseconds).is_sorted());
        assert_eq!(numbers.map(|n| Time::from_nanoseconds(n).nanoseconds()), numbers);
        assert_eq!(Time::from_nanoseconds(i64::MIN).nanoseconds(), i64::MIN + 1);
    }

    #[test]
    fn seconds_survive_a_round_trip_to_the_nanosecond() {
        for nanoseconds in [0, 1, -1, 30_303_030, 299_989_390_000, -86_400_000_000_001] {
            let time = Time::from_nanoseconds(nanoseconds);
            assert_eq!(Time::from_seconds(time.seconds()), time);
            assert_eq!(Time::try_from_seconds(time.seconds()), Some(time));
        }
    }

    #[test]
    fn seconds_round_to_the_nearest_nanosecond_in_both_constructors() {
        const AT_BUILD: Time = Time::from_seconds(0.25);
        assert_eq!(AT_BUILD.nanoseconds(), 250_000_000);
        let halves = (-3_i32..=3).map(|half| f64::from(half) * 0.5e-9);
        let others = [1e-9 / 3.0, -1e-9 / 3.0, 4.999_999_999_999_999e-10, 123_456.789_012_345, 9e9];
        for seconds in halves.chain(others) {
            assert_eq!(Some(Time::from_seconds(seconds)), Time::try_from_seconds(seconds));
        }
    }

    #[test]
    fn whole_seconds_are_whole() {
        assert!(
            (0..10_000).all(|s| Time::from_nanoseconds(s * 1_000_000_000).seconds() == s as f64)
        );
    }

    #[test]
    fn what_is_not_a_time_is_refused() {
        for seconds in [f64::NAN, f64::INFINITY, -1e300, 1e10] {
            assert_eq!(Time::try_from_seconds(seconds), None);
        }
    }

    #[test]
    fn the_ends_of_the_range_saturate() {
        let last = Time::from_nanoseconds(i64::MAX);
        assert_eq!(last + 1e12, last);
        assert!((last - Time::from_nanoseconds(i64::MIN)).is_finite());
        assert_eq!(Time::ZERO + f64::NAN, Time::ZERO);
        assert_eq!(Time::from_seconds(f64::INFINITY), last);
        assert_eq!(Time::from_seconds(-1e300), Time::from_nanoseconds(i64::MIN));
        assert_eq!(Time::from_seconds(f64::NAN), Time::ZERO);
    }
}
