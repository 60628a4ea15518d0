//! What a model's file promises, and a model that is refused.

use hovernav_model::{ModelError, Parameter, Signal, StateSpace, TimeDomain, shipped};
use nalgebra::DMatrix;
use std::path::Path;

#[test]
fn a_model_file_gives_back_the_model_to_the_last_bit() {
    let parameters = ["Lp", "Mq"].map(|name| Parameter {
        name: name.into(),
        value: -0.1 - 1.0 / 3.0,
        unit: "1/s".into(),
    });
    let model = StateSpace::new(
        "a \"quoted\" name",
        TimeDomain::Discrete { period_s: 1.0 / 33.0 },
        vec![Signal::new("p", "rad/s"), Signal::new("phi", "rad")],
        vec![Signal::new("lateral", "stick")],
        DMatrix::from_row_slice(2, 2, &[0.1 + 0.2, 1e-300, 1.0 / 3.0, 1.0]),
        DMatrix::from_row_slice(2, 1, &[1e22, -0.0]),
    )
    .unwrap()
    .with_source("a test\nof two lines")
    .with_outputs(
        vec![Signal::new("roll", "deg")],
        DMatrix::from_row_slice(1, 2, &[0.0, 57.3]),
        DMatrix::zeros(1, 1),
    )
    .unwrap()
    .with_parameters(
        parameters.to_vec(),
        Some(DMatrix::from_row_slice(2, 2, &[1e-4, 1e-5, 1e-5, 4e-4])),
    )
    .unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.toml");
    model.write(&path).unwrap();
    assert_eq!(StateSpace::read(&path).unwrap(), model);
    for name in ["thesis", "mettler_r50", "raptor60"] {
        let shipped = shipped::by_name(name).unwrap();
        assert!(!shipped.source().is_empty());
        assert_eq!(StateSpace::parse(&shipped.to_toml(), Path::new("again")).unwrap(), shipped);
    }
}

#[test]
fn a_file_that_is_no_model_is_refused_with_line_and_reason() {
    let good = "name = \"m\"\ntime_domain = \"continuous\"\n\
        states = [{ name = \"p\", unit = \"rad/s\" }, { name = \"phi\", unit = \"rad\" }]\n\
        inputs = [{ name = \"lateral\", unit = \"stick\" }]\n\
        A = [[-8.0, 0.0], [1.0, 0.0]]\nB = [[20.0], [0.0]]\n";
    assert!(StateSpace::parse(good, Path::new("m.toml")).is_ok());
    for (from, to, expected) in [
        ("time_domain = \"continuous\"\n", "", "time_domain"),
        ("\"continuous\"", "\"sampled\"", "m.toml:2: unknown variant `sampled`"),
        ("\"continuous\"", "\"discrete\"", "without its period"),
        ("\"continuous\"", "\"discrete\"\nperiod_s = 0.0", "m.toml:3: sample period: found 0 s"),
        ("\"continuous\"", "\"continuous\"\nperiod_s = 0.1", "m.toml:3: found period_s"),
        ("-8.0", "nan", "m.toml:5: A: found NaN in row 1, column 1"),
        ("[[20.0], [0.0]]", "[[20.0], [inf]]", "m.toml:6: B: found inf in row 2"),
        ("[1.0, 0.0]", "[1.0]", "m.toml:5: A: found 1 numbers in row 2, expected 2"),
        ("[[20.0], [0.0]]", "[[20.0]]", "m.toml:6: B: found 1x1, expected 2x1"),
        ("\"phi\"", "\"p\"", "m.toml:3: states: found the name \"p\" twice"),
        ("\"lateral\"", "\"\"", "m.toml:4: inputs: found the name \"\" empty"),
        ("B =", "b =", "unknown field `b`"),
        ("name = \"m\"", "name = ", "m.toml:1"),
    ] {
        let text = good.replacen(from, to, 1);
        let error = StateSpace::parse(&text, Path::new("m.toml")).unwrap_err().to_string();
        assert!(error.contains(expected), "{to}: {error}");
    }
}

#[test]
fn what_does_not_fit_a_model_is_refused_by_name() {
    let thesis = shipped::thesis();
    let told = |error: ModelError| error.to_string();
    let unknown = told(thesis.subsystem(&["p", "psi"], &[]).unwrap_err());
    assert!(unknown.contains("no \"psi\"") && unknown.contains("theta"), "{unknown}");
    assert!(told(thesis.require_discrete().unwrap_err()).contains("continuous"));
    let adrift = told(shipped::raptor60().residualised(&["psi"]).unwrap_err());
    assert!(adrift.contains("no steady value"), "{adrift}");
}

#[test]
fn parameters_and_covariances_that_none_has_are_refused_by_name() {
    let parameter = |name: &str, value| Parameter { name: name.into(), value, unit: "s".into() };
    let refused = |parameters: [Parameter; 2], covariance: &[f64]| {
        let covariance = DMatrix::from_row_slice(2, 2, covariance);
        let refused = shipped::thesis().with_parameters(parameters.to_vec(), Some(covariance));
        refused.unwrap_err().to_string()
    };
    let one = [1.0, 0.0, 0.0, 1.0];
    let late = |name: &str, value| [parameter("Lb", 1.0), parameter(name, value)];
    assert!(
        refused(late("tau_ped", -5.0), &one).contains("tau_ped: found a stick's delay outside")
    );
    assert!(refused(late("tau_col", 5.0), &one).contains("tau_col: found a stick's delay outside"));
    assert!(refused(late("lag_lat", -0.1), &one).contains("lag_lat: found a servo's lag outside"));
    let sure = refused(late("Ma", 1.0), &[1.0, 75.0, 75.0, 1.0]);
    assert!(sure.contains("Ma: found a correlation beyond 1"), "{sure}");
    // What a search finds of a stick that comes early by less than a sample, and a rotor's own time.
    let found = vec![parameter("tau_lat", -0.015), parameter("tau_f", 0.1)];
    assert!(shipped::thesis().with_parameters(found, None).is_ok());
}
