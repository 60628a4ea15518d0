//! Check of the fixes' positions against their own velocity: units, signs, order.

use std::f64::consts::{FRAC_PI_2, PI};

use hovernav::frames::wrap_angle;
use hovernav::gps::Fix;

use super::pairs::pairs;
use super::regression::{Fit, fit};
use crate::finding::{Sensor, SetupFinding};

/// Time over which horizontal displacements are compared, s.
const HORIZONTAL_S: f64 = 4.0;
/// Time over which vertical displacements are compared, s.
const VERTICAL_S: f64 = 8.0;
/// Smallest change of the velocity that is judged, m/s rms.
const MIN_MPS: f64 = 0.4;
/// Smallest fraction of the displacements that the fit has to explain.
const EXPLAINED: f64 = 0.6;
/// Sine of the angle between velocity and displacement above which the velocity belongs to another time.
const TURNED: f64 = 0.25;
/// Smallest scale of a velocity in m/s, divided by the explained fraction: noise reduces a scale at most to that
/// fraction. A smaller scale means another unit.
const SMALLER: f64 = 0.75;
/// Smallest plausible scale of an intact receiver.
const MIN_SCALE: f64 = 0.6;
/// Largest difference of two courses that count as equal, rad (12°). The scale of a displacement depends on the
/// latitude, which may be wrong.
const ALIKE_RAD: f64 = 0.2;
/// Range of heights at which helicopters and drones fly, m.
const HEIGHTS_M: std::ops::RangeInclusive<f64> = -450.0..=9000.0;
/// Largest fraction of fixes outside [`HEIGHTS_M`] without a finding.
const OUTSIDE: f64 = 0.3;

/// Coordinates of 47°30' written as 47.30°, in place of a velocity unit: distances are 0.6 of the true ones.
const MINUTES: &str = "minutes after the decimal point";
/// Velocity units with their size in m/s.
const UNITS: [(f64, &str); 7] = [
    (0.6, MINUTES),
    (0.5144, "knots"),
    (0.4470, "miles per hour"),
    (0.3048, "feet per second"),
    (0.2778, "km/h"),
    (0.01, "cm/s"),
    (0.001, "mm/s"),
];
/// Cause and remedy of fixes with heights in feet.
pub(super) const HEIGHT_IN_FEET: (&str, &str) =
    ("height_m in feet, expected metres", "multiply height_m by 0.3048");
/// Number of each height unit in a metre, with the cause and the remedy.
const HEIGHT_UNITS: [(f64, (&str, &str)); 3] = [
    (3.281, HEIGHT_IN_FEET),
    (100.0, ("height_m in centimetres, expected metres", "divide height_m by 100")),
    (1000.0, ("height_m in millimetres, expected metres", "divide height_m by 1000")),
];
/// Smallest fraction of the height changes that the vertical velocity explains if the heights are certainly in another
/// unit.
const EXPLAINED_HEIGHTS: f64 = 0.8;
/// Smallest distance from 0° N 0° E, degrees, of coordinates that may be radians. Closer ones come from a simulation.
const MIN_RADIANS: f64 = 0.05;
/// One degree in radians: the scale of displacements whose coordinates are radians read as degrees.
const DEGREE: f64 = PI / 180.0;

pub(super) fn check(fixes: &[Fix], found: &mut Vec<SetupFinding>) {
    let known = found.len();
    horizontal(fixes, found);
    if found.len() == known {
        in_radians(fixes, found);
    }
    vertical(fixes, found);
    if found.len() == known {
        epochs(fixes, found);
    }
    let is_outside = |fix: &&Fix| !HEIGHTS_M.contains(&fix.position.height_m);
    let outside = fixes.iter().filter(is_outside).count();
    if outside as f64 > OUTSIDE * fixes.len() as f64
        && let Some(fix) = fixes.iter().find(is_outside)
    {
        found.push(gps(
            false,
            format!(
                "height {:.1} m at {:.3} s, expected {:.0} to {:.0} m",
                fix.position.height_m,
                fix.time.seconds(),
                HEIGHTS_M.start(),
                HEIGHTS_M.end()
            ),
            "a height in millimetres or feet, or another quantity",
            "write height_m in metres above the ellipsoid",
        ));
    }
}

