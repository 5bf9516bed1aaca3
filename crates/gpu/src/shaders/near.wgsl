// The neighbourhood of a star: pieces of equal angle, each with its density and its own depth.

// In how many parts a step must be marched, so that each is short beside its distance to a star.
// twin: barnard::plan::near::parts
fn parts(b: f32, foot: f32, dt: f32, voxel: f32) -> f32 {
    let nearest = foot - clamp(foot, 0.0, dt);
    let distance = max(sqrt(b * b + nearest * nearest), NEAR_VOXELS * voxel);
    return max(ceil(min(dt / (PART_DISTANCE * distance), dt / (SHORTEST_PART * voxel))), 1.0);
}

// Optical depth at V between two near places, by midpoints a quarter of a voxel apart.
fn depth_between(a: vec3f, z: vec3f) -> f32 {
    let length = distance(a, z);
    let count = clamp(ceil(4.0 * length / frame.steps.z), 1.0, MAX_DEPTH_STEPS);
    turns += u32(count);
    var depth = 0.0;
    for (var i = 0.0; i < count; i += 1.0) {
        depth += read_dust(mix(a, z, (i + 0.5) / count));
    }
    return depth * length / count;
}

// twin: barnard::plan::near::pieces
fn near(state: ptr<function, State>, ray: Ray, scatterer: u32, b: f32, foot: f32, step_span: StepSpan, growth: f32) {
    let star = constants[STARS + scatterer].xyz;
    let start = atan((step_span.start - foot) / b);
    let end = atan((step_span.start + step_span.length - foot) / b);
    let count = clamp(ceil(max((end - start) / PIECE, growth / PIECE_DEPTH)), 2.0, MAX_PIECES);
    let width = (end - start) / count;
    var asked = 1u;
    if PHASE_KIND != ISOTROPIC {
        asked = phases(width);
    }
    turns += u32(count) * (2u + asked);
    for (var i = 0.0; i < count; i += 1.0) {
        let t = foot + b * tan(start + (i + 0.5) * width);
        let along = (*state).tau + growth * clamp((t - step_span.start) / step_span.length, 0.0, 1.0);
        var lit = ray.origin + t * ray.direction;
        if HAS_DETAIL {
            lit = displaced(ray, t);
        }
        let depth = along + depth_between(star, lit);
        // One depth serves all angles: their light is summed first, where one p(θ) serves all terms.
        var spread = 0.0;
        for (var j = 0u; j < asked; j++) {
            let theta = start + (i + (f32(j) + 0.5) / f32(asked)) * width;
            let place = foot + b * tan(theta);
            var seen = ray.origin + place * ray.direction;
            if HAS_DETAIL {
                seen = displaced(ray, place);
            }
            let sigma = read_dust(seen);
            let scattering = sigma * width / (b * f32(asked));
            let cosine = -sin(theta);
            let at = phase_entry(cosine, 1.0 - cosine * cosine);
            if PHASE_KIND == SPECTRAL {
                accumulate(state, scatterer, at, scattering, depth, 0.0);
            } else {
                spread += scattering * phase_value(scatterer, at);
            }
        }
        if PHASE_KIND != SPECTRAL {
            accumulate(state, scatterer, vec2f(0.0), spread, depth, 0.0);
        }
    }
}

// Optical depth at V from a star to a place, by midpoints through the box of dust: Barrès & Neyret's double
// integration.
// twin: barnard::backend::cpu::double_integration::depths_of
fn depth_again(star: vec3f, p: vec3f) -> f32 {
    let length = distance(star, p);
    let box = lattice(DUST_QUAD);
    let inside = clip(Ray(star, (p - star) / max(length, TINY), 0.0), box.low.xyz, box.high.xyz, 0.0);
    let dt = max(min(inside.y, length) - inside.x, 0.0) / f32(frame.counts.w);
    turns += frame.counts.w;
    var depth = 0.0;
    for (var i = 0u; i < frame.counts.w; i++) {
        depth += dt * read_dust(star + (inside.x + (f32(i) + 0.5) * dt) / max(length, TINY) * (p - star));
        if i % 16u == 15u && depth > OPAQUE {
            break;
        }
    }
    return min(depth, OPAQUE);
}
