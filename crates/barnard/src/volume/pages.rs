//! Memory layout of the voxels of a volume: in one page, or in many, of which those that are empty take none.
//!
//! A page is a cuboid of cells, the spaces between voxel centres, with all voxels around them: the face between two
//! pages stands in both, so that the corners of a cell always lie in one page, as far apart as in any other. Places in
//! pages that are not held lead to one page of nothing, the first, which is never written.

use std::ops::Range;

use rayon::prelude::*;

/// Cells along the edge of a page, where there are many.
pub const PAGE: usize = 16;

/// The pages of a lattice of voxels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pages {
    /// Cells of a page along each axis.
    cells: [usize; 3],
    /// Pages along each axis.
    counts: [usize; 3],
    /// The number of each page in memory, x fastest; zero where it is not held, and where there is one page alone.
    slots: Vec<u32>,
    /// Origins of the resident pages \[voxels\], in the order of memory; without that of nothing.
    firsts: Vec<[usize; 3]>,
    /// Pages of nothing before those: one, or none where all voxels have one page.
    empty: usize,
}

impl Pages {
    /// One page for all of a lattice of a given number of voxels, at least two along each axis.
    pub fn whole(dims: [usize; 3]) -> Self {
        Self { cells: dims.map(|n| n - 1), counts: [1; 3], slots: vec![0], firsts: vec![[0; 3]], empty: 0 }
    }

    /// Resident pages of a lattice, given the voxels along each axis that a page has.
    pub fn stored(dims: [usize; 3], is_held: impl Fn([Range<usize>; 3]) -> bool + Sync) -> Self {
        let counts = dims.map(|n| (n - 1).div_ceil(PAGE));
        let first = |page: usize| [page % counts[0], page / counts[0] % counts[1], page / (counts[0] * counts[1])].map(|i| i * PAGE);
        let voxels = |page: usize| {
            let first = first(page);
            std::array::from_fn(|axis| first[axis]..(first[axis] + PAGE + 1).min(dims[axis]))
        };
        let is_stored: Vec<bool> = (0..counts.iter().product()).into_par_iter().map(|page| is_held(voxels(page))).collect();
        let firsts: Vec<[usize; 3]> = (0..is_stored.len()).filter(|page| is_stored[*page]).map(first).collect();
        let number = |is_stored: &bool, last: &mut u32| {
            *last += u32::from(*is_stored);
            if *is_stored { *last } else { 0 }
        };
        let slots = is_stored.iter().scan(0, |last, is_stored| Some(number(is_stored, last))).collect();
        Self { cells: [PAGE; 3], counts, slots, firsts, empty: 1 }
    }

    /// True if there is one page for all.
    #[inline(always)]
    pub fn is_whole(&self) -> bool {
        self.empty == 0
    }

    /// The number of each page in memory, x fastest; zero for those that are not held.
    pub fn slots(&self) -> &[u32] {
        &self.slots
    }

    /// Pages in memory, that of nothing among them.
    pub fn count(&self) -> usize {
        self.empty + self.firsts.len()
    }

    /// Voxels of a page along each axis.
    #[inline(always)]
    pub fn side(&self) -> [usize; 3] {
        self.cells.map(|n| n + 1)
    }

    /// From voxel to voxel along each axis.
    #[inline(always)]
    pub fn strides(&self) -> [usize; 3] {
        let [nx, ny, _] = self.side();
        [1, nx, nx * ny]
    }

    /// Voxels of a page.
    #[inline(always)]
    fn size(&self) -> usize {
        self.side().iter().product()
    }

    /// The voxels that memory is taken for: more than once for those on faces.
    pub fn voxels(&self) -> usize {
        self.size() * self.count()
    }

    /// True if the page of a cell is held.
    pub fn holds(&self, cell: [usize; 3]) -> bool {
        self.is_whole() || self.number(cell) >= self.size()
    }

    /// The number of a voxel in memory, which is also that of the cell behind it, but for the last along an axis.
    #[inline]
    pub fn number(&self, voxel: [usize; 3]) -> usize {
        let page: [usize; 3] = std::array::from_fn(|axis| (voxel[axis] / self.cells[axis]).min(self.counts[axis] - 1));
        let slot = self.slots[(page[2] * self.counts[1] + page[1]) * self.counts[0] + page[0]];
        self.in_page(slot as usize, std::array::from_fn(|axis| voxel[axis] - page[axis] * self.cells[axis]))
    }

    #[inline(always)]
    fn in_page(&self, slot: usize, [x, y, z]: [usize; 3]) -> usize {
        let [_, dy, dz] = self.strides();
        slot * self.size() + z * dz + y * dy + x
    }

