//! The source of a shader: constants and bindings printed from a [`ShaderShape`], then `shaders/*.wgsl`.

use crate::shader_constants::{Pauses, constants, limits};
use crate::shape::ShaderShape;
use crate::tables::Offsets;
use crate::written_out::{Limits, written_out};

/// The files of the march, in the order in which a ray meets them; the form's own follows.
const FILES: [&str; 12] = [
    include_str!("shaders/frame.wgsl"),
    include_str!("shaders/arithmetic.wgsl"),
    include_str!("shaders/coordinates.wgsl"),
    include_str!("shaders/phase.wgsl"),
    include_str!("shaders/cloud.wgsl"),
    include_str!("shaders/volume.wgsl"),
    include_str!("shaders/detail.wgsl"),
    include_str!("shaders/near.wgsl"),
    include_str!("shaders/near_field.wgsl"),
    include_str!("shaders/field.wgsl"),
    include_str!("shaders/segment.wgsl"),
    include_str!("shaders/march.wgsl"),
];

/// WGSL for a shape, by workgroups of a given number of rays across and down.
pub fn source(shape: &ShaderShape, offsets: &Offsets, workgroup: (u32, u32), pauses: Pauses) -> String {
    let files = FILES.iter().copied().chain([shape.form.wgsl]);
    let mut limits = limits(shape);
    if shape.form.is_short {
        limits.numbers.push(("STARS_IN_TURN", shape.star_slots.len()));
    }
    let files = files.map(|file| format!("\n{}", written_out(file, &limits)));
    constants(shape, offsets, workgroup, pauses) + &lists(&limits) + &bindings(shape) + &files.collect::<String>()
}

/// Lists as WGSL, none of them empty.
fn lists(limits: &Limits) -> String {
    let list = |(name, entries): &(&str, Vec<usize>)| {
        let entries: Vec<String> = entries.iter().chain(entries.is_empty().then_some(&0)).map(|n| format!("{n}u")).collect();
        format!("const {name} = array<u32, {}>({});\n", entries.len(), entries.join(", "))
    };
    limits.lists.iter().map(list).collect()
}

