//! Numbers of binary logs, least significant byte first.

/// A type of number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Primitive {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Primitive {
    /// Length, bytes.
    pub const fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// The number at `offset` in `bytes`; NaN where `bytes` are too short.
    #[allow(clippy::cast_lossless, reason = "one conversion for all types, some of them lossy")]
    pub fn number(self, bytes: &[u8], offset: usize) -> f64 {
        let bytes = bytes.get(offset..).unwrap_or_default();
        macro_rules! number {
            ($kind:ty) => {
                bytes.first_chunk().map(|bytes| <$kind>::from_le_bytes(*bytes) as f64)
            };
        }
        let number = match self {
            Self::I8 => number!(i8),
            Self::U8 => number!(u8),
            Self::I16 => number!(i16),
            Self::U16 => number!(u16),
            Self::I32 => number!(i32),
            Self::U32 => number!(u32),
            Self::I64 => number!(i64),
            Self::U64 => number!(u64),
            Self::F32 => number!(f32),
            Self::F64 => number!(f64),
        };
        number.unwrap_or(f64::NAN)
    }
}
