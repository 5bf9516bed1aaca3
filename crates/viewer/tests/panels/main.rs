//! The explorer without a window: every panel is shown, changed by its own widgets, and looked at.
//!
//! `UPDATE_SNAPSHOTS=1` writes the pictures of the panels anew.

mod documents;
mod edits;
mod explorer;
mod levels;
mod looks;
mod timeline;
mod view;
