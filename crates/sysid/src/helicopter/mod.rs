//! Parametrised hover dynamics of a small helicopter, from yaw alone to Mettler's 13 states.
//!
//! States and inputs have the names of [`crate`]'s flight signals: u, v, w m/s; p, q, r rad/s;
//! phi, theta rad; lateral, longitudinal, collective, pedal −1…1 about trim. Derivatives are in SI,
//! per unit stick. Every structure is continuous in time.
//!
//! # Source
//! Paw (2005), *System identification and control system design for a model helicopter in hover*,
//! NTU, doi:10.32657/10356/47095, equations 3.39–3.57 and section 5.6.1.3. Mettler, Tischler and Kanade
//! (2002), *J. AHS* 47(1), the R-50.

mod equations;

use std::fmt;
use std::str::FromStr;

use super::structure::Structure;

/// Which part of the helicopter, in how much detail.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// r from pedal and collective.
    Yaw,
    /// w from collective.
    Heave,
    /// p, q, φ, θ, u, v from the cyclic, flapping taken as instantaneous: the thesis's reduced model.
    RollPitch,
    /// All ten states of equations 3.50–3.57, flapping included.
    Hybrid,
    /// Roll and pitch, heave and yaw, without flapping: eight states.
    Hover,
    /// Mettler's R-50 with stabiliser bar and yaw gyro: 13 states.
    R50,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Yaw, Self::Heave, Self::RollPitch, Self::Hybrid, Self::Hover, Self::R50];

    /// The name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Yaw => "yaw",
            Self::Heave => "heave",
            Self::RollPitch => "roll-pitch",
            Self::Hybrid => "hybrid",
            Self::Hover => "hover",
            Self::R50 => "r50",
        }
    }

    /// The parametrised model, its parameters at starts and within bounds that suit model helicopters
    /// of a metre or two of rotor.
    #[must_use]
    pub fn structure(self) -> Structure {
        equations::structure(self)
    }

    /// A start for the σ of each process noise of [`Kind::structure`]: gusts and what the equations
    /// leave out, as an acceleration per sample.
    #[must_use]
    pub fn process_sigma(self) -> Vec<f64> {
        let of = |noise: &String| match noise.as_str() {
            "n_p" | "n_q" | "n_r" => 0.3,
            "n_ug" | "n_vg" | "n_wg" => 1.0,
            _ => 0.2,
        };
        self.structure().noises.iter().map(of).collect()
    }

    /// Outputs whose noise is not to be estimated, with the σ to hold, rad.
    ///
    /// An estimator's attitude is the integral of its gyros, noise included: taken at its own
    /// precision it would say that the rates have no noise. A σ far above it lets the attitude
    /// say what it alone knows, where level is, and leaves the dynamics to the rates.
    #[must_use]
    pub fn held_sigma(self) -> Vec<(String, f64)> {
        match self {
            Self::Yaw | Self::Heave | Self::R50 => Vec::new(),
            Self::RollPitch | Self::Hybrid | Self::Hover => {
                vec![("phi".to_owned(), 0.02), ("theta".to_owned(), 0.02)]
            }
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A model's name that is none.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("found \"{0}\", expected yaw, heave, roll-pitch, hybrid, hover or r50")]
pub struct UnknownKind(String);

impl FromStr for Kind {
    type Err = UnknownKind;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Self::ALL
            .into_iter()
            .find(|kind| kind.name() == text)
            .ok_or_else(|| UnknownKind(text.to_owned()))
    }
}
