//! The number type of the filter's arithmetic: `f64`, or `f32` for processors without double precision.

use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// `f32` or `f64`: the number type of vectors, rotations and covariances. Geographic positions and times are exact with
/// both types, because they are `f64` and whole nanoseconds.
pub trait Scalar:
    Copy
    + PartialOrd
    + core::fmt::Debug
    + Default
    + Send
    + Sync
    + 'static
    + sealed::Sealed
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
{
    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;
    /// The largest finite number.
    const MAX: Self;
    /// Largest ratio, √(1/ε), of the state's variance to the measurement's variance for the short form of the
    /// covariance update. Above this ratio the short form loses half of the digits.
    const MAX_INFORMATION: Self;
    /// The nearest number of this type.
    fn of(value: f64) -> Self;
    /// The number as `f64`.
    fn wide(self) -> f64;
    /// Converts nanoseconds to seconds.
    fn of_nanoseconds(nanoseconds: i64) -> Self;
    /// Converts seconds to whole nanoseconds, rounded to nearest. Saturates; NaN gives 0.
    fn to_nanoseconds(self) -> i64;
    /// Square root, the nearest number of this type.
    fn sqrt(self) -> Self;
    /// Sine and cosine of an angle, rad.
    fn sincos(self) -> (Self, Self);
    /// The angle of the point (`x`, `self`), rad, in [−π, π].
    fn atan2(self, x: Self) -> Self;
    /// Arc sine of the number, rad, in [−π/2, π/2]; NaN beyond ±1.
    fn asin(self) -> Self;
    /// Length √(x² + y²) of the hypotenuse, to two units in the last place. Infinite where the squares are infinite:
    /// from 1e154 on (1e19 in single precision).
    fn hypot(self, other: Self) -> Self;
    /// Exponential function of this number.
    fn exp(self) -> Self;
    /// Natural logarithm of this number.
    fn ln(self) -> Self;
    /// The absolute value.
    fn abs(self) -> Self;
    /// The magnitude of this number with the sign of `sign`.
    fn copysign(self, sign: Self) -> Self;
    /// The greater of two numbers; if one is NaN, the other number.
    fn max(self, other: Self) -> Self;
    /// The smaller of two numbers; if one is NaN, the other number.
    fn min(self, other: Self) -> Self;
    /// Whether the number is neither infinite nor NaN.
    fn is_finite(self) -> bool;
}

/// A number formatted for messages: with an exponent beyond 1e9 and below 1e-6, in plain digits otherwise. 1e300 thus
/// has one digit, not 301.
///
/// ```
/// use hovernav::scalar::Readable;
/// let told = [0.0, -1.5, f64::NAN, 1e300, 2e-9].map(|number| Readable(number).to_string());
/// assert_eq!(told, ["0", "-1.5", "NaN", "1e300", "2e-9"]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Readable(pub f64);

impl core::fmt::Display for Readable {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self.0 {
            number if number == 0.0 || !number.is_finite() => core::fmt::Display::fmt(&number, f),
            number if (1e-6..1e9).contains(&libm::fabs(number)) => {
                core::fmt::Display::fmt(&number, f)
            }
            number => core::fmt::LowerExp::fmt(&number, f),
        }
    }
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

macro_rules! scalar {
    ($T:ident, $most_information:literal, $sqrt:path, $sincos:path, $atan2:ident, $asin:ident, $exp:ident, $ln:ident, $round:ident) => {
        impl Scalar for $T {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const MAX: Self = $T::MAX;
            const MAX_INFORMATION: Self = $most_information;
            #[inline(always)]
            fn of(value: f64) -> Self {
                value as Self
            }
            #[inline(always)]
            fn wide(self) -> f64 {
                self.into()
            }
            #[inline(always)]
            fn of_nanoseconds(nanoseconds: i64) -> Self {
                // 1e9 is exact in binary, 1e-9 is not.
                nanoseconds as Self / 1e9
            }
            #[inline(always)]
            fn to_nanoseconds(self) -> i64 {
                libm::$round(self * 1e9) as i64
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                $sqrt(self)
            }
            #[inline(always)]
            fn sincos(self) -> (Self, Self) {
                $sincos(self)
            }
            #[inline(always)]
            fn atan2(self, x: Self) -> Self {
                libm::$atan2(self, x)
            }
            #[inline(always)]
            fn asin(self) -> Self {
                libm::$asin(self)
            }
            #[inline(always)]
            fn hypot(self, other: Self) -> Self {
                $sqrt(self * self + other * other)
            }
            #[inline(always)]
            fn exp(self) -> Self {
                libm::$exp(self)
            }
            #[inline(always)]
            fn ln(self) -> Self {
                libm::$ln(self)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                $T::abs(self)
            }
            #[inline(always)]
            fn copysign(self, sign: Self) -> Self {
                $T::copysign(self, sign)
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                $T::max(self, other)
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                $T::min(self, other)
            }
            #[inline(always)]
            fn is_finite(self) -> bool {
                $T::is_finite(self)
            }
        }
    };
}

