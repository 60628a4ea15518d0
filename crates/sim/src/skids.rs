//! Forces of the ground on the skids.

use hovernav::glam::DVec3;

use hovernav::frames::{Body, Ned, Rotation, Vector};
use hovernav_model::helicopter::HelicopterState;

/// Positions of the feet of the skids relative to the centre of gravity, m.
const FEET_M: [DVec3; 4] = [
    DVec3::new(0.25, 0.18, 0.38),
    DVec3::new(0.25, -0.18, 0.38),
    DVec3::new(-0.25, 0.18, 0.38),
    DVec3::new(-0.25, -0.18, 0.38),
];
/// Stiffness of a foot, N/m.
const FOOT_STIFFNESS_NPM: f64 = 4000.0;
/// Damping of a foot, N·s/m.
const FOOT_DAMPING_NSPM: f64 = 120.0;
/// Friction coefficient of a foot.
const FRICTION: f64 = 0.6;
/// Sliding speed below which friction is proportional to speed, m/s.
const SLIDE_MPS: f64 = 0.1;

/// Distance of the lowest foot below the centre of gravity, m.
pub(super) fn lowest_foot_m(body_to_ned: Rotation<Body, Ned>) -> f64 {
    let feet = FEET_M.iter().map(|&foot| (body_to_ned * Vector::<Body>::claim(foot)).z());
    feet.fold(f64::NEG_INFINITY, f64::max)
}

/// Force and moment of the ground on the skids, with the centre of gravity `height_m` above it.
///
/// # Source
/// Equation (V17) of docs/equations.md.
pub(super) fn reaction(motion: &HelicopterState, height_m: f64) -> (Vector<Body>, Vector<Body>) {
    let (mut force, mut moment) = (Vector::ZERO, Vector::ZERO);
    for foot in FEET_M {
        let arm: Vector<Body> = Vector::claim(foot);
        let depth_m = (motion.body_to_ned * arm).z() - height_m;
        if depth_m <= 0.0 {
            continue;
        }
        let velocity: Vector<Ned> =
            motion.body_to_ned * (motion.velocity_mps + motion.rate_radps.cross(arm));
        let [north, east, down] = velocity.to_array();
        let normal = (FOOT_STIFFNESS_NPM * depth_m + FOOT_DAMPING_NSPM * down).max(0.0);
        let sliding = north.hypot(east);
        let grip = -FRICTION * normal / sliding.max(SLIDE_MPS);
        let push: Vector<Ned> = Vector::new(grip * north, grip * east, -normal);
        let push = motion.body_to_ned.inverse() * push;
        force += push;
        moment += arm.cross(push);
    }
    (force, moment)
}
