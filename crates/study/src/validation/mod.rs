//! The chapters of the validation: one file and one row each.

mod bounces;
mod stars;

use crate::Chapter;

/// All chapters, in the order of the page.
pub const CHAPTERS: &[Chapter] = &[bounces::CHAPTER, stars::CHAPTER];
