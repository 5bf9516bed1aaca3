//! A voxel whose gas is known, and light that goes through it.
//!
//! Where light has become brighter or fainter since the gas was solved, gas is less or more opaque, so that it absorbs as many
//! photons; dust stays as it is.
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | Γ | ionisations of H⁰ by the light that comes in | s⁻¹ |
//! | κ | opacity | cm⁻¹ |

use crate::light::{DETOUR, IonisingLight, OWN_NODES};
use crate::nodes::{Nodes, PLACES};

/// By how much gas may be more or less opaque at once than it was.
pub const CHANGE: f32 = 16.0;
/// Fraction that counts as all of the light \[1\].
pub const ALL: f32 = 1.0 - 1e-6;
/// Negligible light, relative to the star's: denormal numbers would be slow.
pub const NONE: f32 = 1e-30;

/// Upper bound of diffuse light on a faint ray: more has no room in single precision.
pub const MOST_MADE: f64 = 1e30;

/// Gas that beams go through.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Voxel {
    /// The opacity by node, and what dust has of it \[cm⁻¹\].
    pub opacity: [f32; PLACES],
    /// \[cm⁻¹\]
    pub dust: f32,
    /// Photons that it makes \[cm⁻³ s⁻¹\].
    pub emitted: [f32; OWN_NODES],
    /// Γ \[s⁻¹\]; none where there was no light.
    pub rate: f32,
    /// The part of the light that it absorbs, and the depth that does so \[1\].
    pub absorbed: f32,
    /// \[1\]
    pub depth: f32,
    /// The part of its hydrogen that is ionised \[1\].
    pub ionised: f32,
}

/// The depth that absorbs a part of the light.
pub fn absorbing(part: f32) -> f32 {
    -(-part).ln_1p()
}

impl Voxel {
    /// Gas to which no light has come, of an opacity \[cm⁻¹\].
    pub(crate) fn dark(opacity: Nodes) -> Self {
        Self { opacity: opacity.0, dust: 0.0, emitted: [0.0; OWN_NODES], rate: 0.0, absorbed: 1.0, depth: 0.0, ionised: 0.0 }
    }

    /// True if light had come to it.
    pub(crate) fn is_lit(&self) -> bool {
        self.rate > 0.0
    }

    /// Relative opacity for light of a relative brightness, and relative number of absorbed photons, and so
    /// gives back: recombinations are as many as they were, but for what is still neutral.
    fn answer(&self, brighter: f32) -> (f32, f32) {
        let fills = if brighter > 1.0 { (brighter * self.ionised).max(1.0) } else { brighter };
        let absorbed = (self.absorbed / fills).min(ALL);
        ((absorbing(absorbed) / self.depth).clamp(1.0 / CHANGE, CHANGE), brighter * absorbed / self.absorbed)
    }
}

/// Effect of a star's light at each node.
pub(crate) struct ByStar {
    /// The cross section of hydrogen \[cm²\].
    pub sigma: Nodes,
    /// One where its photons ionise hydrogen, zero elsewhere.
    pub ionises: Nodes,
    /// One where the gas's own light is, zero elsewhere.
    is_own: Nodes,
}

impl ByStar {
    /// That of a star's light.
    pub fn new(light: &IonisingLight) -> Self {
        let is_own = Nodes::each(|place| if place < OWN_NODES { 1.0 } else { 0.0 });
        Self { sigma: Nodes::of(&light.weakening[0], 1.0), ionises: Nodes::of(&light.ionises(), 1.0), is_own }
    }
}

/// A ray in a voxel.
pub(crate) struct Crossing {
    /// Start and length \[cm\].
    pub inner: f64,
    /// \[cm\]
    pub thickness: f64,
    /// The flux that all photons of the star would be there \[s⁻¹ cm⁻²\].
    pub undimmed: f64,
    /// Γ by the light of all other stars \[s⁻¹\].
    pub others: f32,
}

/// Has photons by node, in parts of the star's within the ray's solid angle, go through a voxel; gives which part is left that
/// ionises.
#[inline(always)]
pub(crate) fn cross(photons: &mut Nodes, voxel: &Voxel, crossing: &Crossing, light: &ByStar) -> f32 {
    let Crossing { inner, thickness, undimmed, others } = *crossing;
    let rate = (f64::from((*photons * light.sigma).sum()) * undimmed) as f32;
    let all = others + rate;
    let (response, made) = if voxel.rate > 0.0 && all > 0.0 { voxel.answer(all / voxel.rate) } else { (1.0, 0.0) };
    // The ray has of the gas's own light what it has of what ionises it.
    let made = if made > 0.0 { (f64::from(made * rate / all) * thickness / undimmed).min(MOST_MADE) as f32 } else { 0.0 };
    let (way, detour) = (thickness as f32, (DETOUR * (inner + 0.5 * thickness)) as f32);
    let depth = Nodes::each(|place| {
        let gas = voxel.opacity[place] - voxel.dust;
        let opacity = voxel.dust + if gas > 0.0 { gas * response } else { 0.0 };
        // How much longer the ways of the gas's own light are than the way outward.
        opacity * (1.0 + opacity * light.is_own.0[place] * detour) * way
    });
    let decay = depth.decay();
    let mean = depth.mean_decay(decay);
    let rates = Nodes::each(|place| if place < OWN_NODES { voxel.emitted[place % OWN_NODES] } else { 0.0 });
    let leaving = *photons * decay + rates * mean * made;
    *photons = Nodes::each(|place| if leaving.0[place] > NONE { leaving.0[place] } else { 0.0 });
    (*photons * light.ionises).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Thin gas is as many times less opaque as its light is brighter; where a front stands, the voxel takes all light until it
    /// is ionised as a whole.
    #[test]
    fn opacity_answers_to_light() {
        let voxel = |absorbed: f32, ionised| Voxel { absorbed, depth: absorbing(absorbed), ionised, ..Voxel::dark(Nodes::each(|_| 0.0)) };
        for (absorbed, ionised) in [(1e-3, 1.0), (0.5, 1.0), (ALL, 0.4)] {
            let (opacity, made) = voxel(absorbed, ionised).answer(1.0);
            assert!((opacity - 1.0).abs() < 1e-6 && (made - 1.0).abs() < 1e-6);
        }
        let thin = voxel(1e-3, 1.0);
        let [(twice, as_many), (half, hardly_fewer)] = [2.0, 0.5].map(|brighter| thin.answer(brighter));
        assert!((twice - 0.5).abs() < 1e-3 && (half - 2.0).abs() < 2e-3);
        assert!((as_many - 1.0).abs() < 1e-6 && (hardly_fewer - 1.0).abs() < 1e-6);
        // As many photons are absorbed as before: half of twice as many is a quarter of all.
        let part = voxel(0.5, 1.0).answer(2.0).0 * 2f32.ln();
        assert!((1.0 - (-part).exp() - 0.25).abs() < 1e-6);
        // A front takes what comes until its voxel is full, and makes as much more.
        let front = voxel(ALL, 0.4);
        assert!(front.answer(2.4).0 > 0.999 && (front.answer(2.4).1 - 2.4).abs() < 1e-5 && (front.answer(0.3).1 - 0.3).abs() < 1e-5);
        assert!(front.answer(5.0).0 < 0.1 && (front.answer(5.0).1 - 2.5).abs() < 1e-5);
    }
}
