//! The C interface: its guarantees to programs in C and C++, and its response to their errors.

mod c;
mod header;
mod misuse;
mod modules;
mod own;
mod same_bits;
mod settings;
mod values;
