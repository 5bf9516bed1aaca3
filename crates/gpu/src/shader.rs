//! The source of a shader: constants and bindings printed from a [`Shape`], then `shaders/*.wgsl`.

use barnard::packet::{EULER, EXP_INTEGRAL_LEVELS, EXP_INTEGRAL_TERMS, SERIES_LIMIT};
use barnard::plan::many_lights::near_field_kernel::PROFILE;
use barnard::plan::near::{
    CLOSEST, MAX_PHASES, MAX_PIECES, NEAR_ANGLE, NEAR_FIELD_PIECES, NEAR_VOXELS, PART_DISTANCE, PIECE, PIECE_DEPTH, SHORTEST_PART,
};
use barnard::plan::star_depths::OPAQUE;
use barnard::plan::{END_DEPTH, END_EVERY, Extent, PHASE_RANGE};
use spectra::basis::MAX_SIZE;
use spectra::polynomial::MAX_DEGREE;
use spectra::rule::DepthTable;

use crate::forms::GENTLE;
use crate::layout::{PhaseKind, Shape};
use crate::many_lights;
use crate::tables::Offsets;
use crate::written_out::{Limits, written_out};

/// The files of the march, in the order in which a ray meets them; the form's own follows.
const FILES: [&str; 11] = [
    include_str!("shaders/frame.wgsl"),
    include_str!("shaders/arithmetic.wgsl"),
    include_str!("shaders/coordinates.wgsl"),
    include_str!("shaders/phase.wgsl"),
    include_str!("shaders/cloud.wgsl"),
    include_str!("shaders/volume.wgsl"),
    include_str!("shaders/near.wgsl"),
    include_str!("shaders/near_field.wgsl"),
    include_str!("shaders/field.wgsl"),
    include_str!("shaders/segment.wgsl"),
    include_str!("shaders/march.wgsl"),
];

/// Whether rays pause and go on in a later dispatch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pauses {
    /// Rays never pause.
    Never,
    /// Rays pause before a software adapter stops all loops.
    Software,
}

/// WGSL for a shape, by workgroups of so many rays across and down.
pub fn source(shape: &Shape, offsets: &Offsets, workgroup: (u32, u32), pauses: Pauses) -> String {
    let files = FILES.iter().copied().chain([shape.form.wgsl]);
    let mut limits = limits(shape);
    if shape.form.is_short {
        limits.numbers.push(("STARS_IN_TURN", shape.star_slots.len()));
    }
    let files = files.map(|file| format!("\n{}", written_out(file, &limits)));
    constants(shape, offsets, workgroup, pauses) + &lists(&limits) + &bindings(shape) + &files.collect::<String>()
}

/// What loops run to.
fn limits(shape: &Shape) -> Limits {
    let first_terms = shape.terms.iter().scan(0, |sum, terms| Some(std::mem::replace(sum, *sum + terms)));
    Limits {
        most: 8,
        numbers: vec![
            ("QUADS", shape.quads),
            ("BANDS", shape.bands()),
            ("SCATTERERS", shape.star_slots.len()),
            ("EMITTERS", shape.emitter_slots.len()),
            ("INNER", shape.inner),
            ("INNER_BORDERS", 2 * shape.inner),
            ("SPANS", 1 + 2 * shape.inner),
            ("BRICK_GRIDS", shape.brick_grids),
            ("ELEMENTS", shape.elements()),
        ],
        lists: vec![
            ("TERMS_OF", shape.terms.clone()),
            ("FIRST_TERM", first_terms.collect()),
            ("STAR_SLOTS", shape.star_slots.clone()),
            ("EMITTER_SLOTS", shape.emitter_slots.clone()),
        ],
    }
}

/// Lists as WGSL, none of them empty.
fn lists(limits: &Limits) -> String {
    let list = |(name, entries): &(&str, Vec<usize>)| {
        let entries: Vec<String> = entries.iter().chain(entries.is_empty().then_some(&0)).map(|n| format!("{n}u")).collect();
        format!("const {name} = array<u32, {}>({});\n", entries.len(), entries.join(", "))
    };
    limits.lists.iter().map(list).collect()
}

