use super::*;
use crate::camera::Camera;
use crate::image::convolution::Kernel;
use crate::instrument::PointSpread;
use crate::instrument::psf::OpticsView;
use crate::observation::Observation;
use glam::DVec3;

fn picture(camera: &Camera, value: f64) -> Image {
    let count = camera.width * camera.height;
    let image = Image::bare(camera.width, camera.height, vec!["johnson-V".into()], Samples::Double(vec![value; count]));
    Image { pixel: Some(camera.pixel_scale()), axis: camera.axis(), ..image }
}

/// Pixels of a picture see the solid angles that those of its camera do, in a part of a wide view too.
#[test]
fn solid_angles_are_those_of_the_camera() {
    let wide = Camera::look_at(DVec3::Z, DVec3::ZERO).with_field_of_view_deg(110.0).with_size(60, 40);
    for camera in [wide.clone(), wide.crop(31, 3, 20, 17).unwrap()] {
        let pixels = Pixels::of(&picture(&camera, 1.0)).unwrap();
        for (column, row) in [(0, 0), (camera.width - 1, 2), (7, camera.height - 1)] {
            let wanted = camera.pixel_measure(column as f64 + 0.5, row as f64 + 0.5);
            let solid_angle = pixels.solid_angle(row * camera.width + column);
            assert!((solid_angle / wanted - 1.0).abs() < 1e-12, "{column} {row}: {solid_angle} {wanted}");
        }
    }
}

/// Parallel rays from a distance are a narrow view; even light stays even through any optics, and is electrons of its photons.
#[test]
fn even_light_is_even() {
    let bands = [Passband::by_name("johnson-V").unwrap()];
    let flat = Camera::look_at(DVec3::Z, DVec3::ZERO).with_orthographic_pc(1.0).with_size(24, 24);
    let image = Image { observation: Some(Observation { distance_pc: Some(1000.0), ..Observation::default() }), ..picture(&flat, 3e-7) };
    let pixel = 1e-3 / 24.0;
    for edge in [None, Some(3.0 * pixel)] {
        let instrument = Arc::new(Instrument { pixel_rad: edge, obstruction: 0.3, ..Instrument::of_aperture(0.1) });
        let exposures = Exposures::new(instrument.clone(), &image, &bands, &Control::default()).unwrap();
        let wanted = 3e-7 * edge.unwrap_or(pixel).powi(2) * instrument.electrons(bands[0].pivot().0);
        let count = exposures.size()[0] * exposures.size()[1];
        assert_eq!(count, if edge.is_some() { 64 } else { 576 });
        assert!((0..count).all(|i| (exposures.source(0, i) / wanted - 1.0).abs() < 1e-9), "{edge:?}");
    }
    let near = Image { observation: None, ..image };
    assert!(Exposures::new(Arc::new(Instrument::of_aperture(0.1)), &near, &bands, &Control::default()).is_err());
}

/// A star is as narrow on a detector as optics make it, though the picture draws it as a disc of about a pixel: what pixels gather is the
/// integral of a Gaussian over them, wherever in a pixel the star stands, on pixels of the picture's size and on larger ones.
#[test]
fn stars_are_as_sharp_as_optics_make_them() {
    let bands = [Passband::by_name("johnson-V").unwrap()];
    let camera = Camera::look_at(DVec3::Z, DVec3::ZERO).with_field_of_view_deg(0.01).with_size(48, 48);
    let (dark, flux) = (picture(&camera, 0.0), 1e-12);
    let below = Pixels::of(&dark).unwrap();
    for (column, row) in [(24.5, 24.5), (24.0, 25.0), (22.3, 26.71)] {
        let mut samples = vec![0.0; 48 * 48];
        for (pixel, share) in crate::points::disc([48, 48], column, row) {
            samples[pixel] += flux * share / below.solid_angle(pixel);
        }
        let points = vec![crate::image::PointSource { column, row, flux: vec![flux] }];
        for edge in [1.0, 2.0] {
            let drawn = Image { samples: Samples::Double(samples.clone()), points: points.clone(), ..dark.clone() };
            let fwhm = 1.8 * edge;
            let psf: Vec<Arc<dyn crate::instrument::PointSpread>> =
                vec![Arc::new(crate::instrument::psf::Gaussian { fwhm_rad: fwhm * below.edge_rad, ..Default::default() })];
            let instrument = Arc::new(Instrument { psf, pixel_rad: Some(edge * below.edge_rad), ..Instrument::of_aperture(1.0) });
            let per_watt = instrument.electrons(bands[0].pivot().0);
            let recorded = Exposures::new(instrument.clone(), &drawn, &bands, &Control::default()).unwrap();
            let size = recorded.size()[0];
            let sigma = fwhm / (8.0 * std::f64::consts::LN_2).sqrt();
            let along = |pixel: usize, at: f64| {
                const STEPS: usize = 400;
                let place = |step: usize| (pixel as f64 + (step as f64 + 0.5) / STEPS as f64) * edge;
                let density = |x: f64| (-0.5 * ((x - at) / sigma).powi(2)).exp() / (sigma * (2.0 * std::f64::consts::PI).sqrt());
                (0..STEPS).map(|step| density(place(step))).sum::<f64>() * edge / STEPS as f64
            };
            let truth = |i: usize| flux * per_watt * along(i % size, column) * along(i / size, row);
            let peak = (0..size * size).map(truth).fold(0.0, f64::max);
            let worst =
                |exposures: &Exposures| (0..size * size).map(|i| (exposures.source(0, i) - truth(i)).abs() / peak).fold(0.0, f64::max);
            assert!(worst(&recorded) < 5e-3, "{column} {row} {edge}: {}", worst(&recorded));
            // As a disc it would be much lower.
            let blurred = Exposures::new(instrument, &Image { points: Vec::new(), ..drawn }, &bands, &Control::default()).unwrap();
            assert!(worst(&blurred) > if edge == 1.0 { 0.2 } else { 0.05 }, "{}", worst(&blurred));
        }
    }
}

