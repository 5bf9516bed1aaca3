// The light of one segment in closed form, eqs. (5) and (6) of docs/method.md.

// Light of one star, scattered in one segment.
// twin: barnard::backend::cpu::shading::scatter
fn scatter(state: ptr<function, State>, ray: Ray, scatterer: u32, step_span: StepSpan, growth: f32, tilt: f32, depths: vec2f) {
    let star = tables[STARS + scatterer];
    let foot = dot(star.xyz - ray.origin, ray.direction);
    let b = length(star.xyz - (ray.origin + foot * ray.direction));
    let middle = (*state).tau + 0.5 * (growth + depths.x + depths.y);
    let half = 0.5 * (growth + depths.y - depths.x);
    let t0 = step_span.start - foot;
    let p = fma(b, b, t0 * (t0 + step_span.length));
    let reach = NEAR_VOXELS * frame.steps.z;
    (*state).deepest = max((*state).deepest, middle + abs(half));
    if p < reach * reach || b * step_span.length > NEAR_ANGLE * p {
        near(state, ray, scatterer, max(b, CLOSEST), foot, step_span, growth);
        return;
    }
    let mean = mean_inverse_square(b * step_span.length, p);
    if PHASE_KIND == ISOTROPIC {
        accumulate(state, scatterer, vec2f(0.0), mean * growth, middle, half);
        return;
    }
    // The light at some angles goes as σ/r²; one angle in the middle of the segment, mostly.
    let count = phases(mean * b * step_span.length);
    turns += 2u * count;
    let along = t0 + 0.5 * step_span.length;
    var total = 0.0;
    var spread = 0.0;
    for (var j = 0u; j < count; j++) {
        let part = (f32(j) + 0.5) / f32(count) - 0.5;
        let t = fma(part, step_span.length, along);
        let inverse = 1.0 / max(fma(t, t, b * b), TINY);
        total += inverse;
        if PHASE_KIND == SEPARABLE {
            spread += fma(part, tilt, 1.0) * inverse * phase_value(scatterer, phase_entry(-t * sqrt(inverse), b * b * inverse));
        }
    }
    if PHASE_KIND == SEPARABLE {
        accumulate(state, scatterer, vec2f(0.0), mean * growth * spread / total, middle, half);
        return;
    }
    for (var j = 0u; j < count; j++) {
        let part = (f32(j) + 0.5) / f32(count) - 0.5;
        let t = fma(part, step_span.length, along);
        let inverse = 1.0 / max(fma(t, t, b * b), TINY);
        let share = fma(part, tilt, 1.0) * inverse / total;
        accumulate(state, scatterer, phase_entry(-t * sqrt(inverse), b * b * inverse), mean * growth * share, middle, half);
    }
}

// ⟨1/r²⟩ over a segment: atan(q)/(q p), q = b Δt/p, where q is small.
// twin: barnard::plan::segment::mean_inverse_square
fn mean_inverse_square(b_length: f32, p: f32) -> f32 {
    let q = b_length / p;
    let q2 = q * q;
    return fma(q2, fma(q2, fma(q2, fma(q2, 1.0 / 9.0, -1.0 / 7.0), 1.0 / 5.0), -1.0 / 3.0), 1.0) / p;
}

fn scatter_stars(state: ptr<function, State>, ray: Ray, step_span: StepSpan, growth: f32, before: ptr<function, array<vec4f, QUADS>>, after: ptr<function, array<vec4f, QUADS>>) {
    let a = (*before)[DUST_QUAD][DUST_LANE];
    let z = (*after)[DUST_QUAD][DUST_LANE];
    let tilt = 2.0 * (z - a) / (a + z);
    for (var s = 0u; s < SCATTERERS; s++) {
        let slot = u32(tables[STARS + s].w);
        let depths = vec2f((*before)[slot / 4u][slot % 4u], (*after)[slot / 4u][slot % 4u]);
        scatter(state, ray, s, step_span, growth, tilt, depths);
    }
}

// Light of one segment that was scattered before.
// twin: barnard::backend::cpu::shading::scatter_again
fn scatter_again(state: ptr<function, State>, growth: f32, before: ptr<function, array<vec4f, QUADS>>, after: ptr<function, array<vec4f, QUADS>>) {
    turns += BANDS * BAND_TURNS + TERM_TURNS * frame.counts.x;
    for (var b = 0u; b < BANDS; b++) {
        let terms = band_terms(b);
        var sum = 0.0;
        for (var t = terms.x; t < terms.y; t++) {
            let k = numbers[4u * EXTINCTION + t];
            let quad = SCATTERED_QUAD + t / 4u;
            let source = 0.5 * ((*before)[quad][t % 4u] + (*after)[quad][t % 4u]);
            sum = fma(k * source, mean_transmittance(k * ((*state).tau + 0.5 * growth), 0.5 * k * growth), sum);
        }
        (*state).sum[b] = fma(growth, sum, (*state).sum[b]);
    }
}

// Adds the light of one segment and moves the depth to its end.
// twin: barnard::backend::cpu::shading::add
fn segment(state: ptr<function, State>, ray: Ray, step_span: StepSpan, before: ptr<function, array<vec4f, QUADS>>, after: ptr<function, array<vec4f, QUADS>>) {
    var growth = 0.0;
    if HAS_DUST {
        growth = 0.5 * step_span.length * ((*before)[DUST_QUAD][DUST_LANE] + (*after)[DUST_QUAD][DUST_LANE]);
        if growth > 0.0 {
            if HAS_FIELD {
                accumulate_field(state, growth, before, after);
            } else {
                scatter_stars(state, ray, step_span, growth, before, after);
            }
            if MANY_LIGHTS > 0u {
                let dust = vec2f((*before)[DUST_QUAD][DUST_LANE], (*after)[DUST_QUAD][DUST_LANE]);
                scatter_near_field(state, ray, step_span, growth, dust);
                // How deep the stars shine is known for all of them alone.
                (*state).deepest = max((*state).deepest, (*state).tau + growth + frame.depths.x);
            }
            if HAS_SCATTERED_FIELD {
                scatter_again(state, growth, before, after);
            }
        }
    }
    for (var e = 0u; e < EMITTERS; e++) {
        let slot = u32(tables[EMITTER_SLOTS + e].x);
        let light = 0.5 * step_span.length * ((*before)[slot / 4u][slot % 4u] + (*after)[slot / 4u][slot % 4u]);
        if light > 0.0 {
            accumulate(state, SCATTERERS + e, vec2f(0.0), light, (*state).tau + 0.5 * growth, 0.5 * growth);
        }
    }
    (*state).tau += growth;
}