fn gps(is_certain: bool, found: String, cause: &str, mend: &str) -> SetupFinding {
    SetupFinding { sensor: Sensor::Gps, is_certain, found, cause: cause.into(), mend: mend.into() }
}

fn horizontal(fixes: &[Fix], found: &mut Vec<SetupFinding>) {
    // Receivers that report speed and course have no vertical velocity.
    let pairs = pairs(fixes, HORIZONTAL_S, 0, |fix| fix.horizontal_velocity_mps);
    let Some(Fit { matrix: [[nn, ne], [en, ee]], explained }) = fit(&pairs, MIN_MPS) else {
        straight(&pairs, found);
        return;
    };
    if explained.iter().any(|&explained| explained < EXPLAINED) {
        return;
    }
    // A late velocity on a circle is turned against the displacement; a wrong unit or sign does not turn it.
    let largest = [nn, ne, en, ee].into_iter().map(f64::abs).fold(0.0, f64::max);
    if 0.5 * (ne - en).abs() > TURNED * largest {
        return;
    }
    let sizes = format!(
        "positions move north and east {nn:.4} and {ee:.4} times as fast as the velocity, expected 1"
    );
    // Latitudes in radians seem close to the equator, where a degree of longitude is longer.
    if near(nn, DEGREE) && (0.75..6.0).contains(&(ee / DEGREE)) {
        found.push(gps(
            true,
            sizes,
            "latitude and longitude in radians, expected degrees",
            "multiply both by 57.29578",
        ));
    } else if ne.abs().min(en.abs()) > 0.3 && nn.abs() < 0.4 * ne.abs() && ee.abs() < 0.4 * en.abs()
    {
        found.push(swapped(format!(
            "positions move north at the east velocity ({ne:.2} times), and east at the north velocity ({en:.2} times)"
        )));
    } else if nn < -0.5 || ee < -0.5 {
        // A delay of half a circle changes both signs.
        found.push(wrong_sign(nn > 0.0 || ee > 0.0, sizes));
    } else if let Some(unit) = unit_of(&[nn, ee], explained[0].min(explained[1])) {
        found.push(in_unit(sizes, unit));
    } else if [(nn, explained[0]), (ee, explained[1])].iter().any(|&(scale, explained)| {
        // Noise of the velocity reduces a scale, at most to the explained fraction.
        !(MIN_SCALE * explained..1.6).contains(&scale)
    }) {
        let cause = "coordinates or velocity of a wrong unit";
        found.push(gps(false, sizes, cause, "expected degrees and m/s"));
    }
}

/// Checks a vehicle that moves back and forth on one line, where north and east cannot be separated. It compares the
/// speed and the direction of the line.
fn straight(pairs: &[([f64; 2], [f64; 2])], found: &mut Vec<SetupFinding>) {
    // Course from the double angle, which does not depend on the sense of motion.
    let [cos, sin] = pairs.iter().fold([0.0; 2], |[cos, sin], ([north, east], _)| {
        [cos + north * north - east * east, sin + 2.0 * north * east]
    });
    let course_rad = 0.5 * sin.atan2(cos);
    let (east, north) = course_rad.sin_cos();
    let by_axis = [0, 1].map(|axis| {
        let of_axis = |(told, moved): &([f64; 2], [f64; 2])| {
            ([north * told[0] + east * told[1]], [moved[axis]])
        };
        fit(&pairs.iter().map(of_axis).collect::<Vec<_>>(), MIN_MPS)
    });
    let [Some(to_north), Some(to_east)] = by_axis else { return };
    let [moved_north, moved_east] = [to_north.matrix[0][0], to_east.matrix[0][0]];
    let larger = if moved_north.abs() > moved_east.abs() { to_north } else { to_east };
    let [explained] = larger.explained;
    if explained < EXPLAINED {
        return;
    }
    let scale = moved_north.hypot(moved_east);
    let moved_rad = moved_east.atan2(moved_north);
    let is_along = |course_rad: f64| wrap_angle(moved_rad - course_rad).abs() < ALIKE_RAD;
    let sizes = format!(
        "positions move along a line {:.0}° from that of the velocity, {scale:.4} times as fast, expected 0° and 1",
        wrap_angle(moved_rad - course_rad).to_degrees()
    );
    // Directions within twice the tolerance count as equal here.
    if wrap_angle(moved_rad - course_rad).abs() < 2.0 * ALIKE_RAD {
        if let Some(unit) = unit_of(&[scale], explained) {
            found.push(in_unit(sizes, unit));
        }
    } else if is_along(FRAC_PI_2 - course_rad) && (0.6..1.6).contains(&scale) {
        found.push(swapped(sizes));
    } else if is_along(-course_rad) || is_along(PI - course_rad) {
        // A delay of half a period also reverses a motion back and forth.
        let is_reversed = is_along(course_rad + PI);
        found.push(wrong_sign(!is_reversed, sizes));
    }
}

