//! Coordinates of e^(−a k) in a basis: read once for all bands that share it.

use spectra::rule::{Form, Projection};
use wide::f32x4;

use super::{Bases, DepthSpan};
use crate::packet::{LANES, Lane, RowPlace, lanes, largest, place};
use crate::plan::Plan;

/// The bases of all bands.
#[derive(Debug)]
pub struct ProjectionTerms {
    groups: Vec<BasisGroup>,
}

/// The bands that share one basis.
#[derive(Debug)]
struct BasisGroup {
    /// The first term of each band.
    first: Vec<usize>,
    table: CoordinateTable,
}

/// q_i(a) and q_i″(a)/6 with their growth to the next entry, so that few elements are read as short vectors.
#[derive(Debug)]
pub struct CoordinateTable {
    /// The number of elements of the basis.
    size: usize,
    /// Entries per unit of depth.
    per_depth: f32,
    /// Number of gaps between entries.
    gaps: usize,
    /// Four elements each, the last ones filled up with zeros: gap × quad of elements.
    quads: Vec<CoordinateQuad>,
    /// ∫ q da from where each gap begins on, in double precision: thick segments are differences of it.
    left: Vec<[f64; 4]>,
    /// Half difference of depth up to which a segment is its middle and a curvature.
    short: f32,
}

/// Four elements over one gap of the table: one line of the cache.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
struct CoordinateQuad {
    value: f32x4,
    growth: f32x4,
    /// A sixth of q″ at the entry.
    curvature: f32x4,
    curvature_growth: f32x4,
}

impl ProjectionTerms {
    pub(super) fn new(plan: &Plan) -> Self {
        let mut groups: Vec<(&[f64], BasisGroup)> = Vec::new();
        let mut first = 0;
        for band in &plan.spectral.bands {
            let Form::Projection(projection) = &band.rule.form else { continue };
            let exponents = &projection.basis.exponents[..];
            match groups.iter_mut().find(|(e, _)| *e == exponents) {
                Some((_, group)) => group.first.push(first),
                None => groups.push((exponents, BasisGroup { first: vec![first], table: CoordinateTable::new(projection) })),
            }
            first += projection.basis.size();
        }
        Self { groups: groups.into_iter().map(|(_, group)| group).collect() }
    }

    #[inline(always)]
    pub(super) fn accumulate(&self, span: &DepthSpan, bases: Bases, sum: &mut [Lane]) {
        for group in &self.groups {
            if group.table.size <= 4 {
                group.accumulate::<4>(span, bases, sum);
            } else {
                group.accumulate::<8>(span, bases, sum);
            }
        }
    }

    pub(super) fn at(&self, term: usize, depth: f32) -> f32 {
        let inside = |group: &&BasisGroup| group.first.iter().any(|first| (*first..first + group.table.size).contains(&term));
        let Some(group) = self.groups.iter().find(inside) else { return 0.0 };
        let element = group.first.iter().filter(|first| **first <= term).map(|first| term - first).min().unwrap_or(0);
        let RowPlace { cell, fraction } = place(depth * group.table.per_depth, group.table.gaps);
        group.table.quad(cell, element / 4).mean(fraction, 0.0).to_array()[element % 4]
    }
}

impl BasisGroup {
    #[inline(always)]
    fn accumulate<const ROW: usize>(&self, span: &DepthSpan, bases: Bases, sum: &mut [Lane]) {
        let means = self.table.means::<ROW>(span);
        for element in 0..self.table.size {
            let mean = &means[element];
            for first in &self.first {
                let Some(base) = bases.of(first + element) else { continue };
                let sum = &mut sum[first + element];
                for lane in 0..LANES {
                    sum[lane] += base[lane] * mean[lane];
                }
            }
        }
    }
}

