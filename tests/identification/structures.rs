//! Structures of models in files: the built-in ones, one of a user, and files that are none.

use std::path::Path;

use hovernav_log::Dataset;
use hovernav_sysid::helicopter::{
    IdentifyError, ModelStructure, Velocity, gyro_solutions, identify,
};

fn of_text(text: &str) -> Result<ModelStructure, String> {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("mine.toml");
    std::fs::write(&file, text).unwrap();
    file.to_str().unwrap().parse().map_err(|error| format!("{error}"))
}

#[test]
fn a_model_of_parts_has_their_equations_and_its_own_parameters() {
    let structure = |name| ModelStructure::built_in(name).unwrap().equations;
    let hybrid = structure("hybrid");
    assert_eq!(&hybrid.outputs, &["p", "q", "phi", "theta", "u", "v", "w", "r"]);
    // The side velocity moves yaw, and is a state of the whole.
    assert!(structure("yaw").inputs.contains(&"v".to_owned()));
    assert!(!hybrid.inputs.contains(&"v".to_owned()));
    for part in ["flapping", "heave", "yaw"] {
        let part = structure(part);
        assert!(part.states.iter().all(|state| hybrid.states.contains(state)));
        for parameter in part.parameters {
            let own = hybrid.parameter(&parameter.name).expect(&parameter.name);
            assert_eq!(hybrid.parameters[own], parameter);
        }
    }
    let (multirotor, hover) = (structure("multirotor"), structure("hover"));
    assert_eq!(multirotor.states, hover.states);
    let prior = |of: &hovernav_sysid::methods::structure::Structure| {
        of.parameters[of.parameter("lag_lat").unwrap()].prior.unwrap().0
    };
    assert!(prior(&multirotor) > prior(&hover));
}

#[test]
fn a_structure_in_a_file_is_identified_like_a_built_in_one() {
    let dir = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/datasets/heli-hover"));
    let mut dataset = Dataset::open(dir).unwrap();
    let settings = dataset.settings().unwrap();
    let solutions = dataset.smooth(&settings, |_| ()).solutions;
    let mine = of_text(
        "summary = \"yaw rate from the pedal alone\"\n\
         inputs = [\"pedal\"]\n\
         outputs = [\"r\"]\n\
         offsets = [\"r\"]\n\
         equations = [\"r' = damping*r + power*pedal + n_r\"]\n\
         delays = { pedal = \"delay\" }\n\
         noises = { n_r = 0.3 }\n\
         parameters = [\n\
         { name = \"damping\", unit = \"1/s\", start = -4.0, range = [-60.0, 0.0] },\n\
         { name = \"power\", unit = \"rad/s²\", start = 20.0 },\n\
         { name = \"delay\", unit = \"s\", start = 0.01, range = [0.0, 0.2] },\n\
         ]\n",
    );
    let mine = mine.unwrap();
    assert_eq!(mine.name(), "mine");
    let of = |structure| {
        let found = identify(&dataset, &solutions, structure, Velocity::Estimated).unwrap();
        found.identified
    };
    let (own, known) = (of(mine), of(ModelStructure::built_in("yaw").unwrap()));
    for (mine, built_in) in [("damping", "Nr"), ("power", "Nped")] {
        let (mine, known) =
            (own.estimates.get(mine).unwrap(), known.estimates.get(built_in).unwrap());
        let apart = (mine.value - known.value).abs() / mine.bound.hypot(known.bound);
        assert!(apart < 3.0, "{}: {} and {}", known.name, mine.value, known.value);
    }
}

#[test]
fn the_gyros_of_a_log_without_gps_give_the_model_of_the_rates() {
    let dir = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/datasets/heli-hover"));
    let mut dataset = Dataset::open(dir).unwrap();
    let settings = dataset.settings().unwrap();
    let with_gps = dataset.smooth(&settings, |_| ()).solutions;
    let of = |dataset: &Dataset, solutions: &[_], name| {
        identify(dataset, solutions, ModelStructure::built_in(name), Velocity::Estimated)
    };
    let known = of(&dataset, &with_gps, "yaw").unwrap().identified;
    dataset.fixes.clear();
    let alone = gyro_solutions(&dataset);
    let own = identify(&dataset, &alone, None, Velocity::Estimated).unwrap().identified;
    assert_eq!(own.structure.name, "rates");
    for name in ["Nr", "Nped", "Ncol"] {
        let (own, known) = (own.estimates.get(name).unwrap(), known.estimates.get(name).unwrap());
        assert!((own.value - known.value).abs() < known.bound, "{name}: {own:?}, {known:?}");
    }
    let refused = of(&dataset, &alone, "heave").map(drop).unwrap_err();
    assert_eq!(refused, IdentifyError::NoFix { model: "heave".into() });
}

#[test]
fn what_is_no_structure_is_rejected_with_the_file_and_the_reason() {
    let heave = ModelStructure::text("heave").unwrap();
    let changed = |from: &str, to: &str| {
        assert!(heave.contains(from), "{from}");
        of_text(&heave.replacen(from, to, 1)).unwrap_err()
    };
    assert!(of_text(heave).is_ok());
    for (from, to, reason) in [
        ("summary", "summery", "unknown key `summery`"),
        ("n_dw = 1.0, ", "", "no initial sigma of n_dw"),
        ("n_dw = 1.0, ", "n_dw = nan, ", "no initial sigma of n_dw"),
        ("n_dw = 1.0, ", "n_dw = -1.0, ", "no initial sigma of n_dw"),
        ("Zw*w", "Zq*w", "Zq"),
        ("start = -0.7", "start = -70.0", "outside its limits"),
        ("expected = [-0.8, 0.25]", "expected = [-0.8, 0.0]", "Zw"),
        ("expected = [-0.8, 0.25]", "expected = [-0.8, nan]", "Zw"),
        ("start = -0.7", "start = \"low\"", "mine.toml:"),
        ("inputs = [\"collective\", \"kw\"]", "inputs = [\"kw\"]", "collective"),
        ("values = { Zw = -0.7 }", "values = { Zx = -0.7 }", "Zx"),
        ("values = { Zw = -0.7 }", "values = { Zw = 70.0 }", "Zw"),
    ] {
        let error = changed(from, to);
        assert!(error.contains(reason) && error.contains("mine"), "{to}: {error}");
    }
    assert!(of_text("parts = [\"tail\"]").unwrap_err().contains("found the part `tail`"));
    assert!(of_text("parts = [\"hybrid\"]").unwrap_err().contains("found the part `hybrid`"));
    assert!(of_text("").unwrap_err().contains("at least one state"));
    let unknown = "glider".parse::<ModelStructure>().unwrap_err().to_string();
    assert!(unknown.contains("expected a TOML file or one of yaw, heave"), "{unknown}");
}
