//! Encoding of frames: numbers as whole steps, and the byte stuffing that removes zeros. One function over the fields
//! both packs and unpacks.
//!
//! # Source
//! S. Cheshire and M. Baker, *Consistent overhead byte stuffing*, IEEE/ACM Transactions on Networking 7 (2), 1999. Up
//! to 253 bytes of data need one byte of overhead; the longer blocks of the paper are not needed.

use crate::frames::Vector;
use crate::time::Time;

/// Removes the zeros from `bytes`. Its content is one zero, then at most 253 bytes of data. Each zero is replaced by
/// the distance to the next zero, and the last zero by the distance to the end.
pub(super) fn stuff(bytes: &mut [u8]) {
    let mut distance = 1u8;
    for byte in bytes.iter_mut().rev() {
        if *byte == 0 {
            *byte = distance;
            distance = 1;
        } else {
            distance = distance.wrapping_add(1);
        }
    }
}

/// Reverses [`stuff`]. Returns whether each distance leads to the next distance, and the last distance to the end.
pub(super) fn unstuff(bytes: &mut [u8]) -> bool {
    let mut distance = 1u8;
    for byte in bytes {
        distance = distance.wrapping_sub(1);
        if *byte == 0 {
            return false;
        }
        if distance == 0 {
            distance = core::mem::take(byte);
        }
    }
    distance == 1
}

/// Bytes being packed or unpacked, front to back.
pub(super) enum Codec<'a> {
    /// Values are written to these remaining bytes.
    Pack(&'a mut [u8]),
    /// Values are read from these remaining bytes.
    Unpack(&'a [u8]),
}

/// A whole number in a frame.
pub(super) trait Word: Copy {
    /// The whole number nearest to `steps`. Values out of range saturate; NaN and `None` become the number that means
    /// unknown.
    fn of(steps: Option<f64>) -> Self;
    /// The number of steps, if it is known.
    fn steps(self) -> Option<f64>;
    /// Packs or unpacks the number.
    fn code(&mut self, codec: &mut Codec<'_>);
}

macro_rules! word {
    ($type:ident, $unknown:ident, $least:expr, $greatest:expr) => {
        impl Word for $type {
            fn of(steps: Option<f64>) -> Self {
                let known = steps.filter(|steps| !steps.is_nan());
                known.map_or(Self::$unknown, |steps| {
                    (libm::round(steps) as Self).max($least).min($greatest)
                })
            }

            fn steps(self) -> Option<f64> {
                (self != Self::$unknown).then_some(f64::from(self))
            }

            fn code(&mut self, codec: &mut Codec<'_>) {
                let mut bytes = self.to_le_bytes();
                codec.bytes(&mut bytes);
                *self = Self::from_le_bytes(bytes);
            }
        }
    };
}

word!(i16, MIN, Self::MIN + 1, Self::MAX);
word!(i32, MIN, Self::MIN + 1, Self::MAX);
word!(u8, MAX, 0, Self::MAX - 1);
word!(u16, MAX, 0, Self::MAX - 1);

impl Codec<'_> {
    /// Packs or unpacks `N` bytes. Beyond the end nothing is written, and a read value stays unchanged.
    pub fn bytes<const N: usize>(&mut self, value: &mut [u8; N]) {
        match self {
            Self::Pack(room) => {
                if let Some((slot, rest)) = core::mem::take(room).split_first_chunk_mut() {
                    *slot = *value;
                    *room = rest;
                }
            }
            Self::Unpack(bytes) => {
                if let Some((slot, rest)) = bytes.split_first_chunk() {
                    *value = *slot;
                    *bytes = rest;
                }
            }
        }
    }

    /// Packs or unpacks a value as a whole number of steps, `per_unit` of them in one unit.
    pub fn scaled<W: Word>(&mut self, value: &mut Option<f64>, per_unit: f64) {
        let mut word = W::of(value.map(|value| value * per_unit));
        word.code(self);
        *value = word.steps().map(|steps| steps / per_unit);
    }

    /// Packs or unpacks several values as [`scaled`](Self::scaled) does; all are known, or all unknown.
    pub fn scaled_all<W: Word, const N: usize>(
        &mut self,
        values: &mut Option<[f64; N]>,
        per_unit: f64,
    ) {
        let mut known = true;
        let mut read = values.unwrap_or([f64::NAN; N]);
        for value in &mut read {
            let mut component = Some(*value);
            self.scaled::<W>(&mut component, per_unit);
            known &= component.is_some();
            *value = component.unwrap_or_default();
        }
        *values = known.then_some(read);
    }

    /// Packs or unpacks a vector as [`scaled`](Self::scaled) does.
    pub fn vector<W: Word, F>(&mut self, value: &mut Option<Vector<F>>, per_unit: f64) {
        let mut components = value.map(Vector::to_array);
        self.scaled_all::<W, 3>(&mut components, per_unit);
        *value = components.map(Vector::from);
    }

    /// Packs or unpacks a time in whole microseconds, rounded down.
    pub fn time(&mut self, time: &mut Time) {
        let mut time_us = time.nanoseconds().div_euclid(1_000).to_le_bytes();
        self.bytes(&mut time_us);
        *time = Time::from_nanoseconds(i64::from_le_bytes(time_us).saturating_mul(1_000));
    }

    /// Packs or unpacks a count; it saturates at two bytes.
    pub fn count(&mut self, value: &mut u32) {
        let mut bytes = u16::try_from(*value).unwrap_or(u16::MAX).to_le_bytes();
        self.bytes(&mut bytes);
        *value = u32::from(u16::from_le_bytes(bytes));
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn stuffing_is_that_of_the_cobs_crate(
            // Zeros are rare in random bytes. They are added here, because stuffing replaces zeros.
            data in prop::collection::vec(prop_oneof![any::<u8>(), Just(0)], 0..=253),
        ) {
            let mut bytes = [&[0][..], &data].concat();
            stuff(&mut bytes);
            prop_assert_eq!(&bytes, &cobs::encode_vec(&data));
            prop_assert!(unstuff(&mut bytes));
            prop_assert_eq!(&bytes[1..], &data);
        }

        #[test]
        fn what_the_cobs_crate_refuses_is_refused(
            stuffed in prop::collection::vec(prop_oneof![1..=u8::MAX, 1..=9u8], 1..=254),
        ) {
            let mut bytes = stuffed.clone();
            let plain = unstuff(&mut bytes).then(|| bytes[1..].to_vec());
            prop_assert_eq!(plain, cobs::decode_vec(&stuffed).ok());
        }
    }
}
