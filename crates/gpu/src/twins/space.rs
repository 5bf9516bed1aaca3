//! Rays, boxes, volumes and noise of both.

use super::ARGUMENTS;
use super::Arguments;
use super::agree;
use super::arguments;
use super::plan;
use super::seen_from;
use crate::fixtures::parsed;
use crate::fixtures::plan_of;
use crate::fixtures::scene;
use crate::fixtures::text;
use crate::test_device::device;
use barnard::camera::Camera;
use barnard::camera::Stereo;
use barnard::geometry::Bounds;
use glam::DVec3;

#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn rays_and_boxes() {
    let gpu = device();
    let plan = &plan("");
    let middle = plan.space().occupied.map(|b| 0.5 * (b.low + b.high)).unwrap();
    let body = "let r = camera_ray(x[0], x[1]); let p = r.origin + r.first * r.direction; y[0] = p.x; y[1] = p.y; y[2] = p.z; y[3] = r.direction.x; y[4] = r.direction.y; y[5] = r.direction.z;";
    agree(&gpu, plan, body, &[(1.0, 48.0), (1.0, 32.0)], 1e-6, |x| {
        let ray = plan.camera().ray(x[0], x[1]);
        let origin = ray.origin - middle;
        [origin.to_array(), ray.direction.to_array()].concat()
    });
    let seen = plan.camera();
    let part = seen.clone().with_equirectangular(48).crop(3, 2, 40, 20).unwrap();
    let two = |camera: Camera| camera.with_stereo(Stereo::new(0.4, 3.0)).eyes().unwrap();
    let [left, _] = two(seen.clone().with_equirectangular(48));
    let [_, right] = two(seen.clone().with_fisheye_deg(180.0, 30.0));
    // Of no shape that a sphere has: above and below is nothing.
    let square = seen.clone().with_equirectangular(48).with_size(48, 48);
    for camera in [
        square,
        left,
        right,
        seen.clone().with_fisheye_deg(180.0, 30.0),
        seen.clone().with_fisheye_deg(340.0, 90.0),
        seen.clone().with_equirectangular(48),
        part,
    ] {
        let plan = &seen_from(plan, camera);
        let (w, h) = (plan.camera().width as f64, plan.camera().height as f64);
        agree(&gpu, plan, body, &[(0.0, w), (0.0, h)], 5e-6, |x| {
            let ray = plan.camera().ray(x[0], x[1]);
            [(ray.origin - middle).to_array(), ray.direction.to_array()].concat()
        });
        agree(&gpu, plan, "y[0] = f32(sees(x[0], x[1]));", &[(0.0, w), (0.0, h)], 1e-6, |x| {
            vec![f64::from(u8::from(plan.camera().sees(x[0], x[1])))]
        });
    }
    // Directions jump from one face of a cube to the next.
    for face in 0..6 {
        let plan = &seen_from(plan, seen.clone().with_cubemap(16));
        let rows = (16.0 * f64::from(face) + 0.01, 16.0 * f64::from(face) + 15.99);
        agree(&gpu, plan, body, &[(0.0, 16.0), rows], 2e-6, |x| {
            let ray = plan.camera().ray(x[0], x[1]);
            [(ray.origin - middle).to_array(), ray.direction.to_array()].concat()
        });
    }
    let body = "let d = normalize(vec3f(x[3], x[4], x[5])); let c = clip(Ray(vec3f(x[0], x[1], x[2]), d, 0.0), vec3f(-1.0), vec3f(1.0, 2.0, 3.0), 0.0); y[0] = c.x; y[1] = c.y; if c.y <= c.x { y[0] = -1.0; y[1] = -1.0; }";
    let coordinates = [(-2.0, 2.0); 6];
    agree(&gpu, plan, body, &coordinates, 1e-5, |x| {
        let bounds = Bounds { low: DVec3::splat(-1.0), high: DVec3::new(1.0, 2.0, 3.0) };
        let ray = barnard::geometry::Ray { origin: DVec3::new(x[0], x[1], x[2]), direction: DVec3::new(x[3], x[4], x[5]).normalize() };
        bounds.clip(&ray).map_or(vec![-1.0; 2], |(near, far)| vec![near, far])
    });
}

#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn volumes_and_bricks() {
    let gpu = device();
    let plan = &plan("");
    let middle = plan.space().occupied.map(|b| 0.5 * (b.low + b.high)).unwrap();
    let place = |x: &[f64; ARGUMENTS]| middle + DVec3::new(x[0], x[1], x[2]);
    let volumes: Vec<_> = plan.volumes().collect();
    let within = [(-0.9, 0.9); 3];
    // Real devices weigh voxels in 256ths: they read what stands up to half of that beside a place, on each axis.
    let beside = volumes[0].lattice.voxel_pc() / 512.0;
    let rounded = |x: &Arguments| {
        let p = place(&x.map(f64::from));
        let moved =
            |channel: usize, axis: DVec3| [axis, -axis].map(|d| (volumes[0].at(channel, p + d * beside) - volumes[0].at(channel, p)).abs());
        let variation =
            |channel: usize| DVec3::AXES.into_iter().map(|axis| moved(channel, axis).into_iter().fold(0.0, f64::max)).sum::<f64>();
        (0..3).map(variation).fold(0.0, f64::max)
    };
    let weights = if gpu.adapter.real { arguments(&within).iter().map(rounded).fold(0.0, f64::max) } else { 0.0 };
    // Dust and two star depths stand in the first quad, gas in the second; f16 keeps three digits.
    agree(
        &gpu,
        plan,
        "let v = read_all(vec3f(x[0], x[1], x[2])); y[0] = v[0].x; y[1] = v[0].y; y[2] = v[0].z; y[3] = read_dust(vec3f(x[0], x[1], x[2]));",
        &within,
        1e-3 + weights,
        |x| {
            let at = |channel: usize| volumes[0].at(channel, place(&x));
            vec![at(0), at(1), at(2), at(0)]
        },
    );
    agree(&gpu, plan, "let m = masks(vec3f(x[0], x[1], x[2])); y[0] = m[0]; y[1] = m[1];", &[(-1.2, 1.2); 3], 1e-6, |x| {
        volumes.iter().map(|v| f64::from(u8::from(v.inner.bounds.contains(place(&x))))).collect()
    });
    let body = "y[0] = depth_between(vec3f(x[0], x[1], x[2]), vec3f(x[0] + x[3], x[1] + x[4], x[2] + x[5]));";
    let ranges = [within[0], within[1], within[2], (-0.2, 0.2), (-0.2, 0.2), (-0.2, 0.2)];
    agree(&gpu, plan, body, &ranges, 1e-3, |x| vec![plan.space().depth(place(&x), place(&x) + DVec3::new(x[3], x[4], x[5]))]);
}

