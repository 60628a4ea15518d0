//! Memory of the caller for one output.

use core::mem::MaybeUninit;

/// Memory for one output, which is written once.
pub struct Output<'a, T> {
    memory: &'a mut MaybeUninit<T>,
}

impl<'a, T> Output<'a, T> {
    /// An output to `memory`, which may be uninitialised.
    pub fn new(memory: &'a mut MaybeUninit<T>) -> Self {
        Self { memory }
    }

    /// Takes a reference, not a pointer, so that the value is built in its final memory.
    pub fn write(self, value: T) {
        self.memory.write(value);
    }
}
