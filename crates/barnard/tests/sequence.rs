//! Sequences: frames are what stills are, whatever was rendered before them, and do not flicker.

use barnard::animation::{Frames, Interpolation, Timeline, Track};
use barnard::backend::Renderer;
use barnard::backend::cpu::Cpu;
use barnard::composite::mean;
use barnard::control::Control;
use barnard::image::{Image, Level, relative_rms};
use barnard::plan::{Choices, Options, Planned, Planner};
use barnard::properties::Value;
use barnard::sequence::{Follower, FrameSettings, Sequence};
use barnard_files::{SceneFile, builtin};

/// A flight around a ragged cloud, past one of two stars; `rest` is said besides.
fn flight(rest: &str) -> SceneFile {
    let text = format!(
        "bands = \"johnson\"
        [camera]
        kind = \"perspective\"
        field_of_view = \"35 deg\"
        size = [48, 32]
        [[camera.path.key]]
        time = \"0 s\"
        position = \"0.4 0.3 4 pc\"
        [[camera.path.key]]
        time = \"1 s\"
        position = \"2.5 0.8 2.2 pc\"
        [[camera.path.key]]
        time = \"2 s\"
        position = \"2.2 0.2 -1.4 pc\"
        [field.cloud]
        kind = \"fbm\"
        seed = 11
        radius = \"1.1 pc\"
        scale = \"0.8 pc\"
        octaves = 3
        [dust]
        density = \"cloud\"
        scale = \"4 mag/pc\"
        law = \"gordon23\"
        albedo = 0.6
        [[star]]
        kind = \"blackbody\"
        position = \"0.2 0.1 0.6 pc\"
        temperature = \"20000 K\"
        luminosity = \"900 Lsun\"
        [[star]]
        kind = \"blackbody\"
        position = \"-0.4 -0.3 0.2 pc\"
        temperature = \"5000 K\"
        luminosity = \"600 Lsun\"
        [sequence]
        frames_per_second = 24
        {rest}"
    );
    SceneFile::parse("flight.toml", "flight", text, builtin::loader(1 << 30)).unwrap()
}

const SAMPLED: &str = "[method]\naccuracy = 0.01\nbake = 48\n";

fn pictured(plan: &Planned) -> Image {
    Renderer::new(&mut Cpu).render(plan, &Control::default()).unwrap().0
}

fn shared(sequence: &Sequence) -> FrameSettings {
    let pilots = sequence.pilots();
    assert!(pilots.len() >= 3);
    FrameSettings::measured(&pilots, |time| sequence.scene(time), &Options::default(), &Control::default()).unwrap()
}

/// The frame at a moment by one who has followed the sequence from its beginning.
fn followed(sequence: &Sequence, choices: &Choices, times: &[f64]) -> Image {
    let mut follower = Follower::new(sequence);
    let (options, control) = (Options::default(), Control::default());
    let mut image = None;
    for time in times {
        let scene = follower.scene(*time, &control).unwrap();
        image = Some(pictured(follower.plan(&scene, &options, choices, &control).unwrap()));
    }
    image.unwrap()
}

/// A frame has the same bits whether others were rendered before it or not: with a camera that moves, with a star that moves
/// and brightens, with dust that becomes more, with light of many scatterings.
#[test]
#[ignore = "long"]
fn frames_do_not_depend_on_those_before() {
    let track = |place: &str, values: &str| {
        format!(
            r#"[[animation]]
of = "{place}"
times = ["0 s", "2 s"]
values = {values}
"#
        )
    };
    let brighter = track("star[0].luminosity", "[\"900 Lsun\", \"90 Lsun\"]");
    let moving = track("star[1].position", "[\"-0.4 -0.3 0.2 pc\", \"0.3 -0.3 0.4 pc\"]");
    let thicker = track("dust.scale", "[\"2 mag/pc\", \"7 mag/pc\"]");
    let bounces = format!("{SAMPLED}bounces = 4\n");
    let gathered = format!("{SAMPLED}exact_stars = 1\n");
    let seeds = track("field.cloud.offset", "[0.1, 0.2]");
    let all = [
        SAMPLED.to_owned(),
        format!("{SAMPLED}{brighter}{moving}"),
        format!("{SAMPLED}{thicker}"),
        format!("{SAMPLED}{seeds}"),
        bounces.clone(),
        format!("{bounces}{brighter}{moving}"),
        format!("{gathered}{moving}"),
    ];
    for rest in all {
        let file = flight(&rest);
        let sequence = file.sequence().unwrap();
        let choices = shared(&sequence).choices;
        let (alone, last) = (followed(&sequence, &choices, &[1.5]), followed(&sequence, &choices, &[0.0, 0.7, 1.5]));
        assert!(alone.samples == last.samples, "{rest}");
        // What is said of them is the same as well.
        assert_eq!((&alone.notes, &alone.keywords, &alone.report), (&last.notes, &last.keywords, &last.report), "{rest}");
        assert!(alone.samples != followed(&sequence, &choices, &[0.7]).samples, "{rest}");
    }
}

