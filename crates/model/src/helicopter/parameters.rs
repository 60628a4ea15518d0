//! Parameters of a helicopter, with the values of the shipped 60-class helicopter.

use std::f64::consts::PI;

/// A rotor of constant-chord, untwisted blades at constant speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotor {
    /// Radius, m.
    pub radius_m: f64,
    /// Chord of a blade, m.
    pub chord_m: f64,
    /// Number of blades.
    pub blades: f64,
    /// Lift slope of the blade section, 1/rad.
    pub lift_slope_per_rad: f64,
    /// Speed of rotation, rad/s.
    pub speed_radps: f64,
    /// Drag coefficient of the blade section at zero lift.
    pub profile_drag: f64,
}

impl Rotor {
    /// Solidity: blade area divided by disc area.
    #[must_use]
    pub fn solidity(&self) -> f64 {
        self.blades * self.chord_m / (PI * self.radius_m)
    }

    /// Speed of the blade tips, m/s.
    #[must_use]
    pub fn tip_speed_mps(&self) -> f64 {
        self.speed_radps * self.radius_m
    }

    /// Disc area, m².
    #[must_use]
    pub fn disc_area_m2(&self) -> f64 {
        PI * self.radius_m * self.radius_m
    }
}

/// Bell-Hiller stabilizer bar: a slow gyroscopic rotor whose tilt adds to the blades' cyclic pitch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StabilizerBar {
    /// Time constant of the bar's flapping, s.
    pub time_constant_s: f64,
    /// Blade flapping per bar tilt, lateral (Mettler's Bd).
    pub lateral_gain: f64,
    /// Blade flapping per bar tilt, longitudinal (Mettler's Ac).
    pub longitudinal_gain: f64,
    /// Bar tilt at full lateral stick, rad (Mettler's Dlat).
    pub lateral_tilt_rad: f64,
    /// Bar tilt at full longitudinal stick, rad (Mettler's Clon).
    pub longitudinal_tilt_rad: f64,
}

/// A fixed surface on the tail boom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fin {
    /// Area, m².
    pub area_m2: f64,
    /// Lift slope, 1/rad.
    pub lift_slope_per_rad: f64,
    /// Distance behind the centre of gravity, m.
    pub arm_m: f64,
}

/// Parameters of one helicopter and of the air. SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HelicopterParameters {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Principal moments of inertia about forward, right, down, kg·m². Products are neglected.
    pub inertia_kgm2: [f64; 3],
    /// Density of the air, kg/m³.
    pub air_density_kgpm3: f64,
    /// Gravity, m/s².
    pub gravity_mps2: f64,
    /// Main rotor, turning clockwise seen from above.
    pub main_rotor: Rotor,
    /// Inertia of one main blade about its flapping hinge, kg·m².
    pub blade_inertia_kgm2: f64,
    /// Height of the main hub above the centre of gravity, m.
    pub hub_height_m: f64,
    /// Flapping restraint of the hub, N·m/rad (Kβ).
    pub hub_stiffness_nmprad: f64,
    /// Ratio of the flap-back of a real rotor with a bar to that of an ideal rotor (Kμ).
    pub flap_back: f64,
    /// Blade flapping at full lateral stick without the bar, rad (Blat).
    pub lateral_cyclic_rad: f64,
    /// Blade flapping at full longitudinal stick without the bar, rad (Alon).
    pub longitudinal_cyclic_rad: f64,
    /// Blade pitch at full collective stick, rad.
    pub collective_rad: f64,
    /// Stabilizer bar.
    pub bar: StabilizerBar,
    /// Tail rotor, whose thrust pushes the tail to the left.
    pub tail_rotor: Rotor,
    /// Distance of the tail rotor behind the centre of gravity, m.
    pub tail_arm_m: f64,
    /// Height of the tail rotor above the centre of gravity, m.
    pub tail_height_m: f64,
    /// Yaw rate commanded by full pedal, rad/s.
    pub pedal_rate_radps: f64,
    /// Gain of the tail's rate gyro: tail blade pitch per yaw-rate error, rad per rad/s.
    pub gyro_gain_s: f64,
    /// Lowest and highest pitch of the tail blades, rad.
    pub tail_pitch_limits_rad: [f64; 2],
    /// Drag areas of the fuselage seen along forward, right, down, m².
    pub fuselage_area_m2: [f64; 3],
    /// Vertical fin.
    pub vertical_fin: Fin,
    /// Horizontal stabilizer.
    pub horizontal_fin: Fin,
}

