// Polynomial spectra in closed form, in a segment grey with the local mean extinction.

const LEVELS = 24u;
const SERIES_TERMS = 9u;
const EULER = 0.5772157;

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
        for (var m = 1u; m <= SERIES_TERMS; m++) {
            term *= -x / f32(m);
            sum -= term / f32(m);
        }
        first = exp(x) * (sum - EULER - ln(x));
    } else {
        var tail = x + start + 2.0 * f32(LEVELS);
        for (var i = f32(LEVELS); i >= 1.0; i -= 1.0) {
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

// F/F(0) and -dF/da/F(0) of a light in a band; the head holds where its ends start, how many ends and powers, and how many lines follow.
fn closed_form(head: vec4u, depth: f32) -> vec2f {
    var value = vec2f(0.0);
    var at = 4u * head.x;
    for (var i = 0u; i < head.y; i++) {
        // E₁ is infinite at no depth at all.
        let x = max(depth * numbers[at], 1e-6);
        at += 1u;
        let e = scaled_exp_integrals(x, head.z + 1u);
        var sum = vec2f(0.0);
        for (var n = 0u; n < head.z; n++) {
            sum += vec2f(numbers[at] * e[n + 1u], numbers[at + 1u] * e[n]);
            at += 2u;
        }
        value += exp(-x) * sum;
    }
    for (var i = 0u; i < head.w; i++) {
        let line = numbers[at + 1u] * exp(-numbers[at] * depth);
        value += vec2f(line, numbers[at] * line);
        at += 2u;
    }
    return value;
}

// twin: barnard::backend::cpu::terms::AnalyticTerms::gather
fn gather(state: ptr<function, State>, light: u32, at: vec2f, base: f32, middle: f32, half: f32) {
    turns += BANDS * BAND_TURNS + TERM_TURNS * frame.counts.x;
    for (var b = 0u; b < BANDS; b++) {
        let value = closed_form(vec4u(tables[HEADS + light * BANDS + b]), middle);
        var grey = 1.0;
        if value.x > 0.0 {
            grey = mean_transmittance(0.0, value.y / value.x * half);
        }
        (*state).sum[b] += base * weight(light, b, at) * value.x * grey;
    }
}

// No bound is known.
fn left(light: u32, band: u32, depth: f32) -> f32 {
    return FAR;
}
