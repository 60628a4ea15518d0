//! The Earth of `hovernav::earth`, compared with published values and with slow, exact formulas.
//!
//! Published values: NIMA TR8350.2, third edition, amendment 1 (tables 3.3 and 3.4); IOGP
//! publication 373-7-2, *EPSG Guidance Note 7-2*, methods 9602 and 9837; GeographicLib's `GeodSolve`
//! for lengths of meridian; the WGS-84 series for the length of a degree that Wikipedia gives under
//! "Geographic coordinate system".

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

use approx::assert_abs_diff_eq;
use hovernav::earth::*;
use hovernav::frames::{Ecef, Ned, Vector, wrap_angle};
use proptest::prelude::*;

fn dms(degrees: f64, minutes: f64, seconds: f64) -> f64 {
    degrees + minutes / 60.0 + seconds / 3600.0
}

fn place(latitude_deg: f64, longitude_deg: f64, height_m: f64) -> Geodetic {
    Geodetic::from_degrees(latitude_deg, longitude_deg, height_m).unwrap()
}

/// Straight-line distance between two positions, m.
fn apart_m(a: &Geodetic, b: &Geodetic) -> f64 {
    (a.to_ecef() - b.to_ecef()).norm()
}

#[track_caller]
fn assert_vector_close<F>(found: Vector<F>, expected: [f64; 3], tolerance: f64) {
    let off = (found - Vector::from(expected)).norm();
    assert!(off <= tolerance, "found {found:?}, expected {expected:?}");
}

/// Simpson's rule.
fn integral(from: f64, to: f64, integrand: impl Fn(f64) -> f64) -> f64 {
    let pieces = 1000;
    let width = (to - from) / f64::from(pieces);
    let piece = |i| {
        let start = from + f64::from(i) * width;
        let middle = integrand(start + 0.5 * width);
        width / 6.0 * (integrand(start) + 4.0 * middle + integrand(start + width))
    };
    (0..pieces).map(piece).sum()
}

fn at_latitude(latitude_rad: f64) -> LocalEarth {
    LocalEarth::at(&Geodetic { latitude_rad, longitude_rad: 0.0, height_m: 0.0 })
}

/// Normal gravity by the closed formula in ellipsoidal coordinates, (outward, northward) in m/s²,
/// exact at any height (TR8350.2 equations 4-5 to 4-16).
fn closed_form_gravity(place: &Geodetic) -> (f64, f64) {
    const GM: f64 = 3.986_004_418e14;
    let (a, b, rate) = (SEMI_MAJOR_AXIS_M, SEMI_MINOR_AXIS_M, EARTH_RATE_RADPS);
    let focal_squared = a * a - b * b;
    let focal = focal_squared.sqrt();
    let [x, _, z] = Geodetic { longitude_rad: 0.0, ..*place }.to_ecef().to_array();

    let excess = x * x + z * z - focal_squared;
    let u_squared =
        0.5 * excess * (1.0 + (1.0 + 4.0 * focal_squared * z * z / excess.powi(2)).sqrt());
    let u = u_squared.sqrt();
    let across = (u_squared + focal_squared).sqrt();
    let (sin_b, cos_b) = (z * across / (u * x)).atan().sin_cos();
    let w = ((u_squared + focal_squared * sin_b * sin_b) / (u_squared + focal_squared)).sqrt();

    let q =
        |u: f64| 0.5 * ((1.0 + 3.0 * u * u / focal_squared) * (focal / u).atan() - 3.0 * u / focal);
    let q_prime =
        3.0 * (1.0 + u_squared / focal_squared) * (1.0 - u / focal * (focal / u).atan()) - 1.0;
    let swell = rate * rate * a * a / q(b);
    let along_u = -(GM / across.powi(2)
        + swell * focal / across.powi(2) * q_prime * (0.5 * sin_b * sin_b - 1.0 / 6.0)
        - rate * rate * u * cos_b * cos_b)
        / w;
    let along_b = (swell * q(u) / across - rate * rate * across) * sin_b * cos_b / w;

    let gravity_x = u / (w * across) * cos_b * along_u - sin_b / w * along_b;
    let gravity_z = sin_b / w * along_u + u / (w * across) * cos_b * along_b;
    let (sin_lat, cos_lat) = place.latitude_rad.sin_cos();
    (gravity_x * cos_lat + gravity_z * sin_lat, gravity_z * cos_lat - gravity_x * sin_lat)
}

