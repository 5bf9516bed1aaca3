// Intervals of wavelength: ⟨D⟩ = e^(-k_j a₀) T_j(Δ), a₀ in front of the segment, Δ its own depth.

// twin: barnard::backend::cpu::terms::PreintegratedTerms::accumulate
fn accumulate(state: ptr<function, State>, light: u32, at: vec2f, base: f32, middle: f32, half: f32) {
    turns += BANDS * BAND_TURNS + TERM_TURNS * frame.counts.x;
    let front = middle - abs(half);
    let root = sqrt(2.0 * abs(half));
    for (var b = 0u; b < BANDS; b++) { // written out
        var sum = 0.0;
        for (var t = FIRST_TERM[b]; t < FIRST_TERM[b] + TERMS_OF[b]; t++) {
            // Entries per unit of the root of a depth, gaps, and where they start.
            let head = constants[HEADS + light * ROOM + t];
            let place = cell(root * head.x, head.y);
            let first = 4u * u32(head.z) + u32(place.x);
            let mean = mix(numbers[first], numbers[first + 1u], place.y);
            sum += weight(light, t, at) * exp(-extinction(t) * front) * mean;
        }
        (*state).sum[b] += base * sum;
    }
}

// No bound is known.
fn left(light: u32, band: u32, depth: f32) -> f32 {
    return FAR;
}
