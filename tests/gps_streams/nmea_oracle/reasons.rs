//! Reasons for differences between the two readers, and which reader is right by NMEA 0183.

use super::Difference::{self, OnlyOracle, OnlyOurs, Value};
use super::readers::Quantity::{self, *};
use super::sentences::{Kind, Sentence, angle, decimal, whole_digits};

/// A rule that one of the readers does not follow, or that NMEA 0183 leaves open.
pub struct Reason {
    pub name: &'static str,
    /// The rule of NMEA 0183, and the reader that follows it.
    pub rule: &'static str,
    /// Whether this reason explains the difference.
    pub explains: fn(&Sentence, &Difference) -> bool,
}

pub const REASONS: &[Reason] = &[
    Reason {
        name: "maker's talker",
        rule: "Talkers that begin with P belong to makers: ours is right to ignore them.",
        explains: |sentence, difference| {
            *difference == OnlyOracle && sentence.talker().starts_with('P')
        },
    },
    Reason {
        name: "signed checksum",
        rule: "A checksum is two hexadecimal digits: ours is right to reject `+5`.",
        explains: |sentence, difference| {
            *difference == OnlyOracle && sentence.checksum().starts_with('+')
        },
    },
    Reason {
        name: "control character",
        rule: "Control characters are reserved: ours is right to reject them.",
        explains: |sentence, difference| {
            *difference == OnlyOracle
                && sentence.body().bytes().any(|byte| !(b' '..=b'~').contains(&byte))
        },
    },
    Reason {
        name: "length",
        rule: "82 characters are allowed, receivers send more: ours reads 128, the oracle 102.",
        explains: |sentence, difference| *difference == OnlyOurs && sentence.text.len() > 102,
    },
    Reason {
        name: "null time",
        rule: "A null time is allowed: ours needs it, for it tells epochs apart.",
        explains: |sentence, difference| {
            *difference == OnlyOracle && sentence.kind.has_time() && sentence.field(0).is_empty()
        },
    },
    Reason {
        name: "form of the time",
        rule: "A time is six digits and a fraction: ours is right to reject others.",
        explains: |sentence, difference| {
            let field = sentence.field(0);
            *difference == OnlyOracle
                && sentence.kind.has_time()
                && !field.is_empty()
                && !is_time(field)
        },
    },
    Reason {
        name: "fraction of a nanosecond",
        rule: "No rule: ours truncates, the oracle rounds, and rejects a fraction rounded to 1 s.",
        explains: |sentence, difference| {
            let digits =
                sentence.field(0).split_once('.').map_or(0, |(_, fraction)| fraction.len());
            sentence.kind.has_time()
                && digits > 9
                && match difference {
                    OnlyOurs => sentence.field(0).contains(".999999999"),
                    Value { quantity: TimeOfDayNs, ours: Some(ours), oracle: Some(oracle) } => {
                        oracle - ours == 1.0
                    }
                    _ => false,
                }
        },
    },
    Reason {
        name: "null position",
        rule: "A fix has a position: ours is right to reject one without.",
        explains: |sentence, difference| {
            *difference == OnlyOracle
                && sentence.kind.position().is_some_and(|first| {
                    (first..first + 4).all(|index| sentence.field(index).is_empty())
                })
        },
    },
    Reason {
        name: "position off the Earth",
        rule: "A position is ddmm.mm and dddmm.mm on Earth: ours is right to reject others.",
        explains: |sentence, difference| {
            *difference == OnlyOracle
                && sentence.kind.position().is_some_and(|first| {
                    !sentence.field(first).is_empty()
                        && (angle(sentence.field(first), 2, 90.0).is_none()
                            || angle(sentence.field(first + 2), 3, 180.0).is_none())
                })
        },
    },
    Reason {
        name: "impossible motion",
        rule: "No receiver reports 100 km, 600 m/s or more than 360°: ours is right to reject them.",
        explains: |sentence, difference| {
            let number = |index| decimal(sentence.field(index));
            let beyond = |index, least: f64, most: f64| {
                number(index).is_some_and(|value| !(least..=most).contains(&value))
            };
            let height = |index| beyond(index, -1e5, 1e5);
            let speed = |index| beyond(index, 0.0, 600.0 * 3_600.0 / 1_852.0);
            let course = |index| beyond(index, 0.0, 360.0);
            match (difference, sentence.kind) {
                (OnlyOracle, Kind::Gga) => height(8) || height(10),
                (OnlyOracle, Kind::Gns) => height(8) || height(9),
                (OnlyOracle, Kind::Rmc) => speed(6) || course(7),
                (OnlyOracle, Kind::Vtg) => speed(4) || course(0),
                (Value { quantity: GeoidSeparationM, ours: None, .. }, kind) => {
                    let separation = number(if kind == Kind::Gga { 10 } else { 9 });
                    number(8).zip(separation).is_some_and(|(a, b)| (a + b).abs() > 1e5)
                }
                _ => false,
            }
        },
    },
    Reason {
        name: "form of a number",
        rule: "A number is a minus, digits and a point: ours is right to ignore `+1`, `1e3`, `nan`.",
        explains: |sentence, difference| {
            let Value { quantity, ours: None, oracle: Some(_) } = difference else { return false };
            fields_of(sentence.kind, *quantity).iter().any(|index| is_odd(sentence.field(*index)))
        },
    },
    Reason {
        name: "malformed number",
        rule: "No rule: ours ignores the malformed value, the oracle rejects the sentence.",
        explains: |sentence, difference| {
            *difference == OnlyOurs
                && sentence.kind.numbers().iter().any(|index| is_odd(sentence.field(*index)))
        },
    },
    Reason {
        name: "malformed date",
        rule: "A date is six digits: ours ignores others, the oracle rejects or takes a sign.",
        explains: |sentence, difference| {
            let field = sentence.field(8);
            sentence.kind == Kind::Rmc
                && !field.is_empty()
                && !(field.len() == 6 && is_whole(field))
                && matches!(difference, OnlyOurs | Value { quantity: Day, ours: None, .. })
        },
    },
    Reason {
        name: "number of digits",
        rule: "Digits have no limit: ours reads 15, and ignores numbers of more before the point.",
        explains: |sentence, difference| {
            let Value { quantity, ours: None | Some(0.0), .. } = difference else { return false };
            fields_of(sentence.kind, *quantity).iter().any(|index| {
                let field = sentence.field(*index);
                whole_digits(field) > 15
                    || decimal(field).is_some_and(|value| (1e-300..1e-14).contains(&value))
            })
        },
    },
    Reason {
        name: "long count",
        rule: "Satellites are two digits: ours is right to reject more than nine.",
        explains: |sentence, difference| {
            *difference == OnlyOracle && has_satellites(sentence) && sentence.field(6).len() > 9
        },
    },
    Reason {
        name: "many satellites",
        rule: "No receiver uses more than 255 satellites: ours ignores the count.",
        explains: |sentence, difference| {
            has_satellites(sentence)
                && sentence.field(6).parse::<u32>().is_ok_and(|count| count > 255)
                && matches!(difference, Value { quantity: Satellites, ours: None, .. })
        },
    },
    Reason {
        name: "too many satellites",
        rule: "No receiver uses 65536 satellites: ours ignores the count, the oracle the sentence.",
        explains: |sentence, difference| {
            sentence.kind == Kind::Gns
                && sentence.field(6).parse::<u32>().is_ok_and(|count| count > 65_535)
                && *difference == OnlyOurs
        },
    },
    Reason {
        name: "placeholder of a dilution",
        rule: "A dilution is positive: ours is right to ignore zero, and ignores those from 1000.",
        explains: |sentence, difference| match difference {
            Value {
                quantity: quantity @ (PositionDilution | HorizontalDilution | VerticalDilution),
                ours: None,
                oracle: Some(_),
            } => fields_of(sentence.kind, *quantity).iter().any(|index| {
                decimal(sentence.field(*index)).is_some_and(|value| !(1e-14..1e3).contains(&value))
            }),
            _ => false,
        },
    },
    Reason {
        name: "null dilution",
        rule: "Fields may be null: ours is right to read GSA with a null dilution.",
        explains: |sentence, difference| {
            (14..17).any(|index| sentence.field(index).is_empty())
                && misread_dilutions(sentence, difference)
        },
    },
    Reason {
        name: "whole dilution",
        rule: "Fields 3 to 14 are satellites: the oracle is wrong to read a dilution of `2` as one.",
        explains: |sentence, difference| {
            let whole =
                |index| !sentence.field(index).is_empty() && is_whole(sentence.field(index));
            (14..17).any(whole) && misread_dilutions(sentence, difference)
        },
    },
    Reason {
        name: "layout of GSA",
        rule: "GSA has twelve satellites and one digit at its end: ours is right to reject others.",
        explains: |sentence, difference| {
            sentence.kind == Kind::Gsa
                && *difference == OnlyOracle
                && (!(17..=18).contains(&sentence.field_count())
                    || sentence.field(17).len() > 1
                    || (2..14).any(|index| {
                        let field = sentence.field(index);
                        field.len() > 9 || !is_whole(field)
                    }))
        },
    },
    Reason {
        name: "unsafe RMC",
        rule: "Status U of RMC means unsafe: ours is right, the oracle does not know the letter.",
        explains: |sentence, difference| {
            sentence.kind == Kind::Rmc && *difference == OnlyOracle && sentence.field(12) == "U"
        },
    },
    Reason {
        name: "system against talker",
        rule: "Talker and system must agree: the oracle is right, and ours uses neither.",
        explains: |sentence, difference| {
            let own = match sentence.talker() {
                "GP" => 1,
                "GL" => 2,
                "GA" => 3,
                "GB" | "BD" => 4,
                _ => return false,
            };
            sentence.kind == Kind::Gsa
                && *difference == OnlyOurs
                && sentence.field(17).starts_with(['1', '2', '3', '4'])
                && sentence.field(17).parse() != Ok(own)
        },
    },
    Reason {
        name: "GNS of many systems",
        rule: "GNS has a mode for each of six systems: ours is right, the oracle reads two.",
        explains: |sentence, difference| {
            sentence.kind == Kind::Gns && *difference == OnlyOurs && sentence.field(5).len() > 2
        },
    },
    Reason {
        name: "best mode",
        rule: "No rule which system's mode counts: ours uses the best, the oracle the first.",
        explains: |sentence, difference| {
            sentence.kind == Kind::Gns
                && sentence.field(5).len() == 2
                && matches!(difference, Value { quantity: Quality, ours: Some(_), oracle: Some(_) })
        },
    },
    Reason {
        name: "unknown mode",
        rule: "New modes may come: ours is right to read GNS if another system has a known mode.",
        explains: |sentence, difference| {
            sentence.kind == Kind::Gns
                && *difference == OnlyOurs
                && sentence.field(5).contains(|mode| !"ACDEFMNPRSU".contains(mode))
        },
    },
    Reason {
        name: "caution",
        rule: "RMC has no mode C: ours goes by the status, the oracle ranks it as no fix.",
        explains: |sentence, difference| {
            sentence.kind == Kind::Rmc && *difference == OnlyOurs && sentence.field(11) == "C"
        },
    },
    Reason {
        name: "magnetic variation",
        rule: "A variation is a number and E or W: the oracle is right, and ours uses neither.",
        explains: |sentence, difference| {
            let (variation, direction) = (sentence.field(9), sentence.field(10));
            sentence.kind == Kind::Rmc
                && *difference == OnlyOurs
                && !variation.is_empty()
                && (decimal(variation).is_none() || !["E", "W"].contains(&direction))
        },
    },
    Reason {
        name: "letter without variation",
        rule: "The mode is field 12: the oracle is wrong to lose it behind a lone or long letter.",
        explains: |sentence, difference| {
            let (variation, direction) = (sentence.field(9), sentence.field(10));
            sentence.kind == Kind::Rmc
                && *difference == OnlyOracle
                && (direction.len() > 1 || (variation.is_empty() && !direction.is_empty()))
                && (sentence.field(12) == "U"
                    || ["N", "E", "M", "S", "U"].contains(&sentence.field(11)))
        },
    },
    Reason {
        name: "text behind the last value",
        rule: "A field ends at its comma: the oracle is wrong to accept text behind the value.",
        explains: |sentence, difference| {
            *difference == OnlyOracle
                && match sentence.kind {
                    Kind::Gga => !["", "M"].contains(&sentence.field(11)),
                    Kind::Gst => sentence.field(7).starts_with(|c: char| c.is_ascii_alphabetic()),
                    Kind::Gns | Kind::Gsa | Kind::Rmc | Kind::Vtg => false,
                }
        },
    },
    Reason {
        name: "form of a mode or status",
        rule: "Mode and status are one letter each: ours is right to reject digits and more letters.",
        explains: |sentence, difference| {
            let is_odd = |index| {
                let field = sentence.field(index);
                field.len() > 1 || field.contains(|c: char| !c.is_ascii_alphabetic())
            };
            *difference == OnlyOracle
                && match sentence.kind {
                    Kind::Gns => is_odd(12),
                    Kind::Rmc => is_odd(11) || is_odd(12),
                    Kind::Gga | Kind::Gsa | Kind::Gst | Kind::Vtg => false,
                }
        },
    },
    Reason {
        name: "unit of a number",
        rule: "A number has its unit behind it: ours is right to reject knots without N.",
        explains: |sentence, difference| {
            sentence.kind == Kind::Vtg
                && *difference == OnlyOracle
                && !["", "N"].contains(&sentence.field(5))
        },
    },
    Reason {
        name: "null sigma",
        rule: "A sigma may be null: the oracle is right, ours gives three or nothing.",
        explains: |sentence, difference| {
            matches!(
                difference,
                Value { quantity: SigmaNorthM | SigmaEastM | SigmaDownM, ours: None, .. }
            ) && (5..8).any(|index| decimal(sentence.field(index)).is_none_or(|sigma| sigma <= 0.0))
        },
    },
];