#[test]
fn the_ellipsoid_has_the_published_shape() {
    assert_abs_diff_eq!(SEMI_MINOR_AXIS_M, 6_356_752.314_2, epsilon = 5e-5);
    assert_abs_diff_eq!(ECCENTRICITY_SQUARED, 6.694_379_990_14e-3, epsilon = 5e-15);
    let polar_radius_of_curvature_m = 6_399_593.625_8;
    for pole in [-FRAC_PI_2, FRAC_PI_2] {
        assert_abs_diff_eq!(
            at_latitude(pole).north_radius_m,
            polar_radius_of_curvature_m,
            epsilon = 5e-5
        );
        assert_abs_diff_eq!(
            at_latitude(pole).east_radius_m,
            polar_radius_of_curvature_m,
            epsilon = 5e-5
        );
    }
    assert_abs_diff_eq!(at_latitude(0.0).east_radius_m, 6_378_137.0, epsilon = 1e-9);
    assert_abs_diff_eq!(at_latitude(0.0).north_radius_m, 6_335_439.327, epsilon = 5e-4);
}

#[test]
fn meridian_arcs_have_their_published_length() {
    let arc_m = |to| integral(0.0, to, |latitude| at_latitude(latitude).north_radius_m);
    assert_abs_diff_eq!(arc_m(FRAC_PI_4), 4_984_944.377_978, epsilon = 1e-6);
    assert_abs_diff_eq!(arc_m(FRAC_PI_2), 10_001_965.729_313, epsilon = 1e-6);
    assert_abs_diff_eq!(arc_m(1f64.to_radians()), 110_574.389, epsilon = 5e-4);
}

#[test]
fn a_degree_has_its_published_length() {
    for latitude in (0..=90).map(|degrees| f64::from(degrees).to_radians()) {
        let cos = |multiple: f64| (multiple * latitude).cos();
        let north_m = 111_132.92 - 559.82 * cos(2.0) + 1.175 * cos(4.0) - 0.002_3 * cos(6.0);
        let east_m = 111_412.84 * cos(1.0) - 93.5 * cos(3.0) + 0.118 * cos(5.0);
        let local = at_latitude(latitude);
        assert_abs_diff_eq!(local.north_radius_m.to_radians(), north_m, epsilon = 0.1);
        assert_abs_diff_eq!((local.east_radius_m * cos(1.0)).to_radians(), east_m, epsilon = 0.1);
    }
}

#[test]
fn geocentric_coordinates_match_the_epsg_worked_example() {
    let north_sea = place(dms(53.0, 48.0, 33.820), dms(2.0, 7.0, 46.380), 73.0);
    let published = [3_771_793.968, 140_253.342, 5_124_304.349];
    assert_vector_close(north_sea.to_ecef(), published, 1e-3);
    let found = Geodetic::from_ecef(Vector::from(published)).unwrap();
    assert!(apart_m(&found, &north_sea) < 1e-3);
    assert_abs_diff_eq!(found.latitude_deg(), north_sea.latitude_deg(), epsilon = 1e-8);
    assert_abs_diff_eq!(found.longitude_deg(), north_sea.longitude_deg(), epsilon = 1e-8);
    assert_abs_diff_eq!(found.height_m, 73.0, epsilon = 1e-3);
}

#[test]
fn local_coordinates_match_the_epsg_worked_example() {
    let origin = place(55.0, 5.0, 200.0);
    assert_vector_close(origin.to_ecef(), [3_652_755.305_8, 319_574.679_9, 5_201_547.353_6], 1e-4);
    let point = place(dms(53.0, 48.0, 33.820), dms(2.0, 7.0, 46.380), 73.0);
    let (east, north, up) = (-189_013.869, -128_642.040, -4_220.171);
    assert_vector_close(point.local_ned_m(&origin), [north, east, -up], 1e-3);
    let found = Geodetic::from_local_ned(&origin, Vector::new(north, east, -up)).unwrap();
    assert!(apart_m(&found, &point) < 1e-3);
}

