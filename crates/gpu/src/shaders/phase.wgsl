// How scattered light is spread over angles.

// Entry and fraction of the phase table for an angle.
// twin: barnard::plan::PhaseTable::entry
fn phase_entry(cosine: f32, sine2: f32) -> vec2f {
    let small = sqrt(sine2 / (2.0 * (1.0 + abs(cosine))));
    let gaps = f32(frame.counts.y) - 1.0;
    let u = select(PHASE_RANGE - small, small, cosine >= 0.0) * gaps / PHASE_RANGE;
    let entry = clamp(floor(u), 0.0, gaps - 1.0);
    return vec2f(entry, u - entry);
}

// p(θ), where it is one function for all terms; one otherwise, since weights hold it.
fn phase_value(light: u32, at: vec2f) -> f32 {
    if PHASE_KIND != SEPARABLE {
        return 1.0;
    }
    let first = 4u * frame.counts.z + light * frame.counts.y + u32(at.x);
    return mix(numbers[first], numbers[first + 1u], at.y);
}

// At how many angles the phase function must be asked within one.
// twin: barnard::plan::near::phases
fn phases(angle: f32) -> u32 {
    return u32(clamp(ceil(angle / frame.steps.w), 1.0, MAX_PHASES));
}
