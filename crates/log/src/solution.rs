//! `solution.csv`: what the filter found.

use std::path::Path;

use crate::csv_writer::CsvWriter;
use crate::error::LogError;
use hovernav::ekf::Solution;

/// The columns of `solution.csv`: a public interface, only ever added to at the end.
const COLUMNS: [&str; 31] = [
    "t_s",
    "lat_deg",
    "lon_deg",
    "height_m",
    "vn_mps",
    "ve_mps",
    "vd_mps",
    "roll_deg",
    "pitch_deg",
    "yaw_deg",
    "u_mps",
    "v_mps",
    "w_mps",
    "p_radps",
    "q_radps",
    "r_radps",
    "sigma_n_m",
    "sigma_e_m",
    "sigma_d_m",
    "sigma_vn_mps",
    "sigma_ve_mps",
    "sigma_vd_mps",
    "sigma_roll_deg",
    "sigma_pitch_deg",
    "sigma_yaw_deg",
    "gyro_bias_x_radps",
    "gyro_bias_y_radps",
    "gyro_bias_z_radps",
    "accel_bias_x_mps2",
    "accel_bias_y_mps2",
    "accel_bias_z_mps2",
];

/// Writes `solutions` to the file `path`, one row each: degrees of latitude and longitude to 0.01 mm,
/// metres to 0.1 mm, velocities and angles to 1e-5, rates to 1e-7, biases to 1e-8.
///
/// # Errors
/// [`LogError::Unwritable`] for a value that is NaN, infinite or beyond 9e8; nothing is written then.
/// [`LogError::Io`] where the file system refuses.
pub fn write_solution(path: &Path, solutions: &[Solution]) -> Result<(), LogError> {
    let mut csv = CsvWriter::new(path.to_path_buf(), &COLUMNS);
    for solution in solutions {
        csv.time(solution.time);
        csv.fixed(solution.position.latitude_deg(), 10)?;
        csv.fixed_angle_deg(solution.position.longitude_deg(), 10)?;
        csv.fixed(solution.position.height_m, 4)?;
        csv.fixed_each(solution.velocity_mps.to_array(), 5)?;
        let [roll_deg, pitch_deg, yaw_deg] = solution.body_to_ned.euler().to_degrees();
        csv.fixed_angle_deg(roll_deg, 5)?;
        csv.fixed(pitch_deg, 5)?;
        csv.fixed_angle_deg(yaw_deg, 5)?;
        csv.fixed_each(solution.velocity_body_mps().to_array(), 5)?;
        csv.fixed_each(solution.angular_rate_radps.to_array(), 7)?;
        csv.fixed_each(solution.position_sigma_m.to_array(), 4)?;
        csv.fixed_each(solution.velocity_sigma_mps.to_array(), 5)?;
        csv.fixed_each(solution.attitude_sigma_rad.map(f64::to_degrees), 5)?;
        csv.fixed_each(solution.gyro_bias_radps.to_array(), 8)?;
        csv.fixed_each(solution.accel_bias_mps2.to_array(), 8)?;
        csv.end_row();
    }
    csv.finish()
}