/// Whether `value` is close to `expected`.
fn near(value: f64, expected: f64) -> bool {
    (0.75..1.33).contains(&(value / expected))
}

/// Velocity unit that matches all `scales`. `explained` is the smallest fraction, over the axes, of the displacements
/// that the velocity explains.
fn unit_of(scales: &[f64], explained: f64) -> Option<&'static str> {
    let largest = scales.iter().copied().fold(f64::MIN, f64::max);
    let of_size = |(size, _): &&(f64, _)| scales.iter().all(|&scale| near(scale, *size));
    let off = |size: f64| scales.iter().map(|scale| (scale / size).ln().abs()).sum::<f64>();
    let (_, unit) =
        UNITS.iter().filter(of_size).min_by(|(a, _), (b, _)| off(*a).total_cmp(&off(*b)))?;
    (largest < SMALLER * explained).then_some(*unit)
}

fn swapped(found: String) -> SetupFinding {
    gps(
        true,
        found,
        "latitude and longitude swapped, or north and east velocity",
        "swap the names of these two columns in the header of gps.csv, or in mapping.toml",
    )
}

fn wrong_sign(is_certain: bool, found: String) -> SetupFinding {
    gps(
        is_certain,
        found,
        "a velocity or coordinate of the wrong sign (west for east, south for north)",
        "change the sign of that column",
    )
}

fn in_unit(sizes: String, unit: &str) -> SetupFinding {
    if unit == MINUTES {
        let cause = "coordinates with minutes after the decimal point (ddmm.mmmm divided by 100), expected degrees";
        return gps(true, sizes, cause, "divide what follows the decimal point by 0.6");
    }
    let cause = format!("velocity in {unit}, expected m/s");
    gps(true, sizes, &cause, "convert the velocity, or name its unit in mapping.toml")
}

/// Checks for coordinates in radians: all of them look like angles in the Gulf of Guinea, where there is no land. A
/// hovering vehicle gives no other sign. Simulated flights begin at zero and are exempt.
fn in_radians(fixes: &[Fix], found: &mut Vec<SetupFinding>) {
    let degrees = |fix: &Fix| {
        let (latitude, longitude) = (fix.position.latitude_rad, fix.position.longitude_rad);
        (latitude.to_degrees(), longitude.to_degrees())
    };
    let is_radians = |(latitude, longitude): (f64, f64)| {
        latitude.abs() <= FRAC_PI_2
            && longitude.abs() <= PI
            && latitude.hypot(longitude) > MIN_RADIANS
    };
    if let Some(first) = fixes.first().map(degrees)
        && fixes.iter().map(degrees).all(is_radians)
    {
        found.push(gps(
            false,
            format!(
                "all latitudes are within ±1.57° and all longitudes within ±3.14° (the first {:.5}°, {:.5}°), \
                 where there is only sea",
                first.0, first.1
            ),
            "latitude and longitude in radians, expected degrees",
            "multiply both by 57.29578",
        ));
    }
}

