//! The simulated helicopter: its airframe, its engine, and how late the estimator follows it.

mod airframe;
mod estimator_lag;
mod power_loss;
