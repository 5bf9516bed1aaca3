//! Domes, spheres and cubes beside pictures of one direction, back end by back end.

use barnard::backend::{Renderer, cpu, path};
use barnard::camera::{Arrangement, Camera, Stereo};
use barnard::control::Control;
use barnard::glam::DVec3;
use barnard::memory::DEFAULT_LIMIT;
use barnard::plan::{Options, Planner};
use barnard::scene::{Scene, SceneSpec};

/// An eye in a cloud, with a lit ball ahead, one above and one behind.
fn scene() -> Scene {
    let balls = [("a", "0 0 -2"), ("b", "0.5 1.8 0"), ("c", "-1 0 2")];
    let fields = balls
        .map(|(name, at)| {
            format!(
                r#"[field.{name}]
kind = "plummer"
core = "0.5 pc"
cut = "2 pc"
centre = "{at} pc"
"#
            )
        })
        .concat();
    let text = format!(
        r#"bands = ["bessell-V"]
[camera]
kind = "fisheye"
position = "0 0 0 pc"
target = "0 0 -1 pc"
size = [24, 24]
{fields}[dust]
density = "a + 0.5*b + 2*c"
scale = "0.4 /pc"
law = "ccm89"
albedo = 0.6
[[star]]
kind = "blackbody"
position = "0.4 3 2.5 pc"
temperature = "12000 K"
luminosity = "1000 Lsun"
visible = false
"#
    );
    barnard_files::parse("panorama.toml", "panorama", text, &barnard_files::in_folder(".", DEFAULT_LIMIT)).unwrap()
}