/// Checks for positions and velocities of different times, one or two fixes apart, as when a logger joins two messages.
/// With more than a few fixes a second the filter itself finds the offset.
fn epochs(fixes: &[Fix], found: &mut Vec<SetupFinding>) {
    /// Intervals of fixes to be checked, s: shorter ones are left to the filter, longer ones are gaps.
    const INTERVALS_S: std::ops::Range<f64> = 0.4..3.0;
    /// Smallest number of fixes for a judgement.
    const MIN: f64 = 30.0;
    /// Smallest rms difference between velocity and displacement rate, m/s.
    const MIN_OFF_MPS: f64 = 0.5;
    /// Largest difference that counts, m/s, so that a jump of the receiver does not look like a wrong pairing.
    const OUTLIER_MPS: f64 = 20.0;
    /// Largest squared residual of the right pairing, relative to the present one.
    const LEFT: f64 = 0.3;
    /// Largest offset of the pairing that is tried, fixes.
    const MAX: isize = 2;
    let off = |later: isize| {
        let (mut squares, mut count) = (0.0, 0.0);
        for (index, pair) in fixes.windows(2).enumerate() {
            let velocity = |index: usize| {
                fixes
                    .get(index.checked_add_signed(later)?)
                    .and_then(|fix| fix.horizontal_velocity_mps)
            };
            let over_s = pair[1].time - pair[0].time;
            let (Some([north, east]), Some([north_after, east_after])) =
                (velocity(index), velocity(index + 1))
            else {
                continue;
            };
            if !INTERVALS_S.contains(&over_s) {
                continue;
            }
            let moved = pair[1].position.displacement_from(&pair[0].position).to_array();
            let [off_north, off_east] = [
                moved[0] / over_s - 0.5 * (north + north_after),
                moved[1] / over_s - 0.5 * (east + east_after),
            ];
            squares += (off_north.powi(2) + off_east.powi(2)).min(OUTLIER_MPS * OUTLIER_MPS);
            count += 1.0;
        }
        (count >= MIN).then_some(squares / count)
    };
    let Some(as_they_are) = off(0).filter(|squares| squares.sqrt() > MIN_OFF_MPS) else { return };
    let others = (-MAX..=MAX).filter(|later| *later != 0);
    let others = others.filter_map(|later| Some((later, off(later)?)));
    let Some((later, least)) = others.min_by(|a, b| a.1.total_cmp(&b.1)) else { return };
    if least > LEFT * as_they_are {
        return;
    }
    let side = if later > 0 { "after" } else { "before" };
    let whose = match later.unsigned_abs() {
        1 => format!("of the fix {side}"),
        rows => format!("of {rows} fixes {side}"),
    };
    found.push(gps(
        false,
        format!(
            "positions move at the velocity {whose}, to {:.1} m/s rms, and {:.1} m/s off their own",
            least.sqrt(),
            as_they_are.sqrt()
        ),
        "positions and velocities of different times in one row, as from a logger that joins two messages",
        "pair each position with the velocity of the same time",
    ));
}

