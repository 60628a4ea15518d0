//! The unit of the sticks changes no result: fractions of full travel, percent, microseconds, or anything else.

use hovernav_sysid::helicopter::Identification;

use crate::data::{flown, identified};
use crate::flight::{HEAVE, YAW};

/// Derivatives by a stick; the other parameters do not have its unit.
const BY_STICK: [&str; 3] = ["Nped", "Ncol", "Zcol"];
/// Largest change of a parameter, as a fraction of its value or of its bound.
const SAME: f64 = 0.01;

/// `found` with sticks of `scale` per full travel agrees with `usual`.
fn assert_same(usual: &Identification, found: &Identification, scale: f64) {
    for (one, other) in usual.parameters().iter().zip(found.parameters()) {
        let name = &one.name;
        let unit = if BY_STICK.contains(&name.as_str()) { scale } else { 1.0 };
        let off = (other.value * unit - one.value).abs();
        let allowed = SAME * one.value.abs().max(one.bound);
        assert!(off <= allowed, "{name}: {} and {} at {scale}", one.value, other.value * unit);
        let off = (other.bound * unit - one.bound).abs();
        assert!(off <= 3.0 * SAME * one.bound, "{name}: bound {} at {scale}", other.bound * unit);
    }
}

#[test]
fn percent_microseconds_and_larger_sticks_give_the_same_vehicle() {
    let (dataset, solutions) = flown();
    for (name, usual) in [("yaw", &YAW), ("heave", &HEAVE)] {
        let of = |scale: f64, zero: f64| {
            let mut dataset = dataset.clone();
            for (_, sticks) in &mut dataset.controls {
                *sticks = sticks.map(|stick| zero + scale * stick);
            }
            identified(&dataset, &solutions, name)
        };
        for (scale, zero) in [(100.0, 0.0), (500.0, 1500.0), (8.0, 0.0), (0.125, 0.0)] {
            assert_same(usual, &of(scale, zero), scale);
        }
    }
}
