//! Faulty devices and plans that exceed device limits.

use std::sync::{Arc, Mutex};

use barnard::backend::{Backend, Device, Job, Renderer, cpu};
use barnard::control::{Control, Stage};
use barnard::memory::DEFAULT_LIMIT;
use barnard::plan::{Options, Planner, Quality, Stepping};
use glam::DVec3;
use ionisation::balance::{Gas, GasState};
use ionisation::benchmarks::BENCHMARKS;
use ionisation::cloud::{Cloud, Quantity, Settings, Star};
use ionisation::light::IonisingLight;
use ionisation::tracer::RayTracer;

use crate::fixtures::{plan_of, scene};
use crate::test_device::device;
use crate::tuning::Tuning;
use crate::{Auto, DeviceMarch, Gpu, GpuError, IonisingRays, OnDevice, Ordinates};

/// A device that is taken away in the middle of a picture is opened once more; if that is taken too, the processor
/// renders.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn a_lost_device_does_not_lose_the_picture() {
    let scene = scene(24, "");
    let plan = plan_of(&scene);
    let (truth, _) = Renderer::new(&mut cpu::Cpu).render(&plan, &Control::default()).unwrap();
    for losses in [0, 1, 2] {
        let (opened, left) = (Arc::new(Mutex::new(None::<wgpu::Device>)), Arc::new(Mutex::new(losses)));
        let (victim, hits) = (opened.clone(), left.clone());
        let control = Control::with_listener(move |_, _, _| {
            let mut hits = hits.lock().unwrap();
            if *hits > 0
                && let Some(device) = victim.lock().unwrap().take()
            {
                device.destroy();
                *hits -= 1;
            }
        });
        let open = move || {
            let gpu = Gpu::open()?;
            *opened.lock().unwrap() = Some(gpu.device.clone());
            Ok(gpu)
        };
        let mut backend = Auto::on(OnDevice::new(open().unwrap(), Tuning::default()).reopened_by(open));
        let job = Job::from(&plan);
        let (image, _) = Renderer::new(&mut backend).render(&plan, &control).unwrap();
        let warnings = backend.warnings();
        let again = backend.prepare(&job, &control).and_then(|()| Renderer::new(&mut backend).render(&plan, &control));
        assert_eq!(*left.lock().unwrap(), 0);
        assert_eq!(warnings.len(), [0, 1, 2][losses], "{warnings:?}");
        let backend = image.report.backend.as_ref().unwrap();
        assert_eq!(backend.starts_with("gpu"), losses < 2, "{backend}");
        for band in 0..2 {
            assert!(image.relative_rmse(band, &truth, band) < 5e-3);
        }
        assert_eq!(image.samples == truth.samples, losses == 2);
        // The next picture is made by what is left.
        assert!(again.unwrap().0.samples == image.samples);
    }
}

/// An adapter without timestamps renders the same, without timings.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn timestamps_are_not_needed() {
    let mut gpu = device();
    let plan = plan_of(&scene(24, ""));
    let mut renderer = DeviceMarch::new(&gpu, &plan, Tuning::default()).unwrap();
    let with = renderer.radiance(&Control::default()).unwrap();
    let timed = gpu.timer.is_some();
    assert_eq!(renderer.seconds().is_some(), timed);
    gpu.timer = None;
    let mut renderer = DeviceMarch::new(&gpu, &plan, Tuning::default()).unwrap();
    assert!(renderer.radiance(&Control::default()).unwrap() == with);
    assert!(renderer.seconds().is_none());
}

/// Plans beyond a device's limits are refused before anything is uploaded, with what would fit.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn what_is_too_large_is_refused() {
    let limits = wgpu::Limits { max_texture_dimension_3d: 16, ..wgpu::Limits::default() };
    let edges = (limits, "16", "at most 14 voxels");
    let limits = wgpu::Limits { max_sampled_textures_per_shader_stage: 1, ..wgpu::Limits::default() };
    let textures = (limits, "at most 1;", "use at most 4 volumes");
    let limits = wgpu::Limits { max_storage_buffer_binding_size: 1 << 10, ..wgpu::Limits::default() };
    let tables = (limits, "tables", "on the processor");
    let limits = wgpu::Limits { max_storage_buffers_per_shader_stage: 4, ..wgpu::Limits::default() };
    let buffers = (limits, "at most 4;", "on the processor");
    for (limits, is, right) in [edges, textures, tables, buffers] {
        let gpu = Gpu::limited(limits).unwrap();
        let plan = plan_of(&scene(24, ""));
        let error = DeviceMarch::new(&gpu, &plan, Tuning::default()).err().unwrap();
        let words = error.to_string();
        assert!(matches!(error, GpuError::TooLarge { .. }) && words.contains(is) && words.contains(right), "{words}");
    }
    // Steps past what single precision counts would never end.
    let endless = plan_of(&scene(24, "")).with_stepping(Stepping::PerVoxel(1e6));
    let words = DeviceMarch::new(&device(), &endless, Tuning::default()).err().unwrap().to_string();
    assert!(words.contains("steps along a ray") && words.contains("fewer steps"), "{words}");
}