/// Kernels that are kept are those of other optics or pixels no more: light is spread as if they were made anew, bit by bit.
#[test]
fn kernels_are_kept() {
    let bands = [Passband::by_name("johnson-B").unwrap(), Passband::by_name("johnson-V").unwrap()];
    let image = |size: usize, field: f64| {
        let camera = Camera::look_at(DVec3::Z, DVec3::ZERO).with_field_of_view_deg(field).with_size(size, size);
        let names = bands.iter().map(|band| band.name().to_owned()).collect();
        let values = (0..2 * size * size).map(|i| 1e-7 * (1 + i * 7919 % 101) as f64).collect();
        let image_of = Image::bare(size, size, names, Samples::Double(values));
        Image { pixel: Some(camera.pixel_scale()), axis: camera.axis(), ..image_of }
    };
    let lens = |aperture: f64| Instrument { obstruction: 0.3, ..Instrument::of_aperture(aperture) };
    let hazy = |fwhm_rad: f64| Instrument {
        psf: vec![Arc::new(crate::instrument::psf::Gaussian { fwhm_rad, ..Default::default() })],
        ..lens(0.1)
    };
    let redder = |mut image: Image| {
        image.bands[0].pivot_um = Some(0.9);
        image
    };
    let mut kernels = Kernels::within(1 << 30);
    for (instrument, image) in [
        (lens(0.2), image(24, 0.01)),
        (Instrument { sky: crate::instrument::Sky::even(20.0), exposure_s: 7.0, ..lens(0.2) }, image(24, 0.01)),
        (lens(0.1), image(24, 0.01)),
        (lens(0.1), image(24, 0.02)),
        (lens(0.1), image(20, 0.02)),
        (lens(0.1), redder(image(20, 0.02))),
        (Instrument { obstruction: 0.5, ..lens(0.1) }, image(20, 0.02)),
        (hazy(1e-5), image(20, 0.02)),
        (hazy(2e-5), image(20, 0.02)),
    ] {
        let instrument = Arc::new(instrument);
        let exposures = Exposures::by(&mut kernels, instrument.clone(), &image, &bands, &Control::default()).unwrap();
        let new = Exposures::new(instrument, &image, &bands, &Control::default()).unwrap();
        let light = |exposures: &Exposures| exposures.bands.iter().map(|band| band.source.clone()).collect::<Vec<_>>();
        assert!(light(&exposures) == light(&new));
    }
}

/// A kernel is worked out once where there is room for it, and each time where there is none.
#[test]
fn kernels_are_made_once() {
    use std::sync::atomic::{AtomicUsize, Ordering};
    #[derive(Debug, Default)]
    struct Counted(AtomicUsize);
    impl PointSpread for Counted {
        fn kernel(&self, view: &OpticsView) -> Result<Option<Kernel>> {
            self.0.fetch_add(1, Ordering::Relaxed);
            Ok(Some(Kernel::round(view.reach, |square| (-square).exp())))
        }
        fn description(&self) -> String {
            "counted".into()
        }
    }
    let camera = Camera::look_at(DVec3::Z, DVec3::ZERO).with_field_of_view_deg(1.0).with_size(9, 9);
    let bands = [Passband::by_name("johnson-V").unwrap()];
    for (mut kernels, wanted) in [(Kernels::within(1 << 20), 1), (Kernels::within(100), 3), (Kernels::default(), 3)] {
        let counted = Arc::new(Counted::default());
        let instrument = Arc::new(Instrument { psf: vec![counted.clone()], ..Instrument::of_aperture(1.0) });
        for _ in 0..3 {
            Exposures::by(&mut kernels, instrument.clone(), &picture(&camera, 1e-7), &bands, &Control::default()).unwrap();
        }
        assert_eq!(counted.0.load(Ordering::Relaxed), wanted);
    }
}

/// Custom point-spread functions of other crates work.
#[test]
fn other_point_spreads_are_taken() {
    #[derive(Debug)]
    struct Left;
    impl PointSpread for Left {
        fn kernel(&self, view: &OpticsView) -> Result<Option<Kernel>> {
            let mut values = vec![0.0; (2 * view.reach + 1).pow(2)];
            (values[view.reach * (2 * view.reach + 1)], values[view.reach * (2 * view.reach + 2)]) = (0.6, 0.4);
            Ok(Some(Kernel { reach: view.reach, values }))
        }
        fn description(&self) -> String {
            "left".into()
        }
    }
    let camera = Camera::look_at(DVec3::Z, DVec3::ZERO).with_field_of_view_deg(1.0).with_size(9, 9);
    let mut image = picture(&camera, 0.0);
    image.samples.add(4 * 9 + 6, 1e-6);
    let instrument = Arc::new(Instrument { psf: vec![Arc::new(Left)], ..Instrument::of_aperture(1.0) });
    let exposures = Exposures::new(instrument, &image, &[Passband::by_name("johnson-V").unwrap()], &Control::default()).unwrap();
    // What stays is as bright as the point was: as much more would have come from beyond the edge.
    let (moved, stayed) = (exposures.source(0, 4 * 9 + 2), exposures.source(0, 4 * 9 + 6));
    let rest: f64 = (0..81).filter(|i| ![38, 42].contains(i)).map(|i| exposures.source(0, i)).sum();
    assert!((moved / stayed - 0.6).abs() < 1e-6 && rest < 1e-6 * stayed, "{moved} {stayed} {rest}");
}
