//! Numbers that go from 0 to 255 and over again, and what they show to be missing.

/// A frame that comes after at most so many of those sent later was only held up.
const HELD_UP: u8 = 16;

/// Counts what is missing among frames numbered from 0 to 255 over and over.
///
/// Datagrams overtake each other: a frame that comes late was missing, and is no more. What a number cannot
/// tell is a gap of a whole round.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sequence {
    before: Option<u8>,
    missing: u64,
}

impl Sequence {
    /// Hears the frame of this number.
    pub fn hear(&mut self, number: u8) {
        let gap = self.before.map_or(0, |before| number.wrapping_sub(before).wrapping_sub(1));
        if gap > u8::MAX - HELD_UP {
            self.missing = self.missing.saturating_sub(1);
        } else {
            self.missing = self.missing.saturating_add(u64::from(gap));
            self.before = Some(number);
        }
    }

    /// How many did not come so far.
    #[must_use]
    pub const fn missing(&self) -> u64 {
        self.missing
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn missing(numbers: impl IntoIterator<Item = u8>) -> u64 {
        let mut sequence = Sequence::default();
        numbers.into_iter().for_each(|number| sequence.hear(number));
        sequence.missing()
    }

    #[test]
    fn what_does_not_come_is_counted_and_what_comes_late_is_not() {
        assert_eq!(missing([250, 251, 255, 0, 2]), 4);
        assert_eq!(missing([1, 2, 4, 3, 5, 7, 8, 6, 9]), 0);
        assert_eq!(missing((0..=255).chain(0..=255)), 0);
        // A vehicle that begins anew.
        assert_eq!(missing([200, 201, 0, 1]), 54);
    }
}
