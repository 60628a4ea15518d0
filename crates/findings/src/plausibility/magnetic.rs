//! Check of the magnetic field against the World Magnetic Model.

use super::regression::norm;
use crate::finding::{Sensor, SetupFinding};
use hovernav_dataset::Dataset;
use hovernav_dataset::magnetic_field::{MagneticField, decimal_year};
use hovernav_dataset::statistics::Distribution;

/// Largest plausible error of the dip, °, with hard iron and a vehicle that is never level.
const DIP_DEG: f64 = 35.0;

/// Units of a field with their size in gauss, and the conversion to gauss.
const UNITS: [(f64, &str, &str); 4] = [
    (0.01, "µT", "divide by 100"),
    (0.001, "milligauss", "divide by 1000"),
    (1e-5, "nT", "divide by 100 000"),
    (1e4, "T", "multiply by 10 000"),
];

/// Statistics of the magnetic field.
#[derive(Default)]
pub(super) struct Field {
    sizes: Distribution,
    /// Sum of the field's directions, and their number.
    directions: [f64; 3],
    count: usize,
}

impl Field {
    pub fn push(&mut self, field_gauss: [f64; 3]) {
        let size = norm(field_gauss);
        self.sizes.push(size);
        for (sum, component) in self.directions.iter_mut().zip(field_gauss) {
            *sum += component / size.max(1e-12);
        }
        self.count += 1;
    }

    /// Judges the field at the position of `dataset`; `up` is the mean up direction in the body, if there is one.
    pub fn check(&self, dataset: &Dataset, up: Option<[f64; 3]>, found: &mut Vec<SetupFinding>) {
        let Some(place) = dataset.fixes.first().map(|fix| fix.position) else { return };
        let date = dataset.manifest.date.and_then(|date| date.date);
        let year = date.map_or(2025.0, |date| decimal_year(date.year, date.month, date.day));
        let model = MagneticField::at(&place, year).or_else(|_| MagneticField::at(&place, 2025.0));
        let Ok(model) = model else { return };
        let Some(size) = self.sizes.quantile(0.5) else { return };
        let expected = model.strength_gauss();
        let ratio = size / expected;
        let (size_words, is_unit) = (
            format!("the field is {size:.4} gauss strong, expected {expected:.3} gauss here"),
            UNITS.iter().find(|(unit, ..)| (0.4..2.5).contains(&(ratio * unit))),
        );
        if (0.5..2.0).contains(&ratio) {
            if let Some(up) = up {
                dip(self, up, &model, found);
            }
            return;
        }
        let (cause, mend) = match is_unit {
            Some((_, unit, mend)) => (format!("a field in {unit}"), (*mend).to_owned()),
            None => (
                "strong iron or a strong current nearby, or another unit".into(),
                format!("calibrate the magnetometer, or {IGNORE}"),
            ),
        };
        found.push(SetupFinding {
            sensor: Sensor::Magnetometer,
            is_certain: false,
            found: size_words,
            cause,
            mend,
        });
    }
}

/// Settings without a magnetometer, for the initial heading and for the filter.
const IGNORE: &str =
    "ignore it: [aiding] magnetometer = false and [alignment] heading = \"unknown\"";

/// Compares the dip of the field with that of the model.
fn dip(field: &Field, up: [f64; 3], model: &MagneticField, found: &mut Vec<SetupFinding>) {
    // The vehicle is level on average.
    let down: f64 = field.directions.iter().zip(up).map(|(sum, up)| -sum * up).sum();
    let sine = down / field.count.max(1) as f64;
    let (dip_deg, expected_deg) =
        (sine.clamp(-1.0, 1.0).asin().to_degrees(), model.inclination_rad().to_degrees());
    if (dip_deg - expected_deg).abs() <= DIP_DEG {
        return;
    }
    let turned = (dip_deg + expected_deg).abs() < 15.0 && expected_deg.abs() > 20.0;
    found.push(SetupFinding {
        sensor: Sensor::Magnetometer,
        is_certain: false,
        found: format!(
            "the field dips {dip_deg:.0}° below the horizon, expected {expected_deg:.0}° here"
        ),
        cause: if turned {
            "a z axis of the wrong sign, or axes forward, left, up".into()
        } else {
            "axes other than those of the inertial unit, or iron nearby".into()
        },
        mend: format!("rotate mag_{{x,y,z}} to forward, right, down, or {IGNORE}"),
    });
}