fn constants(shape: &Shape, offsets: &Offsets, workgroup: (u32, u32), pauses: Pauses) -> String {
    let lights = shape.lights() - 1;
    let kind = |kind: PhaseKind| kind as usize;
    let whole = [
        ("WORKGROUP_X", workgroup.0 as usize),
        ("WORKGROUP_Y", workgroup.1 as usize),
        ("ROOM", shape.room),
        ("BORDERS", 2 + 2 * shape.inner),
        ("VOXEL_KINDS", shape.voxels),
        ("ISOTROPIC", kind(PhaseKind::Isotropic)),
        ("SEPARABLE", kind(PhaseKind::Separable)),
        ("SPECTRAL", kind(PhaseKind::Spectral)),
        ("PHASE_KIND", kind(shape.phase)),
        ("PHASE_STRIDE", shape.phase_stride()),
        ("STARS_IN_TURN", shape.star_slots.len()),
        ("DUST_QUAD", shape.dust.map_or(0, |d| d.0)),
        ("DUST_LANE", shape.dust.map_or(0, |d| d.1)),
        ("FIELD_ELEMENTS", shape.field.map_or(0, |f| f.elements)),
        ("FIELD_POLYNOMIALS", shape.field.map_or(0, |f| f.polynomials)),
        ("FIELD_CHANNELS", shape.field_channels().max(1)),
        ("FIELD_QUAD", shape.field.map_or(0, |f| f.quad)),
        ("SCATTERED_QUAD", shape.scattered_field.unwrap_or(0)),
        ("MANY_LIGHTS", shape.many_lights),
        ("MANY_LIGHTS_STRIDE", many_lights::STAR + shape.room / 4),
        ("MANY_LIGHTS_WEIGHTS", many_lights::STAR),
        ("PROFILE", PROFILE),
        ("NEAR_FIELD_PIECES", NEAR_FIELD_PIECES),
        ("MAX_ELEMENTS", MAX_SIZE),
        ("MAX_EXP_INTEGRALS", MAX_DEGREE + 3),
        ("EXP_INTEGRAL_LEVELS", EXP_INTEGRAL_LEVELS),
        ("EXP_INTEGRAL_TERMS", EXP_INTEGRAL_TERMS),
        ("END_EVERY", END_EVERY),
        ("BAND_TURNS", shape.form.turns.each_band),
        ("TERM_TURNS", shape.form.turns.each_term),
        ("PART_TURNS", 2 + 4 * shape.quads + 2 * lights),
        ("STEP_TURNS", 4 + 4 * shape.quads + shape.brick_grids + 2 * lights + shape.bands() * lights * shape.room / END_EVERY),
    ];
    let real = [
        ("PHASE_RANGE", PHASE_RANGE),
        ("MAX_PHASES", MAX_PHASES as f64),
        ("MAX_PIECES", MAX_PIECES as f64),
        ("NEAR_ANGLE", NEAR_ANGLE),
        ("NEAR_VOXELS", NEAR_VOXELS),
        ("PART_DISTANCE", PART_DISTANCE),
        ("SHORTEST_PART", SHORTEST_PART),
        ("PIECE", PIECE),
        ("PIECE_DEPTH", PIECE_DEPTH),
        ("CLOSEST", CLOSEST),
        ("OPAQUE", OPAQUE),
        ("SERIES_LIMIT", f64::from(SERIES_LIMIT)),
        ("GENTLE", GENTLE),
        ("EULER", f64::from(EULER)),
        ("LOG_THIN", f64::from(DepthTable::THIN)),
        ("LOG_EVEN", f64::from(DepthTable::EVEN)),
        ("CLOSED_GREY", f64::from(Extent::GREY)),
        ("CLOSED_THIN", f64::from(Extent::THIN)),
        ("MAX_DEPTH_STEPS", MAX_DEPTH_STEPS),
        ("END_DEPTH", f64::from(END_DEPTH)),
        ("FAR", 1e30),
        ("TINY", 1e-30),
    ];
    let truth = [
        ("HAS_DUST", shape.dust.is_some()),
        ("HAS_BACKGROUND", shape.background),
        ("HAS_FIELD", shape.field.is_some()),
        ("HAS_SCATTERED_FIELD", shape.scattered_field.is_some()),
        ("HAS_CLOUD", shape.cloud),
        ("STAR_MARCH", shape.star_march),
        ("HAS_MIDDLES", shape.middles),
        ("PAUSES", pauses == Pauses::Software),
    ];
    let whole =
        limits(shape).numbers.into_iter().chain(whole).chain(offsets.iter()).map(|(name, value)| format!("const {name} = {value}u;\n"));
    let real = real.iter().map(|(name, value)| format!("const {name}: f32 = {:e};\n", *value as f32));
    let truth = truth.iter().map(|(name, value)| format!("const {name} = {value};\n"));
    whole.chain(real).chain(truth).collect()
}

