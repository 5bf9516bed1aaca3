// Exponentials at nodes that all bands share: each light is summed at each node, as in nodes.wgsl, and `band` makes
// bands of the sums at the end.

// Adds base · weight · ⟨D⟩ at every node of a light, over depths between middle - half and middle + half.
// twin: barnard::backend::cpu::terms::CommonTerms::accumulate
fn accumulate(state: ptr<function, State>, light: u32, at: vec2f, base: f32, middle: f32, half: f32) {
    turns += TERM_TURNS * frame.counts.x;
    if abs(half) * frame.limits.w <= GENTLE {
        let square = half * half;
        let fourth = square * square;
        for (var s = 0u; s < SETS; s++) { // written out
            for (var t = 0u; t < TERMS_OF[s]; t++) { // written out
                let exponent = fma(constant(4u * SQUARES + t), square, constant(4u * EXPONENTS + t) * middle);
                let share = base * weight(light, t, at);
                let sum = (*state).sum[light * TERMS_OF[0] + t];
                (*state).sum[light * TERMS_OF[0] + t] = fma(share, exp2(fma(constant(4u * FOURTHS + t), fourth, exponent)), sum);
            }
        }
        return;
    }
    for (var s = 0u; s < SETS; s++) { // written out
        for (var t = 0u; t < TERMS_OF[s]; t++) { // written out
            let k = extinction(t);
            let sum = (*state).sum[light * TERMS_OF[0] + t];
            (*state).sum[light * TERMS_OF[0] + t] = fma(base * weight(light, t, at), mean_transmittance(k * middle, k * half), sum);
        }
    }
}

// What is left of a band behind a depth of a light that is as bright as any angle makes it.
fn left(light: u32, band: u32, depth: f32) -> f32 {
    // The first node that it takes, how many, and where the weights of the lights start.
    let head = vec3u(constants[HEADS + band].xyz);
    var sum = 0.0;
    for (var t = head.x; t < head.x + head.y; t++) {
        let brightest = constant(4u * BRIGHTEST + light * ROOM + t);
        sum += abs(numbers[4u * head.z + light * TERMS_OF[0] + t]) * brightest * exp(-extinction(t) * depth);
    }
    return sum;
}
