//! Scenes from trees of properties.

use std::sync::Arc;

use spectra::fingerprint::Digest;
use spectra::passband::Passband;

use super::gas::VoxelGas;
use super::root::*;
use super::{
    Background, Fields, Film, IonisedGas, Loader, Scene, SceneSpec, Spectrograph, Star, background, band, catalogue, detail, display, dust,
    emission, film, gas, method, observation, output, spectrograph, star_table,
};
use crate::animation::Timeline;
use crate::camera;
use crate::data::Inputs;
use crate::error::{Error, Result};
use crate::instrument::Instrument;
use crate::observation::Observation;
use crate::properties::{Section, Table, places};

impl Scene {
    /// Reads a scene from its properties; `name` is what it is called where it does not say. One that changes is read as it
    /// is at the loader's [moment](Loader::at).
    ///
    /// # Errors
    /// If a key is unknown or missing, a value is wrong, a file cannot be read, and those of [`check`](Self::check);
    /// each says its place.
    pub fn from_properties(table: &Table, name: &str, loader: &Loader) -> Result<Self> {
        let inputs = loader.inputs.recording();
        match Timeline::build(&Section::root(table), &inputs)? {
            None => Self::still(table, name, loader, None),
            Some(timeline) => {
                let film = Film { timeline: &timeline, tree: table, time: loader.moment };
                let mut scene = Self::still(&timeline.at(table, loader.moment)?, name, loader, Some(film))?;
                scene.spec.inputs.extend(inputs.notes());
                scene.spec.timeline = Some(Arc::new(timeline));
                Ok(scene)
            }
        }
    }

    /// Reads a scene without changes from its properties; `film` says which moment of a film it is.
    ///
    /// # Errors
    /// If a key is unknown or missing, or a value is out of range.
    pub fn still(table: &Table, name: &str, loader: &Loader, film: Option<Film>) -> Result<Self> {
        let root = &Section::root(table);
        root.check(ROOT)?;
        let loader = &loader.recording();
        let inputs = &loader.inputs;
        let camera = camera::build(&root.read(&CAMERA)?, inputs)?;
        let bookmark = |(name, section): (&str, Section)| Ok((name.to_owned(), camera::bookmark(&section, inputs, &camera)?));
        let bookmarks = root.read(&BOOKMARK)?.unwrap_or_default().into_iter().map(bookmark).collect::<Result<_>>()?;
        let (bands, mut spectrograph) = Self::passbands(root, inputs)?;
        let stars = star_table::stars(root, loader)?;
        let display = display::build(root.read(&DISPLAY)?.as_ref(), &bands)?;
        let observation = root.read(&OBSERVATION)?.map(|s| observation::build(&s)).transpose()?;
        let background = root.read(&BACKGROUND)?.map(|s| Self::behind(&s, loader, observation.as_ref())).transpose()?;
        let instrument = root.read(&INSTRUMENT)?.map(|s| Instrument::from_properties(s.properties(), inputs).map(Arc::new)).transpose()?;
        let output = output::build(root.read(&OUTPUT)?.as_ref())?;
        let method = method::build(root.read(&METHOD)?.as_ref())?;
        let detail = root.read(&DETAIL)?.map(|s| detail::build(&s)).transpose()?;
        // Fields may take long: whatever else the text says is read first.
        let fields = Fields::new(root, loader)?;
        let dust = root.read(&DUST)?.map(|s| dust::build(&s, loader, &fields)).transpose()?;
        let emission = root.read(&EMISSION)?.unwrap_or_default().into_iter().map(|s| emission::build(&s, loader, &fields));
        let emission = emission.collect::<Result<Vec<_>>>()?;
        let gas_section = root.read(&GAS)?;
        // Fields that are in use are not made again.
        let gas = gas_section.as_ref().map(|section| gas::build(section, &fields)).transpose()?;
        let ionised = gas_section.as_ref().map(|section| ionised(section, &fields, &stars, &bands, film, loader)).transpose()?;
        if let Some(spectrograph) = &mut spectrograph {
            let species = emission.iter().chain(ionised.iter().flat_map(|gas| &gas.species));
            let at_rest: Vec<f64> = species.flat_map(|species| species.spectrum.lines()).map(|line| line.lambda_um).collect();
            spectrograph.axis.rest_um = spectrograph.axis.rest_um.or_else(|| spectrograph.only_line(&at_rest));
        }
        let is_rough = fields.are_rough() || ionised.as_ref().is_some_and(|gas| gas.is_rough);
        let spec = SceneSpec {
            name: root.read(&NAME)?.unwrap_or(name).to_owned(),
            description: root.read(&DESCRIPTION)?.unwrap_or("").to_owned(),
            camera,
            bookmarks,
            dust,
            emission,
            gas,
            stars,
            background: background.unwrap_or_default(),
            detail,
            bands,
            spectrograph,
            display,
            observation,
            instrument,
            output,
            method,
            timeline: None,
            is_rough,
            provenance: None,
            inputs: inputs.notes(),
        };
        let sources = spec.sources();
        let species = spec.species(ionised.as_deref(), inputs.memory_limit, &loader.control);
        species.and_then(|species| spec.derived(ionised, species, sources)).map_err(|error| placed(error, table))
    }

