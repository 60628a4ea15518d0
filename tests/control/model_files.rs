//! Guarantees of a model's file, and rejected models.

use hovernav_model::{ModelError, Parameter, Signal, Slope, StateSpace, TimeDomain, shipped};
use nalgebra::DMatrix;
use std::path::Path;

fn slope(parameter: &str, row: &str, column: &str, slope: f64) -> Slope {
    let [parameter, row, column] = [parameter, row, column].map(str::to_owned);
    Slope { parameter, row, column, slope }
}

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
    .unwrap()
    .with_slopes(vec![slope("Lp", "p", "p", 0.1 + 0.2), slope("Mq", "p", "lateral", -1e-9)])
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
    let slopes = |parameter: &str, row: &str, column: &str, slope: &str| {
        format!(
            "parameters = [{{ name = \"Lp\", value = -8.0, unit = \"1/s\" }}]\nslopes = [{{ parameter = \
             \"{parameter}\", row = \"{row}\", column = \"{column}\", slope = {slope} }}]\nB ="
        )
    };
    let variance = |name: &str, variance: &str| {
        format!(
            "parameters = [{{ name = \"{name}\", value = 0.5, unit = \"1/s\" }}]\nparameter_covariance = \
             [[{variance}]]\nB ="
        )
    };
    for (from, to, expected) in [
        ("time_domain = \"continuous\"\n", "", "m.toml:1: time_domain: found none, expected one"),
        (
            "\"continuous\"",
            "\"sampled\"",
            "m.toml:2: time_domain: found \"sampled\", expected \"continuous\" or \"discrete\"",
        ),
        ("\"continuous\"", "\"discrete\"", "without its period"),
        ("\"continuous\"", "\"discrete\"\nperiod_s = 0.0", "m.toml:3: sample period: found 0 s"),
        ("\"continuous\"", "\"continuous\"\nperiod_s = 0.1", "m.toml:3: found period_s"),
        ("-8.0", "nan", "m.toml:5: A: found NaN in row 1, column 1"),
        ("[[20.0], [0.0]]", "[[20.0], [inf]]", "m.toml:6: B: found inf in row 2"),
        ("[1.0, 0.0]", "[1.0]", "m.toml:5: A: found 1 numbers in row 2, expected 2"),
        ("[[20.0], [0.0]]", "[[20.0]]", "m.toml:6: B: found 1x1, expected 2x1"),
        ("\"phi\"", "\"p\"", "m.toml:3: states: found the name \"p\" twice"),
        ("\"lateral\"", "\"\"", "m.toml:4: inputs: found the name \"\" empty"),
        ("B =", "slopes = [{ parameter = \"Lp\"}]\nB =", "m.toml:6: [slopes] row: found none"),
        ("B =", &slopes("Lv", "p", "p", "1.0"), "m.toml:7: slope 1, parameter: found \"Lv\""),
        (
            "B =",
            &slopes("Lp", "q", "p", "1.0"),
            "slope 1, row: found \"q\", expected one of the st",
        ),
        ("B =", &slopes("Lp", "p", "pedal", "1.0"), "slope 1, column: found \"pedal\", expected"),
        ("B =", &slopes("Lp", "p", "p", "nan"), "slope 1, slope: found \"NaN\", expected a finite"),
        ("B =", &slopes("Lp", "p", "p", "\"1\""), "slope: found \"1\", expected a number"),
        ("B =", "b =", "m.toml:6: b: no such key, expected \"name\", "),
        ("-8.0", "true", "m.toml:5: A: found true, expected a number"),
        (
            "B =",
            "verdict = \"fine\"\nB =",
            "m.toml:6: verdict: found \"fine\", expected \"good\", \"care\" or \"do not fly\"",
        ),
        (
            "B =",
            "verdict = \"care\"\nB =",
            "m.toml:6: found the verdict \"care\" without reasons, expected its original reasons",
        ),
        (
            "B =",
            "reasons = [\"Zw is not known\"]\nB =",
            "m.toml:6: found 1 reason without a verdict, expected their original verdict",
        ),
        (
            "B =",
            &variance("Lb", "1e30"),
            "m.toml:7: parameter_covariance: found 1e30 for Lb, a standard error of 1e15 1/s, expected at most 1e6",
        ),
        ("B =", &variance("tau_col", "2e6"), "found 2e6 for tau_col"),
        (
            "B =",
            "verdict = \"good\"\nreasons = [\"Zw is not known\"]\nB =",
            "m.toml:6: found the verdict \"good\" and 1 reason against it",
        ),
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
    assert!(adrift.contains("no steady state"), "{adrift}");
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
    // Valid results of a search: a stick that is early by less than a sample, and a time constant of the rotor.
    let found = vec![parameter("tau_lat", -0.015), parameter("tau_f", 0.1)];
    assert!(shipped::thesis().with_parameters(found, None).is_ok());
}

