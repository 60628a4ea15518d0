//! Logs and tables of others, read number for number, damaged, and never taken for what they are not.

mod aids;
mod cross_check;
mod damage;
mod damage_foreign;
mod logs;
mod mapped;
mod mapping;
mod mapping_samples;
mod mapping_times;
mod mapping_units;
mod onboard_innovations;
mod raw;
mod ros2;
mod ros2_reference;
mod ulog_marks;
mod wide;
