//! Structures of models in files: built-in structures, a user's own structure, and invalid files.

use std::path::Path;

use approx::assert_abs_diff_eq;
use hovernav_dataset::Dataset;
use hovernav_model::{Grade, Verdict};
use hovernav_sysid::helicopter::{
    FlightRecord, FrequencyDomain, IdentifyError, ModelStructure, Velocity, gyro_solutions,
    identify,
};
use hovernav_sysid::methods::prediction_error::{Estimate, Status};

use crate::data::{flown, identified};

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
    let (dataset, solutions) = flown();
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

/// Parameters of an identification with the changed file of a built-in structure, and its verdict.
fn changed(name: &str, changes: &[(&str, &str)]) -> (Vec<Estimate>, Verdict) {
    let dir = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/datasets/heli-hover"));
    let dataset = Dataset::open(dir).unwrap();
    let mut text = ModelStructure::text(name).unwrap().to_owned();
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    // Yaw needs neither attitude nor velocity.
    let solutions = gyro_solutions(&dataset);
    let structure = of_text(&text).unwrap();
    let found = identify(&dataset, &solutions, structure, Velocity::Estimated).unwrap();
    (found.parameters().to_vec(), found.verdict(None))
}

#[test]
fn fixed_values_and_priors_are_in_the_unit_of_the_record() {
    let nped = "{ name = \"Nped\", unit = \"rad/s²\", start = 20.0, range = [-500.0, 500.0], needed = true }";
    let value = |as_written: &str| {
        let found = changed("yaw", &[(nped, &format!("{{ name = \"Nped\", {as_written} }}"))]);
        (found.0.into_iter().find(|own| own.name == "Nped").unwrap(), found.1)
    };
    let (held, verdict) = value("start = 20.0, fixed = true");
    assert_eq!((held.value, held.status), (20.0, Status::Held));
    assert!(verdict.reasons.iter().any(|own| own.contains("it keeps its initial value, 20.000")));
    let (expected, _) = value("start = 20.0, expected = [20.0, 1e-4]");
    assert_abs_diff_eq!(expected.value, 20.0, epsilon = 1e-2);
}

#[test]
fn a_verdict_does_not_depend_on_the_names_of_the_parameters() {
    let renamed = [("Nped*pedal", "power*pedal"), ("\"Nped\"", "\"power\"")];
    assert_eq!(changed("yaw", &renamed).1.grade, changed("yaw", &[]).1.grade);
    // Without the effect of the pedal on yaw, its own parameter is known to nothing.
    let elsewhere = [("Nped*pedal", "power*collective"), ("Ncol*collective", "0*pedal")];
    let elsewhere = [&elsewhere[..], &renamed[1..]].concat();
    let without = [(
        "    { name = \"Ncol\", unit = \"rad/s²\", start = 0.0, range = [-200.0, 200.0] },\n",
        "",
    )];
    let (own, verdict) = changed("yaw", &[&elsewhere[..], &without].concat());
    let percent = own.iter().find(|own| own.name == "power").unwrap().bound_percent();
    assert!(percent <= 15.0 || verdict.grade != Grade::Good, "{percent}: {verdict:?}");
    let nothing = [
        ("Nped*pedal + Ncol*collective", "0*pedal + 0*collective"),
        (
            "    { name = \"Nped\", unit = \"rad/s²\", start = 20.0, range = [-500.0, 500.0], needed = true },\n",
            "",
        ),
        ("    { name = \"Ncol\", unit = \"rad/s²\", start = 0.0, range = [-200.0, 200.0] },\n", ""),
    ];
    let (_, verdict) = changed("yaw", &nothing);
    assert!(
        verdict.reasons.iter().any(|reason| reason == "no stick acts on the model"),
        "{verdict:?}"
    );
}

#[test]
fn a_model_of_angles_has_no_frequency_domain() {
    let angle = "summary = \"\"\ninputs = [\"longitudinal\"]\noutputs = [\"theta\"]\n\
                 equations = [\"theta' = K*longitudinal + L*theta + n_t\"]\nnoises = { n_t = 0.1 }\n\
                 parameters = [{ name = \"K\", start = -1.0 }, { name = \"L\", start = -0.5, range = [-9.0, 0.0] }]\n";
    let (dataset, solutions) = flown();
    let structure = of_text(angle).unwrap();
    let found = identify(&dataset, &solutions, structure, Velocity::Estimated).unwrap();
    let record = FlightRecord::new(&dataset, &solutions, Velocity::Estimated).unwrap();
    let error = FrequencyDomain::of(&found, &record).unwrap_err().to_string();
    assert!(error.contains("neither rates nor velocities"), "{error}");
}

