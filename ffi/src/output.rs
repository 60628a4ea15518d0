//! Memory of the caller for one output.

use core::mem::MaybeUninit;

/// Memory for one output, which is written once.
pub struct Output<'a, T> {
    place: &'a mut MaybeUninit<T>,
}

impl<'a, T> Output<'a, T> {
    /// The memory `place`, which may be uninitialised.
    pub fn new(place: &'a mut MaybeUninit<T>) -> Self {
        Self { place }
    }

    /// Takes a reference, not a pointer, so that the value is built in its final memory.
    pub fn write(self, value: T) {
        self.place.write(value);
    }
}