impl CoordinateTable {
    /// Converts the coordinate tables of `projection` to single precision.
    pub fn new(projection: &Projection) -> Self {
        let (size, gaps) = (projection.basis.size(), projection.coordinates.len() - 1);
        let curvature = |i: usize| projection.basis.moments(projection.step * i as f64, 2).into_iter().map(|c| c / 6.0).collect();
        let curvatures: Vec<Vec<f64>> = (0..=gaps).map(curvature).collect();
        let each = || (0..gaps).flat_map(|gap| (0..size.div_ceil(4)).map(move |quad| (gap, 4 * quad)));
        let quads = each().map(|(gap, first)| CoordinateQuad::new(&projection.coordinates[gap..], &curvatures[gap..], first)).collect();
        let left =
            each().map(|(gap, first)| std::array::from_fn(|i| projection.left[gap].get(first + i).copied().unwrap_or(0.0))).collect();
        Self { size, per_depth: (1.0 / projection.step) as f32, gaps, quads, left, short: projection.short as f32 }
    }

    /// The mean coordinates over the lanes' spans, element × lane; beyond the table its last entry is held.
    ///
    /// `ROW` is the number of elements, rounded up to four or eight.
    #[inline(always)]
    pub fn means<const ROW: usize>(&self, DepthSpan { middle, half }: &DepthSpan) -> [Lane; ROW] {
        let half = lanes!(|lane| half[lane].abs());
        if largest(&half) > self.short {
            return self.thick(middle, &half);
        }
        let mut means = [[0.0; LANES]; ROW];
        let places: [RowPlace; LANES] = std::array::from_fn(|lane| place(middle[lane] * self.per_depth, self.gaps));
        for q in 0..ROW / 4 {
            for lane in (0..LANES).step_by(4) {
                let mean = |i: usize| self.quad(places[lane + i].cell, q).mean(places[lane + i].fraction, half[lane + i] * half[lane + i]);
                // Four lanes change places with four elements.
                let turned = f32x4::transpose(std::array::from_fn(mean));
                for (mean, values) in means[4 * q..4 * q + 4].iter_mut().zip(turned) {
                    mean[lane..lane + 4].copy_from_slice(&values.to_array());
                }
            }
        }
        means
    }

    /// The mean where a segment is thick: what is left behind its front without what is left behind its back.
    #[inline(never)]
    fn thick<const ROW: usize>(&self, middle: &Lane, half: &Lane) -> [Lane; ROW] {
        let mut means = [[0.0; LANES]; ROW];
        for lane in 0..LANES {
            let (low, high) = ((middle[lane] - half[lane]) * self.per_depth, (middle[lane] + half[lane]) * self.per_depth);
            let (first, last) = (place(low, self.gaps), place(high, self.gaps));
            let span = high.max(self.gaps as f32) - low.max(self.gaps as f32);
            for q in 0..self.size.div_ceil(4) {
                let mean = self.between(q, first, last, span);
                for (mean, value) in means[4 * q..4 * q + 4].iter_mut().zip(mean.to_array()) {
                    mean[lane] = value;
                }
            }
        }
        means
    }

    /// The mean of a quad between two places of the table, and over the gaps beyond the second, whose value is constant.
    fn between(&self, q: usize, first: RowPlace, last: RowPlace, span: f32) -> f32x4 {
        let (from, to) = (first.fraction, last.fraction);
        let (front, back) = (self.quad(first.cell, q), self.quad(last.cell, q));
        let (in_front, behind) = (front.mean(from, 0.0), back.mean(to, 0.0));
        let (within, gaps) = if first.cell < last.cell {
            let left = |gap: u32| &self.left[gap as usize * self.size.div_ceil(4) + q];
            let whole = f32x4::new(std::array::from_fn(|i| (left(first.cell + 1)[i] - left(last.cell)[i]) as f32));
            let (before, after) = (0.5 * (1.0 - from), 0.5 * to);
            let ends = before * (in_front + front.value + front.growth) + after * (back.value + behind);
            (ends + whole * self.per_depth, (1.0 - from) + (last.cell - first.cell - 1) as f32 + to)
        } else if span > 0.0 {
            (0.5 * (to - from) * (in_front + behind), to - from)
        } else {
            return 0.5 * (in_front + behind);
        };
        (within + span * behind) * (1.0 / (gaps + span))
    }

    #[inline(always)]
    fn quad(&self, gap: u32, quad: usize) -> &CoordinateQuad {
        &self.quads[gap as usize * self.size.div_ceil(4) + quad]
    }
}

