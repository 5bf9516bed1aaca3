// Tables of ln F: in a thin segment the medium is grey with the local mean extinction and its bend, in a thick one
// light is what the table leaves behind both ends.

// The mean of e^x over x that is linear between two ends.
fn between(low: f32, high: f32) -> f32 {
    return mean_transmittance(-0.5 * (low + high), 0.5 * (low - high));
}

// The gap between two entries in which a depth lies, and how far within; the head holds entries per unit of depth,
// gaps, and where they start.
fn place(head: vec4f, depth: f32) -> vec2f {
    let x = depth * head.x;
    let gap = clamp(floor(x), 0.0, head.y - 1.0);
    return vec2f(gap, x - gap);
}

// The mean of F over depths between middle - half and middle + half; a row holds ln F where its gap begins, how much
// that rises, its bend, and what is left behind it.
// twin: barnard::backend::cpu::terms::LookupTerms::accumulate
fn mean_left(head: vec4f, middle: f32, half: f32) -> f32 {
    let at = place(head, middle);
    let row = tables[u32(head.z) + u32(at.x)];
    let y = row.y * head.x * half;
    let bend = row.z * half * half;
    if abs(y) <= LOG_THIN && bend <= LOG_EVEN {
        return exp(fma(at.y, row.y, row.x)) * fma(bend, fma(0.1, y * y, 1.0 / 3.0), sinhc(y * y));
    }
    let first = place(head, middle - half);
    let last = place(head, middle + half);
    let front = tables[u32(head.z) + u32(first.x)];
    let back = tables[u32(head.z) + u32(last.x)];
    let in_front = fma(first.y, front.y, front.x);
    let behind = fma(last.y, back.y, back.x);
    if first.x == last.x {
        return between(in_front, behind);
    }
    let before = (1.0 - first.y) * between(in_front, front.x + front.y);
    let after = last.y * between(back.x, behind);
    let left = tables[u32(head.z) + u32(first.x) + 1u].w - back.w;
    return (before + after + left * head.x) / ((1.0 - first.y) + (last.x - first.x - 1.0) + last.y);
}

fn accumulate(state: ptr<function, State>, light: u32, at: vec2f, base: f32, middle: f32, half: f32) {
    turns += BANDS * BAND_TURNS + TERM_TURNS * frame.counts.x;
    for (var b = 0u; b < BANDS; b++) { // written out
        let mean = mean_left(constants[HEADS + light * BANDS + b], middle, abs(half));
        (*state).sum[b] += base * weight(light, b, at) * mean;
    }
}

// No bound is known.
fn left(light: u32, band: u32, depth: f32) -> f32 {
    return FAR;
}
