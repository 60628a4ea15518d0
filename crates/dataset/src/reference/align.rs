//! Alignment of a trajectory with a reference, by a turn about the vertical and a displacement.

use crate::reference::Reference;
use crate::trajectory::Trajectory;
use hovernav::earth::Geodetic;
use hovernav::frames::{Body, Ned, Rotation, Vector};
use hovernav::glam::{DQuat, DVec3};

/// Result of an alignment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alignment {
    /// The turn about the vertical, clockwise from above, rad.
    pub yaw_rad: f64,
    /// Number of times that the trajectory and the reference have in common.
    pub moments: usize,
    /// Root mean square of the remaining distances, m.
    pub rms_m: f64,
}

impl Trajectory {
    /// Aligns a trajectory with `reference` by least squares of the distance. Positions, velocities and attitudes are
    /// turned about the vertical and moved. They are neither tilted nor scaled, as both have the vertical of gravity
    /// and metres. `None`, and an unchanged trajectory, with fewer than two common times.
    ///
    /// # Source
    /// Zhang, Scaramuzza (2018), A tutorial on quantitative trajectory evaluation for visual(-inertial)
    /// odometry, section III: four degrees of freedom for estimators that observe gravity.
    pub fn align(&mut self, reference: &Reference) -> Option<Alignment> {
        let known = self.solutions.iter().enumerate().filter_map(|(index, solution)| {
            let [latitude_rad, longitude_rad, height_m] = reference.at(solution.time).position;
            let place = Geodetic { latitude_rad, longitude_rad, height_m };
            let is_known = [latitude_rad, longitude_rad, height_m].iter().all(|x| x.is_finite());
            is_known.then_some((index, place))
        });
        let known: Vec<(usize, Geodetic)> = known.collect();
        let (_, origin) = *known.first()?;
        if !self.is_local() {
            self.local_m =
                self.solutions.iter().map(|one| one.position.local_ned_m(&origin)).collect();
        }
        let pairs: Vec<(DVec3, DVec3)> = known
            .iter()
            .map(|&(index, place)| {
                (self.local_m[index].components(), place.local_ned_m(&origin).components())
            })
            .filter(|(own, _)| own.is_finite())
            .collect();
        if pairs.len() < 2 {
            return None;
        }
        let count = pairs.len() as f64;
        let own_mean = pairs.iter().map(|(own, _)| *own).sum::<DVec3>() / count;
        let mean = pairs.iter().map(|(_, there)| *there).sum::<DVec3>() / count;
        let (mut along, mut across) = (0.0, 0.0);
        for (own, there) in &pairs {
            let (a, b) = (*own - own_mean, *there - mean);
            along += a.x * b.x + a.y * b.y;
            across += a.x * b.y - a.y * b.x;
        }
        let yaw_rad = across.atan2(along);
        let turn = DQuat::from_rotation_z(yaw_rad);
        let moved = |own: DVec3| turn * (own - own_mean) + mean;
        let left = pairs.iter().map(|(own, there)| (moved(*own) - *there).length_squared());
        let rms_m = (left.sum::<f64>() / count).sqrt();
        for (offset_m, solution) in self.local_m.iter_mut().zip(&mut self.solutions) {
            *offset_m = Vector::<Ned>::claim(moved(offset_m.components()));
            let velocity_mps = turn * solution.velocity_mps.components();
            solution.velocity_mps = Vector::claim(velocity_mps);
            let attitude = turn * solution.body_to_ned.quaternion();
            solution.body_to_ned = Rotation::<Body, Ned>::claim(attitude);
        }
        self.place(&origin);
        Some(Alignment { yaw_rad, moments: pairs.len(), rms_m })
    }
}
