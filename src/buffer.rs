//! Helper for the buffers of the drivers.

use core::cell::Cell;

/// Moves the items from index `count` on to the front of the slice; the items after them do not change.
///
/// `copy_within` does the same, but contains a panic for an invalid range.
pub(crate) fn move_to_front<T: Copy>(items: &mut [T], count: usize) {
    let cells = Cell::from_mut(items).as_slice_of_cells();
    for (to, from) in cells.iter().zip(cells.iter().skip(count)) {
        to.set(from.get());
    }
}

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