#[test]
fn gravity_on_the_ellipsoid_has_the_published_values() {
    assert_abs_diff_eq!(at_latitude(0.0).gravity_mps2, 9.780_325_335_9, epsilon = 1e-12);
    // The published k has twelve digits, so the value at the pole differs by 1e-10.
    assert_abs_diff_eq!(at_latitude(FRAC_PI_2).gravity_mps2, 9.832_184_937_8, epsilon = 2e-10);
    let weighted = |weight: &dyn Fn(&LocalEarth) -> f64| {
        integral(0.0, FRAC_PI_2, |latitude| {
            let local = at_latitude(latitude);
            weight(&local) * local.north_radius_m * local.east_radius_m * latitude.cos()
        })
    };
    let mean = weighted(&|local| local.gravity_mps2) / weighted(&|_| 1.0);
    assert_abs_diff_eq!(mean, 9.797_643_222_2, epsilon = 2e-10);
}

#[test]
fn the_slow_gravity_formula_has_the_published_values() {
    for (latitude, published) in [(1e-9, 9.780_325_335_9), (FRAC_PI_2 - 1e-9, 9.832_184_937_8)] {
        let surface = Geodetic { latitude_rad: latitude, longitude_rad: 0.0, height_m: 0.0 };
        assert_abs_diff_eq!(-closed_form_gravity(&surface).0, published, epsilon = 2e-9);
    }
}

#[test]
fn the_earth_turns_once_a_sidereal_day_about_its_own_axis() {
    // IERS Conventions 2010: a stellar day of 86 164.098 903 691 s of mean solar time; the rounded
    // defining rate gives 86 164.1006 s.
    assert_abs_diff_eq!(TAU / EARTH_RATE_RADPS, 86_164.1, epsilon = 1e-3);
    assert_abs_diff_eq!(EARTH_RATE_RADPS.to_degrees() * 3600.0, 15.041_067, epsilon = 1e-6);
    assert_vector_close(at_latitude(FRAC_PI_2).earth_rate_radps, [0.0, 0.0, -7.292_115e-5], 1e-19);
    assert_vector_close(at_latitude(0.0).earth_rate_radps, [7.292_115e-5, 0.0, 0.0], 1e-19);
}

#[test]
fn poles_and_date_line_are_ordinary_places() {
    let cases: [([f64; 3], [f64; 3]); 6] = [
        ([0.0, 0.0, SEMI_MINOR_AXIS_M], [90.0, 0.0, 0.0]),
        ([0.0, 0.0, -SEMI_MINOR_AXIS_M - 50.0], [-90.0, 0.0, 50.0]),
        ([-SEMI_MAJOR_AXIS_M, 0.0, 0.0], [0.0, 180.0, 0.0]),
        ([-SEMI_MAJOR_AXIS_M, -0.0, 0.0], [0.0, 180.0, 0.0]),
        ([0.0, -SEMI_MAJOR_AXIS_M - 7.0, 0.0], [0.0, -90.0, 7.0]),
        ([SEMI_MAJOR_AXIS_M - 9.0, 0.0, -0.0], [0.0, 0.0, -9.0]),
    ];
    for (ecef, [latitude_deg, longitude_deg, height_m]) in cases {
        let found = Geodetic::from_ecef(Vector::from(ecef)).unwrap();
        assert_eq!(found.latitude_deg(), latitude_deg);
        assert_eq!(found.longitude_deg(), longitude_deg);
        assert_abs_diff_eq!(found.height_m, height_m, epsilon = 1e-8);
        assert_vector_close(found.to_ecef(), ecef, 2e-9);
    }
}

#[test]
fn a_short_way_over_the_date_line_is_short() {
    let west = place(-16.8, 179.999_9, 10.0);
    let east = place(-16.8, -179.999_9, 10.0);
    let parallel_m = west.to_ecef().x().hypot(west.to_ecef().y());
    for displacement in [east.displacement_from(&west), east.local_ned_m(&west)] {
        assert_abs_diff_eq!(displacement.y(), 0.000_2f64.to_radians() * parallel_m, epsilon = 1e-6);
    }
    let moved = west.displaced(east.displacement_from(&west));
    assert!(apart_m(&moved, &east) < 1e-8 && moved.longitude_rad < 0.0);
}

