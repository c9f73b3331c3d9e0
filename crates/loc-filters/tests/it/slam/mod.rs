mod bad_input;
mod consistency;
mod linear;
mod localizer;
mod reference;
mod submap;
mod unknown;
