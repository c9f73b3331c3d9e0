//! The command `loc-sim`.

fn main() {}
