//! Missing frames from frame numbers that count from 0 to 255 and wrap.

/// Largest number of later frames that may arrive before a delayed frame.
const HELD_UP: u8 = 16;

/// Counts missing frames from frame numbers that count from 0 to 255 and wrap.
///
/// Datagrams can overtake each other: a late frame is first counted as missing; its arrival corrects the count. A gap
/// of 256 frames is not detectable from the numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sequence {
    before: Option<u8>,
    missing: u64,
}

impl Sequence {
    /// Processes the number of a received frame.
    pub fn observe(&mut self, number: u8) {
        let gap = self.before.map_or(0, |before| number.wrapping_sub(before).wrapping_sub(1));
        if gap > u8::MAX - HELD_UP {
            self.missing = self.missing.saturating_sub(1);
        } else {
            self.missing = self.missing.saturating_add(u64::from(gap));
            self.before = Some(number);
        }
    }

    /// Number of missing frames since the start.
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
        numbers.into_iter().for_each(|number| sequence.observe(number));
        sequence.missing()
    }

    #[test]
    fn what_does_not_come_is_counted_and_what_comes_late_is_not() {
        assert_eq!(missing([250, 251, 255, 0, 2]), 4);
        assert_eq!(missing([1, 2, 4, 3, 5, 7, 8, 6, 9]), 0);
        assert_eq!(missing((0..=255).chain(0..=255)), 0);
        // A vehicle that restarts: its numbers start at 0 again.
        assert_eq!(missing([200, 201, 0, 1]), 54);
    }
}
