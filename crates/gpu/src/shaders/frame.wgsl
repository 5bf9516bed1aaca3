// What changes from picture to picture; all places are seen from the middle of the scene [pc].

struct Frame {
    // Where the ray through the image's middle starts, and how far the observer stands behind it.
    middle: vec4f,
    // What the origin and the direction change by across half the image, rightwards and upwards.
    across: vec4f,
    upwards: vec4f,
    forward: vec4f,
    turn_x: vec4f,
    turn_y: vec4f,
    // The box of everything that absorbs, scatters or glows.
    low: vec4f,
    high: vec4f,
    // Samples a parsec, or on every ray if not zero; the finest voxel; the angle over which the phase function changes little.
    steps: vec4f,
    // Smallest extinction, what may be left out behind a ray's end, largest dust.
    limits: vec4f,
    // Pixels along a row, rows, rays along each side of a pixel.
    size: vec4u,
    // First row, and how many.
    strip: vec4u,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> tables: array<vec4f>;
@group(0) @binding(2) var<storage, read> brick_distances: array<u32>;
@group(0) @binding(3) var<storage, read_write> radiance: array<f32>;
@group(0) @binding(4) var<storage, read_write> found: array<atomic<u32>>;
