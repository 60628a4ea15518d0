use super::*;
use approx::assert_abs_diff_eq;
use proptest::prelude::*;

/// A row of published test values: decimal year, height, km, latitude and longitude, °, then
/// declination, °, inclination, °, and north, east, down and strength, nT.
type Row = [f64; 10];

/// About every fourth of NCEI's test values of the 2025 model, `WMM2025_TestValues.txt`.
#[rustfmt::skip]
const OF_2025: [Row; 34] = [
    [2025.0, 28.0, 89.0, -121.0, -99.77, 88.47, -255.0, -1482.0, 56194.0, 56214.0],
    [2025.0, 48.0, 80.0, -96.0, -29.91, 87.77, 1876.0, -1079.0, 55623.0, 55665.0],
    [2025.0, 65.0, 43.0, 93.0, 0.50, 64.10, 24300.0, 211.0, 50038.0, 55627.0],
    [2025.0, 51.0, -33.0, 109.0, -5.49, -67.50, 21738.0, -2090.0, -52710.0, 57055.0],
    [2025.0, 39.0, -59.0, -8.0, -15.75, -58.55, 14358.0, -4049.0, -24389.0, 28590.0],
    [2025.0, 66.0, 14.0, 143.0, -0.19, 12.82, 35003.0, -117.0, 7966.0, 35899.0],
    [2025.0, 18.0, 0.0, 21.0, 1.29, -26.06, 29275.0, 660.0, -14317.0, 32595.0],
    [2025.5, 6.0, -36.0, -137.0, 20.28, -52.11, 23782.0, 8787.0, -32578.0, 41281.0],
    [2025.5, 50.0, -70.0, -133.0, 57.21, -71.94, 9022.0, 14002.0, -51085.0, 53732.0],
    [2025.5, 8.0, -66.0, 17.0, -33.14, -59.55, 15201.0, -9926.0, -30881.0, 35822.0],
    [2025.5, 44.0, 33.0, -118.0, 11.10, 57.89, 23236.0, 4558.0, 37728.0, 44543.0],
    [2026.0, 74.0, -57.0, 3.0, -22.51, -58.65, 13268.0, -5498.0, -23576.0, 27606.0],
    [2026.0, 33.0, -3.0, -147.0, 9.71, -2.12, 30514.0, 5222.0, -1147.0, 30979.0],
    [2026.0, 83.0, 86.0, -46.0, -30.61, 86.84, 2582.0, -1528.0, 54279.0, 54362.0],
    [2026.0, 56.0, -81.0, 40.0, -59.77, -68.45, 9001.0, -15447.0, -45268.0, 48670.0],
    [2026.5, 14.0, 0.0, 80.0, -3.10, -17.15, 39431.0, -2133.0, -12189.0, 41327.0],
    [2026.5, 44.0, -46.0, -42.0, -11.36, -54.39, 13863.0, -2786.0, -19744.0, 24286.0],
    [2026.5, 12.0, -79.0, 115.0, -137.58, -77.37, -9614.0, -8786.0, -58104.0, 59546.0],
    [2026.5, 86.0, -11.0, 167.0, 10.24, -31.60, 32578.0, 5883.0, -20368.0, 38869.0],
    [2027.0, 67.0, 72.0, -115.0, 13.73, 84.84, 4883.0, 1193.0, 55690.0, 55916.0],
    [2027.0, 54.0, 54.0, 178.0, 0.63, 65.46, 20616.0, 225.0, 45150.0, 49634.0],
    [2027.0, 57.0, -43.0, 50.0, -48.27, -63.13, 11204.0, -12563.0, -33221.0, 37243.0],
    [2027.0, 61.0, 59.0, -77.0, -16.48, 78.68, 10438.0, -3087.0, 54398.0, 55476.0],
    [2027.5, 8.0, 62.0, 53.0, 19.39, 76.67, 12260.0, 4315.0, 54850.0, 56369.0],
    [2027.5, 0.0, -13.0, -59.0, -17.49, -15.26, 21366.0, -6733.0, -6112.0, 23220.0],
    [2027.5, 72.0, -87.0, 38.0, -65.44, -70.97, 6926.0, -15154.0, -48296.0, 51089.0],
    [2028.0, 71.0, 5.0, -13.0, -6.47, -17.66, 28143.0, -3193.0, -9018.0, 29724.0],
    [2028.0, 75.0, 79.0, 125.0, -18.59, 87.42, 2448.0, -823.0, 57309.0, 57367.0],
    [2028.5, 28.0, 54.0, -120.0, 15.43, 73.74, 14735.0, 4067.0, 52394.0, 54578.0],
    [2028.5, 95.0, 30.0, 28.0, 4.56, 44.27, 29692.0, 2368.0, 29040.0, 41600.0],
    [2029.0, 50.0, 87.0, -154.0, -73.48, 89.07, 258.0, -869.0, 55992.0, 56000.0],
    [2029.0, 19.0, 46.0, -22.0, -5.65, 60.89, 22522.0, -2227.0, 40652.0, 46527.0],
    [2029.5, 63.0, 88.0, 26.0, 36.52, 87.37, 2041.0, 1512.0, 55287.0, 55345.0],
    [2029.5, 77.0, -18.0, 138.0, 4.45, -47.55, 31751.0, 2472.0, -34817.0, 47186.0],
];

