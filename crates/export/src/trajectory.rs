//! TUM and EuRoC trajectories.
//!
//! # Source
//! TUM RGB-D benchmark, file formats: `timestamp tx ty tz qx qy qz qw`. EuRoC MAV dataset,
//! `state_groundtruth_estimate0`: nanoseconds, position, quaternion w x y z, velocity, gyro bias,
//! accelerometer bias.

use std::io::Write as _;

use hovernav::earth::Geodetic;
use hovernav::ekf::Solution;

use crate::local::{enu, flu, flu_to_enu, position_m};
use crate::{ExportError, Out, Sink};

/// TUM's trajectory.
pub struct Tum<'w> {
    out: Out<'w>,
    /// Position of the first solution.
    origin: Option<Geodetic>,
}

impl<'w> Tum<'w> {
    pub fn new(out: Out<'w>) -> Self {
        Self { out, origin: None }
    }

    /// Writes the head of the file, with the origin of the local coordinates.
    fn begin(&mut self, origin: Geodetic) -> Result<Geodetic, ExportError> {
        writeln!(
            self.out,
            "# east, north, up from {:.9} {:.9} {:.4} (deg, deg, m above the ellipsoid); body axes \
             forward, left, up",
            origin.latitude_deg(),
            origin.longitude_deg(),
            origin.height_m
        )?;
        writeln!(self.out, "# timestamp tx ty tz qx qy qz qw")?;
        self.origin = Some(origin);
        Ok(origin)
    }
}

impl Sink for Tum<'_> {
    fn push(&mut self, solution: &Solution) -> Result<(), ExportError> {
        let origin = self.origin.map_or_else(|| self.begin(solution.position), Ok)?;
        let [x, y, z] = position_m(solution, &origin);
        let [qx, qy, qz, qw] = flu_to_enu(solution.body_to_ned);
        let time = solution.time.seconds();
        writeln!(self.out, "{time:.6} {x:.5} {y:.5} {z:.5} {qx:.9} {qy:.9} {qz:.9} {qw:.9}")?;
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<(), ExportError> {
        Ok(self.out.flush()?)
    }
}

/// EuRoC's ground truth.
pub struct Euroc<'w> {
    out: Out<'w>,
    /// Position of the first solution.
    origin: Option<Geodetic>,
}

impl<'w> Euroc<'w> {
    pub fn new(mut out: Out<'w>) -> Result<Self, ExportError> {
        // Its readers expect one header line and no other comments.
        writeln!(
            out,
            "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],\
             q_RS_z [],v_RS_R_x [m s^-1],v_RS_R_y [m s^-1],v_RS_R_z [m s^-1],b_w_RS_S_x [rad s^-1],\
             b_w_RS_S_y [rad s^-1],b_w_RS_S_z [rad s^-1],b_a_RS_S_x [m s^-2],b_a_RS_S_y [m s^-2],\
             b_a_RS_S_z [m s^-2]"
        )?;
        Ok(Self { out, origin: None })
    }
}

impl Sink for Euroc<'_> {
    fn push(&mut self, solution: &Solution) -> Result<(), ExportError> {
        let Solution { gyro_bias_radps, accel_bias_mps2, velocity_mps, .. } = *solution;
        let origin = self.origin.get_or_insert(solution.position);
        let [x, y, z] = position_m(solution, origin);
        let [qx, qy, qz, qw] = flu_to_enu(solution.body_to_ned);
        let out = &mut self.out;
        write!(out, "{},{x:.5},{y:.5},{z:.5}", solution.time.nanoseconds())?;
        write!(out, ",{qw:.9},{qx:.9},{qy:.9},{qz:.9}")?;
        for three in [enu(velocity_mps), flu(gyro_bias_radps), flu(accel_bias_mps2)] {
            write!(out, ",{:.8},{:.8},{:.8}", three[0], three[1], three[2])?;
        }
        writeln!(out)?;
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<(), ExportError> {
        Ok(self.out.flush()?)
    }
}