/// Conversion to single precision, for quantities whose own errors are larger than its rounding.
pub(crate) fn single<T: Scalar>(value: T) -> f32 {
    value.wide() as f32
}

/// Square root by the double-precision routine, which the program contains anyway.
pub(crate) fn root(of: f32) -> f32 {
    Scalar::sqrt(f64::from(of)) as f32
}

scalar!(f32, 2896.0, sqrt_single, sincos_single, atan2f, asinf, expf, logf, roundf);
scalar!(f64, 67_108_864.0, sqrt_double, sincos_double, atan2, asin, exp, log, round);

/// Square root by the SSE2 intrinsic; the bits are those of `libm`. `libm` uses an SSE instruction in every build. A
/// build with `target-cpu=native` uses wide vectors. There this instruction waits for all lanes of the vector, and a
/// fix takes 1.5 times as long.
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
#[inline(always)]
fn sqrt_double(of: f64) -> f64 {
    use safe_arch::{get_f64_from_m128d_s, set_m128d_s, sqrt_m128d_s};
    let of = set_m128d_s(of);
    get_f64_from_m128d_s(sqrt_m128d_s(of, of))
}

/// Square root in single precision; see [`sqrt_double`].
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
#[inline(always)]
fn sqrt_single(of: f32) -> f32 {
    use safe_arch::{get_f32_from_m128_s, set_m128_s, sqrt_m128_s};
    get_f32_from_m128_s(sqrt_m128_s(set_m128_s(of)))
}

#[cfg(not(all(target_arch = "x86_64", target_feature = "sse2")))]
use libm::{sqrt as sqrt_double, sqrtf as sqrt_single};

/// Largest angle, rad, whose reduction subtracts multiples of π/2, split into several constants. Larger angles are
/// first reduced by 2π and lose digits; attitudes never have such angles.
const REDUCED_RAD: f64 = 1e5;
/// Largest angle, rad, for this reduction in single precision, where the constants of π/2 are shorter.
const REDUCED_SINGLE_RAD: f32 = 1e3;

/// Sine and cosine, accurate to 2.5e-16 up to 1e5 rad, without a table of digits of π. The functions of `libm` contain
/// a table of 3.4 kB for angles up to 1e308, and take four times as long. NaN and infinities give NaN.
///
/// # Source
/// W. J. Cody and W. Waite (1980), *Software Manual for the Elementary Functions*, chapter 8 (reduction by constants
/// that add up to π/2). The coefficients and the constants of π/2 are those of fdlibm (Sun Microsystems, 1993),
/// `k_sin.c`, `k_cos.c` and `e_rem_pio2.c`.
fn sincos_double(angle_rad: f64) -> (f64, f64) {
    // Written so that a NaN also takes the second branch.
    let small = libm::fabs(angle_rad) <= REDUCED_RAD;
    let angle_rad =
        if small { angle_rad } else { libm::remainder(angle_rad, core::f64::consts::TAU) };
    // Adding this large number rounds the quotient to a whole number.
    let quarters = (angle_rad * core::f64::consts::FRAC_2_PI + 6_755_399_441_055_744.0)
        - 6_755_399_441_055_744.0;
    // π/2 is the sum of several constants; the first constants have few digits, so that their products are exact.
    let rest = angle_rad
        - quarters * 1.570_796_326_734_125_6
        - quarters * 6.077_100_506_303_966e-11
        - quarters * 2.022_266_248_795_950_6e-21;
    let square = rest * rest;
    let sine = rest
        + rest
            * square
            * (-1.666_666_666_666_663_2e-1
                + square
                    * (8.333_333_333_322_49e-3
                        + square
                            * (-1.984_126_982_985_795e-4
                                + square
                                    * (2.755_731_370_707_007e-6
                                        + square
                                            * (-2.505_076_025_340_686_3e-8
                                                + square * 1.589_690_995_211_55e-10)))));
    let fourth = square
        * square
        * (4.166_666_666_666_66e-2
            + square
                * (-1.388_888_888_887_411e-3
                    + square
                        * (2.480_158_728_947_673e-5
                            + square
                                * (-2.755_731_435_139_066_3e-7
                                    + square
                                        * (2.087_572_321_298_175e-9
                                            + square * -1.135_964_755_778_819_5e-11)))));
    let half = 0.5 * square;
    let most = 1.0 - half;
    let cosine = most + ((1.0 - most - half) + fourth);
    of_quarter(quarters as i32, sine, cosine)
}

