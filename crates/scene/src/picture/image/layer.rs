//! Layers: images that stand behind a picture and say what it is made of.

use super::Samples;

/// Content of a layer. All of it is sums over rays, so that a mean of layers is the layer of a mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LayerContent {
    /// A part of the picture's light, bands × height × width [W m⁻² sr⁻¹]: the sum of all such layers is the picture.
    Light,
    /// Mean distance of the light of dust and gas, 2 × height × width: the light of all bands times its distance
    /// [pc W m⁻² sr⁻¹], and the light [W m⁻² sr⁻¹].
    Depth,
    /// Transmission of dust, 2 × height × width: its optical depth at V, and the part of light at V that it takes \[1\].
    OpticalDepth,
    /// Quality flags of an instrument's picture, bands × height × width: sums of [`Flag`](crate::instrument::Flag)s.
    Mask,
}

/// One layer of a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// The name, such as `emission.Ha`.
    pub name: String,
    /// Content.
    pub content: LayerContent,
    /// The values.
    pub samples: Samples,
}

/// The distance of a pixel without light of dust or gas \[pc\]: far behind everything.
pub const FAR_AWAY: f64 = 1e10;

impl Layer {
    /// The values of a channel that a file holds, row by row: band `number` of light; of a depth the mean distance \[pc\],
    /// [`FAR_AWAY`] where there is no light; of an optical depth that, and the opacity behind it \[1\].
    pub fn channel(&self, number: usize, pixels: usize) -> impl Iterator<Item = f64> + '_ {
        (0..pixels).map(move |i| match self.content {
            LayerContent::Light | LayerContent::OpticalDepth | LayerContent::Mask => self.samples.at(number * pixels + i),
            LayerContent::Depth => {
                let (moment, light) = (self.samples.at(i), self.samples.at(pixels + i));
                if light > 0.0 { moment / light } else { FAR_AWAY }
            }
        })
    }
}
