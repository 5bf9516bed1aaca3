//! The constants of a shader, printed: what a shape comes to, where tables start, and the limits of the processor's march.

use barnard::backend::cpu::EVEN_FRONT;
use barnard::camera::panorama;
use barnard::detail::NORM;
use barnard::packet::{EULER, EXP_INTEGRAL_LEVELS, EXP_INTEGRAL_TERMS, SERIES_LIMIT};
use barnard::plan::many_lights::near_field_kernel::PROFILE;
use barnard::plan::near::{
    CLOSEST, MAX_PHASES, MAX_PIECES, NEAR_ANGLE, NEAR_FIELD_PIECES, NEAR_VOXELS, PART_DISTANCE, PIECE, PIECE_DEPTH, SHORTEST_PART,
};
use barnard::plan::star_depths::OPAQUE;
use barnard::plan::{END_DEPTH, END_EVERY, Extent, PHASE_RANGE};
use barnard::volume::PAGE;
use spectra::basis::MAX_SIZE;
use spectra::polynomial::MAX_DEGREE;
use spectra::rule::DepthTable;

use crate::forms::GENTLE;
use crate::many_lights;
use crate::shape::{PhaseKind, ShaderShape, Sight};
use crate::tables::Offsets;
use crate::written_out::{Limits, MOST_TURNS};

/// Most midpoints of a depth next to a star.
const MAX_DEPTH_STEPS: f64 = 64.0;

/// True if rays pause and go on in a later dispatch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pauses {
    /// Rays never pause.
    Never,
    /// Rays pause before a software adapter stops all loops.
    Software,
}

/// Bounds of loops.
pub fn limits(shape: &ShaderShape) -> Limits {
    let first_terms = shape.terms.iter().scan(0, |sum, terms| Some(std::mem::replace(sum, *sum + terms)));
    Limits {
        most: MOST_TURNS,
        numbers: vec![
            ("QUADS", shape.quads),
            ("BANDS", shape.bands()),
            ("SUMS", shape.sums()),
            ("SUMMED_LIGHTS", if shape.shared { shape.shining() } else { 0 }),
            ("SETS", if shape.shared { 1 } else { shape.bands() }),
            ("SCATTERERS", shape.star_slots.len()),
            ("EMITTERS", shape.emitter_slots.len()),
            ("INNER", shape.inner),
            ("INNER_BORDERS", 2 * shape.inner),
            ("SPANS", 1 + 2 * shape.inner),
            ("BRICK_GRIDS", shape.brick_grids),
            ("ELEMENTS", shape.elements()),
            ("DETAIL_OCTAVES", shape.detail),
        ],
        lists: vec![
            ("TERMS_OF", shape.terms.clone()),
            ("FIRST_TERM", first_terms.collect()),
            ("STAR_SLOTS", shape.star_slots.clone()),
            ("EMITTER_SLOTS", shape.emitter_slots.clone()),
            ("FRONTED", shape.fronted.iter().map(|is| usize::from(*is)).collect()),
        ],
    }
}

/// Whole numbers of the march.
fn integers(shape: &ShaderShape, workgroup: (u32, u32)) -> [(&'static str, usize); 40] {
    let lights = shape.lights() - 1;
    let kind = |kind: PhaseKind| kind as usize;
    let sight = |sight: Sight| sight as usize;
    [
        ("WORKGROUP_X", workgroup.0 as usize),
        ("WORKGROUP_Y", workgroup.1 as usize),
        ("ROOM", shape.room),
        ("BORDERS", 2 + 2 * shape.inner),
        ("VOXEL_KINDS", shape.voxels),
        ("PLANE", sight(Sight::Plane)),
        ("DOME", sight(Sight::Dome)),
        ("SPHERE", sight(Sight::Sphere)),
        ("CUBE", sight(Sight::Cube)),
        ("SIGHT", sight(shape.sight)),
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
        ("FRONT_SLOT", shape.front.unwrap_or(0)),
        ("SCATTERED_QUAD", shape.scattered_field.unwrap_or(0)),
        ("MANY_LIGHTS", shape.many_lights),
        ("MANY_LIGHTS_STRIDE", many_lights::STAR + shape.room / 4),
        ("MANY_LIGHTS_WEIGHTS", many_lights::STAR),
        ("PROFILE", PROFILE),
        ("PAGE", PAGE),
        ("DETAIL_OCTAVE", 6),
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
    ]
}

/// Real numbers of the march.
fn reals() -> [(&'static str, f64); 25] {
    [
        ("EVEN_FRONT", f64::from(EVEN_FRONT)),
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
        ("DETAIL_NORM", NORM),
        ("EULER", f64::from(EULER)),
        ("LOG_THIN", f64::from(DepthTable::THIN)),
        ("LOG_EVEN", f64::from(DepthTable::EVEN)),
        ("CLOSED_GREY", f64::from(Extent::GREY)),
        ("CLOSED_THIN", f64::from(Extent::THIN)),
        ("MAX_DEPTH_STEPS", MAX_DEPTH_STEPS),
        ("END_DEPTH", f64::from(END_DEPTH)),
        ("HALF_PI", std::f64::consts::FRAC_PI_2),
        ("FAR", 1e30),
        ("TINY", 1e-30),
    ]
}

/// A line for each constant of the march.
pub fn constants(shape: &ShaderShape, offsets: &Offsets, workgroup: (u32, u32), pauses: Pauses) -> String {
    let truth = [
        ("SHARED", shape.shared),
        ("SUMS_IN_REGISTERS", shape.sums_in_registers()),
        ("HAS_DUST", shape.dust.is_some()),
        ("HAS_BACKGROUND", shape.background),
        ("HAS_FIELD", shape.field.is_some()),
        ("HAS_SCATTERED_FIELD", shape.scattered_field.is_some()),
        ("HAS_FRONT", shape.front.is_some()),
        ("HAS_CLOUD", shape.cloud),
        ("HAS_DETAIL", shape.detail > 0),
        ("STAR_MARCH", shape.star_march),
        ("HAS_MIDDLES", shape.middles),
        ("PAUSES", pauses == Pauses::Software),
    ];
    let whole = limits(shape)
        .numbers
        .into_iter()
        .chain(integers(shape, workgroup))
        .chain(offsets.iter())
        .map(|(name, value)| format!("const {name} = {value}u;\n"));
    let real = reals().into_iter().map(|(name, value)| format!("const {name}: f32 = {:e};\n", value as f32));
    let truth = truth.iter().map(|(name, value)| format!("const {name} = {value};\n"));
    whole.chain(real).chain(truth).chain([cube()]).collect()
}

/// The axes of each face of a cube, ahead, to the right and upwards, of those of the image.
fn cube() -> String {
    let axis = |axis: (f64, usize)| {
        let component = |i: usize| if i == axis.1 { axis.0 } else { 0.0 };
        format!("vec3f({:?}, {:?}, {:?})", component(0), component(1), component(2))
    };
    let axes: Vec<String> = panorama::CUBE.iter().flatten().map(|a| axis(*a)).collect();
    format!(
        "const CUBE_AXES = array<vec3f, {}>({});\nconst CUBE_FACES: f32 = {:?};\n",
        axes.len(),
        axes.join(", "),
        panorama::CUBE.len() as f64
    )
}
