//! A spatial plan that follows its scene: what still holds is kept, what does not is made anew.

use std::sync::Arc;

use glam::DVec3;

use super::bake::{BakeResolution, baked};
use super::{SpatialPlan, cloud, occupied, sigma_v_per_pc};
use crate::control::Control;
use crate::error::{Error, Result};
use crate::field::{Field, Grid};
use crate::plan::{Options, many_lights, star_depths};
use crate::scene::Scene;
use crate::volume::{Bricks, Channel, Volume};

impl SpatialPlan {
    /// The space of a scene that has the same densities as this one's; none where it has others. Stars that moved are
    /// swept anew, and all of them where dust has become more or less; the space itself where nothing of it changed.
    /// What pilots measured is forgotten where something did.
    pub(crate) fn updated(self: &Arc<Self>, scene: &Scene, options: &Options, control: &Control) -> Result<Option<Arc<Self>>> {
        let same = |(a, b): (&Arc<dyn Field>, &Arc<dyn Field>)| std::ptr::addr_eq(Arc::as_ptr(a), Arc::as_ptr(b));
        let known = scene.densities().count() == self.densities.len() && scene.densities().zip(&self.densities).all(same);
        if !known
            || scene.dust.is_some() != self.dust.is_some()
            || (self.resolution.fixed, self.precision, self.sparsity) != (scene.method.bake, scene.method.volumes, scene.method.sparse)
        {
            return Ok(None);
        }
        let stars: Vec<DVec3> = scene.stars.iter().map(|s| s.position).collect();
        let members = many_lights::members(scene);
        // The gathered stars are those that it has now.
        let gathered = many_lights::mask(&members, stars.len());
        let parted =
            self.marched.len() + members.len() == stars.len() && self.marched.iter().all(|star| gathered.get(*star) == Some(&false));
        if parted && stars.len() == self.stars.len() && sigma_v_per_pc(scene) == self.sigma_v_per_pc {
            let moved: Vec<usize> = (0..stars.len()).filter(|s| stars[*s] != self.stars[*s]).collect();
            if moved.is_empty() {
                let led = self.many_lights.as_ref().and_then(|many_lights| many_lights.led_by(&members));
                return Ok(Some(match led {
                    Some(many_lights) => Arc::new(Self { many_lights: Some(Arc::new(many_lights)), ..(**self).clone() }),
                    None => self.clone(),
                }));
            }
            let mut space = Self { spatial: None, ..(**self).clone() };
            if self.dust.is_none() {
                // Without dust there are no depths.
                return Ok(Some(Arc::new(Self { stars, ..space })));
            }
            let (gathered, marched): (Vec<usize>, Vec<usize>) = moved.into_iter().partition(|star| gathered[*star]);
            for star in marched {
                space.move_star(star, stars[star], control)?;
            }
            if !gathered.is_empty() {
                space.stars = stars;
                space.part_stars(&members, options, control)?;
                space.star_depth = space.deepest();
            }
            return Ok(Some(Arc::new(space)));
        }
        let (moved, ratio) = (!parted || stars != self.stars, sigma_v_per_pc(scene) / self.sigma_v_per_pc);
        let mut space = Self { stars, spatial: None, ..(**self).clone() };
        space.take_dust(scene, options, control)?;
        if moved || !space.scale_depths(ratio) {
            space.part_stars(&members, options, control)?;
            space.refine_stars(self.star_factor, scene, options, control)?;
        }
        Ok(Some(Arc::new(space)))
    }

    /// The space of a scene that has the same densities and as much dust, as it is before pilots choose how finely;
    /// none otherwise.
    pub(crate) fn rebuilt(self: &Arc<Self>, scene: &Scene, options: &Options, control: &Control) -> Result<Option<Self>> {
        if !self.has_as_much_dust_as(scene) || self.resolution != BakeResolution::of(&scene.method) {
            return Ok(None);
        }
        let Some(followed) = self.updated(scene, options, control)? else { return Ok(None) };
        let mut changed = Self { spatial: None, ..Arc::unwrap_or_clone(followed) };
        if changed.star_factor != 1 {
            changed.refine_stars(1, scene, options, control)?;
        }
        Ok(Some(changed))
    }

