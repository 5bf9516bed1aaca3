// Tables of ln F: in a segment the medium is grey with the local mean extinction.

// twin: barnard::backend::cpu::terms::LookupTerms::gather
fn gather(state: ptr<function, State>, light: u32, at: vec2f, base: f32, middle: f32, half: f32) {
    turns += BANDS * BAND_TURNS + TERM_TURNS * frame.counts.x;
    for (var b = 0u; b < BANDS; b++) {
        // Entries per unit of depth, gaps, and where they start.
        let head = tables[HEADS + light * BANDS + b];
        let x = middle * head.x;
        let cell = clamp(floor(x), 0.0, head.y - 1.0);
        let first = 4u * u32(head.z) + u32(cell);
        let low = numbers[first];
        let rise = numbers[first + 1u] - low;
        let grey = mean_transmittance(0.0, rise * head.x * half);
        (*state).sum[b] += base * weight(light, b, at) * grey * exp(fma(x - cell, rise, low));
    }
}

// No bound is known.
fn left(light: u32, band: u32, depth: f32) -> f32 {
    return FAR;
}