fn vertical(fixes: &[Fix], found: &mut Vec<SetupFinding>) {
    let down = |fix: &Fix| fix.down_velocity_mps.filter(|_| !fix.two_dimensional);
    let pairs = pairs(fixes, VERTICAL_S, 2, |fix| down(fix).map(|down| [down]));
    let Some(Fit { matrix: [[scale]], explained: [explained] }) = fit(&pairs, 0.5 * MIN_MPS) else {
        return;
    };
    if explained > EXPLAINED && scale < -0.5 {
        found.push(gps(
            true,
            format!("heights fall {:.2} times as fast as vd_mps reports them to rise", -scale),
            "vertical velocity positive up, expected positive down",
            "change the sign of vd_mps",
        ));
    } else if explained > EXPLAINED
        && let Some((_, (cause, mend))) = HEIGHT_UNITS.iter().find(|(size, ..)| near(scale, *size))
    {
        found.push(gps(
            explained > EXPLAINED_HEIGHTS,
            format!("heights change {scale:.2} times as fast as vd_mps reports, expected 1"),
            cause,
            mend,
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hovernav::earth::Geodetic;
    use hovernav::frames::{Ned, Vector};
    use hovernav::time::Time;

    /// Flight at 10 to 20 m/s on a straight course of 30°, with a velocity of `scale` times the true one. Noise,
    /// one-sigma: positions 0.5 m, velocities 0.1 m/s.
    fn on_a_line(scale: f64, seed: u64) -> Vec<Fix> {
        use rand_chacha::rand_core::SeedableRng;
        use rand_distr::{Distribution, StandardNormal};
        let start = Geodetic::from_degrees(48.0, 11.0, 500.0).unwrap();
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        let mut noise = |sigma: f64| -> f64 {
            let unit: f64 = StandardNormal.sample(&mut random);
            sigma * unit
        };
        let (east, north) = 30f64.to_radians().sin_cos();
        (0..1000)
            .map(|step| {
                let time_s = 0.2 * f64::from(step);
                let speed_mps = 15.0 + 5.0 * (0.1 * time_s).sin();
                let along_m = 15.0 * time_s - 50.0 * (0.1 * time_s).cos();
                let place = Vector::<Ned>::new(
                    north * along_m + noise(0.5),
                    east * along_m + noise(0.5),
                    0.0,
                );
                let velocity = [north, east].map(|part| scale * (part * speed_mps + noise(0.1)));
                Fix {
                    horizontal_velocity_mps: Some(velocity),
                    ..Fix::at(Time::ZERO + time_s, start.displaced(place))
                }
            })
            .collect()
    }

    #[test]
    fn a_straight_course_determines_the_unit_of_the_velocity_and_nothing_else() {
        for seed in 0..40 {
            let mut found = Vec::new();
            check(&on_a_line(1.0, seed), &mut found);
            assert!(found.is_empty(), "seed {seed}: {found:?}");
        }
        for (scale, unit) in [
            (1.0 / 0.6, "minutes after the decimal point"),
            (1.0 / 0.5144, "knots"),
            (3.6, "km/h"),
            (1.0 / 0.3048, "feet per second"),
            (1.0 / 0.4470, "miles per hour"),
            (100.0, "cm/s"),
        ] {
            let mut found = Vec::new();
            check(&on_a_line(scale, 1), &mut found);
            assert_eq!(found.len(), 1, "{found:?}");
            assert!(found[0].is_certain && found[0].cause.contains(unit), "{found:?}");
        }
    }

    #[test]
    fn a_velocity_that_is_reported_late_in_a_circle_is_in_no_other_unit() {
        let center = Geodetic::from_degrees(48.0, 11.0, 500.0).unwrap();
        for (period_s, radius_m, late_s) in
            [(6.0, 5.0, 1.0), (12.0, 6.0, 2.0), (10.0, 6.0, 2.0), (6.0, 5.0, 3.0)]
        {
            let rate = std::f64::consts::TAU / period_s;
            let fixes: Vec<Fix> = (0..300)
                .map(|second| {
                    let (sin, cos) = (rate * f64::from(second)).sin_cos();
                    let (late_sin, late_cos) = (rate * (f64::from(second) - late_s)).sin_cos();
                    let place = Vector::<Ned>::new(radius_m * cos, radius_m * sin, 0.0);
                    let speed_mps = radius_m * rate;
                    Fix {
                        horizontal_velocity_mps: Some([
                            -speed_mps * late_sin,
                            speed_mps * late_cos,
                        ]),
                        ..Fix::at(Time::ZERO + f64::from(second), center.displaced(place))
                    }
                })
                .collect();
            let mut found = Vec::new();
            check(&fixes, &mut found);
            assert!(found.iter().all(|finding| !finding.is_certain), "{period_s}: {found:?}");
        }
    }

    #[test]
    fn heights_in_another_unit_are_named() {
        for (scale, expected) in
            [(1.0, None), (3.281, Some("feet")), (1000.0, Some("millimetres")), (-1.0, Some("up"))]
        {
            let fixes: Vec<Fix> = (0..1000)
                .map(|step| {
                    let time_s = 0.2 * f64::from(step);
                    let place =
                        Geodetic::from_degrees(48.0, 11.0, scale * (20.0 * (0.1 * time_s).sin()));
                    Fix {
                        horizontal_velocity_mps: Some([0.0; 2]),
                        down_velocity_mps: Some(-2.0 * (0.1 * time_s).cos()),
                        ..Fix::at(Time::from_seconds(time_s), place.unwrap())
                    }
                })
                .collect();
            let mut found = Vec::new();
            check(&fixes, &mut found);
            let causes: Vec<_> = found.iter().map(|found| found.cause.as_str()).collect();
            match expected {
                None => assert!(causes.is_empty(), "{causes:?}"),
                Some(unit) => {
                    assert!(causes.iter().any(|cause| cause.contains(unit)), "{causes:?}");
                }
            }
        }
    }
}
