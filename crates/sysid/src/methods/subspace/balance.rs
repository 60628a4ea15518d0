//! The balanced basis, in which damped steps treat all states equally.

use nalgebra::{DMatrix, DVector};

use crate::methods::innovation::InnovationModel;
use hovernav_model::LinearModel;
use hovernav_model::linalg::Stein;

/// `model` in the basis in which each state is as controllable from inputs and innovations as it is observable in the
/// outputs. Unchanged where a state is uncontrollable or unobservable.
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
    let reached =
        Stein::new(&transition)?.solve(&drive * drive.transpose() + gain * gain.transpose());
    let seen = Stein::new(&transition.transpose())?.solve(system.c.tr_mul(&system.c));
    let factor = reached.cholesky()?.unpack();
    let svd = (factor.tr_mul(&seen) * &factor).svd(true, false);
    if svd.singular_values.min() <= 0.0 {
        return None;
    }
    // These singular values are the squares of the Hankel singular values.
    let scales = svd.singular_values.map(|value| value.powf(-0.25));
    Some(factor * svd.u? * DMatrix::from_diagonal(&scales))
}
