mod bad_input;
mod consistency;
mod forms;
mod linear;
mod localizer;
mod reference;
mod submap;
mod unknown;