    /// True if a density of one is as much dust as in `scene`.
    pub(crate) fn has_as_much_dust_as(&self, scene: &Scene) -> bool {
        sigma_v_per_pc(scene) == self.sigma_v_per_pc
    }

    /// Multiplies all star depths and puts the dust of now into its volume; false, and nothing done, where depths were
    /// or would be cut.
    pub(super) fn scale_depths(&mut self, ratio: f64) -> bool {
        let depths = |v: &Volume| (0..v.channels.len()).filter(|c| matches!(v.channels[*c], Channel::StarDepth(_))).collect::<Vec<_>>();
        let largest = |v: &Volume| depths(v).into_iter().map(|slot| v.largest(slot)).fold(0.0, f32::max);
        let deepest = f64::from(self.volumes.iter().map(|v| largest(v)).fold(0.0, f32::max));
        let Some(dust) =
            self.dust.clone().filter(|_| ratio.is_finite() && ratio > 0.0 && deepest * ratio.max(1.0) < 0.99 * star_depths::OPAQUE)
        else {
            return false;
        };
        if let Some(many_lights) = &self.many_lights {
            let Some(scaled) = many_lights.scaled(ratio, &dust) else { return false };
            self.many_lights = Some(Arc::new(scaled));
        }
        for volume in self.volumes.iter_mut().map(Arc::make_mut) {
            depths(volume).into_iter().for_each(|slot| volume.scale(slot, ratio as f32));
            if let Some(slot) = volume.channels.iter().position(|c| *c == Channel::Dust) {
                volume.fill(slot, &dust);
            }
        }
        self.star_depth *= ratio;
        true
    }

    /// Samples the dust of `scene` in place of this one's.
    pub(super) fn take_dust(&mut self, scene: &Scene, options: &Options, control: &Control) -> Result<()> {
        let Some(dust) = scene.dust.as_ref().filter(|d| d.sigma_v_per_pc != self.sigma_v_per_pc) else { return Ok(()) };
        let before = self.dust.as_deref().filter(|_| self.sigma_v_per_pc > 0.0);
        let grid = match before {
            Some(grid) => grid.scaled(dust.sigma_v_per_pc / self.sigma_v_per_pc),
            None => baked(&dust.density, dust.sigma_v_per_pc, "dust", options, self.resolution, control)?,
        };
        grid.check("dust")?;
        self.bricks[0] = Bricks::new(&grid);
        self.dust = Some(Arc::new(grid));
        self.cloud = cloud(scene);
        self.sigma_v_per_pc = dust.sigma_v_per_pc;
        self.occupied = occupied(self.dust.as_deref().into_iter().chain(&self.emission), &self.bricks);
        Ok(())
    }

    /// Copy of the space with functions sampled to at least `edge` voxels along their longest edge; none where that would
    /// take more memory than is allowed.
    pub(crate) fn resampled(&self, scene: &Scene, edge: usize, options: &Options, control: &Control) -> Result<Option<Self>> {
        match Self::sampled(scene, options, BakeResolution { least: edge, ..self.resolution }, control) {
            // Which samples another plan of the same scene begins with does not hang on what this one needed.
            Ok(space) => Ok(Some(Self { resolution: self.resolution, ..space })),
            Err(Error::Memory { .. }) => Ok(None),
            Err(other) => Err(other),
        }
    }

