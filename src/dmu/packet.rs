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
        $Packet:ident, $length:literal, $word:ident,
        $($(#[$meaning:meta])* $triad:ident: $x:ident $y:ident $z:ident),*
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
                let [$($x, $y, $z,)* temperature, timer] = words(bytes)?;
                let count = |word: u16| $word::from_ne_bytes(word.to_ne_bytes());
                Ok(Self { $($triad: [$x, $y, $z].map(count),)* temperature, timer })
            }

            /// The bytes of the packet, as the inertial unit sends them.
            #[must_use]
            pub fn encode(&self) -> [u8; Self::LENGTH] {
                let counts = [$(self.$triad),*].into_iter().flatten();
                let words = counts.map(|count| u16::from_ne_bytes(count.to_ne_bytes()));
                frame(words, self.temperature, self.timer)
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
    attitude: roll pitch yaw,
    /// Angular rates, 1.5 × rated range/32768 a count.
    angular_rate: p q r,
    /// Accelerations, 1.5 × rated range/32768 a count.
    acceleration: ax ay az,
    /// Magnetic field, 1.875 gauss/32768 a count.
    magnetic_field: mx my mz
}

packet! {
    /// A packet of scaled mode, 24 bytes: [`AnglePacket`] without the attitude.
    ScaledPacket, 24, i16,
    /// Angular rates, 1.5 × rated range/32768 a count.
    angular_rate: p q r,
    /// Accelerations, 1.5 × rated range/32768 a count.
    acceleration: ax ay az,
    /// Magnetic field, 1.875 gauss/32768 a count.
    magnetic_field: mx my mz
}

packet! {
    /// A packet of voltage mode, 24 bytes: the readings of the analogue-to-digital converters, 5 V/4096 a count.
    ///
    /// The calibration sheet of each inertial unit gives the conversion from these volts to rates and accelerations.
    VoltagePacket, 24, u16,
    /// Gyros, converter counts.
    angular_rate: p q r,
    /// Accelerometers, converter counts.
    acceleration: ax ay az,
    /// Magnetometers, converter counts.
    magnetic_field: mx my mz
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

/// The `WORDS` words of the frame at the start of `bytes`, after the check of header and checksum.
fn words<const WORDS: usize>(bytes: &[u8]) -> Result<[u16; WORDS], PacketError> {
    let expected = 2 * WORDS + 2;
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
    let mut words = [0; WORDS];
    for (word, pair) in words.iter_mut().zip(payload.as_chunks().0) {
        *word = u16::from_be_bytes(*pair);
    }
    Ok(words)
}

/// The frame of a packet's sensor words, temperature and timer.
fn frame<const LENGTH: usize>(
    sensors: impl Iterator<Item = u16>,
    temperature: u16,
    timer: u16,
) -> [u8; LENGTH] {
    let mut bytes = [HEADER; LENGTH];
    if let [_, payload @ .., checksum] = bytes.as_mut_slice() {
        let words = sensors.chain([temperature, timer]);
        for (pair, word) in payload.as_chunks_mut().0.iter_mut().zip(words) {
            *pair = word.to_be_bytes();
        }
        *checksum = sum(payload);
    }
    bytes
}

fn sum(payload: &[u8]) -> u8 {
    payload.iter().fold(0, |sum, byte| sum.wrapping_add(*byte))
}
