//! Foreign logs and tables: correct numbers, damaged files, and no wrong recognition.

mod aids;
mod alike;
mod bags;
mod campaign;
mod cases;
mod clock;
mod cross_check;
mod damage;
mod damage_foreign;
mod faults;
mod inputs;
mod logs;
mod mapped;
mod mapping;
mod mapping_samples;
mod mapping_times;
mod mapping_units;
mod mavlink;
mod onboard_innovations;
mod raw;
mod ros2;
mod ros2_reference;
mod setup_suspect;
mod ulog_marks;
mod verdict;
mod wide;
