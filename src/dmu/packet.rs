//! The packets of the Crossbow DMU-HDX-AHRS (AHRS400 family), byte for byte.
//!
//! Every packet is a header byte, big-endian 16-bit words and a checksum byte. A packet is checked once, when it is
//! decoded. Its fields are then plain numbers in counts. [`Calibration`](super::Calibration) converts them to physical
//! units.
//!
//! Source: Crossbow, *AHRS Series User's Manual*, 7430-0004-01, pages 14 to 16 (checksum, signs, timer). The order of
//! the words agrees with four independent drivers.

use core::fmt;

/// The first byte of every packet. It also occurs inside packets.
pub(super) const HEADER: u8 = 0xFF;

/// Contents of the inertial unit's packets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Mode {
    /// Raw sensor voltages, [`VoltagePacket`].
    Voltage,
    /// Calibrated rates, accelerations and magnetic field, [`ScaledPacket`].
    Scaled,
    /// The contents of the scaled mode, and the inertial unit's own attitude, [`AnglePacket`].
    Angle,
}

impl Mode {
    /// Length of this mode's packets in bytes, header and checksum included.
    #[must_use]
    pub const fn packet_length(self) -> usize {
        match self {
            Self::Voltage => VoltagePacket::LENGTH,
            Self::Scaled => ScaledPacket::LENGTH,
            Self::Angle => AnglePacket::LENGTH,
        }
    }

    /// Transfer time of one packet, s: 38 400 baud, ten bits a byte.
    #[must_use]
    pub const fn transfer_time_s(self) -> f64 {
        self.packet_length() as f64 * 10.0 / 38_400.0
    }
}

/// Reason why bytes are not a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PacketError {
    /// Too few bytes for a packet; the bytes present are a valid beginning.
    Length {
        /// Length of the packet, bytes.
        expected: usize,
        /// Number of bytes present.
        found: usize,
    },
    /// The first byte is not the header 0xFF.
    Header {
        /// The first byte.
        found: u8,
    },
    /// The sum of the bytes between header and checksum differs from the checksum, modulo 256.
    Checksum {
        /// The sum of the bytes.
        expected: u8,
        /// The checksum byte.
        found: u8,
    },
}

impl fmt::Display for PacketError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length { expected, found } => {
                write!(f, "packet of {expected} bytes cut off after {found}")
            }
            Self::Header { found } => write!(f, "packet header: found {found:#04x}, expected 0xff"),
            Self::Checksum { expected, found } => {
                write!(f, "checksum: found {found:#04x}, expected {expected:#04x}")
            }
        }
    }
}

impl core::error::Error for PacketError {}

