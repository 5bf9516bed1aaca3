//! The files that a picture is written to: one, or one for each eye where its name has a `%V`.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::bail;
use barnard::camera::Camera;
use barnard::composite::parted;
use barnard::image::{Image, LayerChoice};
use barnard::scene::Scene;
use barnard_files::SaveImage;
use barnard_files::formats::{Writer, check_writable, writer};

/// Placeholder of an eye's name, as in Nuke.
const EYE: &str = "%V";
const EYES: [&str; 2] = ["left", "right"];

/// True if standard output is taken by an image or JSON, and words go to standard error.
pub(crate) static STDOUT_IS_TAKEN: AtomicBool = AtomicBool::new(false);

/// Leaves standard output to an image or JSON, if `taken`.
pub fn take_stdout(taken: bool) {
    STDOUT_IS_TAKEN.fetch_or(taken, Ordering::Relaxed);
}

/// The name behind a format that stands for the standard output, as in `png:-`.
const STANDARD: &str = ":-";

/// The format of an output that goes to the standard output; none where it goes to a file.
pub fn standard(path: &Path) -> anyhow::Result<Option<&'static Writer>> {
    match path.to_str() {
        Some("-") => bail!("-o -: the format of standard output is required; write -o png:- or -o fits:-"),
        Some(name) => Ok(name.strip_suffix(STANDARD).map(|format| writer(Path::new(&format!("standard.{format}")))).transpose()?),
        None => Ok(None),
    }
}

/// The writer of an output.
pub fn writer_of(path: &Path) -> anyhow::Result<&'static Writer> {
    standard(path)?.map_or_else(|| Ok(writer(path)?), Ok)
}

/// The files that `path` means for pictures of a camera.
pub fn files(path: &Path, camera: &Camera) -> anyhow::Result<Vec<PathBuf>> {
    let Some(name) = path.to_str().filter(|name| name.contains(EYE)) else { return Ok(vec![path.to_owned()]) };
    if camera.stereo.is_none() {
        bail!("-o {name}: {EYE} requires a stereo camera; add [camera.stereo], or remove {EYE}");
    }
    Ok(EYES.map(|eye| PathBuf::from(name.replace(EYE, eye))).to_vec())
}

/// Checks that all files can be written, before a long render.
pub fn check(paths: &[PathBuf], camera: &Camera) -> anyhow::Result<()> {
    for path in paths {
        if standard(path)?.is_some() {
            continue;
        }
        files(path, camera)?.iter().try_for_each(|file| check_writable(file))?;
    }
    Ok(())
}

/// The layers that --layers names.
pub fn parse_layers(text: &str) -> Result<LayerChoice, String> {
    let names: Vec<&str> = text.split(',').map(str::trim).collect();
    LayerChoice::by_names(&names)
}

/// The scene with the layers that are asked for, of which none is rendered for files that hold none, if it fits into memory.
pub fn layered(scene: Scene, asked: Option<LayerChoice>, outputs: &[PathBuf], memory_limit: u64) -> anyhow::Result<Scene> {
    let any = |is: fn(&Writer) -> bool| outputs.iter().any(|path| writer_of(path).is_ok_and(is));
    let (have_layers, show_colours) = (any(|writer| writer.has_layers), any(|writer| writer.is_picture));
    if asked.is_some_and(LayerChoice::is_any) && !have_layers {
        bail!("--layers requires an .exr or .fits output; add -o layers.exr");
    }
    let layers = asked.unwrap_or(scene.output.layers);
    Ok(scene.with_layers(layers).for_files(have_layers, show_colours, memory_limit)?)
}

/// Writes an image of a scene, and says which files were written.
pub fn save(image: &Image, path: &Path, scene: &Scene) -> anyhow::Result<Vec<PathBuf>> {
    if let Some(writer) = standard(path)? {
        std::io::stdout().write_all(&(writer.encode)(image, &scene.save_options())?)?;
        return Ok(Vec::new());
    }
    let (files, camera, options) = (files(path, &scene.camera)?, &scene.camera, scene.save_options());
    match (&files[..], camera.stereo) {
        ([left, right], Some(stereo)) => {
            let [of_left, of_right] = parted(stereo.arrangement, image, camera);
            of_left.save(left, &options)?;
            of_right.save(right, &options)?;
        }
        _ => image.save(path, &options)?,
    }
    Ok(files)
}
