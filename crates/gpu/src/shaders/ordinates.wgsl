// Orders of scattering by discrete ordinates, for eight terms side by side; see
// barnard::plan::multiple_scattering::ordinates. A number is at ((cell * HARMONICS) + harmonic) * WIDTH + term.

struct Terms {
    // Extinctions, radiance that comes in from around, and factors of a sum.
    k: array<vec4f, 2>,
    around: array<vec4f, 2>,
    factor: array<vec4f, 2>,
    // Number of cells; whether gas glows; dust of less is none [pc⁻¹].
    cells: u32,
    glows: u32,
    least: f32,
    nothing: u32,
}

struct Plane {
    // Number of its first cell, and of that of the plane before.
    first: u32,
    before: u32,
    // From cell to cell along a row, and from row to row.
    column: u32,
    row: u32,
    columns: u32,
    rows: u32,
    // Where the face's beams start.
    beams: u32,
    // Which half of what is kept is written, and two more where no plane is before.
    half: u32,
}

@group(0) @binding(0) var<uniform> terms: Terms;
@group(0) @binding(1) var<uniform> plane: Plane;
@group(0) @binding(2) var<storage, read> sigma: array<f32>;
// ω p_l of each harmonic and term.
@group(0) @binding(3) var<storage, read> scattering: array<f32>;
// Of a face: of each direction where it comes from, its length, and the weights of the four cells there; then Y_lm of
// each harmonic and direction, and Y_lm dΩ.
@group(0) @binding(4) var<storage, read> beams: array<f32>;
@group(0) @binding(5) var<storage, read> glow: array<f32>;
@group(0) @binding(6) var<storage, read_write> source: array<f32>;
@group(0) @binding(7) var<storage, read_write> order: array<f32>;
@group(0) @binding(8) var<storage, read_write> sum: array<f32>;
// Radiance, and σ times the source function, of two planes: half × cell × direction × term.
@group(0) @binding(9) var<storage, read_write> kept: array<vec2f>;
// Power of the order and of the sum: chunk of cells × term.
@group(0) @binding(10) var<storage, read_write> powers: array<vec2f>;

// e^(−Δ), g − e^(−Δ) and 1 − g, with g = (1 − e^(−Δ))/Δ.
// twin: barnard::plan::multiple_scattering::sweep::shares
fn shares(depth: f32) -> vec3f {
    let e = exp(-depth);
    if depth < THIN_CELL {
        let first = depth * fma(depth, fma(depth, 0.125, -1.0 / 3.0), 0.5);
        return vec3f(e, first, depth * fma(depth, fma(depth, 1.0 / 24.0, -1.0 / 6.0), 0.5));
    }
    let g = (1.0 - e) / depth;
    return vec3f(e, g - e, 1.0 - g);
}

// What the order before has becomes the source of the next one.
@compute @workgroup_size(64) fn scatter(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= terms.cells * WIDTH {
        return;
    }
    let t = id.x % WIDTH;
    for (var h = 0u; h < HARMONICS; h++) {
        let at = (id.x / WIDTH * HARMONICS + h) * WIDTH + t;
        source[at] = order[at] * scattering[h * WIDTH + t];
        order[at] = 0.0;
    }
}

// One plane of cells along all directions of a face.
// twin: barnard::plan::multiple_scattering::sweep::march_row
@compute @workgroup_size(64) fn sweep(@builtin(global_invocation_id) id: vec3u) {
    let t = id.x % WIDTH;
    let number = id.x / WIDTH;
    if number >= plane.columns * plane.rows {
        return;
    }
    let here = vec2u(number % plane.columns, number / plane.columns);
    let cell = plane.first + here.x * plane.column + here.y * plane.row;
    let half = (plane.half & 1u) * plane.columns * plane.rows;
    let other = plane.columns * plane.rows - half;
    let alone = (plane.half & 2u) != 0u;
    let k = terms.k[t / 4u][t % 4u];
    let around = terms.around[t / 4u][t % 4u];
    let own_sigma = sigma[cell];
    var own: array<f32, BEAMS>;
    var radiance: array<f32, BEAMS>;
    for (var h = 0u; h < HARMONICS; h++) {
        let moment = source[(cell * HARMONICS + h) * WIDTH + t];
        let at = plane.beams + (HEAD + h) * BEAMS;
        for (var b = 0u; b < BEAMS; b++) { // written out
            own[b] = fma(beams[at + b], moment, own[b]);
        }
    }
    for (var b = 0u; b < BEAMS; b++) { // written out
        let beam = plane.beams + b * HEAD;
        let origin = vec2i(here) + vec2i(i32(beams[beam]), i32(beams[beam + 1u]));
        let long = beams[beam + 2u];
        var incoming = 0.0;
        var coming = 0.0;
        var upwind = 0.0;
        var scattered = 0.0;
        for (var corner = 0u; corner < 4u; corner++) {
            let at = origin + vec2i(i32(corner & 1u), i32(corner >> 1u));
            let weight = beams[beam + 3u + corner];
            if alone || any(at < vec2i(0)) || at.x >= i32(plane.columns) || at.y >= i32(plane.rows) {
                incoming = fma(weight, around, incoming);
            } else {
                let there = plane.before + u32(at.x) * plane.column + u32(at.y) * plane.row;
                let came = kept[((other + u32(at.y) * plane.columns + u32(at.x)) * BEAMS + b) * WIDTH + t];
                incoming = fma(weight, came.x, incoming);
                scattered = fma(weight, came.y, scattered);
                upwind = fma(weight, sigma[there], upwind);
                if terms.glows != 0u {
                    coming = fma(weight, glow[there * WIDTH + t], coming);
                }
            }
        }
        // Where no dust is, its source function is that of the dust beside it.
        var before = own[b];
        if upwind > terms.least {
            before = scattered / upwind;
        }
        let behind = select(own[b], before, own_sigma <= terms.least);
        let part = shares(k * 0.5 * (upwind + own_sigma) * long);
        radiance[b] = fma(incoming, part.x, fma(before, part.y, behind * part.z));
        if terms.glows != 0u {
            radiance[b] = fma(0.5 * (coming + glow[cell * WIDTH + t]) * long, part.x + part.y, radiance[b]);
        }
        kept[((half + number) * BEAMS + b) * WIDTH + t] = vec2f(radiance[b], own[b] * own_sigma);
    }
    for (var h = 0u; h < HARMONICS; h++) {
        let at = (cell * HARMONICS + h) * WIDTH + t;
        var moment = order[at];
        let first = plane.beams + (HEAD + HARMONICS + h) * BEAMS;
        for (var b = 0u; b < BEAMS; b++) { // written out
            moment = fma(beams[first + b], radiance[b], moment);
        }
        order[at] = moment;
    }
}

// Adds the order to the sum, by a factor.
@compute @workgroup_size(64) fn add(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= terms.cells * WIDTH {
        return;
    }
    let t = id.x % WIDTH;
    for (var h = 0u; h < HARMONICS; h++) {
        let at = (id.x / WIDTH * HARMONICS + h) * WIDTH + t;
        sum[at] = fma(terms.factor[t / 4u][t % 4u], order[at], sum[at]);
    }
}

// Fluence in the dust, in chunks of cells.
@compute @workgroup_size(64) fn power(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= CHUNKS * WIDTH {
        return;
    }
    let t = id.x % WIDTH;
    var found = vec2f(0.0);
    for (var cell = id.x / WIDTH; cell < terms.cells; cell += CHUNKS) {
        let at = cell * HARMONICS * WIDTH + t;
        found += sigma[cell] * vec2f(order[at], sum[at]);
    }
    powers[id.x] = found;
}
