// Exponentials: ⟨D⟩ = e^(-k ā) sinh(k y)/(k y).

// Adds base · weight · ⟨D⟩ of every term of a light, over depths between middle - half and middle + half.
// twin: barnard::backend::cpu::terms::NodeTerms::accumulate
fn accumulate(state: ptr<function, State>, light: u32, at: vec2f, base: f32, middle: f32, half: f32) {
    turns += BANDS * BAND_TURNS + TERM_TURNS * frame.counts.x;
    for (var b = 0u; b < BANDS; b++) {
        let terms = band_terms(b);
        var sum = 0.0;
        for (var t = terms.x; t < terms.y; t++) {
            let k = numbers[4u * EXTINCTION + t];
            sum = fma(weight(light, t, at), mean_transmittance(k * middle, k * half), sum);
        }
        (*state).sum[b] = fma(base, sum, (*state).sum[b]);
    }
}

// What is left behind a depth of a light that is as bright as any angle makes it.
fn left(light: u32, band: u32, depth: f32) -> f32 {
    let terms = band_terms(band);
    var sum = 0.0;
    for (var t = terms.x; t < terms.y; t++) {
        sum += numbers[4u * BRIGHTEST + light * ROOM + t] * exp(-numbers[4u * EXTINCTION + t] * depth);
    }
    return sum;
}
