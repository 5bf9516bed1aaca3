//! The lights of a scene, as all back ends name them, and what each contributes through a passband.

use spectra::constants::{PARSEC, SPHERE};
use spectra::extinction::Extinction;
use spectra::spectrum::Spectrum;

use crate::error::Result;
use crate::scene::{Dust, Scene};
use crate::star_catalogue::StarClass;
use crate::star_field::{CLASSES, field_classes};

/// One light and the way it takes to the eye.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Route {
    /// Light of a star that dust scatters once on the way.
    Scattered {
        /// The number of the star in the scene.
        star: usize,
    },
    /// Light that a species of gas sends out.
    Emitted {
        /// The number of the species in the scene.
        species: usize,
    },
    /// Light of the background, the same from all directions.
    Background,
    /// Light of a star that comes straight to the eye.
    Direct {
        /// The number of the star in the scene.
        star: usize,
    },
    /// Light of a class of stars at infinity.
    FieldStar {
        /// The number of the class: of the star field, then, from [`CLASSES`]' length on, of the catalogue.
        class: usize,
    },
}

impl Route {
    /// The part of the picture's light that takes it.
    pub fn part(self) -> LightPart {
        match self {
            Route::Scattered { .. } => LightPart::Scattered,
            Route::Emitted { species } => LightPart::Emission { species },
            Route::Background => LightPart::Background,
            Route::Direct { .. } | Route::FieldStar { .. } => LightPart::Stars,
        }
    }
}

/// A part of a picture's light, by where it comes from last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LightPart {
    /// Starlight that dust scatters towards the eye.
    Scattered,
    /// Light of a species of gas.
    Emission {
        /// The number of the species in the scene.
        species: usize,
    },
    /// The even light behind the cloud.
    Background,
    /// Stars that are seen as points.
    Stars,
}

impl LightPart {
    /// The parts that a scene's light has.
    pub fn of(scene: &Scene) -> Vec<Self> {
        let mut parts = Vec::new();
        if scene.dust.is_some() && !scene.stars.is_empty() {
            parts.push(Self::Scattered);
        }
        parts.extend((0..scene.species().len()).map(|species| Self::Emission { species }));
        if scene.background.spectrum.is_some() {
            parts.push(Self::Background);
        }
        if scene.background.has_stars() || scene.stars.iter().any(|star| star.visible) {
            parts.push(Self::Stars);
        }
        parts
    }

    /// The scene whose light is this part of another's: other lights are out, all dust is there.
    ///
    /// # Errors
    /// Errors of [`Scene::check`](crate::scene::Scene::check).
    pub fn alone(self, scene: &Scene) -> Result<Scene> {
        let mut spec = scene.as_lights();
        let species = std::mem::take(&mut spec.emission);
        if let Self::Emission { species: number } = self {
            spec.emission.extend(species.into_iter().nth(number));
        }
        match self {
            Self::Scattered => spec.stars.iter_mut().for_each(|star| star.visible = false),
            Self::Emission { .. } | Self::Background => spec.stars.clear(),
            Self::Stars => {}
        }
        if self != Self::Background {
            spec.background.spectrum = None;
        }
        if self != Self::Stars {
            spec.background.star_field = None;
            spec.background.catalogue = None;
        }
        spec.build()
    }
}

/// A light with its spectrum, in the unit that its geometry turns into radiance: scattered: W m⁻² sr… times σ dl and
/// 1/r² [pc⁻²]; emitted: times j dl \[pc\]; background: as it is; direct: times 1/r² [pc⁻²], irradiance.
#[derive(Debug, Clone)]
pub struct Light {
    /// The route it takes to the eye.
    pub route: Route,
    /// The name that certificates give it.
    pub name: String,
    /// The spectrum it begins with.
    pub spectrum: Spectrum,
}

/// All lights of a scene; those that can send nothing are left out.
///
/// # Errors
/// If the classes of field stars cannot be made.
pub fn lights(scene: &Scene) -> Result<Vec<Light>> {
    let mut lights = Vec::new();
    let per_square_parsec = 1.0 / (SPHERE * PARSEC * PARSEC);
    for (star, s) in scene.stars.iter().enumerate() {
        let spectrum = s.spectrum.clone().scaled(per_square_parsec);
        if scene.dust.is_some() {
            lights.push(Light { route: Route::Scattered { star }, name: format!("{}, scattered", s.name), spectrum: spectrum.clone() });
        }
        if s.visible {
            lights.push(Light { route: Route::Direct { star }, name: format!("{}, direct", s.name), spectrum });
        }
    }
    for (species, e) in scene.species().iter().enumerate() {
        lights.push(Light { route: Route::Emitted { species }, name: e.name.clone(), spectrum: e.spectrum.clone().scaled(PARSEC) });
    }
    if let Some(spectrum) = &scene.background.spectrum {
        lights.push(Light { route: Route::Background, name: "background".into(), spectrum: spectrum.clone() });
    }
    if scene.background.star_field.is_some() {
        for (class, StarClass { name, spectrum }) in field_classes()?.into_iter().enumerate() {
            lights.push(Light { route: Route::FieldStar { class }, name, spectrum });
        }
    }
    if let Some(placed) = &scene.background.catalogue {
        for (class, StarClass { name, spectrum }) in placed.catalogue.classes.iter().enumerate() {
            let route = Route::FieldStar { class: CLASSES.len() + class };
            lights.push(Light { route, name: name.clone(), spectrum: spectrum.clone() });
        }
    }
    Ok(lights)
}

/// Extinction of a scene; without dust nothing is asked of it but a number.
///
/// # Errors
/// If the catalogue lacks the plainest law, which a test rules out.
pub fn law(scene: &Scene) -> Result<std::sync::Arc<Extinction>> {
    Ok(match &scene.dust {
        Some(dust) => dust.extinction.clone(),
        None => std::sync::Arc::new(Extinction::by_name("inverse_wavelength")?),
    })
}

/// The spectral factor of a route beside its spectrum: k ω where light is scattered, 1 otherwise.
pub fn factor(route: Route, dust: Option<&Dust>) -> impl Fn(f64) -> f64 + Send + Sync + Clone + 'static {
    let scattering = match (route, dust) {
        (Route::Scattered { .. }, Some(dust)) => Some((dust.extinction.clone(), dust.albedo.clone())),
        _ => None,
    };
    move |lambda| scattering.as_ref().map_or(1.0, |(law, albedo)| law.k(lambda) * albedo.at(lambda))
}
