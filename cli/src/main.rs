//! The command `hovernav`.

#[cfg_attr(not(test), expect(dead_code, reason = "the verb that writes reports comes next"))]
mod report;

fn main() {}
