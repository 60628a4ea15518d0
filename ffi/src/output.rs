//! A place of the caller's that may be written.

use core::mem::MaybeUninit;

/// A place that may be written, once.
pub struct Output<'a, T> {
    place: &'a mut MaybeUninit<T>,
}

impl<'a, T> Output<'a, T> {
    /// The place `place`, which need not be initialised.
    pub fn new(place: &'a mut MaybeUninit<T>) -> Self {
        Self { place }
    }

    /// A reference, not a pointer, so that the value is put together in its place.
    pub fn write(self, value: T) {
        self.place.write(value);
    }
}