/// Most midpoints of a depth next to a star.
const MAX_DEPTH_STEPS: f64 = 64.0;

/// The constants, the textures, and which of them a quad is.
fn bindings(shape: &Shape) -> String {
    let quads = shape.quads;
    let (space, length) = match shape.constants_are_uniform() {
        true => ("uniform", format!(", {}", shape.constants.max(1))),
        false => ("storage, read", String::new()),
    };
    let constants = format!("@group(0) @binding(7) var<{space}> constants: array<vec4f{length}>;\n");
    let texture = |q: usize| format!("@group(1) @binding({q}) var volume_{q}: texture_3d<f32>;\n");
    let read = |q: usize| format!("        case {q}u: {{ return textureSampleLevel(volume_{q}, linear, at, 0.0); }}\n");
    format!(
        "{constants}{}@group(1) @binding({quads}) var linear: sampler;\n\nfn read_quad(q: u32, at: vec3f) -> vec4f {{\n    switch q {{\n{}        default: {{ return textureSampleLevel(volume_0, linear, at, 0.0); }}\n    }}\n}}\n",
        (0..quads).map(texture).collect::<String>(),
        (1..quads).map(read).collect::<String>()
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forms::FORMS;
    use crate::frame::Frame;
    use crate::layout::{FieldShape, Layout, quads};
    use crate::ordinates::{self, ORDINATES, PlaneNumbers, TermNumbers};
    use crate::resolve::{self, DisplayLevels};
    use crate::sweep::{PACK, PackNumbers, SWEEP, SweepNumbers, sweep_source};
    use crate::twins::{plan_of, scene};

    const WORKGROUP: (u32, u32) = (8, 8);

    fn shapes() -> Vec<Shape> {
        let plain = Shape {
            form: FORMS[0],
            quads: 1,
            room: 32,
            terms: vec![2; 3],
            star_slots: vec![1],
            emitter_slots: Vec::new(),
            inner: 0,
            brick_grids: 1,
            voxels: 1,
            phase: PhaseKind::Isotropic,
            dust: Some((0, 0)),
            background: false,
            field: None,
            scattered_field: None,
            many_lights: 0,
            star_march: false,
            cloud: false,
            middles: false,
            constants: 1000,
        };
        let of_forms = FORMS.iter().map(|form| Shape { form, phase: PhaseKind::Spectral, background: true, ..plain.clone() });
        let others = [
            Shape { phase: PhaseKind::Separable, star_march: true, ..plain.clone() },
            Shape {
                phase: PhaseKind::Spectral,
                quads: 3,
                star_slots: (1..7).collect(),
                emitter_slots: vec![7, 8],
                inner: 2,
                ..plain.clone()
            },
            Shape { cloud: true, ..plain.clone() },
            Shape { middles: true, quads: 4, scattered_field: Some(1), emitter_slots: vec![3], ..plain.clone() },
            Shape { quads: 4, scattered_field: Some(1), ..plain.clone() },
            Shape { quads: 4, star_slots: Vec::new(), scattered_field: Some(1), many_lights: 1000, ..plain.clone() },
            Shape { quads: 4, scattered_field: Some(1), many_lights: 9, phase: PhaseKind::Separable, ..plain.clone() },
            Shape { quads: 4, scattered_field: Some(1), many_lights: 9, phase: PhaseKind::Spectral, ..plain.clone() },
            Shape { star_slots: Vec::new(), emitter_slots: vec![0], dust: None, ..plain.clone() },
            Shape { terms: vec![30; 12], room: 512, star_slots: (0..20).map(|s| 1 + s % 3).collect(), constants: 10_000, ..plain.clone() },
            Shape { star_slots: Vec::new(), quads: 3, field: Some(FieldShape { elements: 3, polynomials: 2, quad: 1 }), ..plain.clone() },
        ];
        of_forms.chain(others).collect()
    }

    fn validated(text: &str) -> naga::Module {
        let module = naga::front::wgsl::parse_str(text).unwrap_or_else(|e| panic!("{}", e.emit_to_string(text)));
        let mut validator = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::default());
        if let Err(e) = validator.validate(&module) {
            panic!("{}", e.emit_to_string(text));
        }
        module
    }

    /// Every shape is right WGSL, without any adapter.
    #[test]
    fn shaders_are_valid() {
        let offsets = offsets();
        for shape in shapes() {
            for pauses in [Pauses::Never, Pauses::Software] {
                validated(&source(&shape, &offsets, WORKGROUP, pauses));
            }
        }
    }

    /// Names and places of the fields of a struct in WGSL, and its size.
    fn fields(module: &naga::Module, name: &str) -> (Vec<(String, usize)>, usize) {
        let found = module.types.iter().find_map(|(_, t)| match &t.inner {
            naga::TypeInner::Struct { members, span } if t.name.as_deref() == Some(name) => Some((members, *span)),
            _ => None,
        });
        let (members, span) = found.unwrap();
        (members.iter().map(|m| (m.name.clone().unwrap_or_default(), m.offset as usize)).collect(), span as usize)
    }

    /// The structs that Rust writes are those that WGSL reads, field by field.
    #[test]
    fn structs_agree() {
        macro_rules! ours {
            ($kind:ty: $($field:ident),*) => {
                (vec![$((stringify!($field).to_owned(), std::mem::offset_of!($kind, $field))),*], size_of::<$kind>())
            };
        }
        let frame = ours!(Frame: middle, across, upwards, forward, turn_x, turn_y, low, high, steps, limits, jitter, size, strip, counts, depths, seeds);
        assert_eq!(frame, fields(&validated(&source(&shapes()[0], &offsets(), WORKGROUP, Pauses::Never)), "Frame"));
        let sweep = ours!(SweepNumbers: apex, along_u, along_v, along_w, star, slopes, edge, sides, counts, dims, strides);
        assert_eq!(sweep, fields(&validated(&sweep_source()), "Sweep"));
        assert_eq!(ours!(PackNumbers: dims, scale), fields(&validated(PACK), "Pack"));
        let ordinates = validated(&ordinates::source(36, 9));
        assert_eq!(ours!(TermNumbers: k, around, factor, cells, glows, least, nothing), fields(&ordinates, "Terms"));
        assert_eq!(ours!(PlaneNumbers: first, before, column, row, columns, rows, beams, half), fields(&ordinates, "Plane"));
        let display = ours!(DisplayLevels: levels, size);
        assert_eq!(display, fields(&validated(resolve::SOURCE), "Display"));
    }

    /// The Rust file of a twin's module, as deep as its path names modules, and what is left of the path: a function,
    /// or a type and its method.
    fn module_of(twin: &str) -> (std::path::PathBuf, Vec<&str>) {
        let mut parts: std::collections::VecDeque<&str> = twin.split("::").collect();
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let mut folder = root.join(parts.pop_front().unwrap()).join("src");
        let mut file = folder.join("lib.rs");
        while let Some(part) = parts.front() {
            let (own, inner) = (folder.join(format!("{part}.rs")), folder.join(part).join("mod.rs"));
            if own.exists() {
                (file, folder) = (own, folder.join(part));
            } else if inner.exists() {
                (file, folder) = (inner, folder.join(part));
            } else {
                break;
            }
            parts.pop_front();
        }
        (file, parts.into())
    }

    /// The texts of a module's file, and of those beside it where the module is a folder that names them again.
    fn sources_of(file: &std::path::Path) -> Vec<String> {
        let read = |path: &std::path::Path| std::fs::read_to_string(path).unwrap();
        if !file.ends_with("mod.rs") {
            return vec![read(file)];
        }
        let (mut sources, mut folders) = (Vec::new(), vec![file.parent().unwrap().to_owned()]);
        while let Some(folder) = folders.pop() {
            for path in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
                if path.is_dir() { folders.push(path) } else { sources.push(read(&path)) }
            }
        }
        sources
    }

    /// Whether a path such as `barnard::plan::near::pieces` leads to a function.
    fn is_there(twin: &str) -> bool {
        let (file, rest) = module_of(twin);
        let has = |source: &str, name: &str| source.contains(&format!("fn {name}(")) || source.contains(&format!("fn {name}<"));
        sources_of(&file).iter().any(|source| match rest[..] {
            // A function of its own, not a method.
            [name] => source.lines().any(|line| !line.starts_with(' ') && has(line, name)),
            [owner, name] => {
                let owns = |line: &str| line.starts_with("impl") && line.split(|c: char| !c.is_alphanumeric()).any(|word| word == owner);
                has(source, name) && source.lines().any(owns)
            }
            _ => false,
        })
    }

    /// Where the sections of some plan's tables start: shaders need their names, whatever the plan.
    fn offsets() -> Offsets {
        let plan = plan_of(&scene(8, ""));
        Layout::new(&plan, quads(&plan, 0), false).unwrap().offsets
    }

    /// Each function of a shader that repeats one in Rust, with the path of that: (function, path).
    fn twins() -> Vec<(&'static str, &'static str)> {
        let files = FILES.iter().copied().chain(FORMS.iter().map(|f| f.wgsl)).chain([resolve::SOURCE, SWEEP, PACK, ORDINATES]);
        let of_file = |file: &'static str| {
            file.split("// twin: ").skip(1).map(|after| {
                let (path, below) = after.split_once('\n').unwrap();
                let name = below.split_once("fn ").unwrap().1.split('(').next().unwrap();
                (name, path)
            })
        };
        files.flat_map(of_file).collect()
    }

    /// Functions of shaders that are compared with their twins by a picture, a sweep or colours, which they make
    /// together, and the tests that do it; all others are called by the tests of `twins.rs`.
    const COMPARED_TOGETHER: [(&str, &[&str]); 7] = [
        ("each_part_is_that_of_the_processor", &["scatter", "scatter_again", "segment", "near"]),
        ("every_method_is_that_of_the_processor", &["accumulate_field", "resolve_field"]),
        ("many_lights_are_those_of_the_processor", &["depth_within", "scatter_near_star"]),
        ("tuning_changes_nothing", &["ended"]),
        ("passes_settle", &["stretched", "stretched_rgb", "srgb_encode"]),
        ("a_star_moves_on_the_device", &["match_mean", "along_x", "gain", "enters", "cubic", "collect"]),
        ("orders_are_those_of_the_processor", &["shares", "sweep"]),
    ];
    /// Functions that a function which `twins.rs` calls is made of: (part, whole).
    const PARTS: [(&str, &str); 4] =
        [("hash", "simplex"), ("noise_corner", "simplex"), ("mean_coordinates", "accumulate"), ("mean_left", "accumulate")];

    /// Every twin is compared by numbers: a test calls it, or makes something by it.
    #[test]
    fn twins_are_compared() {
        let own = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
        let tests = ["src/twins.rs", "tests/pictures/parts.rs", "tests/pictures/changes.rs", "tests/ordinates.rs"]
            .map(|f| std::fs::read_to_string(own.join(f)).unwrap());
        let called = |name: &str| tests[0].contains(&format!("{name}("));
        let is_compared = |name: &str| {
            let by_whole = PARTS.iter().any(|(part, whole)| *part == name && called(whole));
            let together = COMPARED_TOGETHER.iter().find(|(_, functions)| functions.contains(&name));
            called(name) || by_whole || together.is_some_and(|(test, _)| tests.iter().any(|t| t.contains(&format!("fn {test}()"))))
        };
        let alone: Vec<_> = twins().into_iter().filter(|(name, _)| !is_compared(name)).collect();
        assert!(alone.is_empty(), "{alone:?} are compared with nothing");
        assert!(!is_compared("march_span") && !is_compared("frustum"));
    }

    /// Every function of a shader that repeats one in Rust says which, by its whole path; those are there.
    #[test]
    fn twins_are_named() {
        let twins: Vec<&str> = twins().into_iter().map(|(_, path)| path).collect();
        assert!(twins.len() >= 20, "{twins:?}");
        let lost: Vec<&&str> = twins.iter().filter(|twin| !is_there(twin)).collect();
        assert!(lost.is_empty(), "{lost:?}");
        // A function that stands elsewhere is no twin.
        for wrong in [
            "barnard::plan::near::scatter_again",
            "barnard::backend::cpu::near_field::scatter",
            "barnard::plan::window::pieces",
            "barnard::plan::SpectralPlan::voxel_along",
        ] {
            assert!(!is_there(wrong), "{wrong}");
        }
    }
}
