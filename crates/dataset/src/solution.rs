//! `solution.csv`: the filter's solution.

use std::path::Path;

use crate::error::LogError;
use crate::table::csv_writer::CsvWriter;
use hovernav::earth::Geodetic;
use hovernav::ekf::Solution;

/// The columns of `solution.csv`: a public interface, extended only at the end.
pub const COLUMNS: [&str; 31] = [
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

/// The numbers of one row, in the order and units of [`COLUMNS`], unrounded.
#[must_use]
pub fn solution_row(solution: &Solution) -> [f64; 31] {
    let Solution { position, velocity_mps, body_to_ned, .. } = solution;
    let groups = [
        [position.latitude_deg(), position.longitude_deg(), position.height_m],
        velocity_mps.to_array(),
        body_to_ned.euler().to_degrees(),
        solution.velocity_body_mps().to_array(),
        solution.angular_rate_radps.to_array(),
        solution.position_sigma_m.to_array(),
        solution.velocity_sigma_mps.to_array(),
        solution.attitude_sigma_rad.map(f64::to_degrees),
        solution.gyro_bias_radps.to_array(),
        solution.accel_bias_mps2.to_array(),
    ];
    let mut row = [solution.time.seconds(); 31];
    for (place, value) in row[1..].iter_mut().zip(groups.into_iter().flatten()) {
        *place = value;
    }
    row
}

/// Optional columns of `solution.csv` after the standard ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExtraColumns {
    /// The attitude from body to NED as a unit quaternion; the scalar is first and not negative: `q_w, q_x, q_y, q_z`.
    Quaternion,
    /// Displacement from the first solution, m, north, east and down: `north_m, east_m, down_m`.
    Local,
    /// Variances of position, m², velocity, m²/s², and Euler angles, rad²: the diagonal of the
    /// covariance, `var_n_m2` to `var_yaw_rad2`.
    Covariance,
}

impl ExtraColumns {
    /// All optional columns.
    pub const ALL: [Self; 3] = [Self::Quaternion, Self::Local, Self::Covariance];

    /// Name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Quaternion => "quaternion",
            Self::Local => "local",
            Self::Covariance => "covariance",
        }
    }

    const fn columns(self) -> &'static [&'static str] {
        match self {
            Self::Quaternion => &["q_w", "q_x", "q_y", "q_z"],
            Self::Local => &["north_m", "east_m", "down_m"],
            Self::Covariance => &[
                "var_n_m2",
                "var_e_m2",
                "var_d_m2",
                "var_vn_m2ps2",
                "var_ve_m2ps2",
                "var_vd_m2ps2",
                "var_roll_rad2",
                "var_pitch_rad2",
                "var_yaw_rad2",
            ],
        }
    }

    fn write(
        self,
        csv: &mut CsvWriter,
        solution: &Solution,
        origin: &Geodetic,
    ) -> Result<(), LogError> {
        match self {
            Self::Quaternion => {
                let [x, y, z, w] = solution.body_to_ned.quaternion().to_array();
                let sign = if w < 0.0 { -1.0 } else { 1.0 };
                [w, x, y, z].into_iter().try_for_each(|part| csv.fixed(sign * part, 9))
            }
            Self::Local => csv.fixed_each(solution.position.local_ned_m(origin).to_array(), 4),
            Self::Covariance => {
                let squares = |sigmas: [f64; 3]| sigmas.map(|sigma| sigma * sigma);
                let groups = [
                    solution.position_sigma_m.to_array(),
                    solution.velocity_sigma_mps.to_array(),
                    solution.attitude_sigma_rad,
                ];
                groups.map(squares).into_iter().flatten().try_for_each(|one| csv.shortest(one))
            }
        }
    }
}

/// Writer of `solution.csv`, row by row. Resolution: latitude and longitude 0.01 mm, in degrees; metres 0.1 mm;
/// velocities and angles 1e-5; rates 1e-7; biases 1e-8. The file gets its name when it is complete.
pub struct SolutionWriter {
    csv: CsvWriter,
    extra: Vec<ExtraColumns>,
    /// Position of the first solution.
    origin: Option<Geodetic>,
}

impl SolutionWriter {
    /// Starts the file `path`, with `extra` columns at the end.
    #[must_use]
    pub fn new(path: &Path, extra: &[ExtraColumns]) -> Self {
        let extra_columns = extra.iter().flat_map(|extra| extra.columns());
        let columns: Vec<&'static str> = COLUMNS.iter().chain(extra_columns).copied().collect();
        let csv = CsvWriter::new(path.to_path_buf(), &columns);
        Self { csv, extra: extra.to_vec(), origin: None }
    }

    /// Adds a row.
    ///
    /// # Errors
    /// [`LogError::Unwritable`] for a value that is NaN, infinite or beyond 9e8.
    pub fn push(&mut self, solution: &Solution) -> Result<(), LogError> {
        let csv = &mut self.csv;
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
        let origin = self.origin.get_or_insert(solution.position);
        for extra in &self.extra {
            extra.write(csv, solution, origin)?;
        }
        csv.end_row();
        Ok(())
    }

    /// Completes the file and gives it its name.
    ///
    /// # Errors
    /// [`LogError::Io`] if the file system reports an error, now or for an earlier row.
    pub fn finish(self) -> Result<(), LogError> {
        self.csv.finish()
    }
}