impl HelicopterParameters {
    /// A modified Raptor 60 as in Paw (2005): 60-class, rotor of 1.5 m, 6.0 kg dry to 10.0 kg maximum, stabilizer bar,
    /// governor, rate gyro on the tail.
    ///
    /// # Source
    /// Mass and rotor diameter: Paw, table of the airframe. Blade chord, rotor speeds, tail geometry, lift slopes,
    /// flapping inertia and hub height: typical of the class. They follow Gavrilets, Mettler and Feron, *Dynamic model
    /// for a miniature aerobatic helicopter*, MIT LIDS P-2580, 2003, for an X-Cell 60. Inertias: those of the X-Cell,
    /// increased for the payload under the skids. The hub is softer than the aerobatic hub of the X-Cell, and the two
    /// bar gains differ. The effective dampings, Lp = −(Kβ+hT)(τf+Bd τs)/Ixx and likewise Mq, are then near −8 and −12
    /// 1/s. Paw's printed matrix gives these dampings if it is a one-step matrix at 33 Hz.
    #[must_use]
    pub const fn raptor60() -> Self {
        Self {
            mass_kg: 8.0,
            inertia_kgm2: [0.30, 0.38, 0.34],
            air_density_kgpm3: 1.225,
            gravity_mps2: 9.81,
            main_rotor: Rotor {
                radius_m: 0.75,
                chord_m: 0.06,
                blades: 2.0,
                lift_slope_per_rad: 5.5,
                speed_radps: 160.0,
                profile_drag: 0.024,
            },
            blade_inertia_kgm2: 0.038,
            hub_height_m: 0.235,
            hub_stiffness_nmprad: 12.0,
            flap_back: 0.5,
            lateral_cyclic_rad: 0.14,
            longitudinal_cyclic_rad: 0.14,
            collective_rad: 0.08,
            bar: StabilizerBar {
                time_constant_s: 0.20,
                lateral_gain: 0.25,
                longitudinal_gain: 0.61,
                lateral_tilt_rad: 0.30,
                longitudinal_tilt_rad: 0.30,
            },
            tail_rotor: Rotor {
                radius_m: 0.13,
                chord_m: 0.029,
                blades: 2.0,
                lift_slope_per_rad: 5.0,
                speed_radps: 746.0,
                profile_drag: 0.024,
            },
            tail_arm_m: 0.91,
            tail_height_m: 0.08,
            pedal_rate_radps: 2.0,
            gyro_gain_s: 0.25,
            tail_pitch_limits_rad: [-0.35, 0.5],
            fuselage_area_m2: [0.20, 0.35, 0.15],
            vertical_fin: Fin { area_m2: 0.012, lift_slope_per_rad: 2.0, arm_m: 0.91 },
            horizontal_fin: Fin { area_m2: 0.010, lift_slope_per_rad: 3.0, arm_m: 0.71 },
        }
    }

    /// Time constant of the bare rotor's flapping, s: τf = 16/(γΩ), γ = ρ a c R⁴/Iβ.
    ///
    /// # Source
    /// Equation (V9) of docs/equations.md.
    #[must_use]
    pub fn flapping_time_constant_s(&self) -> f64 {
        16.0 / (self.lock_number() * self.main_rotor.speed_radps)
    }

    /// Lock number of a main blade, γ: ratio of aerodynamic to inertial moment.
    #[must_use]
    pub fn lock_number(&self) -> f64 {
        let rotor = &self.main_rotor;
        self.air_density_kgpm3 * rotor.lift_slope_per_rad * rotor.chord_m * rotor.radius_m.powi(4)
            / self.blade_inertia_kgm2
    }

    /// Cross-coupling of the two flapping angles by the hub's restraint, 8Kβ/(γΩ²Iβ).
    #[must_use]
    pub fn flapping_coupling(&self) -> f64 {
        8.0 * self.hub_stiffness_nmprad
            / (self.lock_number() * self.main_rotor.speed_radps.powi(2) * self.blade_inertia_kgm2)
    }