    /// Puts a star elsewhere \[pc\] and sweeps its depths alone anew.
    ///
    /// # Errors
    /// If there is no such star, its depths are not kept, or the place is none.
    pub fn move_star(&mut self, star: usize, place: DVec3, control: &Control) -> Result<()> {
        if !place.is_finite() {
            return Err(Error::Star(format!("the star position {place} pc must be finite")));
        }
        let slot_in = |v: &Volume| v.channels.iter().position(|c| *c == Channel::StarDepth(star));
        let Some((i, slot)) = self.volumes.iter().enumerate().find_map(|(i, v)| slot_in(v).map(|slot| (i, slot))) else {
            let count = self.stars.len();
            return Err(Error::Star(format!("star number {star} of {count} has no individual depths; make a new plan")));
        };
        let before = std::mem::replace(&mut self.stars[star], place);
        let mut volume = self.volumes.swap_remove(i);
        let done = self.fill(Arc::make_mut(&mut volume), slot, control);
        if done.is_err() {
            // Somebody stopped it half way: the star goes back, without being asked again.
            self.stars[star] = before;
            self.fill(Arc::make_mut(&mut volume), slot, &Control::default())?;
        }
        self.volumes.push(volume);
        let last = self.volumes.len() - 1;
        self.volumes.swap(i, last);
        self.star_depth = self.deepest();
        done
    }