/// Whether NMEA 0183 has no such number.
fn is_odd(field: &str) -> bool {
    !field.is_empty() && decimal(field).is_none()
}

fn is_whole(text: &str) -> bool {
    text.bytes().all(|byte| byte.is_ascii_digit())
}

/// Whether the oracle counts the fields of GSA wrongly: it rejects the sentence, or shifts dilutions.
fn misread_dilutions(sentence: &Sentence, difference: &Difference) -> bool {
    sentence.kind == Kind::Gsa
        && match difference {
            OnlyOurs => true,
            Value { quantity, .. } => *quantity != Dimension,
            OnlyOracle => false,
        }
}

fn is_time(field: &str) -> bool {
    let (whole, fraction) = field.split_once('.').unwrap_or((field, ""));
    whole.len() == 6 && is_whole(whole) && is_whole(fraction)
}

fn has_satellites(sentence: &Sentence) -> bool {
    matches!(sentence.kind, Kind::Gga | Kind::Gns)
}

/// Indices of the fields that a quantity comes from.
fn fields_of(kind: Kind, quantity: Quantity) -> &'static [usize] {
    match (kind, quantity) {
        (Kind::Gga | Kind::Gns, HorizontalDilution) => &[7],
        (Kind::Gga | Kind::Gns, AltitudeMslM) => &[8],
        (Kind::Gga, GeoidSeparationM) => &[8, 10],
        (Kind::Gns, GeoidSeparationM) => &[8, 9],
        (Kind::Rmc, SpeedMps) => &[6],
        (Kind::Rmc, NorthMps | EastMps) => &[6, 7],
        (Kind::Vtg, SpeedMps) => &[4],
        (Kind::Vtg, NorthMps | EastMps) => &[0, 4],
        (Kind::Gsa, PositionDilution) => &[14],
        (Kind::Gsa, HorizontalDilution) => &[15],
        (Kind::Gsa, VerticalDilution) => &[16],
        (Kind::Gst, SigmaNorthM | SigmaEastM | SigmaDownM) => &[5, 6, 7],
        _ => &[],
    }
}
