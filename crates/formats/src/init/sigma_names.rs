//! Names of one-sigmas per axis.

use super::quantity::Quantity;

/// The words for a one-sigma; each longer word precedes the shorter ones that it begins with.
const MARKS: [&str; 6] = ["stddev", "stdev", "std", "sigma", "sig", "sd"];

/// The one-sigma of a receiver's position or velocity along one axis that `name` denotes: `stdn`, `latstd`,
/// `sdvn`, `velocitysigmaeast`. The name is in lower case, without punctuation.
pub(crate) fn per_axis(name: &str) -> Option<Quantity> {
    let position = |axis| Some(Quantity::SigmaPosition(axis));
    let velocity = |axis| Some(Quantity::SigmaVelocity(axis));
    let of = MARKS.iter().find_map(|mark| {
        let (before, after) = name.split_once(mark)?;
        // "velocitysigmaeast" means the same as "sigmavelocityeast".
        Some(before.to_owned() + after)
    })?;
    let of = of.strip_prefix("position").or_else(|| of.strip_prefix("pos")).unwrap_or(&of);
    match of {
        "n" | "north" | "lat" | "latitude" => position(0),
        "e" | "east" | "lon" | "lng" | "long" | "longitude" => position(1),
        "d" | "down" | "u" | "up" | "alt" | "altitude" | "hgt" | "height" => position(2),
        "vn" | "veln" | "vnorth" | "velnorth" | "velocitynorth" | "velocityn" => velocity(0),
        "ve" | "vele" | "veast" | "veleast" | "velocityeast" | "velocitye" => velocity(1),
        "vd" | "veld" | "vdown" | "veldown" | "velocitydown" | "velocityd" | "vu" | "velu"
        | "vup" | "velup" | "velocityup" | "velocityu" => velocity(2),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_sigmas_of_many_receivers_and_programs_are_understood() {
        use Quantity::{SigmaPosition as P, SigmaVelocity as V};
        for (name, quantity) in [
            ("stdn", P(0)),
            ("sde", P(1)),
            ("sdu", P(2)),
            ("sigmad", P(2)),
            ("nstd", P(0)),
            ("latstd", P(0)),
            ("stddevlongitude", P(1)),
            ("posstdd", P(2)),
            ("sigmavn", V(0)),
            ("stdveleast", V(1)),
            ("vdsigma", V(2)),
            ("velocitysigmaeast", V(1)),
        ] {
            assert_eq!(per_axis(name), Some(quantity), "{name}");
        }
        // Covariances between axes, horizontal one-sigmas, and those of the attitude.
        for name in ["sdne", "sigmah", "sigmav", "sigmavh", "stdroll", "std", "speed", "north"] {
            assert_eq!(per_axis(name), None, "{name}");
        }
    }
}
