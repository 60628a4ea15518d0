//! What the estimator makes of whole flights: where it starts, which aids it takes in, what it does with faults, and
//! whether its errors are as large as it says.

mod aid_faults;
mod aids;
mod alignment;
mod barometer_in_wind;
mod blocks;
mod consistency;
mod covariance_interval;
mod findings;
mod found_heading;
mod garbage;
mod heading;
mod heading_borne_out;
mod health;
mod injection;
mod large_step;
mod late_fixes;
mod launch;
mod layouts;
mod lost_heading;
mod lost_level;
mod magnetic_after_gap;
mod midair;
mod motors;
mod notch;
mod places;
mod recovery;
mod single_precision;
mod slow_increments;
mod small_numbers;
mod stated_sigmas;
mod steep_circles;
mod trouble;
mod unaided;
mod unfound_heading;
mod wheels;
