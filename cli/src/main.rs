//! The command `hovernav`.
fn main() {}
