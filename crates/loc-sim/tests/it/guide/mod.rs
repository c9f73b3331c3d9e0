//! The guide and the READMEs: what they link to, include, show and tell people to type is there.

mod book;
mod commands;
mod figures;
mod includes;
mod links;
mod pages;
