//! Checks of packets with a valid checksum: impossible values, saturation, stuck sensors.

use core::fmt;

use super::packet::{AnglePacket, Packet, ScaledPacket, VoltagePacket};

/// The largest value of a 12-bit converter.
const CONVERTER_MAX: u16 = 0x0FFF;

/// A quarter turn in counts of the attitude words.
const VERTICAL: u16 = 0x4000;

/// Counts of a rate or acceleration at the rated range: full scale is 1.5 times this range.
const RATED_RANGE: u16 = 21_845;

/// Number of consecutive packets with the same three words after which a sensor counts as stuck; half a second at 33
/// Hz. Noise changes at least one of the three words earlier, even at rest.
const STUCK_AFTER: u32 = 16;

/// Change of a word from one packet to the next, counts, that counts as a jump. For angular rates it is more than any
/// helicopter reaches: half of the rated range, or 3 300 °/s² at 33 packets a second with a range of 200 °/s.
/// Accelerations change more in vibration, so only acceleration words beyond the rated range are checked.
const JUMP: u16 = RATED_RANGE / 2;

/// Smallest average number of packets from one rejected jump to the next. Violent motion thus loses at most one packet
/// a second at 33 Hz.
const JUMPS_APART: u32 = 33;
/// Number of jumps that may be rejected in quick succession.
const JUMPS_AT_ONCE: u32 = 3;

/// A triad of sensors in the inertial unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Sensor {
    /// Angular rate.
    Gyros,
    /// Acceleration.
    Accelerometers,
    /// Magnetic field.
    Magnetometers,
}

impl fmt::Display for Sensor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Gyros => "gyro",
            Self::Accelerometers => "accelerometer",
            Self::Magnetometers => "magnetometer",
        })
    }
}

/// A fault in a packet with a valid checksum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlausibilityFault {
    /// The temperature word does not fit its 12-bit converter.
    TemperatureWord {
        /// The word.
        counts: u16,
    },
    /// A word of voltage mode does not fit its 12-bit converter.
    VoltageWord {
        /// The triad.
        sensor: Sensor,
        /// 0, 1 or 2: x, y or z.
        axis: usize,
        /// The word.
        counts: u16,
    },
    /// Pitch beyond ±90°.
    Pitch {
        /// The word, 180°/32768 a count.
        counts: i16,
    },
    /// The word is at the end of its scale: the true value may be any value beyond it.
    Saturated {
        /// The triad.
        sensor: Sensor,
        /// 0, 1 or 2: x, y or z.
        axis: usize,
    },
    /// The word is beyond the rated range, where the accuracy is not specified.
    BeyondRating {
        /// The triad.
        sensor: Sensor,
        /// 0, 1 or 2: x, y or z.
        axis: usize,
        /// The word; the rated range is 21 845 counts.
        counts: i16,
    },
    /// A word differs from that of the previous packet by more than any motion: damage that passed the checksum. If the
    /// next packet has a jump too, it is accepted.
    Jump {
        /// The triad.
        sensor: Sensor,
        /// 0, 1 or 2: x, y or z.
        axis: usize,
        /// The word; the rated range is 21 845 counts.
        counts: i16,
    },
    /// All three words of a sensor are unchanged.
    Stuck {
        /// The triad.
        sensor: Sensor,
        /// Number of consecutive packets with the same words.
        packets: u32,
    },
}

impl PlausibilityFault {
    /// Whether the inertial unit cannot have sent such a value, so that no value of the packet may be used.
    #[must_use]
    pub const fn invalidates_packet(&self) -> bool {
        matches!(
            self,
            Self::TemperatureWord { .. }
                | Self::VoltageWord { .. }
                | Self::Pitch { .. }
                | Self::Jump { .. }
        )
    }
}