/// Frames are the stills of their moments where the scene fixes what pilots choose otherwise, bit by bit; where it does not,
/// both are as exact as they say.
#[test]
fn frames_are_stills() {
    let fixed = "[method]\ncount = 4\nsteps_per_voxel = 1.5\nstar_depth_voxels = 2\nbake = 32\n[display]\nwhite = 1e-6\n";
    for (rest, equal) in [(fixed, true), (SAMPLED, false)] {
        let file = flight(rest);
        let sequence = file.sequence().unwrap();
        let shared = shared(&sequence);
        for time in [0.0, 1.25] {
            let frame = followed(&sequence, &shared.choices, &[time]);
            let scene = sequence.scene(time).unwrap();
            let plan = Planner::new(&Options::default()).plan(&scene, None, &Control::default()).unwrap();
            let still = pictured(&plan);
            let off = (0..3).map(|band| relative_rms(frame.band(band).zip(still.band(band)))).fold(0.0, f64::max);
            assert!(if equal { frame.samples == still.samples } else { off < 0.01 }, "{rest} {time} {off:e}");
            assert_eq!(shared.display(&scene.display).white == scene.display.white, equal);
        }
    }
}

/// A timeline made in Rust shows what the same words of a file do, and can be of no key that defines the animation.
#[test]
fn timelines_are_made_in_rust() {
    let still =
        "bands = \"johnson\"\n[camera]\nkind = \"perspective\"\nposition = \"0 0 5 pc\"\nfield_of_view = \"30 deg\"\nsize = [8, 8]\n[[star]]\nkind = \"blackbody\"
        position = \"0 0 0 pc\"\ntemperature = \"9000 K\"\nluminosity = \"100 Lsun\"\n";
    let words = "[[animation]]\nof = \"star[0].temperature\"\ntimes = [\"0 s\", \"2 s\"]\nvalues = [\"9000 K\", \"30000 K\"]
        interpolation = \"linear\"\n[sequence]\nframes_per_second = 10\nduration = \"3 s\"\n";
    let parse = |text: String| SceneFile::parse("star.toml", "star", text, builtin::loader(1 << 30)).unwrap();
    let (file, animated) = (parse(still.into()), parse(format!("{still}{words}")));
    let kelvin = |number: f64| Value::Quantity(vec![number], "K".into());
    let track = Track::new(vec![(0.0, kelvin(9000.0)), (2.0, kelvin(30_000.0))], Interpolation::Linear).unwrap();
    let timeline = Timeline::new(Frames::new(10.0, 3.0).unwrap());
    let scene = file.scene.clone().with_timeline(timeline.clone().with_track("star[0].temperature", track.clone()).unwrap().into());
    let (made, read) = (Sequence::new(file.tree().clone(), file.loader().clone(), &scene).unwrap(), animated.sequence().unwrap());
    assert_eq!((made.frames().first, made.frames().last()), (read.frames().first, read.frames().last()));
    let physics = |sequence: &Sequence, time: f64| sequence.scene(time).unwrap().parts().physics();
    for time in [0.0, 0.7, 2.5] {
        assert_eq!(physics(&made, time), physics(&read, time), "{time}");
    }
    assert_ne!(physics(&made, 0.7), physics(&made, 0.8));
    for key in ["camera.path", "camera.path.ease", "animation[0].of", "sequence.duration"] {
        assert!(timeline.clone().with_track(key, track.clone()).unwrap_err().to_string().contains("cannot be animated"), "{key}");
    }
    for (per_second, duration) in [(0.0, 1.0), (f64::NAN, 1.0), (25.0, f64::INFINITY), (25.0, -1.0)] {
        assert!(Frames::new(per_second, duration).is_err(), "{per_second} {duration}");
    }
}