/// Test values from the report of the 2020 model, `WMM2020testvalues.pdf`.
#[rustfmt::skip]
const OF_2020: [Row; 12] = [
    [2020.0, 0.0, 80.0, 0.0, -1.28, 83.14, 6570.4, -146.3, 54606.0, 55000.1],
    [2020.0, 0.0, 0.0, 120.0, 0.16, -15.42, 39624.3, 109.9, -10932.5, 41104.9],
    [2020.0, 0.0, -80.0, 240.0, 69.36, -72.20, 5940.6, 15772.1, -52480.8, 55120.6],
    [2020.0, 100.0, 80.0, 0.0, -1.70, 83.19, 6261.8, -185.5, 52429.1, 52802.0],
    [2020.0, 100.0, 0.0, 120.0, 0.16, -15.55, 37636.7, 104.9, -10474.8, 39067.3],
    [2020.0, 100.0, -80.0, 240.0, 68.78, -72.37, 5744.9, 14799.5, -49969.4, 52430.6],
    [2022.5, 0.0, 80.0, 0.0, 0.01, 83.19, 6529.9, 1.1, 54713.4, 55101.7],
    [2022.5, 0.0, 0.0, 120.0, -0.06, -15.24, 39684.7, -42.2, -10809.5, 41130.5],
    [2022.5, 0.0, -80.0, 240.0, 69.13, -72.09, 6016.5, 15776.7, -52251.6, 54912.1],
    [2022.5, 100.0, 80.0, 0.0, -0.41, 83.24, 6224.0, -44.5, 52527.0, 52894.5],
    [2022.5, 100.0, 0.0, 120.0, -0.05, -15.37, 37694.0, -35.3, -10362.0, 39092.4],
    [2022.5, 100.0, -80.0, 240.0, 68.55, -72.27, 5815.0, 14803.0, -49755.3, 52235.4],
];

fn at(year: f64, height_km: f64, latitude_deg: f64, longitude_deg: f64) -> MagneticField {
    let place = Geodetic {
        latitude_rad: latitude_deg.to_radians(),
        longitude_rad: longitude_deg.to_radians(),
        height_m: 1e3 * height_km,
    };
    MagneticField::at(&place, year).unwrap()
}

/// Compares rows whose field is rounded to `step_nt`.
fn check(rows: &[Row], step_nt: f64) {
    for row in rows {
        let [year, height_km, latitude_deg, longitude_deg, declination, inclination, ..] = *row;
        let field = at(year, height_km, latitude_deg, longitude_deg);
        let [north, east, down] = (field.field_gauss * 1e5).to_array();
        let found = [north, east, down, field.strength_gauss() * 1e5];
        for (found, expected) in found.into_iter().zip(&row[6..]) {
            assert!((found - expected).abs() < 0.51 * step_nt, "{row:?}: {found}");
        }
        let angles = [field.declination_rad(), field.inclination_rad()].map(f64::to_degrees);
        for (found, expected) in angles.into_iter().zip([declination, inclination]) {
            assert!((found - expected).abs() < 0.0051, "{row:?}: {found}");
        }
    }
}