/// The constants, the textures, and which of them a quad is.
fn bindings(shape: &ShaderShape) -> String {
    let quads = shape.quads;
    let (space, length) = match shape.constants_are_uniform() {
        true => ("uniform", format!(", {}", shape.constants.max(1))),
        false => ("storage, read", String::new()),
    };
    let constants = format!("@group(0) @binding(7) var<{space}> constants: array<vec4f{length}>;\n");
    let texture = |q: usize| format!("@group(1) @binding({q}) var volume_{q}: texture_3d<f32>;\n");
    let is_paged = |q: usize| shape.paged.get(q) == Some(&true);
    let place = |q: usize| match is_paged(q) {
        true => format!("in_atlas(at, {}u)", (0..q).filter(|q| is_paged(*q)).count()),
        false => "at".to_owned(),
    };
    let read = |q: usize| format!("{{ return textureSampleLevel(volume_{q}, linear, {}, 0.0); }}\n", place(q));
    format!(
        "{constants}{}@group(1) @binding({quads}) var linear: sampler;\n\nfn read_quad(q: u32, at: vec3f) -> vec4f {{\n    switch q {{\n{}        default: {}    }}\n}}\n",
        (0..quads).map(texture).collect::<String>(),
        (1..quads).map(|q| format!("        case {q}u: {}", read(q))).collect::<String>(),
        read(0)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::{plan_of, scene};
    use crate::forms::FORMS;
    use crate::frame::FrameConstants;
    use crate::layout::{ShaderLayout, quads};
    use crate::ordinates::{self, ORDINATES, PlaneNumbers, TermNumbers};
    use crate::ray_tracer::{self, GenerationNumbers, RAY_TRACER, RayNumbers, StarNumbers};
    use crate::resolve::{self, DisplayLevels};
    use crate::shape::{FieldShape, PhaseKind, Sight};
    use crate::sweep::{PACK, PackNumbers, SWEEP, SweepNumbers, sweep_source};

    const WORKGROUP: (u32, u32) = (8, 8);

    fn shapes() -> Vec<ShaderShape> {
        let plain = ShaderShape {
            sight: Sight::Plane,
            form: FORMS[0],
            quads: 1,
            room: 32,
            terms: vec![2; 3],
            shared: false,
            star_slots: vec![1],
            emitter_slots: Vec::new(),
            front: None,
            fronted: Vec::new(),
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
            detail: 0,
            middles: false,
            paged: vec![false],
            constants: 1000,
        };
        let of_forms = FORMS.iter().map(|form| ShaderShape { form, phase: PhaseKind::Spectral, background: true, ..plain.clone() });
        let others = [
            ShaderShape { phase: PhaseKind::Separable, star_march: true, ..plain.clone() },
            ShaderShape { sight: Sight::Dome, ..plain.clone() },
            ShaderShape { sight: Sight::Sphere, background: true, ..plain.clone() },
            ShaderShape { sight: Sight::Cube, ..plain.clone() },
            ShaderShape {
                phase: PhaseKind::Spectral,
                quads: 3,
                star_slots: (1..7).collect(),
                emitter_slots: vec![7, 8],
                front: Some(9),
                fronted: vec![false, true],
                inner: 2,
                ..plain.clone()
            },
            ShaderShape { cloud: true, ..plain.clone() },
            ShaderShape { detail: 4, quads: 3, emitter_slots: vec![9], fronted: vec![false], ..plain.clone() },
            ShaderShape { quads: 3, paged: vec![true, false, true], ..plain.clone() },
            ShaderShape {
                middles: true,
                quads: 4,
                scattered_field: Some(1),
                emitter_slots: vec![3],
                front: Some(2),
                fronted: vec![true],
                ..plain.clone()
            },
            ShaderShape { quads: 4, scattered_field: Some(1), ..plain.clone() },
            ShaderShape { quads: 4, star_slots: Vec::new(), scattered_field: Some(1), many_lights: 1000, ..plain.clone() },
            ShaderShape { quads: 4, scattered_field: Some(1), many_lights: 9, phase: PhaseKind::Separable, ..plain.clone() },
            ShaderShape { quads: 4, scattered_field: Some(1), many_lights: 9, phase: PhaseKind::Spectral, ..plain.clone() },
            ShaderShape { star_slots: Vec::new(), emitter_slots: vec![0], fronted: vec![false], dust: None, ..plain.clone() },
            ShaderShape {
                terms: vec![30; 12],
                room: 512,
                star_slots: (0..20).map(|s| 1 + s % 3).collect(),
                constants: 10_000,
                ..plain.clone()
            },
            ShaderShape {
                star_slots: Vec::new(),
                quads: 3,
                field: Some(FieldShape { elements: 3, polynomials: 2, quad: 1 }),
                ..plain.clone()
            },
        ];
        let of_forms = of_forms.map(|shape| match shape.form.name {
            "common_nodes" => ShaderShape { terms: vec![12, 0, 0], shared: true, ..shape },
            _ => shape,
        });
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

    /// The condition of each `while` of the march, and why it ends.
    const WHILES: [(&str, &str); 4] = [
        ("(*state).step < steps", "a turn adds one or more to the step, or reads what the next needs to do so"),
        ("(*state).part < count", "a turn adds one to the part, or reads what the next needs to do so, or leaves"),
        ("(*state).span < SPANS", "a turn adds one to the span, or leaves"),
        ("n < frame.depths.y", "a turn adds one to n"),
    ];

    /// Loop errors of a text: each must count by one to where it ends, by a number that nothing else in it
    /// sets, or be one of [`WHILES`].
    fn endless(text: &str) -> Vec<String> {
        let lines: Vec<&str> = text.lines().collect();
        let mut found = Vec::new();
        for (at, line) in lines.iter().enumerate() {
            let (line, indent) = (line.trim_start(), line.len() - line.trim_start().len());
            let ends = if let Some(head) = line.strip_prefix("for (var ") {
                let name = head.split(' ').next().unwrap();
                let inner = head.split(';').nth(2).unwrap().split(") {").next().unwrap().trim();
                let counts = ["++", "--", " += 1.0", " -= 1.0"].iter().any(|step| inner == format!("{name}{step}"));
                let condition = head.split(';').nth(1).unwrap().trim();
                let (up, down) = (inner.contains('+'), inner.contains('-'));
                let meets = up && [" < ", " <= "].iter().any(|than| condition.starts_with(&format!("{name}{than}")))
                    || down && [" > 0u", " >= 1.0"].iter().any(|than| condition == format!("{name}{than}"));
                let body = lines[at + 1..].iter().take_while(|l| l.trim().is_empty() || l.len() - l.trim_start().len() > indent);
                let sets = |l: &&&str| {
                    let l = format!(" {l}");
                    let is_set = |set: &str| [" ", "{"].iter().any(|before| l.contains(&format!("{before}{name}{set}")));
                    [" = ", " += ", " -= ", "++", "--"].into_iter().any(is_set) || l.contains(&format!("&{name},"))
                };
                counts && meets && body.filter(sets).count() == 0
            } else if let Some(head) = line.strip_prefix("while ") {
                WHILES.iter().any(|(condition, _)| head == format!("{condition} {{"))
            } else {
                !line.starts_with("loop")
            };
            if !ends {
                found.push(line.to_owned());
            }
        }
        found
    }

    /// No loop of the march needs a counter that ends it.
    #[test]
    fn loops_end() {
        let texts = FILES.iter().copied().chain(FORMS.iter().map(|form| form.wgsl));
        let found: Vec<String> = texts.flat_map(endless).collect();
        assert!(found.is_empty(), "{found:?}");
        let all: String = FILES.concat();
        assert!(WHILES.iter().all(|(condition, _)| all.contains(&format!("while {condition} {{"))));
        for wrong in [
            "loop {\n}",
            "while true {\n}",
            "for (var i = 0u; i < 3u; i += 2u) {\n}",
            "for (var i = 0u; i < 3u; i++) {\n    if x {\n        i = 0u;\n    }\n}",
            "for (var i = 0u; i < 3u; i++) {\n    if x { i = 0u; }\n}",
            "for (var i = 3u; i >= 0u; i--) {\n}",
            "for (var i = 3u; i > 0u; i++) {\n}",
        ] {
            assert_eq!(endless(wrong).len(), 1, "{wrong}");
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
        let frame = ours!(FrameConstants: middle, across, upwards, forward, turn_x, turn_y, low, high, steps, limits, jitter, size, strip, counts, depths, seeds);
        assert_eq!(frame, fields(&validated(&source(&shapes()[0], &offsets(), WORKGROUP, Pauses::Never)), "Frame"));
        let sweep = ours!(SweepNumbers: apex, along_u, along_v, along_w, star, slopes, edge, sides, counts, dims, strides);
        assert_eq!(sweep, fields(&validated(&sweep_source()), "Sweep"));
        assert_eq!(ours!(PackNumbers: dims, scale), fields(&validated(PACK), "Pack"));
        let ordinates = validated(&ordinates::source(36, 9));
        assert_eq!(ours!(TermNumbers: k, around, factor, cells, glows, least, nothing), fields(&ordinates, "Terms"));
        assert_eq!(ours!(PlaneNumbers: first, before, column, row, columns, rows, beams, half), fields(&ordinates, "Plane"));
        let ray_tracer = validated(&ray_tracer::source());
        assert_eq!(ours!(StarNumbers: place, edges, scales, dims, counts), fields(&ray_tracer, "Star"));
        assert_eq!(ours!(GenerationNumbers: number), fields(&ray_tracer, "Generation"));
        assert_eq!(ours!(RayNumbers: photons, way, patch_of), fields(&ray_tracer, "Ray"));
        let display = ours!(DisplayLevels: levels, size);
        assert_eq!(display, fields(&validated(resolve::SOURCE), "Display"));
    }

    /// The Rust file of a twin's module, as deep as its path names modules, and what is left of the path: a function,
    /// or a type and its method.
    fn module_of(twin: &str) -> (std::path::PathBuf, Vec<&str>) {
        let mut parts: std::collections::VecDeque<&str> = twin.split("::").collect();
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let package = parts.pop_front().unwrap();
        let mut folder = root.join(package.strip_prefix("barnard_").unwrap_or(package)).join("src");
        let mut file = folder.join("lib.rs");
        while let Some(part) = parts.front() {
            let (beside, inner) = (folder.join(format!("{part}.rs")), folder.join(part).join("mod.rs"));
            if beside.exists() {
                (file, folder) = (beside, folder.join(part));
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

    /// A source with the functions within `simd!` at the margin.
    fn unwrapped(source: &str) -> String {
        let mut is_within = false;
        let line = |line: &'_ str| {
            is_within = (is_within || line == "simd! {") && line != "}";
            line.strip_prefix("    ").filter(|_| is_within).unwrap_or(line).to_owned() + "\n"
        };
        source.lines().map(line).collect()
    }

    /// True if a path such as `barnard::plan::near::pieces` leads to a function.
    fn is_there(twin: &str) -> bool {
        let (file, rest) = module_of(twin);
        let has = |source: &str, name: &str| source.contains(&format!("fn {name}(")) || source.contains(&format!("fn {name}<"));
        sources_of(&file).iter().any(|source| match rest[..] {
            // A function of its own, not a method.
            [name] => unwrapped(source).lines().any(|line| !line.starts_with(' ') && has(line, name)),
            [owner, name] => {
                let owns = |line: &str| line.starts_with("impl") && line.split(|c: char| !c.is_alphanumeric()).any(|word| word == owner);
                has(source, name) && source.lines().any(owns)
            }
            _ => false,
        })
    }

    /// Offsets of the sections of a plan's tables: shaders need their names, whatever the plan.
    fn offsets() -> Offsets {
        let plan = plan_of(&scene(8, ""));
        ShaderLayout::new(&plan, quads(&plan, 0), false).unwrap().offsets
    }

    /// Each function of a shader that repeats one in Rust, with the path of that: (function, path).
    fn twins() -> Vec<(&'static str, &'static str)> {
        let files = FILES.iter().copied().chain(FORMS.iter().map(|f| f.wgsl)).chain([resolve::SOURCE, SWEEP, PACK, ORDINATES, RAY_TRACER]);
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
    /// together, and the tests that do it; all others are called by the tests of `twins`.
    const COMPARED_TOGETHER: [(&str, &[&str]); 8] = [
        ("each_part_is_that_of_the_processor", &["scatter", "scatter_again", "segment", "near", "in_atlas"]),
        ("every_method_is_that_of_the_processor", &["accumulate_field", "resolve_field"]),
        ("many_lights_are_those_of_the_processor", &["depth_within", "scatter_near_star"]),
        ("tuning_changes_nothing", &["ended"]),
        ("passes_settle", &["stretched", "stretched_rgb", "srgb_encode"]),
        ("a_star_moves_on_the_device", &["match_mean", "along_x", "gain", "enters", "cubic", "collect"]),
        ("orders_are_those_of_the_processor", &["shares", "sweep"]),
        ("turns_are_those_of_the_processor", &["met", "square", "meet", "add_area", "absorbing", "cross_voxel", "follow", "sum_up"]),
    ];
    /// Functions that a function which `twins` calls is made of: (part, whole).
    const PARTS: [(&str, &str); 9] = [
        ("hash", "simplex"),
        ("noise_corner", "simplex"),
        ("mean_coordinates", "accumulate"),
        ("mean_left", "accumulate"),
        ("detail_hash", "detail_noise"),
        ("detail_corner", "detail_noise"),
        ("image_place", "camera_ray"),
        ("panorama_direction", "camera_ray"),
        ("eye_offset", "camera_ray"),
    ];

    /// Every twin is compared by numbers: a test calls it, or makes something by it.
    #[test]
    fn twins_are_compared() {
        let crate_folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
        let tests = [
            "src/twins/mod.rs",
            "src/twins/arithmetic.rs",
            "src/twins/space.rs",
            "tests/pictures/parts.rs",
            "tests/pictures/changes.rs",
            "tests/ordinates.rs",
            "tests/ray_tracer.rs",
        ]
        .map(|f| std::fs::read_to_string(crate_folder.join(f)).unwrap());
        let called = |name: &str| tests[..3].iter().any(|twins| twins.contains(&format!("{name}(")));
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
