//! Whether the vehicle stands still, by its samples and fixes.

use super::MeanRates;
use crate::frames::{Body, Vector};
use crate::scalar::Scalar;
use crate::time::Time;

/// Watches for rest: seconds in which nothing shakes, nothing changes and no fix moves.
///
/// An engine, a rotor or a road shakes a unit by more than 0.1 m/s²; a vehicle that is carried, or floats,
/// turns by more than its gyros' noise. Where the fixes have no velocity there is no rest.
#[derive(Clone, Copy, Debug)]
pub struct Rest<T = f64> {
    second: Second<T>,
    /// Means of the second before, where that was still.
    before: Option<[T; AXES]>,
    /// Mean velocity of the fixes of late, north and east, m/s, and when the last came.
    fixes: Option<(Time, [f64; 2])>,
    /// Whether the last second was one of rest.
    rests: bool,
    /// Whether the last sample ended the second after a rest.
    moves_off: bool,
}

/// Rates, then forces.
const AXES: usize = 6;

/// Largest standard deviations of a unit at rest: gyros, rad/s, and accelerometers, m/s².
const STILL_RADPS: f64 = 0.012;
const STILL_MPS2: f64 = 0.1;
/// Largest change of the means from one second to the next, likewise.
const STEADY_RADPS: f64 = 0.005;
const STEADY_MPS2: f64 = 0.05;
/// No gyro bias is larger than this, rad/s; what turns faster is no vehicle at rest.
const LARGEST_BIAS_RADPS: f64 = 0.05;
/// Fixes of a vehicle at rest have a speed below this, m/s, and a mean below that.
const FIX_MPS: f64 = 0.5;
const FIX_MEAN_MPS: f64 = 0.15;
/// Memory of that mean, s.
const FIX_MEMORY_S: f64 = 5.0;
/// A fix counts for so long, s.
const FIX_S: f64 = 3.0;
/// Samples further apart than this, s, tell nothing of what was between them.
const LONGEST_INTERVAL_S: f64 = 0.1;

/// Sums over the second under way, of what exceeds its first sample.
#[derive(Clone, Copy, Debug)]
struct Second<T> {
    length_s: T,
    count: T,
    first: [T; AXES],
    sum: [T; AXES],
    squares: [T; AXES],
}

impl<T: Scalar> Second<T> {
    const EMPTY: Self = Self {
        length_s: T::ZERO,
        count: T::ZERO,
        first: [T::ZERO; AXES],
        sum: [T::ZERO; AXES],
        squares: [T::ZERO; AXES],
    };

    fn add(&mut self, values: [T; AXES]) {
        if self.count == T::ZERO {
            self.first = values;
        }
        self.count += T::ONE;
        let sums = self.sum.iter_mut().zip(&mut self.squares).zip(self.first);
        for (((sum, square), first), value) in sums.zip(values) {
            let above = value - first;
            *sum += above;
            *square += above * above;
        }
    }

    /// Means, where no axis shook.
    fn still_means(&self) -> Option<[T; AXES]> {
        let mut means = self.first;
        let still: [T; AXES] = limits(STILL_RADPS, STILL_MPS2);
        let sums = self.sum.iter().zip(&self.squares).zip(still);
        for (mean, ((&sum, &squares), limit)) in means.iter_mut().zip(sums) {
            let above = sum / self.count;
            // Written so that a NaN is not still.
            let is_still = squares / self.count - above * above < limit * limit;
            if !is_still {
                return None;
            }
            *mean += above;
        }
        Some(means)
    }
}

/// Whether a level velocity, m/s, is faster than that. Without a root, which takes long where there is no instruction for it.
fn is_faster([north, east]: [f64; 2], mps: f64) -> bool {
    north * north + east * east > mps * mps
}

/// A limit for each axis.
fn limits<T: Scalar>(gyro: f64, accel: f64) -> [T; AXES] {
    let (gyro, accel) = (T::of(gyro), T::of(accel));
    [gyro, gyro, gyro, accel, accel, accel]
}

impl<T: Scalar> Rest<T> {
    /// Nothing seen yet.
    pub const NONE: Self =
        Self { second: Second::EMPTY, before: None, fixes: None, rests: false, moves_off: false };

    /// Takes in the horizontal velocity of a fix, north and east, m/s, or that it has none.
    pub fn fix(&mut self, time: Time, velocity_mps: Option<[f64; 2]>) {
        let Some(now) = velocity_mps else {
            self.fixes = None;
            return;
        };
        if is_faster(now, FIX_MPS) {
            self.fixes = None;
            return;
        }
        let Some((then, mean)) = &mut self.fixes else {
            self.fixes = Some((time, now));
            return;
        };
        let share = ((time - *then) / FIX_MEMORY_S).clamp(0.0, 1.0);
        for (mean, now) in mean.iter_mut().zip(now) {
            *mean += share * (now - *mean);
        }
        *then = time;
    }