#[test]
fn the_gyros_of_a_log_without_gps_give_the_model_of_the_rates() {
    let (mut dataset, with_gps) = flown();
    let known = identified(&dataset, &with_gps, "yaw").identified;
    dataset.fixes.clear();
    let alone = gyro_solutions(&dataset);
    let own = identify(&dataset, &alone, None, Velocity::Estimated).unwrap().identified;
    assert_eq!(own.structure.name, "rates");
    for name in ["Nr", "Nped", "Ncol"] {
        let (own, known) = (own.estimates.get(name).unwrap(), known.estimates.get(name).unwrap());
        assert!((own.value - known.value).abs() < known.bound, "{name}: {own:?}, {known:?}");
    }
    let heave = ModelStructure::built_in("heave").unwrap();
    let refused = identify(&dataset, &alone, heave, Velocity::Estimated).map(drop).unwrap_err();
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
        ("n_dw = 1.0, ", "", "sigma of n_dw above 0"),
        ("n_dw = 1.0, ", "n_dw = nan, ", "sigma of n_dw above 0"),
        ("n_dw = 1.0, ", "n_dw = -1.0, ", "sigma of n_dw above 0"),
        ("Zw*w", "Zq*w", "Zq"),
        ("start = -0.7", "start = -70.0", "outside its limits"),
        ("expected = [-0.8, 0.25]", "expected = [-0.8, 0.0]", "Zw"),
        ("expected = [-0.8, 0.25]", "expected = [-0.8, nan]", "Zw"),
        ("start = -0.7", "start = \"low\"", "mine.toml:"),
        ("inputs = [\"collective\", \"kw\"]", "inputs = [\"kw\"]", "collective"),
        ("values = { Zw = -0.7 }", "values = { Zx = -0.7 }", "Zx"),
        ("values = { Zw = -0.7 }", "values = { Zw = 70.0 }", "Zw"),
        ("values = { Zw = -0.7 }", "values = { tau_gust = 5.0 }", "tau_gust"),
        ("noises = { n_dw = 10.0 }", "noises = { n_x = 10.0 }", "n_x"),
        ("outputs = [\"w\"]", "outputs = [\"w\", \"w\"]", "`w` twice"),
        ("outputs = [\"w\"]", "outputs = [\"w x\"]", "`w x`"),
        ("\"kw\"]", "\"kw\", \"banana\"]", "`banana`"),
        ("range = [-10.0, 5.0]", "range = [5.0, -10.0]", "Zw"),
        ("range = [0.0, 0.1]", "range = [-0.1, 0.1]", "lag_col"),
        ("stick_travel = 0.3", "stick_travel = 0.0", "stick_travel"),
        ("\"tau_col\"", "\"tau_col\\nlag\"", "letters, digits"),
        ("name = \"Zw\"", "name = \"Zcol\"", "`Zcol` twice"),
        ("name = \"Zw\"", "name = \"dw\"", "the parameter `dw`"),
    ] {
        let error = changed(from, to);
        assert!(error.contains(reason) && error.contains("mine"), "{to}: {error}");
    }
    let both = format!("parts = [\"yaw\"]\n{heave}");
    assert!(of_text(&both).unwrap_err().contains("`parts` and other keys"));
    assert!(of_text("parts = [\"yaw\", \"yaw\"]").unwrap_err().contains("`yaw` twice"));
    assert!(of_text("parts = [\"roll\", \"roll-pitch\"]").unwrap_err().contains("`p\u{27}` twice"));
    let fixed = "parts = [\"yaw\", \"heave\"]\n\
                 parameters = [{ name = \"Nr\", start = -3.0, fixed = true }]";
    assert!(of_text(fixed).is_ok(), "{:?}", of_text(fixed));
    assert!(of_text("parts = [\"tail\"]").unwrap_err().contains("found the part `tail`"));
    assert!(of_text("parts = [\"hybrid\"]").unwrap_err().contains("found the part `hybrid`"));
    assert!(of_text("").unwrap_err().contains("at least one state"));
    let unknown = "glider".parse::<ModelStructure>().unwrap_err().to_string();
    assert!(unknown.contains("expected a TOML file or one of yaw, heave"), "{unknown}");
}
