//! Creation and destruction of an object, and properties of the library.

use core::ffi::{c_char, c_void};
use core::mem::{MaybeUninit, align_of, size_of};

use hovernav::ekf::{Estimator, SteplessSolution};
use hovernav::health::HealthMonitor;
use hovernav::imu::Notch;

use crate::access::{input, object, optional, output};
use crate::object::{HOVERNAV_ABI, Hovernav, MARK};
use crate::queue::NoticeQueue;
use crate::settings::{Checked, Config};
use crate::status::{Fault, Status};

/// Size of an object of this library, bytes: at most HOVERNAV_SIZE.
#[unsafe(no_mangle)]
pub extern "C" fn hovernav_size() -> usize {
    size_of::<Hovernav>()
}

/// Alignment of an object of this library, bytes: at most HOVERNAV_ALIGNMENT.
#[unsafe(no_mangle)]
pub extern "C" fn hovernav_alignment() -> usize {
    align_of::<Hovernav>()
}

/// The library's version, such as "0.1.0": a static text that ends with a zero byte.
#[unsafe(no_mangle)]
pub extern "C" fn hovernav_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}

/// Checks that header and library match; call it with HOVERNAV_ABI. Returns HOVERNAV_STATUS_ABI_MISMATCH if they do not
/// match. hovernav_default_config() makes the same check.
#[unsafe(no_mangle)]
pub extern "C" fn hovernav_check_abi(abi: u32) -> Status {
    if abi == HOVERNAV_ABI { Status::Ok } else { Status::AbiMismatch }
}

/// Creates an object in `memory`. `size` is the size of the memory, bytes, at least hovernav_size(). The memory is
/// aligned at least to hovernav_alignment(). `created` receives the address of the object, which is the address of the
/// memory. The memory belongs to the object until hovernav_destroy(); nothing else is ever allocated. An earlier object
/// in the memory is overwritten. `fault`, unless null, receives the first value of the configuration that is out of
/// range.
///
/// HOVERNAV_STATUS_NULL_POINTER, _MISALIGNED, _MEMORY_TOO_SMALL or _OUT_OF_RANGE.
///
/// # Safety
/// Pointers follow the rules of the crate; `memory` has `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_create(
    memory: *mut c_void,
    size: usize,
    config: *const Config,
    fault: *mut Fault,
    created: *mut *mut Hovernav,
) -> Status {
    let create = || {
        // SAFETY: guaranteed by the caller, as at the start of every function.
        let created = unsafe { output(created) }?;
        // SAFETY: as above.
        let config = unsafe { input(config) }?;
        // SAFETY: as above.
        let fault = unsafe { optional(fault) }?;
        let address = memory.cast::<Hovernav>();
        if address.is_null() {
            return Err(Status::NullPointer);
        }
        if !address.is_aligned() {
            return Err(Status::Misaligned);
        }
        if size < size_of::<Hovernav>() {
            return Err(Status::MemoryTooSmall);
        }
        let config = config.checked().map_err(|wrong| Status::reject(wrong, fault))?;
        // SAFETY: not null, aligned and large enough, and owned by the caller; it may be uninitialised.
        make(unsafe { &mut *address.cast() }, &config);
        created.write(address);
        Ok(())
    };
    Status::of(create())
}

/// Builds an object in its memory, field by field: the stack holds at most one field at a time.
#[expect(clippy::multiple_unsafe_ops_per_block, reason = "one condition holds for all parts")]
fn make(memory: &mut MaybeUninit<Hovernav>, config: &Checked) {
    let nav = memory.as_mut_ptr();
    // SAFETY: `memory` is valid for writes. All fields of the object are written.
    unsafe {
        let flight = &raw mut (*nav).flight;
        build(&raw mut (*flight).notch, || config.notch.map(Notch::new));
        build(&raw mut (*flight).estimator, || Estimator::with_layout(config.estimator));
        build(&raw mut (*flight).monitor, || HealthMonitor::new(config.health.cast()));
        build(&raw mut (*flight).stepless, SteplessSolution::default);
        build(&raw mut (*flight).autopilot, || None);
        build(&raw mut (*flight).notices, NoticeQueue::default);
        build(&raw mut (*nav).lines, || None);
        build(&raw mut (*nav).mark, || MARK);
    }
}

/// Writes a new value to its slot, in a stack frame of its own.
///
/// # Safety
/// `slot` is aligned and valid for writes.
#[inline(never)]
unsafe fn build<T>(slot: *mut T, new: impl FnOnce() -> T) {
    // SAFETY: guaranteed by the caller.
    unsafe { slot.write(new()) }
}

/// Destroys an object. Its memory belongs to the caller again, and its address is no longer the address of an object. A
/// null pointer is accepted and has no effect.
///
/// HOVERNAV_STATUS_NOT_CREATED if there is no object at the address, or _MISALIGNED.
///
/// # Safety
/// Pointers follow the rules of the crate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_destroy(nav: *mut Hovernav) -> Status {
    if nav.is_null() {
        return Status::Ok;
    }
    // SAFETY: guaranteed by the caller.
    Status::of(unsafe { object(nav) }.map(|nav| nav.mark = 0))
}