/// Sine and cosine, accurate to 1e-7, in single precision only, for processors without double precision.
///
/// # Source
/// As [`sincos_double`]; the coefficients are those of S. L. Moshier, *Methods and Programs for Mathematical
/// Functions* (1989), for single precision.
fn sincos_single(angle_rad: f32) -> (f32, f32) {
    let small = angle_rad.abs() <= REDUCED_SINGLE_RAD;
    if !small {
        let (sine, cosine) = sincos_double(angle_rad.into());
        return (sine as f32, cosine as f32);
    }
    let quarters = (angle_rad * core::f32::consts::FRAC_2_PI + 12_582_912.0) - 12_582_912.0;
    let rest =
        angle_rad - quarters * 1.570_312_5 - quarters * 4.837_513e-4 - quarters * 7.549_789_4e-8;
    let square = rest * rest;
    let sine = rest
        + rest * square * (-1.666_665_5e-1 + square * (8.332_161e-3 - square * 1.951_529_6e-4));
    let cosine = 1.0 - 0.5 * square
        + square * square * (4.166_664_6e-2 + square * (-1.388_731_6e-3 + square * 2.443_315_7e-5));
    of_quarter(quarters as i32, sine, cosine)
}

/// Sine and cosine of the angle plus `quarters` quarter turns.
fn of_quarter<T: Scalar>(quarters: i32, sine: T, cosine: T) -> (T, T) {
    match quarters & 3 {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_in_single_precision_are_right_to_its_last_digits() {
        let mut worst = 0.0f64;
        for k in -200_000..=200_000 {
            let angle = k as f32 * 0.005_1;
            let (sine, cosine) = angle.sincos();
            let (exact_sine, exact_cosine) = f64::from(angle).sin_cos();
            let off = (sine.wide() - exact_sine).abs().max((cosine.wide() - exact_cosine).abs());
            worst = worst.max(off);
        }
        assert!(worst < 1e-7, "{worst:e}");
    }

    #[test]
    fn sine_and_cosine_are_right_to_their_last_digits() {
        let off = |angle: f64| {
            let (sine, cosine) = Scalar::sincos(angle);
            let (exact_sine, exact_cosine) = libm::sincos(angle);
            (sine - exact_sine).abs().max((cosine - exact_cosine).abs())
        };
        let quarter = core::f64::consts::FRAC_PI_2;
        for k in -200_000i32..=200_000 {
            let angle = f64::from(k);
            for angle in [angle * 1e-5, angle * 0.499_7, f64::from(k % 60_000) * quarter] {
                assert!(off(angle) < 2.5e-16, "{angle}: {:e}", off(angle));
            }
        }
        assert!(off(1e-300) == 0.0 && off(1e6) < 1e-9);
    }

    #[test]
    fn square_roots_are_those_of_libm_to_the_bit() {
        let mut bits = 0x9E37_79B9_7F4A_7C15u64;
        for _ in 0..100_000 {
            bits ^= bits << 13;
            bits ^= bits >> 7;
            bits ^= bits << 17;
            let (double, single) = (f64::from_bits(bits), f32::from_bits(bits as u32));
            for of in [double, double.abs()] {
                let (root, expected) = (Scalar::sqrt(of), libm::sqrt(of));
                assert!(root.to_bits() == expected.to_bits() || root.is_nan() && expected.is_nan());
            }
            for of in [single, single.abs()] {
                let (root, expected) = (Scalar::sqrt(of), libm::sqrtf(of));
                assert!(root.to_bits() == expected.to_bits() || root.is_nan() && expected.is_nan());
            }
        }
        for of in [0.0, -0.0, f64::INFINITY, f64::MIN_POSITIVE, 5e-324, f64::MAX] {
            assert_eq!(Scalar::sqrt(of).to_bits(), libm::sqrt(of).to_bits());
        }
        assert!(Scalar::sqrt(-1.0f64).is_nan() && Scalar::sqrt(f64::NAN).is_nan());
    }

    #[test]
    fn a_hypotenuse_is_right_to_its_last_digits_and_infinite_where_its_square_is() {
        for k in 0..10_000 {
            let (x, y) = (f64::from(k) * 0.37 - 900.0, 1e3 / (1.0 + f64::from(k)));
            let exact = libm::hypot(x, y);
            assert!((Scalar::hypot(x, y) - exact).abs() <= 2.0 * f64::EPSILON * exact);
        }
        assert_eq!(Scalar::hypot(-3.0f32, 4.0), 5.0);
        assert_eq!(Scalar::hypot(1e200, 1.0), f64::INFINITY);
        assert!(Scalar::hypot(f64::NAN, f64::INFINITY).is_nan());
    }

    #[test]
    fn what_is_no_angle_has_no_sine() {
        for angle in [f64::NAN, f64::NEG_INFINITY] {
            let (sine, cosine) = Scalar::sincos(angle);
            assert!(sine.is_nan() && cosine.is_nan());
        }
        for angle in [f32::NAN, f32::INFINITY] {
            let (sine, cosine) = angle.sincos();
            assert!(sine.is_nan() && cosine.is_nan());
        }
        assert_eq!((-0.0f32).sincos(), (0.0, 1.0));
    }
}
