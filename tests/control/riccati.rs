//! Guarantees of the Riccati solvers: every benchmark to rounding, also with singular weights.

use approx::assert_abs_diff_eq;
use hovernav_design::{DesignError, care, dare};
use hovernav_testing::shared;
use nalgebra::{DMatrix, dmatrix};
use serde_json::Value;

fn matrix(value: &Value) -> DMatrix<f64> {
    let rows: Vec<Vec<f64>> = serde_json::from_value(value.clone()).unwrap();
    DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
}

/// Solves every row of a collection and prints the distance of each solution from the solution with 300 digits.
fn errors(
    collection: &str,
    solve: impl Fn(&Value) -> Result<DMatrix<f64>, DesignError>,
) -> Option<Vec<f64>> {
    let text = std::fs::read_to_string(shared(format!("reference/{collection}.json"))?).unwrap();
    let collection: Value = serde_json::from_str(&text).unwrap();
    let errors = collection["examples"].as_array().unwrap().iter().map(|row| {
        let expected = matrix(&row["x_ref"]);
        let solved = solve(row);
        let error =
            solved.as_ref().map_or(f64::INFINITY, |x| (x - &expected).norm() / expected.norm());
        let refused = solved.err().map(|error| error.to_string()).unwrap_or_default();
        println!("{:22} n = {:3} {error:8.1e} {refused}", row["id"], row["n"]);
        error
    });
    Some(errors.collect())
}

fn mostly_to_rounding(errors: &[f64]) {
    assert!(errors.iter().all(|&error| error <= 1e-8));
    let fine = errors.iter().filter(|&&error| error <= 1e-12).count();
    assert!(5 * fine >= 4 * errors.len(), "{fine} of {}", errors.len());
}

#[test]
fn the_continuous_benchmark_equations_are_solved_to_rounding() {
    let solve = |row: &Value| {
        let [a, b, q, r] = ["A", "B", "Q", "R"].map(|key| matrix(&row[key]));
        care(&a, &b, &q, &r).map(|solution| solution.x)
    };
    if let Some(errors) = errors("carex", solve) {
        mostly_to_rounding(&errors);
    }
}

#[test]
fn the_discrete_benchmark_equations_are_solved_to_rounding_singular_weights_too() {
    let solve = |row: &Value| {
        let [a, b, q, r, s] = ["A", "B", "Q", "R", "S"].map(|key| matrix(&row[key]));
        dare(&a, &b, &q, &r, Some(&s)).map(|solution| solution.x)
    };
    if let Some(errors) = errors("darex", solve) {
        mostly_to_rounding(&errors);
    }
}

#[test]
fn large_and_long_problems_meet_their_closed_forms() {
    // A ring of 64 cells: X has the eigenvectors of A and λ + √(λ² + 1) (CAREX 3.2).
    let n = 64;
    let ring = DMatrix::from_fn(n, n, |i, j| match (i + n - j) % n {
        0 => -2.0,
        1 | 63 => 1.0,
        _ => 0.0,
    });
    let one = DMatrix::identity(n, n);
    let x = care(&ring, &one, &one, &one).unwrap().x;
    let eigen = ring.symmetric_eigen();
    let values = eigen.eigenvalues.map(|value| value + (value * value + 1.0).sqrt());
    let expected =
        &eigen.eigenvectors * DMatrix::from_diagonal(&values) * eigen.eigenvectors.transpose();
    assert!((x - &expected).norm() < 1e-12 * expected.norm());

    // A chain of 21 integrators, measured at one end and driven at the other. The element of X in the first row and the
    // last column is 1 (CAREX 4.1, Laub 1979).
    let n = 21;
    let chain = DMatrix::from_fn(n, n, |i, j| if j == i + 1 { 1.0 } else { 0.0 });
    let end = DMatrix::from_fn(n, 1, |i, _| if i == n - 1 { 1.0 } else { 0.0 });
    let mut seen = DMatrix::zeros(n, n);
    seen[(0, 0)] = 1.0;
    let solution = care(&chain, &end, &seen, &dmatrix![1.0]).unwrap();
    println!("corner off by {:e}", solution.x[(0, n - 1)] - 1.0);
    assert_abs_diff_eq!(solution.x[(0, n - 1)], 1.0, epsilon = 1e-10);
}

#[test]
fn a_singular_weight_under_an_indefinite_cost_is_solved() {
    // DAREX 1.2 (Ionescu and Weiss 1992): R has rank 1, the cost is indefinite; the closed loop is known.
    let a = dmatrix![0.0, 1.0; 0.0, -1.0];
    let b = dmatrix![1.0, 0.0; 2.0, 1.0];
    let q = dmatrix![-4.0, -4.0; -4.0, 7.0] / 11.0;
    let r = dmatrix![9.0, 3.0; 3.0, 1.0];
    let s = dmatrix![3.0, 1.0; -1.0, 7.0];
    let solution = dare(&a, &b, &q, &r, Some(&s)).unwrap();
    println!("residual {:.1e}, X = {}", solution.residual, solution.x);
    assert!(solution.residual < 1e-14);
    let closed = &a - &b * &solution.gain;
    let mut sizes: Vec<f64> = closed.complex_eigenvalues().iter().map(|pole| pole.norm()).collect();
    sizes.sort_by(f64::total_cmp);
    for (found, expected) in sizes.iter().zip([0.217_058_149_757, 0.687_271_691_664]) {
        assert!((found - expected).abs() < 1e-10, "{sizes:?}");
    }
}

#[test]
fn every_weight_at_zero_is_solved_where_the_cost_is_in_the_states() {
    // Deadbeat control: the control has no cost, so the states are at rest in two steps.
    let a = dmatrix![1.0, 0.1; 0.0, 1.0];
    let b = dmatrix![0.005; 0.1];
    let solution = dare(&a, &b, &dmatrix![1.0, 0.0; 0.0, 1.0], &dmatrix![0.0], None).unwrap();
    let radius = (a - b * &solution.gain)
        .complex_eigenvalues()
        .iter()
        .map(|pole| pole.norm())
        .fold(0.0, f64::max);
    assert!(radius < 1.0 && solution.residual < 1e-13, "{radius}");
}

#[test]
fn a_mode_that_must_stay_on_the_border_is_refused_by_name() {
    // The cost does not contain an undamped oscillation: the pencil has this eigenvalue pair twice on the unit circle.
    let turn = dmatrix![0.8, 0.6; -0.6, 0.8];
    let (b, none) = (dmatrix![0.0; 1.0], DMatrix::zeros(2, 2));
    let error = dare(&turn, &b, &none, &dmatrix![1.0], None).unwrap_err().to_string();
    assert!(error.contains("no stabilising solution"), "{error}");
    let swing = dmatrix![0.0, 1.0; -4.0, 0.0];
    let error = care(&swing, &b, &none, &dmatrix![1.0]).unwrap_err().to_string();
    assert!(error.contains("no stabilising solution"), "{error}");
}
