// Exponentials: ⟨D⟩ = e^(-k ā) sinh(k y)/(k y), one exponential of ā, y² and y⁴ where k y is small.

// Adds base · weight · ⟨D⟩ of every term of a light, over depths between middle - half and middle + half.
// twin: barnard::backend::cpu::terms::NodeTerms::accumulate
fn accumulate(state: ptr<function, State>, light: u32, at: vec2f, base: f32, middle: f32, half: f32) {
    turns += BANDS * BAND_TURNS + TERM_TURNS * frame.counts.x;
    // Where no term changes much within the segment, each mean is one exponential.
    if abs(half) * frame.limits.w <= GENTLE {
        let square = half * half;
        let fourth = square * square;
        for (var b = 0u; b < BANDS; b++) { // written out
            var sum = 0.0;
            for (var t = 0u; t < TERMS_OF[b]; t++) { // written out
                let term = FIRST_TERM[b] + t;
                let exponent = fma(constant(4u * SQUARES + term), square, constant(4u * EXPONENTS + term) * middle);
                sum = fma(weight(light, term, at), exp2(fma(constant(4u * FOURTHS + term), fourth, exponent)), sum);
            }
            (*state).sum[b] = fma(base, sum, (*state).sum[b]);
        }
        return;
    }
    for (var b = 0u; b < BANDS; b++) { // written out
        var sum = 0.0;
        for (var t = 0u; t < TERMS_OF[b]; t++) {
            let k = extinction(FIRST_TERM[b] + t);
            sum = fma(weight(light, FIRST_TERM[b] + t, at), mean_transmittance(k * middle, k * half), sum);
        }
        (*state).sum[b] = fma(base, sum, (*state).sum[b]);
    }
}

// What is left behind a depth of a light that is as bright as any angle makes it.
fn left(light: u32, band: u32, depth: f32) -> f32 {
    var sum = 0.0;
    for (var t = FIRST_TERM[band]; t < FIRST_TERM[band] + TERMS_OF[band]; t++) {
        sum += constant(4u * BRIGHTEST + light * ROOM + t) * exp(-extinction(t) * depth);
    }
    return sum;
}