    /// Passbands, and the spectrograph whose channels they are.
    fn passbands(root: &Section, inputs: &Inputs) -> Result<(Vec<Passband>, Option<Spectrograph>)> {
        let Some(section) = root.read(&SPECTROGRAPH)? else { return Ok((band::build(root, inputs)?, None)) };
        let spectrograph = spectrograph::build(&section)?;
        root.refuse(&[&band::BANDS.row, &BAND.row], "custom passbands, without [spectrograph]")?;
        Ok((spectrograph::bands(&section, &spectrograph)?, Some(spectrograph)))
    }

    /// Reads what lies behind the cloud; stars of a catalogue that was read before are taken again.
    fn behind(section: &Section, loader: &Loader, observation: Option<&Observation>) -> Result<Background> {
        let placed = |table: Section| {
            table.check(catalogue::KEYS)?;
            let stars = loader.catalogue(table.fingerprint(), || catalogue::build(&table, &loader.inputs))?;
            catalogue::placed(&table, stars, observation)
        };
        let catalogue = section.table("catalogue")?.map(placed).transpose()?;
        background::build(section, &loader.inputs, catalogue)
    }
}

/// State of the gas of a table: that of a film is a mean over the stars of its moments.
fn ionised(
    section: &Section,
    fields: &Fields,
    stars: &[Star],
    bands: &[Passband],
    film: Option<Film>,
    loader: &Loader,
) -> Result<Arc<IonisedGas>> {
    let content = |moments: &[&[Star]]| {
        let mut content = Digest::new("gas");
        content.part(section.fingerprint()).part(fields.fingerprint());
        for stars in moments {
            content.part(gas::sources(stars, bands));
        }
        content.finish()
    };
    let solve = |stars: &[Star]| gas::solve(section, loader, fields, stars, bands);
    let nearest = match film.filter(|_| !loader.is_rough) {
        Some(film) => film.around(section, fields, loader)?,
        None => None,
    };
    let Some([(before, first), (present, second), (after, third)]) = nearest else {
        return loader.gas(content(&[stars]), || Ok(solve(stars)?.with_fronts()));
    };
    // The mean over the stars of several moments.
    let knot = |knot: &film::Knot| {
        let moments: Vec<&[Star]> = knot.iter().map(Vec::as_slice).collect();
        loader.knot(content(&moments), || gas::mean(&moments, solve))
    };
    let earlier = VoxelGas::clone(&*knot(&before)?).mixed(&*knot(&present)?, second / (first + second));
    Ok(Arc::new(earlier.mixed(&*knot(&after)?, third).with_fronts()))
}

/// Copy of the error with the line of the text, where the tree that the scene is from knows it.
fn placed(error: Error, tree: &Table) -> Error {
    let Error::Scene { message, mut place } = error else { return error };
    // Passbands of one's own stand elsewhere.
    if place.key == band::BANDS.name && tree.get(BAND.name).is_some() {
        place.key = BAND.name.into();
    }
    let whole = if place.path.is_empty() { place.key.clone() } else { format!("{}.{}", place.path, place.key) };
    let ancestors = std::iter::successors(Some(whole.as_str()), |path| path.rfind(['.', '[']).map(|end| &path[..end]));
    let known = |path: &str| places::get(tree, path).ok().flatten().and_then(|property| property.origin.clone());
    place.origin = ancestors.filter_map(known).next().or(tree.origin().cloned());
    Error::Scene { message, place }
}
