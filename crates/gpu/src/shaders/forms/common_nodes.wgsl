// Exponentials at nodes that all bands share: each light is summed at each node, as in nodes.wgsl, and `band_of` makes
// bands of the sums at the end.

// Adds to the sum of a light at a node. Where registers hold all sums, none is indexed by what only the ray knows.
fn add_at_node(state: ptr<function, State>, light: u32, node: u32, own: f32) {
    if !SUMS_IN_REGISTERS {
        (*state).sum[light * TERMS_OF[0] + node] += own;
        return;
    }
    for (var l = 0u; l < SUMMED_LIGHTS; l++) { // written out
        if l == light {
            for (var s = 0u; s < SETS; s++) { // written out
                for (var t = 0u; t < TERMS_OF[s]; t++) { // written out
                    if t == node {
                        (*state).sum[l * TERMS_OF[0] + t] += own;
                    }
                }
            }
        }
    }
}

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
                let left = exp2(fma(constant(4u * FOURTHS + t), fourth, exponent));
                add_at_node(state, light, t, base * weight(light, t, at) * left);
            }
        }
        return;
    }
    for (var s = 0u; s < SETS; s++) { // written out
        for (var t = 0u; t < TERMS_OF[s]; t++) { // written out
            let k = extinction(t);
            add_at_node(state, light, t, base * weight(light, t, at) * mean_transmittance(k * middle, k * half));
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
