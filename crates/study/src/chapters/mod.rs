//! The chapters: one file and one row each.

mod augmentation;
mod basis_size;
mod complexity;
mod convergence;
mod density;
mod filters;
mod frames;
mod lights;
mod scene;

use crate::Chapter;

/// All chapters, in the order of the page.
pub const CHAPTERS: &[Chapter] = &[
    convergence::CHAPTER,
    basis_size::CHAPTER,
    augmentation::CHAPTER,
    density::CHAPTER,
    lights::CHAPTER,
    frames::CHAPTER,
    filters::CHAPTER,
    complexity::CHAPTER,
];
