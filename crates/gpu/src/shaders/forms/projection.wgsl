// Coordinates in a basis: read once for all bands that share it.

// twin: barnard::backend::cpu::terms::ProjectionTerms::accumulate
fn accumulate(state: ptr<function, State>, light: u32, at: vec2f, base: f32, middle: f32, half: f32) {
    turns += BANDS * BAND_TURNS + TERM_TURNS * frame.counts.x;
    var means: array<f32, MAX_ELEMENTS>;
    var table = 0u;
    for (var b = 0u; b < BANDS; b++) { // written out
        let head = constants[HEADS + b];
        if u32(head.z) != table {
            table = u32(head.z);
            means = mean_coordinates(head, middle, half);
        }
        var sum = 0.0;
        for (var t = 0u; t < TERMS_OF[b]; t++) { // written out
            sum = fma(weight(light, FIRST_TERM[b] + t, at), means[t], sum);
        }
        (*state).sum[b] = fma(base, sum, (*state).sum[b]);
    }
}

// No bound is known.
fn left(light: u32, band: u32, depth: f32) -> f32 {
    return FAR;
}
