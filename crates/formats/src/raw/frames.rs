//! Frames of several protocols on one serial line, distinguished by their checksums.
//!
//! # Source
//! u-blox, *u-blox 8 / M8 Receiver description*, UBX-13003221, section UBX frame structure. NMEA 0183, section
//! Sentence structure. RTCM 10403.3, section 4.2, transport layer; its checksum is CRC-24Q.

/// A kind of frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Ubx {
        /// Class of the message.
        class: u8,
    },
    Nmea,
    Rtcm,
}

/// CRC-24Q, as in LTE.
const CRC: crc::Crc<u32, crc::Table<16>> = crc::Crc::<u32, crc::Table<16>>::new(&crc::CRC_24_LTE_A);

/// Longest frame that is recognised, bytes.
pub(super) const LONGEST: usize = 8192;
/// Longest sentence, bytes.
const LONGEST_SENTENCE: usize = 132;

/// The frame at the start of `bytes` and its length; `None` if no whole frame with a correct checksum begins there.
pub(super) fn at(bytes: &[u8]) -> Option<(Kind, usize)> {
    match bytes.first()? {
        0xB5 => ubx(bytes),
        b'$' => nmea(bytes),
        0xD3 => rtcm(bytes),
        _ => None,
    }
}

/// Number of bytes over which [`at`] computes a checksum; zero if no frame begins there.
pub(super) fn work(bytes: &[u8]) -> usize {
    let end = match *bytes {
        [0xB5, 0x62, _, _, low, high, ..] => 6 + usize::from(u16::from_le_bytes([low, high])),
        [0xD3, high @ ..4, low, ..] => 3 + usize::from(u16::from_be_bytes([high, low])),
        [b'$', ..] => LONGEST_SENTENCE,
        _ => 0,
    };
    if end > LONGEST { 0 } else { end.min(bytes.len()) }
}

/// Whether a frame may begin with `bytes`, whole or damaged.
pub(super) fn may_begin(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0xB5, 0x62]) || bytes.first() == Some(&b'$')
}

fn ubx(bytes: &[u8]) -> Option<(Kind, usize)> {
    let &[0xB5, 0x62, class, _, low, high] = bytes.first_chunk()? else { return None };
    let end = 6 + usize::from(u16::from_le_bytes([low, high]));
    let checksum = bytes.get(end..end + 2).filter(|_| end + 2 <= LONGEST)?;
    let sums = bytes[2..end].iter().fold([0_u8; 2], |[a, b], byte| {
        let a = a.wrapping_add(*byte);
        [a, b.wrapping_add(a)]
    });
    (checksum == sums).then_some((Kind::Ubx { class }, end + 2))
}

fn nmea(bytes: &[u8]) -> Option<(Kind, usize)> {
    let sentence = &bytes[..bytes.len().min(LONGEST_SENTENCE)];
    let star = sentence.iter().position(|byte| *byte == b'*')?;
    let body = &sentence[1..star];
    let digits = std::str::from_utf8(sentence.get(star + 1..star + 3)?).ok()?;
    let sum = body.iter().fold(0, |sum, byte| sum ^ byte);
    let is_right = u8::from_str_radix(digits, 16).is_ok_and(|stated| stated == sum);
    let end = sentence[star + 3..].iter().take_while(|byte| matches!(byte, b'\r' | b'\n')).count();
    let is_text = body.iter().all(|byte| (b' '..=b'~').contains(byte));
    (is_right && is_text).then_some((Kind::Nmea, star + 3 + end.min(2)))
}

fn rtcm(bytes: &[u8]) -> Option<(Kind, usize)> {
    let &[_, high, low] = bytes.first_chunk()?;
    let end = 3 + usize::from(u16::from_be_bytes([high, low]));
    let &[a, b, c] = bytes.get(end..)?.first_chunk().filter(|_| high < 4)?;
    let sum = CRC.checksum(&bytes[..end]);
    (sum == u32::from_be_bytes([0, a, b, c])).then_some((Kind::Rtcm, end + 3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_frames_are_recognised_and_damaged_ones_are_not() {
        let frames: [(&[u8], Kind); 3] = [
            (&[0xB5, 0x62, 0x05, 0x01, 0x02, 0x00, 0x06, 0x01, 0x0F, 0x38], Kind::Ubx { class: 5 }),
            (b"$GPABC,1*4A\r\n", Kind::Nmea),
            // A message without content.
            (&[0xD3, 0x00, 0x00, 0x47, 0xEA, 0x4B], Kind::Rtcm),
        ];
        for (frame, kind) in frames {
            let followed = [frame, b"$"].concat();
            assert_eq!(at(&followed), Some((kind, frame.len())), "{kind:?}");
            for cut in 1..frame.len() - 2 {
                assert_eq!(at(&frame[..cut]), None, "{kind:?} {cut}");
            }
            let mut damaged = frame.to_vec();
            damaged[3] ^= 1;
            assert_eq!(at(&damaged), None, "{kind:?}");
        }
    }
}