fn cameras(camera: &Camera) -> [(&'static str, Camera); 5] {
    let copy = || camera.clone();
    [
        ("dome", copy()),
        ("tilted dome", copy().with_fisheye_deg(210.0, 20.0)),
        ("all of the sphere on a dome", copy().with_fisheye_deg(360.0, 90.0)),
        ("sphere", copy().with_equirectangular(32)),
        ("cube", copy().with_cubemap(8)),
    ]
}

/// A camera of one pixel that looks along the ray of another's.
fn along(camera: &Camera, column: usize, row: usize) -> Camera {
    let direction = camera.ray(column as f64 + 0.5, row as f64 + 0.5).direction;
    let up = if direction.y.abs() > 0.9 { DVec3::X } else { DVec3::Y };
    Camera::look_at(camera.position, camera.position + direction).with_up(up).with_field_of_view_deg(1e-4).with_size(1, 1)
}

/// Each pixel is what an eye sees that looks its way; beside the circle of a dome all back ends leave black.
#[test]
#[ignore = "long"]
fn pixels_are_what_is_seen_their_way() {
    let scene = scene();
    let control = Control::default();
    for (name, camera) in cameras(&scene.camera) {
        let whole = scene.clone().with_camera(camera.clone());
        let plan = Planner::new(&Options::within(DEFAULT_LIMIT)).plan(&whole, None, &control).unwrap();
        let (fast, _) = Renderer::new(&mut cpu::Cpu).render(&plan, &control).unwrap();
        let exact = barnard::render_reference(&whole, 1e-4, &control).unwrap();
        let samples = |image: &barnard::Image| image.band(0).collect::<Vec<f64>>();
        let (fast, exact) = (samples(&fast), samples(&exact));
        let brightest = exact.iter().copied().fold(0.0, f64::max);
        let (mut seen, mut black) = (0, 0);
        for (i, (fast, exact)) in fast.iter().zip(&exact).enumerate() {
            let (column, row) = (i % camera.width, i / camera.width);
            if !camera.sees(column as f64 + 0.5, row as f64 + 0.5) {
                assert!(*fast == 0.0 && *exact == 0.0, "{name} {column} {row}");
                black += 1;
                continue;
            }
            assert!((fast - exact).abs() < 0.01 * brightest, "{name} {column} {row}: {fast:e} {exact:e}");
            if i % 7 == 0 {
                let one = barnard::render_reference(&scene.clone().with_camera(along(&camera, column, row)), 1e-4, &control).unwrap();
                let truth = one.band(0).next().unwrap();
                assert!((exact - truth).abs() < 1e-3 * brightest, "{name} {column} {row}: {exact:e} {truth:e}");
                seen += 1;
            }
        }
        assert!(seen > 40 && (black > 50) == name.contains("dome"), "{name} {seen} {black}");
    }
}

/// Paths by chance, too, begin where there is a direction alone, and bring what the reference sees.
#[test]
fn paths_see_a_dome() {
    let scene = scene();
    let control = Control::default();
    let exact: Vec<f64> = barnard::render_reference(&scene, 1e-4, &control).unwrap().band(0).collect();
    let mut film = path::Film::default();
    path::trace(&scene, &path::Options::default().with_samples(600), &mut film, &control, &mut |_| ()).unwrap();
    let found: Vec<f64> = film.estimates.iter().map(|estimate| estimate.mean).collect();
    let (sum, truth): (f64, f64) = (found.iter().sum(), exact.iter().sum());
    assert!((sum / truth - 1.0).abs() < 0.02, "{}", sum / truth);
    for (i, (found, exact)) in found.iter().zip(&exact).enumerate() {
        assert!((*exact == 0.0) == (*found == 0.0), "{i}: {found:e} {exact:e}");
    }
}

/// Solid angles of all pixels are those of what is seen.
#[test]
fn pixels_fill_the_sphere() {
    let camera = scene().camera.clone().with_size(200, 200);
    let cap = |half: f64| 2.0 * std::f64::consts::PI * (1.0 - half.to_radians().cos());
    let [dome, tilted, around, sphere, cube] = cameras(&camera).map(|(_, camera)| camera);
    let all = [
        (dome, cap(90.0)),
        (tilted, cap(105.0)),
        (around, cap(180.0)),
        (sphere.with_equirectangular(200), cap(180.0)),
        (cube.with_cubemap(100), cap(180.0)),
    ];
    for (camera, truth) in all {
        let places = (0..camera.height).flat_map(|row| (0..camera.width).map(move |column| (column as f64 + 0.5, row as f64 + 0.5)));
        let seen = places.filter(|(column, row)| camera.sees(*column, *row));
        let sum: f64 = seen.map(|(column, row)| camera.pixel_measure(column, row)).sum();
        assert!((sum / truth - 1.0).abs() < 2e-3, "{:?}: {sum} {truth}", camera.projection);
    }
}

/// A part of a dome has the rays of the whole, and a star is drawn where its direction is.
#[test]
fn parts_and_places() {
    let small_dome = scene().camera.clone().with_size(120, 120);
    for (name, camera) in cameras(&small_dome) {
        let part = camera.clone().crop(3, 5, camera.width - 6, camera.height / 2).unwrap();
        for (column, row) in [(0.5, 0.5), (9.25, 2.0), (7.0, 11.5)] {
            assert!(part.ray(column, row).direction.distance(camera.ray(column + 3.0, row + 5.0).direction) < 1e-12, "{name}");
            assert_eq!(part.sees(column, row), camera.sees(column + 3.0, row + 5.0));
        }
        let (column, row) = (0.4 * camera.width as f64, 0.6 * camera.height as f64);
        let back = camera.project(camera.ray(column, row).at(5.0)).unwrap();
        assert!((back.0 - column).hypot(back.1 - row) < 1e-8, "{name} {back:?}");
    }
}

/// Angles that are none are refused, and say what would be right.
#[test]
fn bad_angles_are_refused() {
    let read = |keys: &str| {
        let text = format!(
            r#"bands = ["bessell-V"]
[camera]
kind = "fisheye"
position = "0 0 0 pc"
target = "0 0 -1 pc"
{keys}
"#
        );
        barnard_files::parse("dome.toml", "dome", text, &barnard_files::in_folder(".", DEFAULT_LIMIT)).map_err(|e| e.to_string())
    };
    for (keys, words) in [
        ("aperture = \"361 deg\"", "at most 360 deg"),
        ("aperture = \"-10 deg\"", "above zero"),
        ("aperture = \"nan deg\"", "aperture"),
        ("tilt = \"-1 deg\"", "between 0 and 180 deg"),
        ("tilt = \"181 deg\"", "between 0 and 180 deg"),
        ("field_of_view = \"30 deg\"", "field_of_view"),
    ] {
        let error = read(keys).unwrap_err();
        assert!(error.contains(words), "{keys}: {error}");
    }
    assert!(read("aperture = \"360 deg\"\ntilt = \"180 deg\"").is_ok());
    for camera in [
        scene().camera.clone().with_fisheye_deg(400.0, 0.0),
        scene().camera.clone().with_fisheye_deg(180.0, f64::NAN),
        scene().camera.clone().with_fisheye_deg(0.0, 0.0),
    ] {
        assert!(camera.check().is_err(), "{:?}", camera.projection);
    }
}

/// Eyes of a flat image are two shifted cameras that look straight ahead: what lies at the distance of convergence has one place
/// in both images, and what is nearer lies farther to the right for the left eye.
#[test]
fn pairs_of_flat_images_are_shifted_cameras() {
    let (distance, convergence) = (0.3, 4.0);
    let flat = Camera::look_at(DVec3::new(0.5, 0.2, 6.0), DVec3::ZERO).with_field_of_view_deg(40.0).with_size(64, 36);
    let camera = flat.clone().with_stereo(Stereo::new(distance, convergence));
    let [left, right] = camera.eyes().unwrap();
    for (eye, side) in [(&left, -0.5), (&right, 0.5)] {
        assert!(eye.eyes().is_none() && eye.position.distance(flat.position + side * distance * flat.right) < 1e-15);
        assert!(eye.forward == flat.forward && eye.up == flat.up);
        for (column, row) in [(0.5, 0.5), (32.0, 18.0), (60.0, 3.0)] {
            let ray = flat.ray(column, row);
            let at_window = ray.at(convergence / ray.direction.dot(flat.forward));
            let (x, y) = eye.project(at_window).unwrap();
            assert!((x - column).abs() < 1e-9 && (y - row).abs() < 1e-9, "{x} {y}");
            let seen = eye.ray(column, row);
            assert!(seen.origin == eye.position && seen.direction.cross(at_window - eye.position).length() < 1e-12);
        }
    }
    let near = flat.ray(32.0, 18.0).at(2.0);
    assert!(left.project(near).unwrap().0 > 32.0 + 1.0 && right.project(near).unwrap().0 < 32.0 - 1.0);
    // A part of a pair is a pair of parts.
    let [part, _] = camera.crop(10, 5, 20, 20).unwrap().eyes().unwrap();
    let (a, b) = (part.ray(3.5, 4.5), left.ray(13.5, 9.5));
    assert!(a.origin == b.origin && a.direction.distance(b.direction) < 1e-14);
}

/// In an image of all around, each horizontal direction is seen by two eyes that face it, whose rays cross at the distance of
/// convergence; above one's head both eyes are one; and a place is found where its ray goes.
#[test]
fn eyes_face_every_direction() {
    let (distance, convergence) = (0.4, 3.0);
    let dome = scene().camera.clone();
    for camera in [dome.clone().with_equirectangular(48), dome.clone().with_fisheye_deg(220.0, 30.0), dome.clone().with_cubemap(12)] {
        for convergence in [convergence, f64::INFINITY] {
            let [left, right] = camera.clone().with_stereo(Stereo::new(distance, convergence)).eyes().unwrap();
            let mut faced = 0;
            for (column, row) in (0..camera.width).flat_map(|x| (0..camera.height).map(move |y| (x as f64 + 0.5, y as f64 + 0.5))) {
                if !camera.sees(column, row) {
                    continue;
                }
                let (d, l, r) = (camera.ray(column, row).direction, left.ray(column, row), right.ray(column, row));
                let height = d.dot(dome.up).asin().abs();
                let side = d.cross(dome.up).normalize();
                let apart = r.origin - l.origin;
                if height < 60f64.to_radians() {
                    assert!(apart.distance(distance * side) < 1e-12);
                    faced += 1;
                } else if height > 75f64.to_radians() {
                    assert!(apart.length() == 0.0 && l.direction.distance(d) < 1e-15);
                } else {
                    assert!(apart.length() < distance && apart.cross(side).length() < 1e-12);
                }
                if convergence.is_finite() {
                    let meet = dome.position + convergence * d;
                    assert!([l, r].iter().all(|ray| (meet - ray.origin).cross(ray.direction).length() < 1e-12));
                } else {
                    assert!(l.direction == r.direction);
                }
                for (eye, ray) in [(&left, l), (&right, r)] {
                    let (x, y) = eye.project(ray.at(2.2)).unwrap();
                    // A place of the border is on either side of it.
                    let jumps = (x - column).abs() > 0.5 * camera.width as f64;
                    assert!(jumps || (x - column).hypot(y - row) < 1e-6, "{column} {row}: {x} {y}");
                }
            }
            assert!(faced > 100);
        }
    }
}

/// What a back end renders of two eyes is the image of each, one above the other or beside it.
#[test]
fn both_eyes_are_one_image() {
    let control = Control::default();
    let mono = scene().with_camera(scene().camera.clone().with_equirectangular(24));
    for arrangement in [Arrangement::OverUnder, Arrangement::SideBySide] {
        let stereo = Stereo { arrangement, ..Stereo::new(0.5, 3.0) };
        let both = mono.clone().with_camera(mono.camera.clone().with_stereo(stereo));
        let options = Options::within(DEFAULT_LIMIT);
        let plan = Planner::new(&options).plan(&both, None, &control).unwrap();
        let (image, _) = Renderer::new(&mut cpu::Cpu).render(&plan, &control).unwrap();
        let eyes = both.camera.eyes().unwrap().map(|camera| {
            let mut plan = plan.clone();
            plan.look_from(camera.clone(), &control).unwrap();
            Renderer::new(&mut cpu::Cpu).render(&plan, &control).unwrap().0
        });
        let (w, h) = (24, 12);
        let (wide, high) = if arrangement == Arrangement::OverUnder { (w, 2 * h) } else { (2 * w, h) };
        assert_eq!((image.width, image.height), (wide, high));
        for (row, column) in (0..h).flat_map(|row| (0..w).map(move |column| (row, column))) {
            let other = if arrangement == Arrangement::OverUnder { (row + h, column) } else { (row, column + w) };
            assert_eq!(image.at(0, row, column), eyes[0].at(0, row, column));
            assert_eq!(image.at(0, other.0, other.1), eyes[1].at(0, row, column));
        }
        assert!(eyes[0].samples != eyes[1].samples);
    }
}

/// Eyes that cannot be are refused, in programs as in scene files.
#[test]
fn impossible_eyes_are_refused() {
    let camera = scene().camera.clone();
    for stereo in
        [Stereo::new(0.0, 1.0), Stereo::new(0.1, -1.0), Stereo::new(f64::NAN, 1.0), Stereo { merge: (1.2, 1.0), ..Stereo::new(0.1, 1.0) }]
    {
        assert!(camera.clone().with_stereo(stereo).check().is_err(), "{stereo:?}");
    }
    assert!(camera.clone().with_stereo(Stereo::new(0.1, 1.0)).check().is_ok());
    assert!(
        camera
            .with_orthographic_pc(3.0)
            .with_stereo(Stereo::new(0.1, 1.0))
            .check()
            .unwrap_err()
            .to_string()
            .contains("orthographic camera does not support stereo")
    );
    for (keys, words) in [
        ("eye_distance = \"0 pc\"", "above zero"),
        ("convergence = \"1 pc\"", "eye_distance"),
        ("eye_distance = \"0.1 pc\"\npole_merge = [\"80 deg\", \"70 deg\"]", "ascending"),
        ("eye_distance = \"0.1 pc\"\narrangement = \"anaglyph\"", "over_under"),
        ("eye_distance = \"0.1 pc\"\nfocus = 1", "unknown key"),
    ] {
        let text = format!(
            r#"[camera]
kind = "fisheye"
position = "0 0 4 pc"
[camera.stereo]
{keys}
"#
        );
        let error = barnard_files::parse("eyes.toml", "eyes", text, &barnard_files::in_folder(".", DEFAULT_LIMIT)).unwrap_err().to_string();
        assert!(error.contains(words), "{keys}: {error}");
    }
}

/// The flux of one star, Σ I Ω, and where its light is on the sphere: directions and radiances.
fn star_light(camera: &Camera, towards: DVec3) -> (f64, Vec<(DVec3, f64)>) {
    let star = barnard::scene::Star::blackbody(spectra::units::Temperature(6000.0), spectra::units::Luminosity::suns(1.0));
    let star = star.with_position(camera.position + 5.0 * towards.normalize());
    let band = spectra::passband::Passband::by_name("bessell-V").unwrap();
    let scene = SceneSpec::new(camera.clone()).with_bands(vec![band]).with_star(star).build().unwrap();
    let image = barnard::render_reference(&scene, 1e-4, &Control::default()).unwrap();
    let (mut flux, mut light) = (0.0, Vec::new());
    for (i, value) in image.band(0).enumerate().filter(|(_, value)| *value != 0.0) {
        let (x, y) = ((i % camera.width) as f64 + 0.5, (i / camera.width) as f64 + 0.5);
        assert!(camera.sees(x, y), "light outside of the image's directions at {x} {y}");
        flux += value * camera.pixel_measure(x, y);
        light.push((camera.ray(x, y).direction, value));
    }
    (flux, light)
}

/// Stars keep their flux at seams, poles, edges and corners, and their discs are round on the sphere: radiance is a function of the
/// angle from the star alone.
#[test]
fn stars_keep_their_light_everywhere() {
    let ahead = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z);
    let places = [
        ("ahead", DVec3::new(0.1, 0.2, -1.0)),
        ("seam", DVec3::Z),
        ("seam at 40 deg", DVec3::new(0.0, 40f64.to_radians().tan(), 1.0)),
        ("zenith", DVec3::Y),
        ("nadir", DVec3::NEG_Y),
        ("88 deg", DVec3::new(0.02, 1.0, 0.03)),
        ("edge of a cube", DVec3::new(1.0, 0.3, 1.0)),
        ("another edge", DVec3::new(0.2, 1.0, -1.0)),
        ("corner of a cube", DVec3::new(1.0, 1.0, 1.0)),
        ("another corner", DVec3::new(-1.0, 1.0, -1.0)),
    ];
    let flat = ahead.clone().with_field_of_view_deg(30.0).with_size(201, 201);
    let truth = star_light(&flat, DVec3::new(0.01, 0.02, -1.0)).0;
    let spheres = [
        ("sphere", ahead.clone().with_equirectangular(200)),
        ("cube", ahead.clone().with_cubemap(64)),
        ("full dome", ahead.clone().with_fisheye_deg(360.0, 90.0).with_size(200, 200)),
    ];
    for (name, camera) in &spheres {
        for (place, towards) in places {
            let (flux, light) = star_light(camera, towards);
            assert!((flux / truth - 1.0).abs() < 1e-3, "{name}, {place}: {}", flux / truth);
            // A disc that falls as a raised cosine from 0.65 to 2.2 pixels around the star.
            let (column, row) = camera.project(1e12 * towards).unwrap();
            let step = camera.footprint().per_pc.max(camera.pixel_measure(column, row).sqrt());
            let fall =
                |d: DVec3| 0.5 + 0.5 * (std::f64::consts::PI * ((d.angle_between(towards) / step - 0.65) / 1.55).clamp(0.0, 1.0)).cos();
            let ratios = light.iter().filter(|(d, _)| fall(*d) > 1e-3).map(|(d, radiance)| radiance / fall(*d));
            let (low, high) = ratios.fold((f64::MAX, 0.0f64), |(low, high), ratio| (low.min(ratio), high.max(ratio)));
            assert!(high / low < 1.0 + 1e-3 && light.len() >= 4, "{name}, {place}: {low} {high} of {}", light.len());
        }
    }
    // Half of the light at a border was lost once: so much is seen.
    let cut = ahead.clone().with_equirectangular(200).crop(0, 0, 100, 100).unwrap();
    assert!((star_light(&cut, DVec3::Z).0 / truth - 0.5).abs() < 0.05);
}
