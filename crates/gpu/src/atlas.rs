//! Positions of the pages of a volume in a texture.

use barnard::volume::{Pages, Volume};

/// Pages of a volume along each axis of its atlas: as near to a cube as they come; one where all voxels have one page.
pub fn atlas(pages: &Pages) -> [usize; 3] {
    let count = pages.count();
    let x = (count as f64).cbrt().ceil() as usize;
    let y = (count.div_ceil(x) as f64).sqrt().ceil() as usize;
    [x, y, count.div_ceil(x * y)]
}

/// Texels along each axis of a volume's texture.
pub fn size(volume: &Volume) -> [usize; 3] {
    let (atlas, side) = (atlas(volume.pages()), volume.pages().side());
    std::array::from_fn(|axis| atlas[axis] * side[axis])
}
