//! Logs: reading what others recorded, writing what we computed. Needs `std`.

pub mod dataset;
