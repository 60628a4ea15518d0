//! The simulated helicopter: its airframe, its engine, and the lag of the estimator.

mod airframe;
mod estimator_lag;
mod power_loss;
