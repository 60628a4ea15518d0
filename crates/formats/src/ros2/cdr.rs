//! Common Data Representation (CDR), the encoding of ROS 2 messages.
//!
//! # Source
//! OMG, *Common Object Request Broker Architecture*, part 2, section 9.3 (CDR), and OMG, *Extensible
//! and Dynamic Topic Types for DDS*, section 7.6.3 (the encapsulation header).

/// A message that is read forward. A read beyond its end returns `None`, also if a length field is wrong.
#[derive(Clone, Debug)]
pub(super) struct Cdr<'a> {
    body: &'a [u8],
    at: usize,
    little: bool,
    /// Largest alignment, bytes.
    widest: usize,
}

impl<'a> Cdr<'a> {
    /// A reader of `message`, which begins with four bytes of encapsulation; `None` for another representation.
    pub fn new(message: &'a [u8]) -> Option<Self> {
        let (head, body) = message.split_first_chunk::<4>()?;
        let (little, widest) = match [head[0], head[1]] {
            [0, 0] => (false, 8),
            [0, 1] => (true, 8),
            [0, 6] => (false, 4),
            [0, 7] => (true, 4),
            _ => return None,
        };
        Some(Self { body, at: 0, little, widest })
    }

    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let aligned = self.at.next_multiple_of(N.min(self.widest));
        let bytes = self.body.get(aligned..)?.first_chunk::<N>()?;
        self.at = aligned + N;
        let mut bytes = *bytes;
        if !self.little {
            bytes.reverse();
        }
        Some(bytes)
    }

    pub fn u8(&mut self) -> Option<u8> {
        self.take().map(u8::from_le_bytes)
    }

    pub fn i8(&mut self) -> Option<i8> {
        self.take().map(i8::from_le_bytes)
    }

    pub fn u16(&mut self) -> Option<u16> {
        self.take().map(u16::from_le_bytes)
    }

    pub fn i16(&mut self) -> Option<i16> {
        self.take().map(i16::from_le_bytes)
    }

    /// Skips a sequence of four-byte numbers.
    pub fn skip_numbers(&mut self) -> Option<()> {
        let length = (self.u32()? as usize).checked_mul(4)?;
        self.body.get(self.at..)?.get(..length)?;
        self.at += length;
        Some(())
    }

    pub fn i32(&mut self) -> Option<i32> {
        self.take().map(i32::from_le_bytes)
    }

    pub fn u32(&mut self) -> Option<u32> {
        self.take().map(u32::from_le_bytes)
    }

    pub fn f32(&mut self) -> Option<f32> {
        self.take().map(f32::from_le_bytes)
    }

    pub fn f64(&mut self) -> Option<f64> {
        self.take().map(f64::from_le_bytes)
    }

    pub fn f64s<const N: usize>(&mut self) -> Option<[f64; N]> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.f64()?;
        }
        Some(values)
    }

    /// The text of a string, without its terminating zero.
    pub fn text(&mut self) -> Option<&'a [u8]> {
        let length = self.u32()? as usize;
        let text = self.body.get(self.at..)?.get(..length)?;
        self.at += length;
        Some(text.strip_suffix(b"\0").unwrap_or(text))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_byte_orders_are_read_with_their_alignment() {
        // A byte, seven of padding, a double.
        let little = [&[0, 1, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0][..], &1.5f64.to_le_bytes()].concat();
        let big = [&[0, 0, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0][..], &1.5f64.to_be_bytes()].concat();
        for message in [little, big] {
            let mut cdr = Cdr::new(&message).unwrap();
            assert_eq!(cdr.u8(), Some(7));
            assert_eq!(cdr.f64(), Some(1.5));
            assert_eq!(cdr.f64(), None);
        }
        let second = [&[0, 7, 0, 0, 7, 0, 0, 0][..], &1.5f64.to_le_bytes()].concat();
        let mut cdr = Cdr::new(&second).unwrap();
        assert_eq!((cdr.u8(), cdr.f64()), (Some(7), Some(1.5)));
    }

    #[test]
    fn a_wrong_length_does_not_lead_beyond_the_message() {
        let mut cdr = Cdr::new(&[0, 1, 0, 0, 255, 255, 255, 255, 65]).unwrap();
        assert_eq!(cdr.text(), None);
        assert!(Cdr::new(&[0, 9, 0, 0, 1]).is_none());
        assert!(Cdr::new(&[0, 1]).is_none());
    }
}
