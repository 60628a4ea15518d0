//! The balanced basis, in which damped steps treat all states alike.

use nalgebra::{DMatrix, DVector};

use crate::linear::{InnovationModel, LinearModel};

/// `model` in the basis in which each state is as easy to reach from inputs and innovations as to
/// see in the outputs; unchanged where some state is neither.
pub(super) fn balanced(
    model: InnovationModel,
    initial_state: DVector<f64>,
) -> (InnovationModel, DVector<f64>) {
    let Some(basis) = balancing_basis(&model) else { return (model, initial_state) };
    let Some(inverse) = basis.clone().try_inverse() else { return (model, initial_state) };
    let system = model.system;
    let moved = LinearModel {
        a: &inverse * system.a * &basis,
        b: &inverse * system.b,
        c: system.c * &basis,
        ..system
    };
    (InnovationModel { system: moved, gain: &inverse * model.gain }, inverse * initial_state)
}

fn balancing_basis(model: &InnovationModel) -> Option<DMatrix<f64>> {
    let (system, gain) = (&model.system, &model.gain);
    let transition = &system.a - gain * &system.c;
    let drive = &system.b - gain * &system.d;
    let reached = gramian(&transition, &(&drive * drive.transpose() + gain * gain.transpose()))?;
    let seen = gramian(&transition.transpose(), &system.c.tr_mul(&system.c))?;
    let factor = reached.cholesky()?.unpack();
    let svd = (factor.tr_mul(&seen) * &factor).svd(true, false);
    if svd.singular_values.min() <= 0.0 {
        return None;
    }
    // The singular values here are the squares of Hankel's.
    let scales = svd.singular_values.map(|value| value.powf(-0.25));
    Some(factor * svd.u? * DMatrix::from_diagonal(&scales))
}

/// X = A X Aᵀ + Q by doubling (Smith, 1968); `None` where A is not stable.
fn gramian(a: &DMatrix<f64>, q: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let (mut power, mut sum) = (a.clone(), q.clone());
    for _ in 0..60 {
        let added = &power * &sum * power.transpose();
        sum += &added;
        if !sum.norm().is_finite() {
            return None;
        }
        if added.amax() <= 1e-15 * sum.amax() {
            return Some(sum);
        }
        power = &power * &power;
    }
    None
}
