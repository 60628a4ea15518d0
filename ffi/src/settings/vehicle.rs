//! Kinds of vehicles.

use hovernav::ekf::VehicleKind;

use crate::status::Fault;

/// In HovernavConfig.vehicle_kind: unstated. The fixes show whether the vehicle rolls on wheels.
pub const HOVERNAV_VEHICLE_UNSTATED: u32 = 0;
/// Helicopter with one main rotor.
pub const HOVERNAV_VEHICLE_HELICOPTER: u32 = 1;
/// Vehicle with several rotors.
pub const HOVERNAV_VEHICLE_MULTIROTOR: u32 = 2;
/// Aeroplane.
pub const HOVERNAV_VEHICLE_FIXED_WING: u32 = 3;
/// Vehicle on wheels: its velocity across the road is constrained while fixes are absent.
pub const HOVERNAV_VEHICLE_WHEELED: u32 = 4;
/// Vessel on water.
pub const HOVERNAV_VEHICLE_BOAT: u32 = 5;
/// Inertial unit held in a hand or worn by a person.
pub const HOVERNAV_VEHICLE_HANDHELD: u32 = 6;

const NUMBERS: [(u32, VehicleKind); 6] = [
    (HOVERNAV_VEHICLE_HELICOPTER, VehicleKind::Helicopter),
    (HOVERNAV_VEHICLE_MULTIROTOR, VehicleKind::Multirotor),
    (HOVERNAV_VEHICLE_FIXED_WING, VehicleKind::FixedWing),
    (HOVERNAV_VEHICLE_WHEELED, VehicleKind::Wheeled),
    (HOVERNAV_VEHICLE_BOAT, VehicleKind::Boat),
    (HOVERNAV_VEHICLE_HANDHELD, VehicleKind::Handheld),
];

pub(super) fn kind_of(number: u32) -> Result<Option<VehicleKind>, Fault> {
    let kind = NUMBERS.into_iter().find(|(of, _)| *of == number).map(|(_, kind)| kind);
    if kind.is_none() && number != HOVERNAV_VEHICLE_UNSTATED {
        return Err(Fault::new(&["vehicle_kind"], f64::from(number), "one of HOVERNAV_VEHICLE_"));
    }
    Ok(kind)
}

pub(super) fn number_of(kind: Option<VehicleKind>) -> u32 {
    let number = NUMBERS.into_iter().find(|(_, of)| Some(*of) == kind);
    number.map_or(HOVERNAV_VEHICLE_UNSTATED, |(number, _)| number)
}
