// The light of one segment in closed form, eqs. (5) and (6) of docs/method.md.

struct Ray {
    origin: vec3f,
    direction: vec3f,
    // Where the observer stands on it.
    first: f32,
}

// Light so far, the depth in front of what comes, and the largest one met.
struct State {
    sum: array<vec4f, TERM_QUADS>,
    tau: f32,
    deepest: f32,
}

struct Stretch {
    start: f32,
    length: f32,
}

// sinh(y)/y up to |y| = 1.
// twin: barnard::packet::sinhc
fn sinhc(y2: vec4f) -> vec4f {
    return fma(y2, fma(y2, fma(y2, vec4f(1.0 / 5040.0), vec4f(1.0 / 120.0)), vec4f(1.0 / 6.0)), vec4f(1.0));
}

// Mean of e^(-a) over a that is linear between middle - y and middle + y.
// twin: barnard::packet::mean_transmittance
fn mean_transmittance(middle: vec4f, y: vec4f) -> vec4f {
    let size = abs(y);
    let steep = (exp(size - middle) - exp(-size - middle)) / (2.0 * max(size, vec4f(1e-6)));
    return select(steep, exp(-middle) * sinhc(y * y), size <= vec4f(SERIES_LIMIT));
}

// Entry and fraction of the phase table for an angle.
// twin: barnard::plan::PhaseTable::entry
fn phase_entry(cosine: f32, sine2: f32) -> vec2f {
    let small = sqrt(sine2 / (2.0 * (1.0 + abs(cosine))));
    let u = select(PHASE_RANGE - small, small, cosine >= 0.0) * f32(PHASE_ENTRIES - 1u) / PHASE_RANGE;
    let entry = min(floor(u), f32(PHASE_ENTRIES - 2u));
    return vec2f(entry, u - entry);
}

// The phase function's share of a term: one number for all where it does not change with wavelength.
fn phase_weight(scatterer: u32, term: u32, at: vec2f) -> vec4f {
    if PHASE_KIND == SEPARABLE {
        let first = scatterer * PHASE_ENTRIES + u32(at.x);
        return vec4f(mix(tables[PHASE + first / 4u][first % 4u], tables[PHASE + (first + 1u) / 4u][(first + 1u) % 4u], at.y)) * tables[WEIGHTS + scatterer * TERM_QUADS + term];
    }
    let first = (scatterer * PHASE_ENTRIES + u32(at.x)) * TERM_QUADS + term;
    return mix(tables[PHASE + first], tables[PHASE + first + TERM_QUADS], at.y);
}

// At how many angles the phase function must be asked within one.
// twin: barnard::plan::near::phases
fn phases(angle: f32) -> u32 {
    return u32(clamp(ceil(angle / frame.steps.w), 1.0, MAX_PHASES));
}

// What a star's light through a segment weighs, term by term, its phase function included.
fn spread(scatterer: u32, b: f32, along: f32, length: f32, mean: f32, tilt: f32) -> array<vec4f, TERM_QUADS> {
    var spread: array<vec4f, TERM_QUADS>;
    if PHASE_KIND == ISOTROPIC {
        for (var c = 0u; c < TERM_QUADS; c++) {
            spread[c] = tables[WEIGHTS + scatterer * TERM_QUADS + c];
        }
        return spread;
    }
    let count = phases(mean * b * length);
    var total = 0.0;
    for (var j = 0u; j < count; j++) {
        let part = (f32(j) + 0.5) / f32(count) - 0.5;
        let t = fma(part, length, along);
        let inverse = 1.0 / max(fma(t, t, b * b), TINY);
        total += inverse;
        let at = phase_entry(-t * sqrt(inverse), b * b * inverse);
        for (var c = 0u; c < TERM_QUADS; c++) {
            spread[c] += fma(part, tilt, 1.0) * inverse * phase_weight(scatterer, c, at);
        }
    }
    for (var c = 0u; c < TERM_QUADS; c++) {
        spread[c] /= total;
    }
    return spread;
}

// Light of one star, scattered in one segment.
fn scatter(state: ptr<function, State>, ray: Ray, scatterer: u32, stretch: Stretch, growth: f32, tilt: f32, depths: vec2f) {
    let star = tables[STARS + scatterer];
    let foot = dot(star.xyz - ray.origin, ray.direction);
    let b = length(star.xyz - (ray.origin + foot * ray.direction));
    let middle = (*state).tau + 0.5 * (growth + depths.x + depths.y);
    let half = 0.5 * (growth + depths.y - depths.x);
    let t0 = stretch.start - foot;
    let p = fma(b, b, t0 * (t0 + stretch.length));
    let reach = NEAR_VOXELS * frame.steps.z;
    (*state).deepest = max((*state).deepest, middle + abs(half));
    if p < reach * reach || b * stretch.length > NEAR_ANGLE * p {
        near(state, ray, scatterer, max(b, CLOSEST), foot, stretch, growth);
        return;
    }
    // atan(q)/q, as on the processor.
    let q = b * stretch.length / p;
    let q2 = q * q;
    let mean = fma(q2, fma(q2, fma(q2, fma(q2, 1.0 / 9.0, -1.0 / 7.0), 1.0 / 5.0), -1.0 / 3.0), 1.0) / p;
    let shares = spread(scatterer, b, t0 + 0.5 * stretch.length, stretch.length, mean, tilt);
    for (var c = 0u; c < TERM_QUADS; c++) {
        (*state).sum[c] += mean * growth * shares[c] * mean_transmittance(tables[EXTINCTION + c] * middle, tables[EXTINCTION + c] * half);
    }
}

// Adds the light of one segment and moves the depth to its end.
fn segment(state: ptr<function, State>, ray: Ray, stretch: Stretch, before: ptr<function, array<vec4f, QUADS>>, after: ptr<function, array<vec4f, QUADS>>) {
    var growth = 0.0;
    if HAS_DUST {
        let a = (*before)[DUST_QUAD][DUST_LANE];
        let z = (*after)[DUST_QUAD][DUST_LANE];
        growth = 0.5 * stretch.length * (a + z);
        if growth > 0.0 {
            let tilt = 2.0 * (z - a) / (a + z);
            for (var s = 0u; s < SCATTERERS; s++) {
                let slot = u32(tables[STARS + s].w);
                let depths = vec2f((*before)[slot / 4u][slot % 4u], (*after)[slot / 4u][slot % 4u]);
                scatter(state, ray, s, stretch, growth, tilt, depths);
            }
        }
    }
    for (var e = 0u; e < EMITTERS; e++) {
        let slot = u32(tables[EMITTER_SLOTS + e].x);
        let light = 0.5 * stretch.length * ((*before)[slot / 4u][slot % 4u] + (*after)[slot / 4u][slot % 4u]);
        if light > 0.0 {
            let first = (SCATTERERS + e) * TERM_QUADS;
            for (var c = 0u; c < TERM_QUADS; c++) {
                let k = tables[EXTINCTION + c];
                (*state).sum[c] += light * tables[WEIGHTS + first + c] * mean_transmittance(k * ((*state).tau + 0.5 * growth), k * 0.5 * growth);
            }
        }
    }
    (*state).tau += growth;
}