#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn empty_bricks() {
    let gpu = device();
    let plan = &plan_of(&scene(128, ""));
    let middle = plan.space().occupied.map(|b| 0.5 * (b.low + b.high)).unwrap();
    agree(&gpu, plan, "y[0] = clear_pc(Ray(vec3f(x[0], x[1], x[2]), vec3f(1.0, 0.0, 0.0), 0.0), 0.0).x;", &[(-1.1, 1.1); 3], 1e-6, |x| {
        let place = middle + DVec3::new(x[0], x[1], x[2]);
        let clear_pc = |b: &barnard::volume::Bricks| b.clear(b.brick_of(place)) as f64 * b.lattice.voxel_pc().min_element();
        vec![plan.space().bricks.iter().map(clear_pc).fold(f64::INFINITY, f64::min)]
    });
}

/// Voxels that are longer one way than another: a ray takes as many steps as those along its direction ask for.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn voxels_along_a_ray() {
    let gpu = device();
    let plate = "[field.plate]\nkind = \"box\"\nlow = \"-1 -0.3 -0.5 pc\"\nhigh = \"1 0.4 0.1 pc\"\n[dust]\ndensity = \"plate\"";
    let text = text(8, "").replace("[dust]\ndensity = \"ball\"", plate).replace("knot\"\ntemp", "plate\"\ntemp");
    let plan = &plan_of(&parsed(text));
    let longest = |d: DVec3| 1.0 / plan.space().voxel_along(d);
    assert!(longest(DVec3::Z) < 0.9 * longest(DVec3::X), "{} {}", longest(DVec3::X), longest(DVec3::Z));
    let body = "y[0] = 0.1 * voxels_along(normalize(vec3f(x[0], x[1], x[2])));";
    agree(&gpu, plan, body, &[(-1.0, 1.0); 3], 1e-6, |x| vec![0.1 * longest(DVec3::new(x[0], x[1], x[2]).normalize())]);
}

#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn noise() {
    let gpu = device();
    let plan = &plan("");
    let (cloud, sigma) = plan.space().cloud.as_ref().unwrap();
    agree(&gpu, plan, "y[0] = simplex(vec3f(x[0], x[1], x[2]), frame.seeds.x);", &[(-20.0, 20.0); 3], 2e-5, |x| {
        vec![cloud.noise.at(DVec3::new(x[0], x[1], x[2]))]
    });
    let middle = plan.space().occupied.map(|b| 0.5 * (b.low + b.high)).unwrap();
    agree(&gpu, plan, "y[0] = cloud(vec3f(x[0], x[1], x[2]));", &[(-0.7, 0.7); 3], 2e-5, |x| {
        vec![sigma * barnard::field::Field::at(cloud, middle + DVec3::new(x[0], x[1], x[2]))]
    });
}

/// The noise of detail, and the places that are read.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn detail() {
    let gpu = device();
    let detailed = barnard::detail::Detail::default();
    let plan = &plan_of(&scene(24, "").edited(|spec| spec.detail = Some(detailed)).unwrap());
    let noise = plan.detail().unwrap();
    agree(&gpu, plan, "let c = detail_noise(vec3f(x[0], x[1], x[2]), 77u); y[0] = c.x; y[1] = c.y;", &[(-20.0, 20.0); 3], 3e-4, |x| {
        barnard::detail::double([x[0], x[1], x[2]], 77).to_vec()
    });
    let middle = plan.space().occupied.map(|b| 0.5 * (b.low + b.high)).unwrap();
    let (per_pc, ahead) = (plan.camera().footprint().per_pc, 0.03);
    // Along a ray on which the observer stands behind.
    let body = "var ray: Ray; ray.origin = vec3f(x[0], x[1], x[2]); ray.direction = vec3f(0.6, 0.0, 0.8); ray.first = -x[3];\n\
                let d = displaced(ray, 0.03) - ray.origin - 0.03 * ray.direction; y[0] = 100.0 * d.x; y[1] = 100.0 * d.y; y[2] = 100.0 * d.z;";
    agree(&gpu, plan, body, &[(-0.7, 0.7), (-0.7, 0.7), (-0.7, 0.7), (0.3, 1.2)], 2e-3, |x| {
        let place = middle + DVec3::new(x[0], x[1], x[2]) + ahead * DVec3::new(0.6, 0.0, 0.8);
        (100.0 * noise.displacement(place, per_pc * (ahead + x[3]))).to_array().to_vec()
    });
}
