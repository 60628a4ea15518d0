//! TUM and EuRoC trajectories.
//!
//! # Source
//! TUM RGB-D benchmark, file formats: `timestamp tx ty tz qx qy qz qw`. EuRoC MAV dataset,
//! `state_groundtruth_estimate0`: nanoseconds, position, quaternion w x y z, velocity, gyro bias,
//! accelerometer bias.

use std::io::{self, Write};

use hovernav::earth::Geodetic;
use hovernav::ekf::Solution;

use crate::Export;
use crate::local::{enu, flu, flu_to_enu, position_m};

fn origin(export: &Export<'_>) -> Option<Geodetic> {
    export.solutions.first().map(|solution| solution.position)
}

pub fn write_tum(export: &Export<'_>, out: &mut impl Write) -> io::Result<()> {
    let Some(origin) = origin(export) else { return Ok(()) };
    describe(out, &origin)?;
    writeln!(out, "# timestamp tx ty tz qx qy qz qw")?;
    for solution in export.solutions {
        let [x, y, z] = position_m(solution, &origin);
        let [qx, qy, qz, qw] = flu_to_enu(solution.body_to_ned);
        let time = solution.time.seconds();
        writeln!(out, "{time:.6} {x:.5} {y:.5} {z:.5} {qx:.9} {qy:.9} {qz:.9} {qw:.9}")?;
    }
    Ok(())
}

pub fn write_euroc(export: &Export<'_>, out: &mut impl Write) -> io::Result<()> {
    let Some(origin) = origin(export) else { return Ok(()) };
    // Its readers expect one line of heads, and know no other remark.
    writeln!(
        out,
        "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],\
         q_RS_z [],v_RS_R_x [m s^-1],v_RS_R_y [m s^-1],v_RS_R_z [m s^-1],b_w_RS_S_x [rad s^-1],\
         b_w_RS_S_y [rad s^-1],b_w_RS_S_z [rad s^-1],b_a_RS_S_x [m s^-2],b_a_RS_S_y [m s^-2],\
         b_a_RS_S_z [m s^-2]"
    )?;
    for solution in export.solutions {
        let Solution { gyro_bias_radps, accel_bias_mps2, velocity_mps, .. } = *solution;
        let [x, y, z] = position_m(solution, &origin);
        let [qx, qy, qz, qw] = flu_to_enu(solution.body_to_ned);
        write!(out, "{},{x:.5},{y:.5},{z:.5}", solution.time.nanoseconds())?;
        write!(out, ",{qw:.9},{qx:.9},{qy:.9},{qz:.9}")?;
        for three in [enu(velocity_mps), flu(gyro_bias_radps), flu(accel_bias_mps2)] {
            write!(out, ",{:.8},{:.8},{:.8}", three[0], three[1], three[2])?;
        }
        writeln!(out)?;
    }
    Ok(())
}

fn describe(out: &mut impl Write, origin: &Geodetic) -> io::Result<()> {
    writeln!(
        out,
        "# east, north, up from {:.9} {:.9} {:.4} (deg, deg, m above the ellipsoid); body axes \
         forward, left, up",
        origin.latitude_deg(),
        origin.longitude_deg(),
        origin.height_m
    )
}
