//! Models, what is designed for them, and the autopilot that flies it.

mod autopilot;
mod design;
mod model;
mod model_files;
mod riccati;
mod thesis;
