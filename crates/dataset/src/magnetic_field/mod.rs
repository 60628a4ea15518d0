//! The Earth's magnetic field from the World Magnetic Model.

mod coefficients;
#[cfg(test)]
mod tests;

use coefficients::{DEGREE, Model, WMM2020, WMM2025};
use hovernav::earth::Geodetic;
use hovernav::frames::{Ned, Vector};

/// The Earth's main magnetic field at a position and time, without the fields of rock, buildings and the vehicle.
///
/// ```
/// use hovernav::earth::Geodetic;
/// use hovernav_dataset::magnetic_field::{MagneticField, decimal_year};
///
/// let munich = Geodetic::from_degrees(48.14, 11.58, 520.0).unwrap();
/// let field = MagneticField::at(&munich, decimal_year(2026, 7, 1))?;
/// assert!((field.declination_rad().to_degrees() - 4.3).abs() < 0.1);
/// assert!((field.inclination_rad().to_degrees() - 64.4).abs() < 0.1);
/// assert!((field.strength_gauss() - 0.488).abs() < 0.001);
/// # Ok::<(), hovernav_dataset::magnetic_field::OutsideModel>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MagneticField {
    /// Field north, east and down, gauss.
    pub field_gauss: Vector<Ned>,
}

/// Reason why the World Magnetic Model does not apply.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum OutsideModel {
    /// The time is outside the years of the model.
    #[error(
        "found the year {found:.2}, expected 2020.0 to 2030.0, where the World Magnetic Model holds"
    )]
    Year {
        /// The decimal year.
        found: f64,
    },
    /// The position is too deep or too high.
    #[error(
        "found {found} m, expected the World Magnetic Model's -1 km to 850 km above the ellipsoid"
    )]
    Height {
        /// Height above the ellipsoid, m.
        found: f64,
    },
}

impl MagneticField {
    /// The field at `place` in the year `decimal_year`, with the part of the year after the decimal point: see
    /// [`decimal_year`]. The model of 2020 applies before 2025.0, that of 2025 from then on.
    ///
    /// One-sigma errors, mostly from magnetic rock: strength 0.0014 gauss, inclination 0.2°. Declination: the root of
    /// the sum of squares of 0.26° and of 0.05° divided by the horizontal field in gauss.
    ///
    /// # Errors
    /// [`OutsideModel`] before 2020.0, from 2030.0 on, below −1 km or above 850 km.
    ///
    /// # Source
    /// *The US/UK World Magnetic Model for 2025–2030* (doi:10.25923/prbc-s316), section 1.2, equations
    /// 4 to 16, and section 3.4 for the errors.
    pub fn at(place: &Geodetic, decimal_year: f64) -> Result<Self, OutsideModel> {
        let model = match decimal_year {
            2020.0..2025.0 => &WMM2020,
            2025.0..2030.0 => &WMM2025,
            found => return Err(OutsideModel::Year { found }),
        };
        if !(-1e3..=850e3).contains(&place.height_m) {
            return Err(OutsideModel::Height { found: place.height_m });
        }
        const GAUSS_PER_NANOTESLA: f64 = 1e-5;
        Ok(Self { field_gauss: model.field_nt(place, decimal_year) * GAUSS_PER_NANOTESLA })
    }

    /// Angle from true to magnetic north, east positive, rad in (−π, π].
    ///
    /// # Source
    /// Equation (E11) of docs/equations.md.
    #[must_use]
    pub fn declination_rad(&self) -> f64 {
        libm::atan2(self.field_gauss.y(), self.field_gauss.x())
    }

    /// Dip: angle from the horizontal down to the field, rad in −π/2 to π/2.
    #[must_use]
    pub fn inclination_rad(&self) -> f64 {
        libm::atan2(self.field_gauss.z(), self.horizontal_gauss())
    }

    /// Strength of the field, gauss.
    #[must_use]
    pub fn strength_gauss(&self) -> f64 {
        self.field_gauss.norm()
    }

    /// Strength of the horizontal field, gauss; below 0.02 a compass is useless.
    #[must_use]
    pub fn horizontal_gauss(&self) -> f64 {
        libm::hypot(self.field_gauss.x(), self.field_gauss.y())
    }
}

/// Start of a day as a decimal year: 2025.0 is the start of 1 January 2025. `month` is 1 to 12, `day` is from 1.
#[must_use]
pub fn decimal_year(year: u16, month: u8, day: u8) -> f64 {
    const BEFORE_MONTH: [u16; 12] = [0, 31, 59, 90, 120, 151, 181, 212, 243, 273, 304, 334];
    let is_leap = year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    let month = usize::from(month.clamp(1, 12));
    let days =
        BEFORE_MONTH[month - 1] + u16::from(is_leap && month > 2) + u16::from(day.max(1)) - 1;
    f64::from(year) + f64::from(days) / if is_leap { 366.0 } else { 365.0 }
}

