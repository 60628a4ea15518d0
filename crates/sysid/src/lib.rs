//! Identification: from a recorded flight to a validated model, or to the reasons why it cannot be trusted.
//!
//! The crate has three modules. Each uses only the modules above it in the table:
//!
//! | module | contents |
//! |---|---|
//! | [`record`] | flight records ([`Experiment`](record::Experiment)): test points, tones, filters, kinematic checks |
//! | [`methods`] | excitation, subspace identification, frequency responses, prediction error, validation |
//! | [`helicopter`] | the equations of a small helicopter, and all of the above applied to a recorded flight |
//!
//! Every identified model is a [`LinearModel`](hovernav_model::LinearModel) or
//! [`StateSpace`](hovernav_model::StateSpace), which state whether they are continuous or discrete in time.
//!
//! ```
//! use hovernav_sysid::methods::prediction_error::{Settings, identify};
//! use hovernav_sysid::methods::structure::{Parameter, Structure};
//! use hovernav_sysid::nalgebra::DMatrix;
//! use hovernav_sysid::record::Experiment;
//!
//! // Yaw by pedal, r' = -4 r + 25 pedal, sampled at 33 Hz.
//! let (decay, pedal) = (f64::exp(-0.12), |k: usize| if (k / 40) % 2 == 0 { 0.1 } else { -0.1 });
//! let mut r = 0.0;
//! let outputs = DMatrix::from_fn(400, 1, |k, _| {
//!     let measured = r + 0.01 * ((k * k) as f64 * 0.618).fract();
//!     r = decay * r + 6.25 * (1.0 - decay) * pedal(k);
//!     measured
//! });
//! let inputs = DMatrix::from_fn(400, 1, |k, _| pedal(k));
//! let names = |name: &str| vec![name.to_owned()];
//! let flight = Experiment::new("yaw", 0.03, names("pedal"), names("r"), inputs, outputs)?;
//!
//! let yaw = Structure::new(
//!     "yaw",
//!     vec![Parameter::new("Nr", "1/s", -1.0), Parameter::new("Nped", "rad/s²", 10.0)],
//!     "inputs pedal
//!      outputs r
//!      noise n_r
//!      offsets r
//!      r' = Nr*r + Nped*pedal + n_r",
//! )?;
//! let found = identify(&yaw, &[flight], &Settings::innovations(vec![0.3]))?;
//! let damping = found.estimates.get("Nr").unwrap();
//! assert!((damping.value - -4.0).abs() < 4.0 * damping.bound);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod helicopter;
pub mod methods;
pub mod record;

pub use nalgebra;
