//! What a pointer alone can tell, checked before it is used.

use crate::object::{Hovernav, MARK};
use crate::output::Output;
use crate::status::Status;

fn checked<T>(pointer: *const T) -> Result<(), Status> {
    if pointer.is_null() {
        Err(Status::NullPointer)
    } else if !pointer.is_aligned() {
        Err(Status::Misaligned)
    } else {
        Ok(())
    }
}

/// The object at `pointer`.
///
/// # Safety
/// Not null, it points to readable memory; an object there is used by nobody else during `'a`.
pub unsafe fn object<'a>(pointer: *mut Hovernav) -> Result<&'a mut Hovernav, Status> {
    checked(pointer)?;
    // SAFETY: readable by the caller's promise; no reference is made before the mark is seen.
    let mark = unsafe { &raw const (*pointer).mark };
    // SAFETY: as before; the caller's memory may not be an object yet, so its bytes are only read.
    if unsafe { mark.read_volatile() } != MARK {
        return Err(Status::NotCreated);
    }
    // SAFETY: the mark is there from the end of hovernav_create to hovernav_destroy, and nobody else
    // uses the object.
    Ok(unsafe { &mut *pointer })
}

/// What is at `pointer`, copied.
///
/// # Safety
/// Not null, it points to a `T` that is initialised.
pub unsafe fn input<T: Copy>(pointer: *const T) -> Result<T, Status> {
    // SAFETY: the caller's promise.
    unsafe { borrowed(pointer) }.copied()
}

/// What is at `pointer`, where it lies: a copy of much takes its time.
///
/// # Safety
/// Not null, it points to a `T` that is initialised and that nobody writes during `'a`.
pub unsafe fn borrowed<'a, T>(pointer: *const T) -> Result<&'a T, Status> {
    checked(pointer)?;
    // SAFETY: not null and aligned, so a `T` by the caller's promise.
    Ok(unsafe { &*pointer })
}

/// The place at `pointer`, to be written.
///
/// # Safety
/// Not null, it points to memory of a `T` that nobody else uses during `'a`; it need not be initialised.
pub unsafe fn output<'a, T>(pointer: *mut T) -> Result<Output<'a, T>, Status> {
    checked(pointer)?;
    // SAFETY: not null and aligned, and memory of that size that nobody else uses by the caller's promise.
    Ok(Output::new(unsafe { &mut *pointer.cast() }))
}

/// The place at `pointer`, or none where it is null, for what a caller need not take.
///
/// # Safety
/// As of [`output`].
pub unsafe fn optional<'a, T>(pointer: *mut T) -> Result<Option<Output<'a, T>>, Status> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: the caller's promise.
    unsafe { output(pointer) }.map(Some)
}

/// The `length` bytes at `pointer`; none where the length is 0, whatever the pointer.
///
/// # Safety
/// Not null, it points to `length` readable bytes that nobody writes during `'a`.
pub unsafe fn bytes<'a>(pointer: *const u8, length: usize) -> Result<&'a [u8], Status> {
    if length == 0 {
        return Ok(&[]);
    }
    checked(pointer)?;
    if length > isize::MAX as usize {
        return Err(Status::OutOfRange);
    }
    // SAFETY: not null, of a length that a slice can have, and readable by the caller's promise.
    Ok(unsafe { core::slice::from_raw_parts(pointer, length) })
}
