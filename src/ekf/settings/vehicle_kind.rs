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
    /// Vehicle on wheels. From 2.5 s after the last fix on, the filter limits its velocity to the direction of the
    /// road, without first having to detect wheels from fixes. The direction of travel in the inertial unit's axes is
    /// as uncertain as the mounting of the inertial unit, until fixes show it. Only layouts with
    /// [`WHEELS`](crate::ekf::layout::Layout::WHEELS) have this constraint; in others the kind has no effect.
    Wheeled,
    /// Vessel on water.
    Boat,
    /// Inertial unit in a hand or on a person.
    Handheld,
}
