// The light field of all stars: a sample adds Δτ Σ_i (Σ_m q_m(τ) M_imj) V_i to the ray's j-th polynomial.

// twin: barnard::backend::cpu::propagation::accumulate
fn accumulate_field(state: ptr<function, State>, growth: f32, before: ptr<function, array<vec4f, QUADS>>, after: ptr<function, array<vec4f, QUADS>>) {
    turns += 2u * MAX_ELEMENTS + FIELD_ELEMENTS * FIELD_ELEMENTS * (2u + FIELD_ELEMENTS + FIELD_POLYNOMIALS);
    let means = mean_coordinates(constants[FIELD_HEAD], (*state).tau + 0.5 * growth, 0.5 * growth);
    for (var i = 0u; i < FIELD_ELEMENTS; i++) {
        for (var j = 0u; j < FIELD_ELEMENTS; j++) {
            var share = 0.0;
            for (var m = 0u; m < FIELD_ELEMENTS; m++) {
                share = fma(numbers[4u * FIELD_PRODUCTS + (m * FIELD_ELEMENTS + i) * FIELD_ELEMENTS + j], means[m], share);
            }
            share *= 0.5 * growth;
            for (var p = 0u; p < FIELD_POLYNOMIALS; p++) {
                let channel = i * FIELD_POLYNOMIALS + p;
                let quad = FIELD_QUAD + channel / 4u;
                (*state).field[j * FIELD_POLYNOMIALS + p] += share * ((*before)[quad][channel % 4u] + (*after)[quad][channel % 4u]);
            }
        }
    }
    // How deep the stars shine is known for the whole field alone.
    (*state).deepest = max((*state).deepest, (*state).tau + growth + frame.depths.x);
}

// The polynomials of a ray, seen through the bands.
// twin: barnard::backend::cpu::light_sums::LightSums::resolve
fn resolve_field(state: ptr<function, State>) {
    for (var b = 0u; b < BANDS; b++) { // written out
        for (var c = 0u; c < FIELD_CHANNELS; c++) {
            (*state).sum[b] += numbers[4u * FIELD_RESOLUTION + b * FIELD_CHANNELS + c] * (*state).field[c];
        }
    }
}
