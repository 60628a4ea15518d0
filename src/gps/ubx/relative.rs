//! Position of the second antenna relative to the first: NAV-RELPOSNED.
//!
//! # Source
//! u-blox, *F9 HPG 1.32 Interface Description*, UBX-22008968, section 3.15.14 (version 1 of the message).

use crate::buffer::Bytes;
use crate::frames::wrap_angle;
use crate::gps::{AntennaHeading, ReceiverHeading};
use crate::time::Time;

/// Class and id of NAV-RELPOSNED.
pub(super) const NAV_RELPOSNED: (u8, u8) = (0x01, 0x3C);

/// Mask of the flags that a heading needs: `gnssFixOK`, `relPosValid`, `carrSoln` and `relPosHeadingValid`.
const WANTED: u32 = 1 | 1 << 2 | 3 << 3 | 1 << 8;
/// Value of these flags in a usable heading; a `carrSoln` of 2 is a fixed carrier phase solution.
const FIXED: u32 = 1 | 1 << 2 | 2 << 3 | 1 << 8;

/// Reads a message. The heading is `None` if the receiver marks it as invalid, or its ambiguities are not resolved. The
/// result is `None` for a message that is too short or has another version.
pub(super) fn read(payload: &[u8], arrival: Time) -> Option<Option<ReceiverHeading>> {
    let i32_at = |offset: usize| Bytes::<false>(payload.get(offset..)?).i32();
    let u32_at = |offset: usize| Bytes::<false>(payload.get(offset..)?).u32();
    let (version, flags) = (*payload.first()?, u32_at(60)?);
    if version != 1 {
        return None;
    }
    let time_of_week_ms = u32_at(4)?;
    let fine_mm = f64::from(payload.get(35)?.cast_signed()) * 0.1;
    let length_m = f64::from(i32_at(20)?) * 1e-2 + fine_mm * 1e-3;
    let heading_rad = wrap_angle((f64::from(i32_at(24)?) * 1e-5).to_radians());
    let sigma_rad = (f64::from(u32_at(52)?) * 1e-5).to_radians();
    let heading = AntennaHeading {
        time: arrival,
        heading_rad,
        sigma_rad: Some(sigma_rad),
        length_m: Some(length_m),
    };
    let vouched = flags & WANTED == FIXED && heading.is_finite();
    Some(vouched.then_some(ReceiverHeading { time_of_week_ms, heading }))
}
