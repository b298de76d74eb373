//! Grooming, on skins whose geometry is known.

mod folds;
mod lawn;
mod masks;
mod operations;
mod refusals;