impl fmt::Display for PlausibilityFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let letter = |axis| ["x", "y", "z"].get(axis).copied().unwrap_or("?");
        match *self {
            Self::TemperatureWord { counts } => {
                write!(f, "temperature word: found {counts}, expected at most {CONVERTER_MAX}")
            }
            Self::VoltageWord { sensor, axis, counts } => write!(
                f,
                "{sensor} {} word: found {counts}, expected at most {CONVERTER_MAX}",
                letter(axis)
            ),
            Self::Pitch { counts } => {
                write!(f, "pitch {:.3} deg is beyond vertical", f64::from(counts) * 180.0 / 32768.0)
            }
            Self::Saturated { sensor, axis } => write!(f, "{sensor} {} is saturated", letter(axis)),
            Self::BeyondRating { sensor, axis, counts } => write!(
                f,
                "{sensor} {} at {:.2} times its rated range",
                letter(axis),
                f64::from(counts.unsigned_abs()) / f64::from(RATED_RANGE)
            ),
            Self::Jump { sensor, axis, counts } => write!(
                f,
                "{sensor} {} jumped to {:.2} times its rated range: packet rejected",
                letter(axis),
                f64::from(counts.unsigned_abs()) / f64::from(RATED_RANGE)
            ),
            Self::Stuck { sensor, packets } => {
                write!(f, "{sensor} words unchanged for {packets} packets")
            }
        }
    }
}

/// Checks one packet after another for impossible and suspect values.
///
/// ```
/// use hovernav::dmu::{AnglePacket, PlausibilityFault, Packet, Plausibility, Sensor};
/// let spinning = AnglePacket { angular_rate: [0, 0, i16::MAX], ..Default::default() };
/// let mut found = Plausibility::default().check(&Packet::Angle(spinning));
/// assert_eq!(found.next(), Some(PlausibilityFault::Saturated { sensor: Sensor::Gyros, axis: 2 }));
/// assert_eq!(found.next(), None);
/// ```
#[derive(Clone, Debug, Default)]
pub struct Plausibility {
    triads: [Repetition; 3],
    jumps: Jumps,
}

/// State of the check for single jumps.
#[derive(Clone, Copy, Debug, Default)]
struct Jumps {
    /// Rates and accelerations of the last accepted packet.
    accepted: Option<[[i16; 3]; 2]>,
    /// Rates and accelerations of the last packet, if it was rejected.
    rejected: Option<[[i16; 3]; 2]>,
    /// [`JUMPS_APART`] for each rejected packet, less one for each packet since.
    recent: u32,
}

impl Jumps {
    /// Checks the rates and accelerations of a packet for a jump. A second packet near a rejected one shows motion.
    /// Returns the fault of a rejected packet, `None` for an accepted packet.
    fn check(&mut self, words: [[i16; 3]; 2]) -> Option<PlausibilityFault> {
        self.recent = self.recent.saturating_sub(1);
        let is_frequent = self.recent >= (JUMPS_AT_ONCE - 1) * JUMPS_APART;
        let is_confirmed = self.rejected.is_some_and(|before| jump(before, words).is_none());
        let fault = self.accepted.and_then(|before| jump(before, words));
        let fault = fault.filter(|_| !(is_confirmed || is_frequent));
        if fault.is_some() {
            self.rejected = Some(words);
            self.recent += JUMPS_APART;
        } else {
            (self.accepted, self.rejected) = (Some(words), None);
        }
        fault
    }
}

/// The jump from the rates and accelerations of one packet to those of another, if there is one.
fn jump(before: [[i16; 3]; 2], words: [[i16; 3]; 2]) -> Option<PlausibilityFault> {
    let sensors = [(Sensor::Gyros, 0), (Sensor::Accelerometers, RATED_RANGE)];
    let triads = sensors.into_iter().zip(before.into_iter().zip(words));
    triads.into_iter().find_map(|((sensor, least), (before, words))| {
        let axes = before.into_iter().zip(words).enumerate();
        axes.into_iter().find_map(|(axis, (before, counts))| {
            let jumps = counts.abs_diff(before) > JUMP && counts.unsigned_abs() > least;
            jumps.then_some(PlausibilityFault::Jump { sensor, axis, counts })
        })
    })
}

#[derive(Clone, Copy, Debug, Default)]
struct Repetition {
    words: [u16; 3],
    packets: u32,
}