impl CoordinateQuad {
    /// Four elements from the `first` on in the gap between two depths; elements beyond the basis are none.
    fn new(values: &[Vec<f64>], curvatures: &[Vec<f64>], first: usize) -> Self {
        let value = |at: &[f64], i: usize| at.get(first + i).copied().unwrap_or(0.0);
        let growth = |columns: &[Vec<f64>], i: usize| value(&columns[1], i) - value(&columns[0], i);
        let four = |value: &dyn Fn(usize) -> f64| f32x4::new(std::array::from_fn(|i| value(i) as f32));
        Self {
            value: four(&|i| value(&values[0], i)),
            growth: four(&|i| growth(values, i)),
            curvature: four(&|i| value(&curvatures[0], i)),
            curvature_growth: four(&|i| growth(curvatures, i)),
        }
    }

    /// The mean over a thin segment, q + half² q″/6.
    #[inline(always)]
    fn mean(&self, fraction: f32, half_squared: f32) -> f32x4 {
        let fraction = f32x4::splat(fraction);
        let curvature = self.curvature_growth.mul_add(fraction, self.curvature);
        curvature.mul_add(f32x4::splat(half_squared), self.growth.mul_add(fraction, self.value))
    }
}

#[cfg(test)]
mod tests {
    use spectra::basis::{Basis, Criterion, Domain};
    use spectra::quadrature::gauss_legendre;

    use super::*;
    use crate::fixtures::{ball, dust, on_axis, scene, star};
    use crate::plan::{Planner, Quality};

    /// ⟨q⟩ of the plan's own basis by quadrature, for one quad of elements and for two, short spans, long ones, and
    /// such as leave the table.
    #[test]
    fn means_are_those_of_the_basis() {
        let rule = gauss_legendre(64);
        for size in [3, 6] {
            let camera = on_axis(4.0, 30.0, (4, 4));
            let mut spec =
                scene(camera, 8).with_dust(dust(ball(1.0), "inverse_wavelength", 4.0)).with_star(star(9000.0, 1.0, glam::DVec3::ZERO));
            spec.method = spec.method.with_name("projection").unwrap();
            spec.method.settings.count = Some(size);
            let scene = spec.build().unwrap();
            let plan = Planner::new(&crate::plan::Options::default())
                .with_quality(Quality::Fixed(10))
                .plan(&scene, None, &crate::control::Control::default())
                .unwrap();
            let Form::Projection(projection) = &plan.spectral.bands[0].rule.form else { panic!("another form") };
            let table = CoordinateTable::new(projection);
            let end = projection.basis.range;
            for reach in [0.0, 0.1, 0.15, 1.0, 2.5] {
                let span =
                    DepthSpan { middle: lanes!(|lane| end as f32 * lane as f32 / 12.0), half: lanes!(|lane| reach * (lane % 3) as f32) };
                let means = if size <= 4 { table.means::<4>(&span).to_vec() } else { table.means::<8>(&span).to_vec() };
                for lane in 0..LANES {
                    let at =
                        |x: f64| projection.basis.coordinates(f64::from(span.middle[lane] + x as f32 * span.half[lane]).clamp(0.0, end));
                    // No depth is less than none.
                    for element in (0..size).filter(|_| span.middle[lane] >= span.half[lane]) {
                        let truth: f64 = rule.iter().map(|(x, w)| 0.5 * w * at(*x)[element]).sum();
                        let error = (f64::from(means[element][lane]) - truth).abs();
                        assert!(error < 2e-4 * truth.abs().max(0.1), "{size} {reach} {lane} {element}: {} {truth}", means[element][lane]);
                    }
                }
            }
            // Another basis has other coordinates.
            let domain = Domain::new((0.4, 0.7), |l| 0.55 / l, |_| 1.0).unwrap();
            let other = Basis::optimal(&domain, end, size, Criterion::Mean).unwrap().coordinates(1.0);
            assert!((other[0] - projection.basis.coordinates(1.0)[0]).abs() > 1e-3);
        }
    }
}
