// Gathered stars near a segment: the part of their light that is not gathered in the field.

// Depth at V from a gathered star to a place in its kernel.
// twin: barnard::plan::many_lights::near_field_kernel::depth_within
fn depth_within(star: u32, sigma: f32, distance: f32, cosine: f32) -> f32 {
    let around = distance * sigma;
    let ahead = max(cosine, 0.0) * max(cosine, 0.0);
    let at = min(distance * tables[MANY_LIGHTS_STARS + star * MANY_LIGHTS_STRIDE + 1u].w, f32(PROFILE));
    let i = min(u32(at), PROFILE - 1u);
    let first = 4u * (MANY_LIGHTS_STARS + star * MANY_LIGHTS_STRIDE + 2u);
    let low = select(numbers[first + max(i, 1u) - 1u], 0.0, i == 0u);
    let along = mix(low, numbers[first + i], at - f32(i));
    return around + ahead * (along - around);
}

// p(θ) of a term at its node, where light is not scattered evenly; 1/4π is in the weights.
fn phase_at_node(term: u32, at: vec2f) -> f32 {
    if PHASE_KIND == ISOTROPIC {
        return 1.0;
    }
    var column = 0u;
    if PHASE_KIND == SPECTRAL {
        column = term;
    }
    let first = 4u * frame.counts.z + (SCATTERERS * frame.counts.y + u32(at.x)) * PHASE_STRIDE + column;
    return mix(numbers[first], numbers[first + PHASE_STRIDE], at.y);
}

// Adds base · weight · p(θ) · ⟨D⟩ of every term of a gathered star.
fn accumulate_near_star(state: ptr<function, State>, star: u32, at: vec2f, base: f32, middle: f32, half: f32) {
    turns += BANDS * BAND_TURNS + TERM_TURNS * frame.counts.x;
    let weights = 4u * (MANY_LIGHTS_STARS + star * MANY_LIGHTS_STRIDE + MANY_LIGHTS_WEIGHTS);
    for (var b = 0u; b < BANDS; b++) { // written out
        var sum = 0.0;
        for (var t = FIRST_TERM[b]; t < FIRST_TERM[b] + TERMS_OF[b]; t++) {
            let k = extinction(t);
            var share = numbers[weights + t];
            if PHASE_KIND == SPECTRAL {
                share *= phase_at_node(t, at);
            }
            sum = fma(share, mean_transmittance(k * middle, k * half), sum);
        }
        (*state).sum[b] = fma(base, sum, (*state).sum[b]);
    }
}

// twin: barnard::backend::cpu::near_field::NearStar::scatter
fn scatter_near_star(state: ptr<function, State>, ray: Ray, number: u32, step_span: StepSpan, growth: f32, sigma: vec2f) {
    let star = tables[MANY_LIGHTS_STARS + number * MANY_LIGHTS_STRIDE];
    // R, L/R, what the kernel is flatter ahead, and places of the profile a parsec.
    let kernel = tables[MANY_LIGHTS_STARS + number * MANY_LIGHTS_STRIDE + 1u];
    let foot = dot(star.xyz - ray.origin, ray.direction);
    let b = max(length(star.xyz - (ray.origin + foot * ray.direction)), CLOSEST);
    let half = sqrt(max(kernel.x * kernel.x - b * b, 0.0));
    let start = step_span.start - foot;
    let entered = max(start, -kernel.y * half);
    let left_at = min(start + step_span.length, half);
    if left_at <= entered {
        return;
    }
    let angle = atan2(b * (left_at - entered), fma(b, b, entered * left_at));
    let count = clamp(ceil(angle / tables[MANY_LIGHTS_HEAD + 2u].x), 1.0, f32(NEAR_FIELD_PIECES));
    let turn = angle / count;
    let first = atan(entered / b);
    turns += 2u * u32(count);
    var total = 0.0;
    var spread = 0.0;
    var deep = 0.0;
    for (var j = 0.0; j < count; j += 1.0) {
        var t = 0.5 * (entered + left_at);
        if count > 1.0 {
            t = clamp(b * tan(first + (j + 0.5) * turn), entered, left_at);
        }
        let square = fma(t, t, b * b);
        let density = mix(sigma.x, sigma.y, (t - start) / step_span.length);
        let along = select(t * t, t * t * (1.0 - kernel.z), t < 0.0);
        let inside = max(1.0 - fma(b, b, along) / (kernel.x * kernel.x), 0.0);
        let piece = density * inside * inside * turn / b;
        let inverse = inverseSqrt(square);
        let cosine = -t * inverse;
        let depth = depth_within(number, 0.5 * (star.w + density), square * inverse, cosine);
        let at = phase_entry(cosine, b * b * inverse * inverse);
        if PHASE_KIND == SPECTRAL {
            accumulate_near_star(state, number, at, piece, (*state).tau + 0.5 * growth + depth, 0.5 * growth);
        } else {
            total += piece;
            deep = fma(piece, depth, deep);
            spread = fma(piece, phase_at_node(0u, at), spread);
        }
    }
    if PHASE_KIND != SPECTRAL && total > 0.0 {
        accumulate_near_star(state, number, vec2f(0.0), spread, (*state).tau + 0.5 * growth + deep / total, 0.5 * growth);
    }
}

// The stars whose kernels reach to a segment, whose ends have this extinction.
fn scatter_near_field(state: ptr<function, State>, ray: Ray, step_span: StepSpan, growth: f32, sigma: vec2f) {
    let low = tables[MANY_LIGHTS_HEAD];
    let dims = vec4u(tables[MANY_LIGHTS_HEAD + 1u]);
    let place = ray.origin + (step_span.start + 0.5 * step_span.length) * ray.direction;
    let cell = vec3u(clamp(vec3i(floor((place - low.xyz) * low.w)), vec3i(0), vec3i(dims.xyz) - 1));
    let index = dims.w + (cell.z * dims.y + cell.y) * dims.x + cell.x;
    let end = brick_distances[index + 1u];
    for (var i = brick_distances[index]; i < end; i++) {
        turns += 2u;
        scatter_near_star(state, ray, brick_distances[i], step_span, growth, sigma);
    }
}