    /// A space whose fields are this one's samples, for exact marches through them.
    pub fn of_samples(&self) -> Self {
        let shared = |grid: &Grid| Arc::new(grid.clone()) as Arc<dyn Field>;
        let densities = self.dust.iter().map(|dust| dust.clone() as Arc<dyn Field>).chain(self.emission.iter().map(shared)).collect();
        Self { densities, sigma_v_per_pc: 1.0, ..self.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Fbm;
    use crate::fixtures::{dust, on_axis, scene, star};
    use crate::plan::{Options, Plan, Planned, Planner, Quality};
    use crate::scene::SceneSpec;
    use crate::stored::Precision;

    const BEFORE: DVec3 = DVec3::new(-0.3, 0.4, 0.2);
    const THERE: DVec3 = DVec3::new(0.5, 0.1, -0.3);

    fn cloud() -> Arc<dyn Field> {
        Arc::new(Fbm::new(1))
    }

    /// A cloud and two stars, the second at `place`.
    fn pair(cloud: &Arc<dyn Field>, place: DVec3, scale: f64) -> Scene {
        let stars = [star(9000.0, 1.0, 0.1 * DVec3::X), star(4000.0, 1.0, place)];
        let camera = on_axis(4.0, 30.0, (4, 4));
        stars.into_iter().fold(scene(camera, 20).with_dust(dust(cloud.clone(), "ccm89", scale)), SceneSpec::with_star).build().unwrap()
    }

    fn plan(place: DVec3) -> Planned {
        let scene = pair(&cloud(), place, 4.0);
        Planner::new(&Options::default()).with_quality(Quality::Fixed(20)).plan(scene, None, &Control::default()).unwrap()
    }

    fn data(space: &SpatialPlan) -> Vec<Vec<f32>> {
        space.volumes.iter().map(|v| v.rows().flat_map(|row| row.into_owned()).collect()).collect()
    }

    /// A space follows a scene that is read again: the same where nothing moved, with the bits of a new one where a
    /// star did, within rounding where there is more dust; not at all where the densities are others.
    #[test]
    fn spaces_follow_their_scenes() {
        let (cloud, control) = (cloud(), Control::default());
        let first = pair(&cloud, BEFORE, 4.0);
        let space = Arc::new(SpatialPlan::new(&first, &Options::default(), &control).unwrap());
        let follow = |scene: Scene| {
            let followed = space.updated(&scene, &Options::default(), &control).unwrap();
            (followed, SpatialPlan::new(&scene, &Options::default(), &control).unwrap())
        };
        let colder = first.edited(|spec| spec.stars[0] = star(5000.0, 1.0, first.stars[0].position)).unwrap();
        assert!(Arc::ptr_eq(&follow(colder).0.unwrap(), &space));
        let (moved, new) = follow(pair(&cloud, THERE, 4.0));
        assert!(data(&moved.unwrap()) == data(&new) && data(&space) != data(&new));
        let (denser, new) = follow(pair(&cloud, BEFORE, 7.0));
        let denser = denser.unwrap();
        let worst = data(&denser)
            .iter()
            .flatten()
            .zip(data(&new).iter().flatten())
            .map(|(a, b)| (a - b).abs() / (1e-3 + b.abs()))
            .fold(0.0, f32::max);
        assert!(
            worst < 1e-4
                && (denser.star_depth / new.star_depth - 1.0).abs() < 1e-5
                && (new.star_depth / space.star_depth - 1.75).abs() < 1e-4,
            "{worst}"
        );
        let hidden = first.edited(|spec| spec.stars[0].visible = false).unwrap();
        let (fewer, new) = follow(hidden);
        assert!(data(&fewer.unwrap()) == data(&new));
        let larger: Arc<dyn Field> = Arc::new(Fbm { radius: 1.1, ..Fbm::new(1) });
        assert!(follow(pair(&larger, BEFORE, 4.0)).0.is_none());
        let finer = first.edited(|spec| spec.method.bake = Some(22)).unwrap();
        assert!(follow(finer).0.is_none());
        let halves = first.edited(|spec| spec.method.volumes = Precision::Half).unwrap();
        let (none, new) = follow(halves.clone());
        assert!(none.is_none() && new.volumes.iter().all(|volume| volume.precision() == Precision::Half));
        // Halves of more dust are those of less but for their units.
        let denser = halves.edited(|spec| spec.dust = pair(&cloud, BEFORE, 7.0).dust.clone()).unwrap();
        let denser = Arc::new(new.clone()).updated(&denser, &Options::default(), &control).unwrap().unwrap();
        let of_depths = |space: &SpatialPlan| space.volumes.iter().map(|v| v.largest(1)).collect::<Vec<_>>();
        assert!(of_depths(&denser).iter().zip(of_depths(&new)).all(|(more, less)| (more / less / 1.75 - 1.0).abs() < 1e-4));
    }

    /// A plan of another temperature shares the volumes of the plan before, which is still held.
    #[test]
    fn plans_of_other_spectra_share_volumes() {
        // An array: functions are sampled anew, as finely as a picture needs.
        let bounds = crate::geometry::Bounds { low: DVec3::splat(-1.0), high: DVec3::splat(1.0) };
        let array: Arc<dyn Field> = Arc::new(crate::field::Grid::new([8; 3], bounds, vec![1.0; 512]).unwrap());
        let first = pair(&array, BEFORE, 0.1).edited(|spec| spec.method.accuracy = 0.05).unwrap();
        let (options, control) = (Options::default(), Control::default());
        let before = Planner::new(&options).plan(&first, None, &control).unwrap();
        let colder = first.edited(|spec| spec.stars[0] = star(5000.0, 1.0, first.stars[0].position)).unwrap();
        let after = Planner::new(&options).plan(&colder, Some(&before), &control).unwrap();
        let shared = |(a, b): (&Arc<Volume>, &Arc<Volume>)| Arc::ptr_eq(a, b);
        assert_eq!((before.space.star_factor, after.space.star_factor), (1, 1));
        assert!(after.space.volumes.iter().zip(&before.space.volumes).all(shared));
        let denser = Planner::new(&options).plan(pair(&array, BEFORE, 0.2), Some(&before), &control).unwrap();
        assert!(!denser.space.volumes.iter().zip(&before.space.volumes).any(shared));
    }

    /// A moved star has the depths of a plan that was made with it there, bit by bit; who holds the space of before
    /// keeps it; a stopped move changes nothing.
    #[test]
    fn a_star_moves() {
        let data = |plan: &Plan| data(&plan.space);
        let (first, there) = (plan(BEFORE), plan(THERE));
        let mut moved = first.clone();
        moved.move_star(1, THERE, &Control::default()).unwrap();
        assert!(data(&moved) == data(&there) && moved.space.star_depth == there.space.star_depth);
        assert!(data(&first) != data(&there) && data(&first) == data(&plan(BEFORE)));
        let stop = Control::default();
        stop.interrupt();
        let mut stopped = first.clone();
        assert!(stopped.move_star(1, DVec3::ZERO, &stop).is_err());
        assert!(data(&stopped) == data(&first) && stopped.space.stars == first.space.stars);
        assert!(stopped.move_star(2, DVec3::ZERO, &Control::default()).is_err());
        assert!(stopped.move_star(1, DVec3::NAN, &Control::default()).is_err());
    }
}
