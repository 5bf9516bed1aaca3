//! What shines before it is scattered, for eight terms.

use std::collections::HashMap;

use super::{Octet, Term, WIDTH};
use crate::light::{Light, Path};
use crate::plan::{BandPlan, Crowd, Spectral};

/// Stars, gas and background.
#[derive(Debug, Clone, PartialEq)]
pub struct Lamps {
    /// Stars that are marched one by one, and what each sends: weights without k ω.
    pub stars: Vec<(usize, Octet)>,
    /// What the stars of the crowd send, in its order.
    pub crowd: Vec<Octet>,
    /// Emission per length.
    pub glow: Option<Vec<Octet>>,
    pub around: Octet,
    /// Radiance that all this is in parts of.
    pub unit: f32,
}

impl Lamps {
    /// Of terms from `first` on.
    pub fn new(lights: &[Light], spectral: &Spectral, (first, terms): (usize, &[Term]), gas: &[Vec<f32>], crowd: Option<&Crowd>) -> Self {
        let all = |light| spectral.bands.iter().flat_map(move |b: &BandPlan| b.rule.form.decay().weights(light)).copied();
        let extended = lights.iter().enumerate().filter(|(_, l)| !matches!(l.path, Path::Direct { .. } | Path::FieldStar { .. }));
        let unit = extended.flat_map(|(light, _)| all(light)).fold(f64::MIN_POSITIVE, |most, w| most.max(w.abs()));
        let mut lamps =
            Self { stars: Vec::new(), crowd: Vec::new(), glow: None, around: [0.0; WIDTH], unit: (unit as f32).max(f32::MIN_POSITIVE) };
        for (light, l) in lights.iter().enumerate() {
            let weights: Vec<f64> = all(light).collect();
            let of = |t: usize| weights.get(first + t).map_or(0.0, |w| w / unit);
            match l.path {
                Path::Scattered { star } => {
                    let sent = |t: usize| terms.get(t).map_or(0.0, |term| term.k * term.albedo);
                    lamps.stars.push((star, std::array::from_fn(|t| if sent(t) > 0.0 { (of(t) / sent(t)) as f32 } else { 0.0 })));
                }
                Path::Emitted { species } => {
                    let own: Octet = std::array::from_fn(|t| of(t) as f32);
                    let glow = lamps.glow.get_or_insert_with(|| vec![[0.0; WIDTH]; gas[species].len()]);
                    glow.iter_mut().zip(&gas[species]).for_each(|(glow, density)| (0..WIDTH).for_each(|t| glow[t] += own[t] * density));
                }
                Path::Background => lamps.around = std::array::from_fn(|t| of(t) as f32),
                Path::Direct { .. } | Path::FieldStar { .. } => {}
            }
        }
        if let Some(crowd) = crowd {
            let (gathered, marched): (Vec<_>, Vec<_>) = lamps.stars.into_iter().partition(|(star, _)| crowd.holds(*star));
            let sent: HashMap<usize, Octet> = gathered.into_iter().collect();
            lamps.crowd = crowd.stars.iter().map(|star| sent.get(star).copied().unwrap_or_default()).collect();
            lamps.stars = marched;
        }
        lamps
    }
}