/// A form of packet: its name and length, and the triads of words before temperature and timer, in order.
macro_rules! packet {
    (
        $(#[$about:meta])*
        $Packet:ident, $length:literal, $word:ident, $($(#[$meaning:meta])* $triad:ident),*
    ) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub struct $Packet {
            $($(#[$meaning])* pub $triad: [$word; 3],)*
            /// Sensor temperature, 12-bit converter counts.
            pub temperature: u16,
            /// The inertial unit's timer at the sample: it counts down, 0.79 µs a count, 65 536 counts a wrap.
            pub timer: u16,
        }

        impl $Packet {
            /// Length of the packet, bytes.
            pub const LENGTH: usize = $length;

            /// The packet at the start of `bytes`; later bytes are ignored.
            ///
            /// # Errors
            /// [`PacketError`] with the first failed check; the header is checked first.
            pub fn decode(bytes: &[u8]) -> Result<Self, PacketError> {
                let ([$($triad),*], [temperature, timer]) = words(bytes)?;
                Ok(Self {
                    $($triad: $triad.map($word::from_be_bytes),)*
                    temperature: u16::from_be_bytes(temperature),
                    timer: u16::from_be_bytes(timer),
                })
            }

            /// The bytes of the packet, as the inertial unit sends them.
            #[must_use]
            pub fn encode(&self) -> [u8; Self::LENGTH] {
                let triads = [$(self.$triad.map($word::to_be_bytes)),*];
                frame(triads.as_flattened(), [self.temperature, self.timer].map(u16::to_be_bytes))
            }
        }
    };
}

packet! {
    /// A packet of angle mode, 30 bytes: attitude, rates, accelerations, magnetic field.
    ///
    /// The axes are those of the inertial unit: x away from the connector, y along the connector's face from left to
    /// right, z down through the mounting plate. Level and at rest, the z acceleration is positive.
    ///
    /// ```
    /// use hovernav::dmu::AnglePacket;
    /// let level = AnglePacket { acceleration: [0, 0, 0x1555], timer: 65_535, ..Default::default() };
    /// assert_eq!(AnglePacket::decode(&level.encode()), Ok(level));
    /// ```
    AnglePacket, 30, i16,
    /// Roll, pitch and magnetic heading, 180°/32768 a count.
    attitude,
    /// Angular rates, 1.5 × rated range/32768 a count.
    angular_rate,
    /// Accelerations, 1.5 × rated range/32768 a count.
    acceleration,
    /// Magnetic field, 1.875 gauss/32768 a count.
    magnetic_field
}

packet! {
    /// A packet of scaled mode, 24 bytes: [`AnglePacket`] without the attitude.
    ScaledPacket, 24, i16,
    /// Angular rates, 1.5 × rated range/32768 a count.
    angular_rate,
    /// Accelerations, 1.5 × rated range/32768 a count.
    acceleration,
    /// Magnetic field, 1.875 gauss/32768 a count.
    magnetic_field
}

packet! {
    /// A packet of voltage mode, 24 bytes: the readings of the analogue-to-digital converters, 5 V/4096 a count.
    ///
    /// The calibration sheet of each inertial unit gives the conversion from these volts to rates and accelerations.
    VoltagePacket, 24, u16,
    /// Gyros, converter counts.
    angular_rate,
    /// Accelerometers, converter counts.
    acceleration,
    /// Magnetometers, converter counts.
    magnetic_field
}

/// A packet of any mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Packet {
    /// A packet of voltage mode.
    Voltage(VoltagePacket),
    /// A packet of scaled mode.
    Scaled(ScaledPacket),
    /// A packet of angle mode.
    Angle(AnglePacket),
}

impl Packet {
    /// The packet of a known `mode` at the start of `bytes`; later bytes are ignored. The bytes do not contain the
    /// mode: the caller knows it from the command that set it.
    ///
    /// # Errors
    /// [`PacketError`] with the first failed check; the header is checked first.
    pub fn decode(mode: Mode, bytes: &[u8]) -> Result<Self, PacketError> {
        match mode {
            Mode::Voltage => VoltagePacket::decode(bytes).map(Self::Voltage),
            Mode::Scaled => ScaledPacket::decode(bytes).map(Self::Scaled),
            Mode::Angle => AnglePacket::decode(bytes).map(Self::Angle),
        }
    }

    /// Sensor temperature, 12-bit converter counts; 5 V/4096 a count.
    #[must_use]
    pub const fn temperature(&self) -> u16 {
        match self {
            Self::Voltage(packet) => packet.temperature,
            Self::Scaled(packet) => packet.temperature,
            Self::Angle(packet) => packet.temperature,
        }
    }

    /// The inertial unit's timer at the sample: it counts down, 0.79 µs a count, 65 536 counts a wrap.
    #[must_use]
    pub const fn timer(&self) -> u16 {
        match self {
            Self::Voltage(packet) => packet.timer,
            Self::Scaled(packet) => packet.timer,
            Self::Angle(packet) => packet.timer,
        }
    }
}

/// Bytes of a word, the most significant one first.
type Word = [u8; 2];

/// The triads and the last two words of the frame at the start of `bytes`, after the check of header and checksum.
fn words<const TRIADS: usize>(
    bytes: &[u8],
) -> Result<([[Word; 3]; TRIADS], [Word; 2]), PacketError> {
    let expected = 6 * TRIADS + 6;
    if let Some(&found) = bytes.first()
        && found != HEADER
    {
        return Err(PacketError::Header { found });
    }
    let Some([_, payload @ .., checksum]) = bytes.get(..expected) else {
        return Err(PacketError::Length { expected, found: bytes.len() });
    };
    let sum = sum(payload);
    if sum != *checksum {
        return Err(PacketError::Checksum { expected: sum, found: *checksum });
    }
    let (mut triads, mut last) = ([[[0; 2]; 3]; TRIADS], [[0; 2]; 2]);
    let words = triads.as_flattened_mut().iter_mut().chain(&mut last);
    words.zip(payload.as_chunks().0).for_each(|(word, found)| *word = *found);
    Ok((triads, last))
}

/// The frame of a packet's words.
fn frame<const LENGTH: usize>(triads: &[Word], last: [Word; 2]) -> [u8; LENGTH] {
    let mut bytes = [HEADER; LENGTH];
    if let [_, payload @ .., checksum] = bytes.as_mut_slice() {
        let words = triads.iter().chain(&last);
        payload.as_chunks_mut().0.iter_mut().zip(words).for_each(|(to, word)| *to = *word);
        *checksum = sum(payload);
    }
    bytes
}

fn sum(payload: &[u8]) -> u8 {
    payload.iter().fold(0, |sum, byte| sum.wrapping_add(*byte))
}
