//! Files that are read and written: one program, so that its tests share the processor.

mod animation;
mod bundles;
mod cache;
mod dust_maps;
mod fields;
mod fits_frames;
mod fits_tiles;
mod formats;
mod gas;
mod grids_written;
mod hdf5;
mod inputs;
mod manual;
mod panoramas;
mod parts;
mod plates;
mod star_tables;
mod support;
mod vdb;
mod volumes;