/// Each pair of correlations is possible, but all three together are not. Two parameters that correlate strongly with
/// a third cannot correlate negatively with each other.
#[test]
fn correlations_that_no_variables_have_together_are_refused() {
    let named = |name: &str| Parameter { name: name.into(), value: 1.0, unit: String::new() };
    let parameters = ["Lb", "Ma", "Nr"].map(named).to_vec();
    let with = |last: f64| {
        let covariance = [1.0, 90.0, 0.9, 90.0, 1e4, 100.0 * last, 0.9, 100.0 * last, 1.0];
        let covariance = DMatrix::from_row_slice(3, 3, &covariance);
        shipped::thesis().with_parameters(parameters.clone(), Some(covariance))
    };
    assert!(with(0.9).is_ok());
    // A held or dropped parameter has no variance.
    let exact = Some(DMatrix::zeros(3, 3));
    assert!(shipped::thesis().with_parameters(parameters.clone(), exact).is_ok());
    assert!(shipped::thesis().with_parameters(Vec::new(), Some(DMatrix::zeros(0, 0))).is_ok());
    let refused = with(-0.9).unwrap_err().to_string();
    assert!(refused.contains("found correlations that are impossible together"), "{refused}");
}

#[test]
fn a_model_moves_along_its_slopes_and_by_nothing_else() {
    let parameters = ["Lp", "tau_lat"].map(|name| Parameter {
        name: name.into(),
        value: 0.05,
        unit: String::new(),
    });
    let thesis = shipped::thesis();
    let model = thesis.clone().with_parameters(parameters.to_vec(), None).unwrap();
    let twice = vec![slope("Lp", "p", "p", 1.0), slope("Lp", "p", "p", 2.0)];
    let twice = model.clone().with_slopes(twice).unwrap_err().to_string();
    let expected = "slope 2, parameter: found \"Lp\", expected each parameter once";
    assert!(twice.contains(expected), "{twice}");
    let slopes = vec![slope("Lp", "p", "p", 2.0), slope("Lp", "q", "lateral", -3.0)];
    let model = model.with_slopes(slopes).unwrap();
    let moved = model.moved(&[0.5, 0.01]).unwrap();
    let (p, q, lateral) = (model.state("p"), model.state("q"), model.input("lateral"));
    let (p, q, lateral) = (p.unwrap(), q.unwrap(), lateral.unwrap());
    let (mut a, mut b) = (thesis.a().clone(), thesis.b().clone());
    a[(p, p)] += 1.0;
    b[(q, lateral)] -= 1.5;
    assert_eq!((moved.a(), moved.b()), (&a, &b));
    assert_eq!([moved.parameters()[0].value, moved.parameters()[1].value], [0.55, 0.05 + 0.01]);
    assert!(model.moved(&[0.5]).is_err() && model.moved(&[f64::INFINITY, 0.0]).is_err());
}
