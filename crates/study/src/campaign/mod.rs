//! The chapters about certificates: one file and one row each.

mod glow;
mod integral;
mod slabs;

use crate::Chapter;

/// All chapters, in the order of the page.
pub const CHAPTERS: &[Chapter] = &[slabs::CHAPTER, glow::CHAPTER];
