//! The C interface: what it promises to programs in C and C++, and what it does with their mistakes.

mod c;
mod header;
mod misuse;
mod modules;
mod same_bits;
mod settings;
mod values;