#[test]
fn what_is_no_place_is_refused() {
    for (latitude, longitude, height) in [
        (90.1, 0.0, 0.0),
        (-91.0, 0.0, 0.0),
        (0.0, 361.0, 0.0),
        (0.0, 0.0, 1.1e5),
        (f64::NAN, 0.0, 0.0),
        (0.0, f64::NAN, 0.0),
        (0.0, 0.0, f64::NAN),
        (0.0, f64::INFINITY, 0.0),
    ] {
        assert_eq!(Geodetic::from_degrees(latitude, longitude, height), None);
    }
    for ecef in [[0.0; 3], [9e5, 0.0, 0.0], [f64::NAN, 7e6, 0.0], [f64::INFINITY, 0.0, 0.0]] {
        assert_eq!(Geodetic::from_ecef(Vector::from(ecef)), None);
    }
    let origin = place(1.35, 103.8, 20.0);
    assert_eq!(Geodetic::from_local_ned(&origin, Vector::new(f64::NAN, 0.0, 0.0)), None);
    assert_abs_diff_eq!(place(0.0, 190.0, 0.0).longitude_deg(), -170.0, epsilon = 1e-12);
}

#[test]
fn north_is_given_up_only_next_to_the_poles() {
    assert!(place(89.8, 0.0, 0.0).is_navigable() && place(-89.8, 0.0, 0.0).is_navigable());
    assert!(!place(89.95, 0.0, 0.0).is_navigable() && !place(-90.0, 0.0, 0.0).is_navigable());
    let nan = Geodetic { latitude_rad: f64::NAN, ..place(0.0, 0.0, 0.0) };
    assert!(!nan.is_navigable());
}

prop_compose! {
    /// Anywhere on the globe, with poles and date line as frequent positions.
    fn anywhere(heights: std::ops::Range<f64>)(
        latitude_deg in prop_oneof![
            8 => -90.0..=90.0, 1 => Just(90.0), 1 => Just(-90.0), 1 => 89.999..=90.0, 1 => Just(0.0)],
        longitude_deg in prop_oneof![
            8 => -180.0..=180.0, 1 => Just(180.0), 1 => -180.0..=-179.999, 1 => Just(0.0)],
        height_m in heights,
    ) -> Geodetic {
        Geodetic {
            latitude_rad: f64::to_radians(latitude_deg),
            longitude_rad: wrap_angle(f64::to_radians(longitude_deg)),
            height_m,
        }
    }
}

prop_compose! {
    fn navigable(limit_deg: f64)(latitude_deg in -limit_deg..=limit_deg, longitude_deg in -180.0..=180.0,
                   height_m in -400.0..9000.0) -> Geodetic {
        place(latitude_deg, longitude_deg, height_m)
    }
}

prop_compose! {
    fn vector(size: f64)(x in -1.0..=1.0, y in -1.0..=1.0, z in -1.0..=1.0) -> Vector<Ned> {
        Vector::new(x, y, z) * size
    }
}

