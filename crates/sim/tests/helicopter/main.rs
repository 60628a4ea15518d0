//! The simulated helicopter: its airframe, its engine, and the lag of the estimator.

mod airframe;
mod estimator_lag;
mod linear;
mod power_loss;
