//! Helper for the buffers of the drivers.

use core::cell::Cell;

/// Moves the items from index `count` to the end of the slice to its front. Items behind the moved ones do not change.
///
/// `copy_within` does the same, but contains a panic for an invalid range.
pub(crate) fn move_to_front<T: Copy>(items: &mut [T], count: usize) {
    let cells = Cell::from_mut(items).as_slice_of_cells();
    for (to, from) in cells.iter().zip(cells.iter().skip(count)) {
        to.set(from.get());
    }
}

/// Bytes of a message, read as numbers from the front. The most significant byte of each number is first if `BIG`, else
/// last.
#[cfg(any(feature = "tsip", feature = "ubx"))]
pub(crate) struct Bytes<'a, const BIG: bool>(pub &'a [u8]);

#[cfg(any(feature = "tsip", feature = "ubx"))]
impl<const BIG: bool> Bytes<'_, BIG> {
    /// The next bytes; `None` if too few are left.
    pub fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (head, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*head)
    }
}

#[cfg(any(feature = "tsip", feature = "ubx"))]
macro_rules! numbers {
    ($($number:ident),*) => {
        // Without some of the features, some numbers are unused.
        #[cfg_attr(not(all(feature = "tsip", feature = "ubx")), allow(dead_code))]
        impl<const BIG: bool> Bytes<'_, BIG> {
            $(pub fn $number(&mut self) -> Option<$number> {
                let from_bytes = if BIG { $number::from_be_bytes } else { $number::from_le_bytes };
                self.take().map(from_bytes)
            })*
        }
    };
}

#[cfg(any(feature = "tsip", feature = "ubx"))]
numbers!(u8, u16, i16, u32, i32, f32, f64);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rest_moves_to_the_front_whatever_the_count() {
        for (count, expected) in [(0, [1, 2, 3]), (1, [2, 3, 3]), (3, [1, 2, 3]), (9, [1, 2, 3])] {
            let mut items = [1, 2, 3];
            move_to_front(&mut items, count);
            assert_eq!(items, expected);
        }
    }
}