impl Plausibility {
    /// All faults of the next packet of the stream; empty for a good packet.
    pub fn check(&mut self, packet: &Packet) -> impl Iterator<Item = PlausibilityFault> + use<> {
        let triads = triads(packet);
        for (repetition, (_, words)) in self.triads.iter_mut().zip(triads) {
            let packets =
                if repetition.words == words { repetition.packets.saturating_add(1) } else { 1 };
            *repetition = Repetition { words, packets };
        }
        let stuck = self.triads.into_iter().zip(triads).filter_map(|(repetition, (sensor, _))| {
            let packets = repetition.packets;
            (packets >= STUCK_AFTER).then_some(PlausibilityFault::Stuck { sensor, packets })
        });
        let voltage = matches!(packet, Packet::Voltage(_));
        let jump = match *packet {
            Packet::Angle(AnglePacket { angular_rate, acceleration, .. })
            | Packet::Scaled(ScaledPacket { angular_rate, acceleration, .. }) => {
                self.jumps.check([angular_rate, acceleration])
            }
            Packet::Voltage(_) => None,
        };
        // The words of a rejected packet are not checked further: they are not used.
        let used = triads.into_iter().filter(move |_| jump.is_none());
        let words = used.flat_map(move |(sensor, words)| {
            words.into_iter().enumerate().filter_map(move |(axis, word)| {
                if voltage {
                    voltage_word(sensor, axis, word)
                } else {
                    signed_word(sensor, axis, word.cast_signed())
                }
            })
        });
        let impossible = temperature_word(packet).into_iter().chain(pitch(packet)).chain(jump);
        impossible.chain(words).chain(stuck)
    }
}

/// The words of the three triads, in the order of transmission.
fn triads(packet: &Packet) -> [(Sensor, [u16; 3]); 3] {
    let (rate, acceleration, magnetic) = match *packet {
        Packet::Angle(AnglePacket { angular_rate, acceleration, magnetic_field, .. })
        | Packet::Scaled(ScaledPacket { angular_rate, acceleration, magnetic_field, .. }) => (
            angular_rate.map(i16::cast_unsigned),
            acceleration.map(i16::cast_unsigned),
            magnetic_field.map(i16::cast_unsigned),
        ),
        Packet::Voltage(VoltagePacket { angular_rate, acceleration, magnetic_field, .. }) => {
            (angular_rate, acceleration, magnetic_field)
        }
    };
    [
        (Sensor::Gyros, rate),
        (Sensor::Accelerometers, acceleration),
        (Sensor::Magnetometers, magnetic),
    ]
}

fn temperature_word(packet: &Packet) -> Option<PlausibilityFault> {
    let counts = packet.temperature();
    (counts > CONVERTER_MAX).then_some(PlausibilityFault::TemperatureWord { counts })
}

fn pitch(packet: &Packet) -> Option<PlausibilityFault> {
    match *packet {
        Packet::Angle(AnglePacket { attitude: [_, counts, _], .. }) => {
            (counts.unsigned_abs() > VERTICAL).then_some(PlausibilityFault::Pitch { counts })
        }
        Packet::Scaled(_) | Packet::Voltage(_) => None,
    }
}

fn voltage_word(sensor: Sensor, axis: usize, counts: u16) -> Option<PlausibilityFault> {
    if counts > CONVERTER_MAX {
        Some(PlausibilityFault::VoltageWord { sensor, axis, counts })
    } else if counts == 0 || counts == CONVERTER_MAX {
        Some(PlausibilityFault::Saturated { sensor, axis })
    } else {
        None
    }
}

/// The fault of a signed word, if any. Magnetometers span three times the Earth's field and have no rated range below
/// full scale, so they are checked for saturation only.
fn signed_word(sensor: Sensor, axis: usize, counts: i16) -> Option<PlausibilityFault> {
    if counts == i16::MIN || counts == i16::MAX {
        Some(PlausibilityFault::Saturated { sensor, axis })
    } else if sensor != Sensor::Magnetometers && counts.unsigned_abs() > RATED_RANGE {
        Some(PlausibilityFault::BeyondRating { sensor, axis, counts })
    } else {
        None
    }
}
