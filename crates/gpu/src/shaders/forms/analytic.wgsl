// Polynomial spectra in closed form, and so is their mean over a thick segment.

// e^x E_n(x) for n = 1 … count, x > 0.
// twin: barnard::packet::scaled_exp_integrals
fn scaled_exp_integrals(x: f32, count: u32) -> array<f32, MAX_EXP_INTEGRALS> {
    var out: array<f32, MAX_EXP_INTEGRALS>;
    // The order from which the recurrence is run up and down.
    let start = clamp(ceil(x), 1.0, f32(count));
    var first = 0.0;
    if x <= 1.0 {
        var sum = 0.0;
        var term = 1.0;
        for (var m = 1u; m <= EXP_INTEGRAL_TERMS; m++) {
            term *= -x / f32(m);
            sum -= term / f32(m);
        }
        first = exp(x) * (sum - EULER - ln(x));
    } else {
        var tail = x + start + 2.0 * f32(EXP_INTEGRAL_LEVELS);
        for (var i = f32(EXP_INTEGRAL_LEVELS); i >= 1.0; i -= 1.0) {
            tail = x + start + 2.0 * (i - 1.0) - i * (start - 1.0 + i) / tail;
        }
        first = 1.0 / tail;
    }
    let middle = u32(start) - 1u;
    out[middle] = first;
    for (var n = middle + 1u; n < count; n++) {
        out[n] = (1.0 - x * out[n - 1u]) / f32(n);
    }
    for (var n = middle; n > 0u; n--) {
        out[n - 1u] = (1.0 - f32(n) * out[n]) / x;
    }
    return out;
}

// F/F(0), -dF/da/F(0) and what is left of F/F(0) behind a depth, of a light in a band; the head holds where its ends
// start, how many ends and powers, and how many lines follow.
fn closed_form(head: vec4u, depth: f32) -> vec3f {
    var sum = vec3f(0.0);
    var at = 4u * head.x + 2u;
    for (var i = 0u; i < head.y; i++) {
        // E₁ is infinite at no depth at all.
        let x = max(depth * numbers[at], 1e-6);
        at += 1u;
        let e = scaled_exp_integrals(x, head.z + 2u);
        var of_end = vec3f(0.0);
        for (var n = 0u; n < head.z; n++) {
            of_end += vec3f(numbers[at] * e[n + 1u], numbers[at + 1u] * e[n], numbers[at + 2u] * e[n + 2u]);
            at += 3u;
        }
        sum += exp(-x) * of_end;
    }
    for (var i = 0u; i < head.w; i++) {
        let k = numbers[at];
        let line = numbers[at + 1u] * exp(-k * depth);
        sum += vec3f(line, k * line, line / k);
        at += 2u;
    }
    return sum;
}

// Where two points of Gauss lie.
const GAUSS = 0.57735026;

// The mean of F/F(0) over depths between middle - half and middle + half: grey, by two points, or by what is left
// behind both ends. In front of the ends stand the spread of k and k in the middle.
// twin: barnard::backend::cpu::terms::AnalyticTerms::accumulate
fn mean_left(head: vec4u, middle: f32, half: f32) -> f32 {
    if half * numbers[4u * head.x] <= CLOSED_GREY {
        let at = closed_form(head, middle);
        var y = 0.0;
        if at.x > 0.0 {
            y = at.y / at.x * half;
        }
        return at.x * mean_transmittance(0.0, y);
    }
    let thin = half * numbers[4u * head.x + 1u] <= CLOSED_THIN;
    let reach = select(half, GAUSS * half, thin);
    let front = closed_form(head, middle - reach);
    let back = closed_form(head, middle + reach);
    if !thin {
        return (front.z - back.z) / (2.0 * half);
    }
    if front.x <= 0.0 || back.x <= 0.0 {
        return 0.5 * (front.x + back.x);
    }
    let y = 0.5 / GAUSS * ln(front.x / back.x);
    return sqrt(front.x * back.x) * sinhc(y * y);
}

fn accumulate(state: ptr<function, State>, light: u32, at: vec2f, base: f32, middle: f32, half: f32) {
    turns += BANDS * BAND_TURNS + TERM_TURNS * frame.counts.x;
    for (var b = 0u; b < BANDS; b++) { // written out
        let mean = mean_left(vec4u(constants[HEADS + light * BANDS + b]), middle, abs(half));
        (*state).sum[b] += base * weight(light, b, at) * mean;
    }
}

// No bound is known.
fn left(light: u32, band: u32, depth: f32) -> f32 {
    return FAR;
}
