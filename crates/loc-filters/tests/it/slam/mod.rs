mod bad_input;
mod consistency;
mod linear;
mod reference;
mod unknown;