proptest! {
    #[test]
    fn geodetic_coordinates_survive_the_way_through_ecef(here in anywhere(-1e4..1e5)) {
        let back = Geodetic::from_ecef(here.to_ecef()).unwrap();
        prop_assert!(apart_m(&back, &here) < 5e-9);
        prop_assert!((back.height_m - here.height_m).abs() < 5e-9);
        prop_assert!((back.latitude_rad - here.latitude_rad).abs() < 1e-15);
        let parallel_m = here.latitude_rad.cos() * SEMI_MAJOR_AXIS_M;
        prop_assert!(wrap_angle(back.longitude_rad - here.longitude_rad).abs() * parallel_m < 5e-9);
        prop_assert!(back.longitude_rad > -PI && back.longitude_rad <= PI);
    }

    #[test]
    fn ecef_survives_the_way_through_geodetic_from_deep_to_beyond_the_moon(
        here in anywhere(-5e6..1e6), scale in prop::sample::select(vec![1.0, 30.0, 1000.0]),
    ) {
        let ecef = here.to_ecef() * scale;
        let back = Geodetic::from_ecef(ecef).unwrap().to_ecef();
        prop_assert!((back - ecef).norm() < 1e-15 * ecef.norm().max(SEMI_MAJOR_AXIS_M));
    }

    #[test]
    fn down_is_the_normal_of_the_ellipsoid(here in anywhere(-400.0..9000.0)) {
        let higher = Geodetic { height_m: here.height_m + 100.0, ..here };
        let local = higher.local_ned_m(&here);
        prop_assert!((local - Vector::new(0.0, 0.0, -100.0)).norm() < 1e-8);
        let pole: Vector<Ecef> = Vector::new(0.0, 0.0, EARTH_RATE_RADPS);
        let earth_rate = here.ecef_to_ned() * pole;
        prop_assert!((LocalEarth::at(&here).earth_rate_radps - earth_rate).norm() < 1e-19);
    }

    #[test]
    fn local_coordinates_lead_there_and_back(
        origin in anywhere(-400.0..9000.0), there in anywhere(-400.0..9000.0),
        near in vector(1e5),
    ) {
        let offset = there.local_ned_m(&origin);
        prop_assert!((offset.norm() - apart_m(&origin, &there)).abs() < 1e-8 + 2e-15 * offset.norm());
        // A direction is accurate to rounding of unity: 26 nm over the Earth's diameter.
        let rounding_m = 1e-8 + 2e-15 * offset.norm();
        prop_assert!(apart_m(&Geodetic::from_local_ned(&origin, offset).unwrap(), &there) < rounding_m);
        let found = Geodetic::from_local_ned(&origin, near).unwrap().local_ned_m(&origin);
        prop_assert!((found - near).norm() < 1e-8);
    }

    #[test]
    fn displacement_by_radii_keeps_to_its_bound(
        here in navigable(80.0), way in vector(100.0 / 3f64.sqrt()),
    ) {
        let straight = Geodetic::from_local_ned(&here, way).unwrap();
        prop_assert!(apart_m(&here.displaced(way), &straight) < 6e-3);
        let lever_arm = way * 0.01;
        let straight = Geodetic::from_local_ned(&here, lever_arm).unwrap();
        prop_assert!(apart_m(&here.displaced(lever_arm), &straight) < 1e-6);
    }

    #[test]
    fn displacement_by_radii_undoes_itself(here in navigable(89.0), way in vector(1000.0)) {
        let found = here.displaced(way).displacement_from(&here);
        prop_assert!((found - way).norm() < 1e-8);
        prop_assert!(here.displaced(way).longitude_rad <= PI);
        prop_assert!(here.displaced(way).longitude_rad > -PI);
    }

    #[test]
    fn radii_and_transport_rate_are_the_motion_of_the_local_frame(
        here in navigable(89.0), velocity in vector(30.0),
    ) {
        // One second apart, centred: the remaining error is of third order in the angle.
        let local = LocalEarth::at(&here);
        let [before, after] = [-0.5, 0.5].map(|s| local.displaced(&here, velocity * s));
        let way = here.ecef_to_ned() * (after.to_ecef() - before.to_ecef());
        prop_assert!((way - velocity).norm() < 2e-6);
        let turn = after.ecef_to_ned().quaternion() * before.ecef_to_ned().quaternion().conjugate();
        // The frame rotates at the rate, so coordinates rotate in the opposite direction.
        let angle: Vector<Ned> = Vector::claim(turn.xyz() * -2.0 * turn.w.signum());
        prop_assert!((angle - local.transport_rate(velocity)).norm() < 1e-9 * angle.norm() + angle.norm().powi(3) + 2e-15);
    }

    #[test]
    fn gravity_is_the_exact_normal_gravity_up_to_15_km(here in anywhere(-400.0..15_000.0)) {
        let (outward, northward) = closed_form_gravity(&here);
        prop_assert!((LocalEarth::at(&here).gravity_mps2 + outward).abs() < 1e-6);
        // Groves 2.140, which the module documents as neglected.
        let omitted = -8.08e-9 * here.height_m * (2.0 * here.latitude_rad).sin();
        prop_assert!((northward - omitted).abs() < 1e-6);
    }
}
