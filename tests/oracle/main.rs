//! A second, plain implementation of the filter, and what the shipped one is held against it for.

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