/// What a device cannot hold the processor renders, and says why; the next plan, which fits, is the device's again.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn the_processor_renders_what_a_device_cannot_hold() {
    let limits = wgpu::Limits { max_texture_dimension_3d: 16, ..wgpu::Limits::default() };
    let mut backend = Auto::on(OnDevice::new(Gpu::limited(limits).unwrap(), Tuning::default()));
    let (large, small) = (scene(24, ""), scene(12, ""));
    for (scene, fits) in [(&small, true), (&large, false), (&small, true)] {
        let plan = plan_of(scene);
        let job = Job::from(&plan);
        backend.prepare(&job, &Control::default()).unwrap();
        let (image, _) = Renderer::new(&mut backend).render(&plan, &Control::default()).unwrap();
        let truth = Renderer::new(&mut cpu::Cpu).render(&plan, &Control::default()).unwrap().0;
        assert_eq!(image.samples == truth.samples, !fits);
        assert_eq!(backend.name().starts_with("gpu"), fits);
        let why = backend.fallback();
        assert!(why.is_none() == fits && why.is_none_or(|why| why.contains("at most 14 voxels")));
    }
}

/// A device without room says how much a plan takes, and what takes less.
#[test]
fn no_room_is_an_error_that_says_what_fits() {
    let words = GpuError::Memory(3 << 30).to_string();
    assert!(words.contains("3072 MiB") && words.contains("fewer voxels") && words.contains("on the processor"), "{words}");
}

/// Light that a device has no room to sweep, or that goes in the middle of it, is swept by the processor, with the same
/// bits; the output says why.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn the_processor_sweeps_what_a_device_cannot() {
    let lost = device();
    let scene = scene(16, "bounces = 30");
    let plan = |gpu: Option<&Gpu>, control: &Control| {
        let mut options = Options::within(DEFAULT_LIMIT);
        if let Some(gpu) = gpu {
            options.sweeper = Some(Arc::new(Ordinates::new(gpu.clone())));
        }
        let plan = Planner::new(&options).with_quality(Quality::Fixed(40)).plan(&scene, None, control).unwrap();
        let words = plan.expected_report().words().into_iter().find(|note| note.0 == "multiple scattering").unwrap().1;
        (plan.scattered_field().unwrap().volumes.iter().flat_map(|v| v.rows().collect::<Vec<_>>().concat()).collect::<Vec<f32>>(), words)
    };
    let small = Gpu::limited(wgpu::Limits { max_storage_buffer_binding_size: 1 << 20, ..wgpu::Limits::default() }).unwrap();
    let (victim, hits) = (lost.device.clone(), Arc::new(Mutex::new(0)));
    let heard = hits.clone();
    let takes_away = Control::with_listener(move |stage, _, _| {
        if stage == Stage::Light {
            *heard.lock().unwrap() += 1;
            victim.destroy();
        }
    });
    let (truth, words) = plan(None, &Control::default());
    assert!(words.contains("computed on cpu in"), "{words}");
    for (gpu, control, why) in
        [(&small, Control::default(), "this device supports at most 1048576"), (&lost, takes_away, "the device failed")]
    {
        let (volumes, words) = plan(Some(gpu), &control);
        assert!(words.contains(&format!("computed on cpu ({}: ", gpu.name())) && words.contains(why), "{words}");
        assert!(volumes == truth);
    }
    assert!(*hits.lock().unwrap() > 0);
}

/// Ionising light that a device has no room to trace, or that goes in the middle of it, is traced by the processor, with the same
/// bits; the report names the device and the reason.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn the_processor_traces_what_a_device_cannot() {
    let (lost, hydrogen, light) = (device(), vec![200.0; 24 * 24 * 24], IonisingLight::blackbody(40_000.0, 2e47));
    let (low, voxel) = (DVec3::splat(-1.2), DVec3::splat(0.1));
    let abundances = BENCHMARKS[0].gas.abundances;
    let cloud = Cloud { dims: [24; 3], low, voxel, hydrogen: &hydrogen, abundances, dust_cm2: 0.0 };
    let stars = [0.31, -0.42].map(|x| Star { place: DVec3::new(x, 0.02, 0.03), light: &light });
    let electrons = |_: &Gas, state: &GasState| state.electrons;
    let solved = |gpu: Option<&Gpu>, watch: &(dyn Fn(u64, u64) -> bool + Sync)| {
        let rays = gpu.map(|gpu| IonisingRays::new(gpu.clone()));
        let tracer = rays.as_ref().map(|rays| rays as &dyn RayTracer);
        cloud.ionised_by(tracer, &stars, &Settings::default(), &[Quantity { most: 300.0, value: &electrons }], watch).unwrap()
    };
    let truth = solved(None, &|_, _| true);
    let small = Gpu::limited(wgpu::Limits { max_storage_buffer_binding_size: 1 << 18, ..wgpu::Limits::default() }).unwrap();
    let victim = lost.device.clone();
    let takes_away = move |_: u64, _: u64| {
        victim.destroy();
        true
    };
    let goes_on = |_: u64, _: u64| true;
    for (gpu, watch, why) in [
        (&small, &goes_on as &(dyn Fn(u64, u64) -> bool + Sync), "this device supports at most 262144"),
        (&lost, &takes_away, "the device failed"),
    ] {
        let found = solved(Some(gpu), watch);
        assert!(found.by.starts_with(&format!("cpu ({}: ", gpu.name())) && found.by.contains(why), "{}", found.by);
        assert!(found.quantities == truth.quantities);
    }
}
