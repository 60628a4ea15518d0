//! A second, plain implementation of the filter's equations, and the comparison of the shipped filter with it.
//!
//! Read it next to `docs/equations.md`, in this order:
//!
//! | file | equations | next to |
//! |---|---|---|
//! | `mechanization` | (S1) to (S8), (S14): the nominal state | `src/ins` |
//! | `transition` | (K2): Φ, dense | `src/ekf/kernel/covariance/propagation.rs` |
//! | `noise` | (K4), (K5), (K13), (K21): Q, dense | `src/ekf/filter/process.rs` |
//! | `filter` | (K3): samples, gaps, resets | `src/ekf/filter/mod.rs` |
//! | `update` | (K1), (K6): Joseph's form, error injection | `src/ekf/kernel/covariance/joint.rs`, `update.rs` |
//! | `history` | (M1), (M2): late measurements | `src/ekf/kernel/history.rs` |
//! | `gps`, `aids` | (M3) to (M6), (M8) to (M14), (M19): h, H and R | `src/ekf/measurement` |
//!
//! `shipped` and `pair` make the same calls to both filters; `compare` has the tolerances. Gates, monitors and learned
//! quantities are not part of the equations: the oracle takes them from `Ekf::learned` and from the trace of the
//! shipped filter. The oracle has no wheel constraint (M17) and no monitor of the magnetic field (M15).

mod aids;
mod compare;
mod filter;
mod flights;
mod gps;
mod history;
mod mechanization;
mod noise;
mod pair;
mod sequences;
mod shipped;
mod transition;
mod update;
