//! Checks of pointers before their use: null, alignment and the mark of an object.

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
/// A `pointer` that is not null points to readable memory. An object there has no other user during `'a`.
pub unsafe fn object<'a>(pointer: *mut Hovernav) -> Result<&'a mut Hovernav, Status> {
    checked(pointer)?;
    // SAFETY: the caller guarantees readable memory; no reference exists before the mark is checked.
    let mark = unsafe { &raw const (*pointer).mark };
    // SAFETY: as above; the memory may not be an object yet, so only its bytes are read.
    if unsafe { mark.read_volatile() } != MARK {
        return Err(Status::NotCreated);
    }
    // SAFETY: the mark is present from the end of hovernav_create to hovernav_destroy, and the object has no other
    // user.
    Ok(unsafe { &mut *pointer })
}

/// A copy of the value at `pointer`.
///
/// # Safety
/// A `pointer` that is not null points to an initialised `T`.
pub unsafe fn input<T: Copy>(pointer: *const T) -> Result<T, Status> {
    // SAFETY: guaranteed by the caller.
    unsafe { borrowed(pointer) }.copied()
}

/// A reference to the value at `pointer`; copying a large value takes time.
///
/// # Safety
/// A `pointer` that is not null points to an initialised `T` without a writer during `'a`.
pub unsafe fn borrowed<'a, T>(pointer: *const T) -> Result<&'a T, Status> {
    checked(pointer)?;
    // SAFETY: not null and aligned, so the caller guarantees a `T`.
    Ok(unsafe { &*pointer })
}

/// The memory at `pointer`, for writing.
///
/// # Safety
/// A `pointer` that is not null points to memory of a `T` without another user during `'a`. The memory may be
/// uninitialised.
pub unsafe fn output<'a, T>(pointer: *mut T) -> Result<Output<'a, T>, Status> {
    checked(pointer)?;
    // SAFETY: not null and aligned; the caller guarantees memory of this size without another user.
    Ok(Output::new(unsafe { &mut *pointer.cast() }))
}

/// The memory at `pointer`, or `None` for a null pointer, for optional outputs.
///
/// # Safety
/// The conditions of [`output`] apply to a `pointer` that is not null.
pub unsafe fn optional<'a, T>(pointer: *mut T) -> Result<Option<Output<'a, T>>, Status> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: guaranteed by the caller.
    unsafe { output(pointer) }.map(Some)
}

/// The `length` bytes at `pointer`; an empty slice for length 0 and any pointer.
///
/// # Safety
/// A `pointer` that is not null points to `length` readable bytes without a writer during `'a`.
pub unsafe fn bytes<'a>(pointer: *const u8, length: usize) -> Result<&'a [u8], Status> {
    if length == 0 {
        return Ok(&[]);
    }
    checked(pointer)?;
    if length > isize::MAX as usize {
        return Err(Status::OutOfRange);
    }
    // SAFETY: not null, of a valid length for a slice, and readable as guaranteed by the caller.
    Ok(unsafe { core::slice::from_raw_parts(pointer, length) })
}