/// Pictures of neighbouring frames, by their own levels and steps: how far the second difference of their mean brightness goes,
/// which is what one sees as flicker, of the brightness itself.
fn flicker(pictures: &[Vec<[f64; 3]>]) -> f64 {
    let mean = |picture: &Vec<[f64; 3]>| picture.iter().flatten().sum::<f64>() / (3 * picture.len()) as f64;
    let means: Vec<f64> = pictures.iter().map(mean).collect();
    means.windows(3).map(|m| ((m[0] + m[2]) / 2.0 - m[1]).abs() / m[1]).fold(0.0, f64::max)
}

/// Nothing flickers in a sequence that is shared; each frame for itself, with bands in balance, does.
#[test]
fn held_frames_do_not_flicker() {
    let file = flight("[display]\nbalance = true\n[method]\naccuracy = 0.01\nbake = 48\n");
    let sequence = file.sequence().unwrap();
    let shared = shared(&sequence);
    let mut follower = Follower::new(&sequence);
    let (options, control) = (Options::default(), Control::default());
    let (mut fixed, mut free) = (Vec::new(), Vec::new());
    for i in 0..12 {
        // Stars cover four to nine pixels: a small part of a picture of this size.
        let scene = follower.scene(0.8 + f64::from(i) / 60.0, &control).unwrap();
        let camera = scene.camera.clone().with_size(96, 64);
        let scene = scene.with_camera(camera);
        let image = pictured(follower.plan(&scene, &options, &shared.choices, &control).unwrap());
        fixed.push(shared.display(&scene.display).picture(&image));
        free.push(scene.display.picture(&image));
    }
    let (fixed, free) = (flicker(&fixed), flicker(&free));
    assert!(fixed < 1e-3 && free > 3.0 * fixed, "{fixed:e} {free:e}");
}

/// Levels are the median of what pilot frames ask for, so that one which flies through a star does not darken all others.
#[test]
fn levels_are_the_median_of_the_pilots() {
    let file = flight(SAMPLED);
    let sequence = file.sequence().unwrap();
    let shared = shared(&sequence);
    let Level::Radiance(white) = shared.display.white else { panic!("no white") };
    let white_at = |time: f64| {
        let scene = sequence.scene(time).unwrap();
        let camera = scene.camera.clone().with_supersampling(1);
        let small = scene.with_camera(camera);
        let plan = Planner::new(&Options::default()).plan(&small, None, &Control::default()).unwrap();
        small.display.tone(&pictured(&plan)).white
    };
    let mut whites: Vec<f64> = sequence.pilots().into_iter().map(white_at).collect();
    whites.sort_by(f64::total_cmp);
    assert!(whites.len() == 3 && whites[0] < 0.98 * whites[1] && whites[1] < 0.99 * whites[2], "{whites:?}");
    assert!((white / whites[1] - 1.0).abs() < 2e-3, "{white:e} {whites:?}");
    let through = flight(&format!(
        r#"{SAMPLED}[[animation]]
of = "star[1].position"
times = ["0 s", "1 s", "2 s"]
values = ["-0.4 -0.3 0.2 pc", "2.5 0.8 2.2 pc", "-0.4 -0.3 0.2 pc"]
"#
    ));
    let Level::Radiance(beside) = self::shared(&through.sequence().unwrap()).display.white else { panic!("no white") };
    assert!(beside <= whites[2] * 1.01, "{beside:e} {whites:?}");
}

/// A frame with an open shutter is the mean of its moments, which lie around its own.
#[test]
fn open_shutters_blur() {
    let file = flight(&format!("shutter = \"180 deg\"\nshutter_moments = 4\n{SAMPLED}"));
    let sequence = file.sequence().unwrap();
    let frames = sequence.frames();
    let moments = frames.moments(25);
    let middle = moments.iter().sum::<f64>() / 4.0;
    assert!((middle - 1.0).abs() < 1e-12 && (moments[3] - moments[0] - 0.375 / 24.0).abs() < 1e-12, "{moments:?}");
    let choices = shared(&sequence).choices;
    let images: Vec<Image> = moments.iter().map(|time| followed(&sequence, &choices, &[*time])).collect();
    let blurred = mean(images.iter().cloned().map(Ok::<_, barnard::Error>)).unwrap().unwrap();
    for i in [0, 700, 2000] {
        let mean = images.iter().map(|image| image.samples.at(i)).sum::<f64>() / 4.0;
        assert!((blurred.samples.at(i) - mean).abs() <= 1e-6 * mean);
    }
    let small = Image::bare(1, 1, vec!["a".into()], barnard::image::Samples::Single(vec![1.0]));
    assert!(mean([Ok::<_, barnard::Error>(images[0].clone()), Ok(small)]).is_err() && mean::<barnard::Error>([]).unwrap().is_none());
}