    /// Takes in a sample, `interval_s` after the one before. Gives the mean angular rate, rad/s, of a
    /// second that ends with it, if the vehicle rested through that second and the one before.
    pub fn push(
        &mut self,
        time: Time,
        rates: &MeanRates<T>,
        interval_s: T,
    ) -> Option<Vector<Body, T>> {
        self.moves_off = false;
        if interval_s > T::of(LONGEST_INTERVAL_S) {
            (self.second, self.before) = (Second::EMPTY, None);
            return None;
        }
        let [p, q, r] = rates.angular_rate_radps.to_array();
        let [x, y, z] = rates.specific_force_mps2.to_array();
        self.second.add([p, q, r, x, y, z]);
        self.second.length_s += interval_s;
        if self.second.length_s < T::ONE {
            return None;
        }
        let rate = self.rate_at_rest(time);
        self.moves_off = self.rests && rate.is_none();
        self.rests = rate.is_some();
        rate
    }

    /// Whether the last sample ended the first second after a rest in which the vehicle did not rest.
    pub fn moves_off(&self) -> bool {
        self.moves_off
    }

    fn rate_at_rest(&mut self, time: Time) -> Option<Vector<Body, T>> {
        let means = core::mem::replace(&mut self.second, Second::EMPTY).still_means();
        let before = core::mem::replace(&mut self.before, means);
        let (means, before) = means.zip(before)?;
        let steady = (means.iter().zip(before))
            .zip(limits(STEADY_RADPS, STEADY_MPS2))
            .all(|((&mean, before), limit)| (mean - before).abs() < limit);
        let [p, q, r, ..] = means;
        let rate = Vector::new(p, q, r);
        let slow = self
            .fixes
            .is_some_and(|(last, mean)| time - last < FIX_S && !is_faster(mean, FIX_MEAN_MPS));
        (steady && slow && rate.norm() < T::of(LARGEST_BIAS_RADPS)).then_some(rate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How many of twenty seconds count as rest: a unit shaken by this much, turning at this rate, at fixes
    /// of this speed.
    fn rests(shake: f64, turn_radps: f64, fix_mps: Option<f64>) -> usize {
        let mut rest = Rest::<f64>::NONE;
        let mut count = 0;
        for k in 0..1000 {
            let time = Time::from_nanoseconds(k * 20_000_000);
            if k % 50 == 0 {
                rest.fix(time, fix_mps.map(|speed| [speed, 0.0]));
            }
            let sign = if k % 2 == 0 { shake } else { -shake };
            let rates = MeanRates {
                angular_rate_radps: Vector::new(0.004, -0.002, turn_radps + 0.02 * sign),
                specific_force_mps2: Vector::new(0.1, sign, -9.8),
            };
            if let Some(rate) = rest.push(time, &rates, 0.02) {
                assert!((rate - Vector::new(0.004, -0.002, turn_radps)).norm() < 1e-6);
                count += 1;
            }
        }
        count
    }

    #[test]
    fn what_neither_shakes_nor_turns_nor_moves_rests() {
        assert!(rests(0.03, 0.0, Some(0.05)) >= 17);
        assert_eq!(rests(0.3, 0.0, Some(0.05)), 0);
        assert_eq!(rests(0.03, 0.1, Some(0.05)), 0);
        assert_eq!(rests(0.03, 0.0, Some(0.3)), 0);
        assert_eq!(rests(0.03, 0.0, Some(8.0)), 0);
        assert_eq!(rests(0.03, 0.0, None), 0);
        assert_eq!(rests(f64::NAN, 0.0, Some(0.05)), 0);
    }

    #[test]
    fn what_starts_to_turn_rests_no_longer() {
        let mut rest = Rest::<f64>::NONE;
        for k in 0..1000 {
            let time = Time::from_nanoseconds(k * 20_000_000);
            rest.fix(time, Some([0.0, 0.05]));
            let turn = if k < 500 { 0.0 } else { 3e-4 * (k - 500) as f64 };
            let rates = MeanRates {
                angular_rate_radps: Vector::new(turn, 0.0, 0.0),
                specific_force_mps2: Vector::new(0.0, 0.0, -9.8),
            };
            let rested = rest.push(time, &rates, 0.02).is_some();
            assert!(!(rested && k > 600), "{k}");
        }
    }
}
