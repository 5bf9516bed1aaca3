// What changes from picture to picture; all places are seen from the middle of the scene [pc].

struct Frame {
    // Where the ray through the image's middle starts, and how far the observer stands behind it.
    middle: vec4f,
    // What the origin and the direction change by across half the image, rightwards and upwards. In an image of all around
    // the axes of the image, with up behind them; the image's middle from its axis of view, half its width and the angle to
    // its circle; how far one of two eyes stands aside, the inverse of where both converge, and heights between which they
    // become one.
    across: vec4f,
    upwards: vec4f,
    forward: vec4f,
    turn_x: vec4f,
    turn_y: vec4f,
    // The box of everything that absorbs, scatters or glows.
    low: vec4f,
    high: vec4f,
    // Samples a voxel, or on every ray if not zero; the finest voxel [pc]; the angle over which the phase function
    // changes little.
    steps: vec4f,
    // Smallest extinction, what may be left out behind a ray's end, largest dust, largest extinction.
    limits: vec4f,
    // Where in its pixel a ray goes, and in which part of a step it starts, or none if negative; what this picture
    // counts beside those before it.
    jitter: vec4f,
    // Pixels along a row, rows, turns of loops before a ray pauses, and whether rays go on where they paused.
    size: vec4u,
    // First row and how many; first row that the picture holds and how many.
    strip: vec4u,
    // Terms; entries of the phase table, and the quad where it starts; samples of a star depth that is marched again.
    counts: vec4u,
    // The largest star depth, where a light field stands in place of all of them; turns by which a loop shows that it
    // turns.
    depths: vec4f,
    // Numbers of the noise that dust is, and of those that bend space along x, y and z.
    seeds: vec4u,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> tables: array<vec4f>;
// The same, number by number.
@group(0) @binding(2) var<storage, read> numbers: array<f32>;
@group(0) @binding(3) var<storage, read> brick_distances: array<u32>;
@group(0) @binding(4) var<storage, read_write> picture: array<f32>;
// The largest depth met, whether a ray paused, and whether one paused too late.
@group(0) @binding(5) var<storage, read_write> stats: array<atomic<u32>>;
// Rays that pause, number × ray.
@group(0) @binding(6) var<storage, read_write> paused: array<f32>;

// Turns of loops so far, about: software adapters stop all loops of a shader after 65535 and go on as if they were
// done, so rays pause before that.
var<private> turns: u32;

struct Ray {
    origin: vec3f,
    direction: vec3f,
    // Where the observer stands on it.
    first: f32,
}

// Light of each band so far, or of each light at each term that bands share, the depth in front of what comes, and the largest one met.
struct State {
    sum: array<f32, SUMS>,
    // Element × polynomial of the light field.
    field: array<f32, FIELD_CHANNELS>,
    tau: f32,
    deepest: f32,
    // Where the ray is: number of the span, step within, part of the step.
    span: u32,
    step: f32,
    part: f32,
}

struct StepSpan {
    start: f32,
    length: f32,
}

// A number of the head of the tables, which stands in `constants` again.
fn constant(i: u32) -> f32 {
    return constants[i / 4u][i % 4u];
}

// The light of a band so far.
// twin: barnard::backend::cpu::terms::CommonTerms::resolve
fn band_of(state: ptr<function, State>, band: u32) -> f32 {
    if !SHARED {
        return (*state).sum[band];
    }
    // The first term that it takes, how many, and where the weights of the lights start.
    let head = vec3u(constants[HEADS + band].xyz);
    var sum = 0.0;
    if SUMS_IN_REGISTERS {
        for (var l = 0u; l < SUMMED_LIGHTS; l++) { // written out
            for (var s = 0u; s < SETS; s++) { // written out
                for (var t = 0u; t < TERMS_OF[s]; t++) { // written out
                    sum = fma(numbers[4u * head.z + l * TERMS_OF[0] + t], (*state).sum[l * TERMS_OF[0] + t], sum);
                }
            }
        }
        return sum;
    }
    for (var l = 0u; l < SUMMED_LIGHTS; l++) {
        for (var t = l * TERMS_OF[0] + head.x; t < l * TERMS_OF[0] + head.x + head.y; t++) {
            sum = fma(numbers[4u * head.z + t], (*state).sum[t], sum);
        }
    }
    return sum;
}

// The extinction of a term relative to V.
fn extinction(term: u32) -> f32 {
    return constant(4u * EXTINCTION + term);
}

// What a light's term weighs at a place of the phase table; 1/4π or p(θ) is included, but where one p(θ) serves all
// terms.
fn weight(light: u32, term: u32, at: vec2f) -> f32 {
    if PHASE_KIND == SPECTRAL && light < SCATTERERS {
        let row = frame.counts.z + (light * frame.counts.y + u32(at.x)) * (PHASE_STRIDE / 4u) + term / 4u;
        return mix(tables[row][term % 4u], tables[row + PHASE_STRIDE / 4u][term % 4u], at.y);
    }
    return constant(4u * WEIGHTS + light * ROOM + term);
}
