//! Models, designs for them, and the autopilot that flies them.

mod airframe;
mod autopilot;
mod autopilot_settings;
mod design;
mod excitation;
mod model;
mod model_files;
mod riccati;
mod thesis;