    /// Name and value of the first parameter outside its physical range.
    pub(super) fn out_of_range(&self) -> Option<(&'static str, f64)> {
        let above_zero = [
            ("mass_kg", self.mass_kg),
            ("inertia_kgm2 about forward", self.inertia_kgm2[0]),
            ("inertia_kgm2 about right", self.inertia_kgm2[1]),
            ("inertia_kgm2 about down", self.inertia_kgm2[2]),
            ("air_density_kgpm3", self.air_density_kgpm3),
            ("gravity_mps2", self.gravity_mps2),
            ("main_rotor.radius_m", self.main_rotor.radius_m),
            ("main_rotor.chord_m", self.main_rotor.chord_m),
            ("main_rotor.blades", self.main_rotor.blades),
            ("main_rotor.lift_slope_per_rad", self.main_rotor.lift_slope_per_rad),
            ("main_rotor.speed_radps", self.main_rotor.speed_radps),
            ("blade_inertia_kgm2", self.blade_inertia_kgm2),
            ("lateral_cyclic_rad", self.lateral_cyclic_rad),
            ("longitudinal_cyclic_rad", self.longitudinal_cyclic_rad),
            ("collective_rad", self.collective_rad),
            ("bar.time_constant_s", self.bar.time_constant_s),
            ("tail_rotor.radius_m", self.tail_rotor.radius_m),
            ("tail_rotor.chord_m", self.tail_rotor.chord_m),
            ("tail_rotor.blades", self.tail_rotor.blades),
            ("tail_rotor.lift_slope_per_rad", self.tail_rotor.lift_slope_per_rad),
            ("tail_rotor.speed_radps", self.tail_rotor.speed_radps),
            ("tail_arm_m", self.tail_arm_m),
            ("pedal_rate_radps", self.pedal_rate_radps),
            ("gyro_gain_s", self.gyro_gain_s),
        ];
        let not_below_zero = [
            ("main_rotor.profile_drag", self.main_rotor.profile_drag),
            ("tail_rotor.profile_drag", self.tail_rotor.profile_drag),
            ("hub_height_m", self.hub_height_m),
            ("hub_stiffness_nmprad", self.hub_stiffness_nmprad),
            ("flap_back", self.flap_back),
            ("bar.lateral_gain", self.bar.lateral_gain),
            ("bar.longitudinal_gain", self.bar.longitudinal_gain),
            ("bar.lateral_tilt_rad", self.bar.lateral_tilt_rad),
            ("bar.longitudinal_tilt_rad", self.bar.longitudinal_tilt_rad),
            ("fuselage_area_m2 along forward", self.fuselage_area_m2[0]),
            ("fuselage_area_m2 along right", self.fuselage_area_m2[1]),
            ("fuselage_area_m2 along down", self.fuselage_area_m2[2]),
            ("vertical_fin.area_m2", self.vertical_fin.area_m2),
            ("vertical_fin.lift_slope_per_rad", self.vertical_fin.lift_slope_per_rad),
            ("horizontal_fin.area_m2", self.horizontal_fin.area_m2),
            ("horizontal_fin.lift_slope_per_rad", self.horizontal_fin.lift_slope_per_rad),
        ];
        let [low, high] = self.tail_pitch_limits_rad;
        let any_finite = [
            ("tail_height_m", self.tail_height_m),
            ("vertical_fin.arm_m", self.vertical_fin.arm_m),
            ("horizontal_fin.arm_m", self.horizontal_fin.arm_m),
            ("tail_pitch_limits_rad, high above low by", high - low),
        ];
        let positive = |value: f64| value > 0.0 && value.is_finite();
        above_zero
            .into_iter()
            .find(|&(_, value)| !positive(value))
            .or_else(|| not_below_zero.into_iter().find(|&(_, v)| !(v >= 0.0 && v.is_finite())))
            .or_else(|| any_finite.into_iter().find(|&(_, value)| !value.is_finite()))
            .or_else(|| {
                (high <= low).then_some(("tail_pitch_limits_rad, high above low by", high - low))
            })
    }
}