impl Model {
    /// The field, nT: minus the gradient of the potential
    /// V = a Σ (a/r)^(n+1) Σ (g cos mλ + h sin mλ) P(n, m).
    ///
    /// # Source
    /// Equation (E12) of docs/equations.md.
    fn field_nt(&self, place: &Geodetic, decimal_year: f64) -> Vector<Ned> {
        /// Radius of the sphere to which the coefficients refer, m.
        const REFERENCE_RADIUS_M: f64 = 6_371_200.0;
        let [radius_m, sin, cos] = geocentric(place);
        let ratio = REFERENCE_RADIUS_M / radius_m;
        let years = decimal_year - self.epoch;
        // North, east, down in spherical coordinates.
        let [mut north, mut east, mut down] = [0.0; 3];
        let mut diagonal = Legendre { value: 1.0, slope: 0.0, over_cos: 0.0 };
        for order in 0..=DEGREE {
            if order > 0 {
                diagonal = diagonal.next_order(order, sin, cos);
            }
            let (sin_order, cos_order) = libm::sincos(order as f64 * place.longitude_rad);
            let (mut before, mut now) = (Legendre::default(), diagonal);
            for degree in order..=DEGREE {
                if degree > order {
                    (before, now) = (now, now.next_degree(&before, degree, order, sin, cos));
                }
                if degree == 0 {
                    continue;
                }
                let [g, h, g_rate, h_rate] =
                    self.coefficients[degree * (degree + 1) / 2 + order - 1];
                let (g, h) = (g + years * g_rate, h + years * h_rate);
                let scale = libm::pow(ratio, (degree + 2) as f64);
                let along = scale * (g * cos_order + h * sin_order);
                let across = scale * (g * sin_order - h * cos_order);
                north -= along * now.slope;
                east += order as f64 * across * now.over_cos;
                down -= (degree + 1) as f64 * along * now.value;
            }
        }
        // Rotation from the sphere's vertical to the ellipsoid's.
        let (sin_tilt, cos_tilt) = libm::sincos(libm::atan2(sin, cos) - place.latitude_rad);
        Vector::new(north * cos_tilt - down * sin_tilt, east, north * sin_tilt + down * cos_tilt)
    }
}

/// Distance from the Earth's centre, m, and sine and cosine of the geocentric latitude.
fn geocentric(place: &Geodetic) -> [f64; 3] {
    let [x_m, y_m, z_m] = place.to_ecef().to_array();
    let equatorial_m = libm::hypot(x_m, y_m);
    let radius_m = libm::hypot(equatorial_m, z_m);
    [radius_m, z_m / radius_m, equatorial_m / radius_m]
}

/// A Schmidt semi-normalised associated Legendre function of the sine of the latitude.
#[derive(Clone, Copy, Default)]
struct Legendre {
    value: f64,
    /// Derivative of the value with respect to the latitude.
    slope: f64,
    /// Value divided by the cosine of the latitude, finite at the poles; meaningless at order 0.
    over_cos: f64,
}

impl Legendre {
    /// P(m, m) from P(m−1, m−1).
    fn next_order(&self, order: usize, sin: f64, cos: f64) -> Self {
        let factor = match order {
            1 => 1.0,
            _ => libm::sqrt(1.0 - 0.5 / order as f64),
        };
        Self {
            value: factor * cos * self.value,
            slope: factor * (cos * self.slope - sin * self.value),
            over_cos: factor * self.value,
        }
    }

    /// P(n, m) from P(n−1, m) and from `before`, P(n−2, m).
    ///
    /// # Source
    /// Equation (E13) of docs/equations.md.
    fn next_degree(&self, before: &Self, degree: usize, order: usize, sin: f64, cos: f64) -> Self {
        let (n, m) = (degree as f64, order as f64);
        let scale = 1.0 / libm::sqrt(n * n - m * m);
        let from_last = (2.0 * n - 1.0) * scale;
        let from_before = libm::sqrt((n - 1.0) * (n - 1.0) - m * m) * scale;
        Self {
            value: from_last * sin * self.value - from_before * before.value,
            slope: from_last * (cos * self.value + sin * self.slope) - from_before * before.slope,
            over_cos: from_last * sin * self.over_cos - from_before * before.over_cos,
        }
    }
}
