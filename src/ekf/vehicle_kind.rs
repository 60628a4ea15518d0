//! Kinds of vehicles.

/// Kind of a vehicle, as its user declares it. It determines whether the filter assumes wheels.
///
/// # Source
/// Equation (M17) of docs/equations.md.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(rename_all = "kebab-case")
)]
pub enum VehicleKind {
    /// Helicopter with one main rotor.
    Helicopter,
    /// Vehicle with several rotors.
    Multirotor,
    /// Aeroplane.
    FixedWing,
    /// Vehicle on wheels. While fixes are absent, the filter constrains its motion to the road from the first sample
    /// on. The fixes show the direction of travel in body axes; before that it is uncertain by the mounting of the
    /// inertial unit.
    Wheeled,
    /// Vessel on water.
    Boat,
    /// Unit in a hand or on a person.
    Handheld,
}