#[test]
fn the_published_values_of_both_models_come_out_to_the_last_digit() {
    check(&OF_2025, 1.0);
    check(&OF_2020, 0.1);
}

#[test]
fn the_poles_have_a_field_that_turns_with_the_meridian_and_nothing_else() {
    for latitude_deg in [90.0, -90.0] {
        let reference = at(2026.0, 0.0, latitude_deg, 0.0);
        for longitude_deg in [-120.0, 35.0, 180.0] {
            let turned = at(2026.0, 0.0, latitude_deg, longitude_deg);
            assert_abs_diff_eq!(turned.field_gauss.z(), reference.field_gauss.z(), epsilon = 1e-12);
            let hemisphere = f64::signum(latitude_deg);
            let turn_rad = turned.declination_rad() - reference.declination_rad();
            let off_rad = turn_rad - hemisphere * longitude_deg.to_radians();
            assert!(libm::sin(0.5 * off_rad).abs() < 1e-9, "{latitude_deg} {longitude_deg}");
            assert_abs_diff_eq!(
                turned.horizontal_gauss(),
                reference.horizontal_gauss(),
                epsilon = 1e-12
            );
        }
    }
}

#[test]
fn outside_its_years_and_heights_the_model_says_nothing() {
    let place = Geodetic { latitude_rad: 0.8, longitude_rad: 0.2, height_m: 500.0 };
    let of = |year| MagneticField::at(&place, year);
    assert!(of(2020.0).is_ok() && of(2029.999).is_ok());
    for year in [2019.999, 2030.0, f64::NAN] {
        assert!(matches!(of(year), Err(OutsideModel::Year { .. })), "{year}");
    }
    for height_m in [-1001.0, 851e3, f64::NAN] {
        let found = MagneticField::at(&Geodetic { height_m, ..place }, 2026.0);
        assert!(matches!(found, Err(OutsideModel::Height { .. })), "{height_m}");
    }
}

#[test]
fn years_are_cut_into_days() {
    assert_eq!(decimal_year(2025, 1, 1), 2025.0);
    assert_eq!(decimal_year(2025, 12, 31), 2025.0 + 364.0 / 365.0);
    assert_eq!(decimal_year(2028, 3, 1), 2028.0 + 60.0 / 366.0);
    assert_eq!(decimal_year(2028, 12, 31), 2028.0 + 365.0 / 366.0);
}

proptest! {
    // A field without sources has neither divergence nor curl. Both come from central differences over 1 km.
    #[test]
    fn the_field_has_no_sources_above_the_ground(
        latitude_deg in -85.0..85.0f64, longitude_deg in -180.0..180.0f64,
    ) {
        use hovernav::frames::Ecef;
        let centre = Geodetic {
            latitude_rad: latitude_deg.to_radians(),
            longitude_rad: longitude_deg.to_radians(),
            height_m: 50e3,
        };
        const STEP_M: f64 = 1e3;
        let field = |offset_m: [f64; 3]| {
            let place = Geodetic::from_ecef(centre.to_ecef() + Vector::<Ecef>::from(offset_m));
            let place = place.unwrap();
            let ned = MagneticField::at(&place, 2026.0).unwrap().field_gauss;
            (place.ecef_to_ned().inverse() * ned).to_array()
        };
        // derivatives[axis][component], gauss per metre.
        let derivatives: [[f64; 3]; 3] = std::array::from_fn(|axis| {
            let mut offset_m = [0.0; 3];
            offset_m[axis] = STEP_M;
            let (ahead, behind) = (field(offset_m), field(offset_m.map(|value| -value)));
            std::array::from_fn(|component| (ahead[component] - behind[component]) / (2.0 * STEP_M))
        });
        // The field changes by about 3e-7 gauss per metre.
        let divergence = derivatives[0][0] + derivatives[1][1] + derivatives[2][2];
        prop_assert!(divergence.abs() < 1e-12, "{}", divergence);
        for (one, other) in [(0, 1), (1, 2), (2, 0)] {
            let curl = derivatives[one][other] - derivatives[other][one];
            prop_assert!(curl.abs() < 1e-12, "{}", curl);
        }
    }
}
