//! Barnard: physically calibrated spectral rendering of nebulae.
//!
//! A [`Scene`] is what is in front of the telescope, and the telescope; [`render()`] turns it into an
//! [`Image`], band radiances in W m⁻² sr⁻¹ with a stated error.
//!
//! ```
//! use barnard::prelude::*;
//! use barnard_files::SaveImage;
//!
//! # let data: Vec<f32> = (0..64 * 64 * 64).map(|i| ((i % 64) as f32 * 0.2).sin().powi(2)).collect();
//! # let folder = tempfile::tempdir()?;
//! # std::env::set_current_dir(&folder)?;
//! let density = Grid::new([64, 64, 64], Bounds::cube(DVec3::ZERO, 1.0), data)?;
//! let dust = Dust::new(density, Extinction::by_name("gordon23")?, Scale::per_pc(5.0)).with_albedo(0.6).with_phase(HenyeyGreenstein::new(0.5)?);
//! let star = Star::blackbody(Temperature(22_000.0), Luminosity::suns(5000.0)).with_position(dvec3(0.2, 0.1, 0.3));
//! let camera = Camera::look_at(dvec3(0.0, 0.0, 6.0), DVec3::ZERO).with_field_of_view_deg(25.0).with_size(512, 512);
//! # let camera = camera.with_size(24, 24);
//! let scene = SceneSpec::new(camera).with_bands(passband::set("johnson")?).with_dust(dust).with_star(star).build()?;
//! let image = barnard::render(&scene, &Options::default())?;
//! image.save("nebula.fits", &scene.save_options())?;
//! # assert!(image.band(1).all(|v| v.is_finite()) && image.band(1).any(|v| v > 0.0) && std::path::Path::new("nebula.fits").exists());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Where more than a picture is wanted:
//!
//! | | |
//! |---|---|
//! | [`scene`], [`field`], [`phase`], [`camera`] | the objects of a scene; fields, phase functions, [extinction laws](spectra::extinction) and [passbands](spectra::passband) of one's own implement their traits |
//! | [`plan`] | the numbers that a scene comes to: made once, kept while a camera or a spectrum changes |
//! | [`plates`] | a picture kept light by light, so that spectra change without a march |
//! | [`backend`] | what turns either into light: the processor, the exact reference, the path tracer, and those of other crates |
//! | [`control`] | progress and interruption |
//! | [`animation`], [`sequence`] | scenes that change from moment to moment, and their frames |
//! | [`image`] | the result, its display, what it says of itself |
//! | [`observation`], [`instrument`] | where on the sky it is taken, and what records it |
//! | [`detail`] | what densities have below their voxels |
//! | [`properties`], [`data`] | the neutral tree that scenes are read from, and what it names |

pub mod backend;
#[doc(hidden)]
pub mod packet;
pub mod plan;
pub mod plates;
pub mod prelude;
mod render;
pub mod sequence;
mod stats;
pub mod volume;

pub use barnard_scene::{
    Camera, Control, Error, Image, Result, Scene, animation, blocks, cache, camera, composite, control, data, detail, error, field,
    geometry, glam, image, instrument, keywords, light, memory, observation, phase, points, properties, random, scene, spectra,
    star_catalogue, star_field, stored,
};
pub use plan::{Options, Plan, Planned, Planner};
pub use plates::Plates;
pub use render::{render, render_reference, render_with};

#[doc(hidden)]
pub use barnard_scene::fixtures;