    /// The numbers of the first voxels of some cells, axis × lane.
    #[inline(always)]
    pub fn first_voxels<const LANES: usize>(&self, [x, y, z]: [&[u32; LANES]; 3]) -> [usize; LANES] {
        const { assert!(PAGE.is_power_of_two()) };
        let [_, dy, dz] = self.strides();
        let mut numbers = [0; LANES];
        if self.is_whole() {
            for lane in 0..LANES {
                numbers[lane] = z[lane] as usize * dz + y[lane] as usize * dy + x[lane] as usize;
            }
            return numbers;
        }
        let (shift, within, size) = (PAGE.trailing_zeros(), PAGE as u32 - 1, self.size());
        let [counts_x, counts_y, _] = self.counts.map(|n| n as u32);
        for lane in 0..LANES {
            let page = ((z[lane] >> shift) * counts_y + (y[lane] >> shift)) * counts_x + (x[lane] >> shift);
            let local = (z[lane] & within) as usize * dz + (y[lane] & within) as usize * dy + (x[lane] & within) as usize;
            numbers[lane] = self.slots[page as usize] as usize * size + local;
        }
        numbers
    }

    /// The pages along an axis that hold a voxel of this place: two on the face between them.
    fn touching(&self, axis: usize, voxel: usize) -> Range<usize> {
        voxel.saturating_sub(self.cells[axis]).div_ceil(self.cells[axis])..(voxel / self.cells[axis] + 1).min(self.counts[axis])
    }

    /// The pages that are held and have voxels of a line along `axis`, at these places along the others: where each
    /// begins, and the number of the line's first voxel in it.
    pub fn along(&self, axis: usize, voxel: [usize; 3]) -> impl Iterator<Item = (usize, usize)> + '_ {
        let range = move |a: usize| if a == axis { 0..self.counts[a] } else { self.touching(a, voxel[a]) };
        let pages = range(2).flat_map(move |z| range(1).flat_map(move |y| range(0).map(move |x| [x, y, z])));
        pages.filter_map(move |page| {
            let slot = self.slots[(page[2] * self.counts[1] + page[1]) * self.counts[0] + page[0]] as usize;
            let first: [usize; 3] = std::array::from_fn(|a| page[a] * self.cells[a]);
            let local = std::array::from_fn(|a| if a == axis { 0 } else { voxel[a] - first[a] });
            (slot >= self.empty).then(|| (first[axis], self.in_page(slot, local)))
        })
    }

    /// The pages that are held, each with where it begins, of values, several per voxel.
    pub fn of<'a, T: Send>(
        &'a self,
        values: &'a mut [T],
        channels: usize,
    ) -> impl IndexedParallelIterator<Item = ([usize; 3], &'a mut [T])> {
        let size = self.size() * channels;
        self.firsts.par_iter().copied().zip(values[self.empty * size..].par_chunks_exact_mut(size))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LANES: usize = 16;

    /// Every voxel of a page that is held has a number of its own, two on a face have one in each page, and others are
    /// nothing's.
    #[test]
    fn voxels_are_numbered() {
        let dims = [36, 17, 2];
        let pages = Pages::stored(dims, |voxels| voxels[0].contains(&33));
        assert_eq!((pages.counts, pages.firsts.clone()), ([3, 1, 1], vec![[32, 0, 0]]));
        assert_eq!(pages.voxels(), 2 * 17usize.pow(3));
        assert_eq!([[0, 0, 0], [31, 16, 1]].map(|v| pages.number(v) < 17usize.pow(3)), [true; 2]);
        assert_eq!(pages.number([33, 2, 1]), 17usize.pow(3) + 289 + 34 + 1);
        // The face between the second page and the third belongs to the third; the second is not held.
        let on_face: Vec<_> = pages.along(0, [0, 16, 1]).collect();
        assert_eq!(on_face, [(32, 17usize.pow(3) + 289 + 16 * 17)]);
        let whole = Pages::whole(dims);
        assert!(whole.is_whole() && whole.voxels() == 36 * 17 * 2 && whole.number([35, 16, 1]) == whole.voxels() - 1);
        assert_eq!(whole.along(1, [7, 0, 1]).collect::<Vec<_>>(), [(0, 36 * 17 + 7)]);
    }

    /// One page that is held in a lattice of one page is not the whole: nothing has a page of its own.
    #[test]
    fn a_page_of_nothing_is_no_page_for_all() {
        for is_stored in [false, true] {
            let pages = Pages::stored([9, 9, 9], |_| is_stored);
            assert!(!pages.is_whole() && pages.voxels() == (1 + usize::from(is_stored)) * 17usize.pow(3));
        }
    }

    /// The first voxels of the cells of many lanes are those that one asks for by one.
    #[test]
    fn cells_are_found_for_all_lanes() {
        let dims = [40, 35, 50];
        for pages in [Pages::whole(dims), Pages::stored(dims, |v| ((v[0].start + v[1].start + v[2].start) / PAGE).is_multiple_of(2))] {
            let cells: [[u32; LANES]; 3] =
                std::array::from_fn(|axis| std::array::from_fn(|lane| ((lane * (7 + axis) + axis) % (dims[axis] - 1)) as u32));
            let [x, y, z] = &cells;
            let numbers = pages.first_voxels([x, y, z]);
            (0..LANES).for_each(|lane| assert_eq!(numbers[lane], pages.number([x, y, z].map(|c| c[lane] as usize))));
        }
    }
}
