//! The command as a user meets it: good input works, bad input gives one clear message, status 1 or 2 and no file.

mod answers;
mod cache;
mod desk;
mod fit;
mod frames;
mod inputs;
#[cfg(all(feature = "formats", feature = "study", feature = "view"))]
mod manual;
mod observe;
mod outputs;
mod plates;
mod renders;
mod scenes;
