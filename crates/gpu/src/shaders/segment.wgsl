// The light of one segment in closed form, eqs. (5) and (6) of docs/method.md.

// A star as a ray passes it: where it comes nearest, and the square of how near.
struct StarView {
    foot: f32,
    square: f32,
}

fn star_view(ray: Ray, scatterer: u32) -> StarView {
    let star = constants[STARS + scatterer].xyz;
    let foot = dot(star - ray.origin, ray.direction);
    let beside = star - (ray.origin + foot * ray.direction);
    return StarView(foot, dot(beside, beside));
}

// A segment as a star sees it.
struct SegmentView {
    // 1/p, p = b² + t₀ t₁, t from the foot.
    inverse: f32,
    // q², q = b Δt/p, the tangent of the angle between both ends.
    tangent2: f32,
    // Whether it is so near that it is marched in pieces.
    is_near: bool,
}

fn segment_view(view: StarView, step_span: StepSpan) -> SegmentView {
    let t0 = step_span.start - view.foot;
    let p = fma(t0, t0 + step_span.length, view.square);
    let reach = NEAR_VOXELS * frame.steps.z;
    let inverse = 1.0 / p;
    let ratio = step_span.length * inverse;
    let tangent2 = view.square * ratio * ratio;
    return SegmentView(inverse, tangent2, p < reach * reach || tangent2 > NEAR_ANGLE * NEAR_ANGLE);
}

// Light of one star, scattered in one segment; false where the segment is near to it, and nothing is done.
// twin: barnard::backend::cpu::shading::scatter
fn scatter(state: ptr<function, State>, ray: Ray, scatterer: u32, step_span: StepSpan, growth: f32, sigma: vec3f, depths: vec3f) -> bool {
    let view = star_view(ray, scatterer);
    let seen = segment_view(view, step_span);
    let middle = fma(0.5, growth, (*state).tau) + mean_over_dust(sigma, depths);
    let half = 0.5 * (growth + depths.z - depths.x);
    (*state).deepest = max((*state).deepest, middle + abs(half));
    if seen.is_near {
        return false;
    }
    let mean = mean_inverse_square(seen.tangent2, seen.inverse);
    if PHASE_KIND == ISOTROPIC {
        accumulate(state, scatterer, vec2f(0.0), mean * growth, middle, half);
        return true;
    }
    // The light at some angles goes as σ/r²; one angle in the middle of the segment, mostly.
    let count = phases(mean * sqrt(view.square) * step_span.length);
    turns += 2u * count;
    let ends = sigma.x + sigma.z;
    let tilt = select(0.0, 2.0 * (sigma.z - sigma.x) / max(ends, TINY), ends > 0.0);
    let along = step_span.start - view.foot + 0.5 * step_span.length;
    var total = 0.0;
    var spread = 0.0;
    for (var j = 0u; j < count; j++) {
        let part = (f32(j) + 0.5) / f32(count) - 0.5;
        let t = fma(part, step_span.length, along);
        let inverse = 1.0 / max(fma(t, t, view.square), TINY);
        total += inverse;
        if PHASE_KIND == SEPARABLE {
            spread += fma(part, tilt, 1.0) * inverse * phase_value(scatterer, phase_entry(-t * sqrt(inverse), view.square * inverse));
        }
    }
    if PHASE_KIND == SEPARABLE {
        accumulate(state, scatterer, vec2f(0.0), mean * growth * spread / total, middle, half);
        return true;
    }
    for (var j = 0u; j < count; j++) {
        let part = (f32(j) + 0.5) / f32(count) - 0.5;
        let t = fma(part, step_span.length, along);
        let inverse = 1.0 / max(fma(t, t, view.square), TINY);
        let share = fma(part, tilt, 1.0) * inverse / total;
        accumulate(state, scatterer, phase_entry(-t * sqrt(inverse), view.square * inverse), mean * growth * share, middle, half);
    }
    return true;
}

// ⟨1/r²⟩ over a segment: atan(q)/(q p), q = b Δt/p, where q is small.
// twin: barnard::plan::segment::mean_inverse_square
fn mean_inverse_square(q2: f32, inverse_p: f32) -> f32 {
    return fma(q2, fma(q2, fma(q2, fma(q2, 1.0 / 9.0, -1.0 / 7.0), 1.0 / 5.0), -1.0 / 3.0), 1.0) * inverse_p;
}

// The depths from a star to the ends of a segment, its middle between them.
fn star_depths(scatterer: u32, before: ptr<function, array<vec4f, QUADS>>, middle: ptr<function, array<vec4f, QUADS>>, after: ptr<function, array<vec4f, QUADS>>) -> vec3f {
    var depths = vec3f(0.0);
    for (var s = 0u; s < SCATTERERS; s++) { // written out
        if s == scatterer {
            let slot = STAR_SLOTS[s];
            depths = vec3f((*before)[slot / 4u][slot % 4u], (*middle)[slot / 4u][slot % 4u], (*after)[slot / 4u][slot % 4u]);
        }
    }
    return depths;
}

fn scatter_stars(state: ptr<function, State>, ray: Ray, step_span: StepSpan, growth: f32, before: ptr<function, array<vec4f, QUADS>>, middle: ptr<function, array<vec4f, QUADS>>, after: ptr<function, array<vec4f, QUADS>>) {
    let sigma = vec3f((*before)[DUST_QUAD][DUST_LANE], (*middle)[DUST_QUAD][DUST_LANE], (*after)[DUST_QUAD][DUST_LANE]);
    var all_far = true;
    for (var s = 0u; s < STARS_IN_TURN; s++) { // written out
        let is_far = scatter(state, ray, s, step_span, growth, sigma, star_depths(s, before, middle, after));
        all_far = all_far && is_far;
    }
    if all_far {
        return;
    }
    for (var s = 0u; s < SCATTERERS; s++) {
        let view = star_view(ray, s);
        if segment_view(view, step_span).is_near {
            near(state, ray, s, max(sqrt(view.square), CLOSEST), view.foot, step_span, growth);
        }
    }
}

// Light of one segment that was scattered before.
// twin: barnard::backend::cpu::shading::scatter_again
fn scatter_again(state: ptr<function, State>, growth: f32, before: ptr<function, array<vec4f, QUADS>>, middle: ptr<function, array<vec4f, QUADS>>, after: ptr<function, array<vec4f, QUADS>>) {
    turns += BANDS * BAND_TURNS + TERM_TURNS * frame.counts.x;
    for (var b = 0u; b < BANDS; b++) { // written out
        var sum = 0.0;
        for (var t = 0u; t < TERMS_OF[b]; t++) { // written out
            let term = FIRST_TERM[b] + t;
            let k = extinction(term);
            let quad = SCATTERED_QUAD + term / 4u;
            let source = 0.5 * twice_the_mean((*before)[quad][term % 4u], (*middle)[quad][term % 4u], (*after)[quad][term % 4u]);
            sum = fma(k * source, mean_transmittance(k * ((*state).tau + 0.5 * growth), 0.5 * k * growth), sum);
        }
        (*state).sum[b] = fma(growth, sum, (*state).sum[b]);
    }
}

// Two times the mean over a segment of what is linear between its samples.
// twin: barnard::backend::cpu::segment::Segment::twice_the_mean
fn twice_the_mean(before: f32, middle: f32, after: f32) -> f32 {
    if HAS_MIDDLES {
        return fma(0.5, before + after, middle);
    }
    return before + after;
}

// Mean of min(max(u, 0), 1) between two values of u, linear in between.
// twin: barnard_scene::medium::field::front::mean_share
fn mean_share(before: f32, after: f32) -> f32 {
    let ends = vec2f(before, after);
    let below = max(ends, vec2f(0.0));
    let primitive = select(ends - 0.5, 0.5 * below * below, ends < vec2f(1.0));
    let change = after - before;
    let is_even = abs(change) < EVEN_FRONT;
    return select((primitive.y - primitive.x) / select(change, 1.0, is_even), clamp(0.5 * (before + after), 0.0, 1.0), is_even);
}

// Shares of the halves of a segment that are in front of the front; without middles, of all of it.
fn front_shares(before: ptr<function, array<vec4f, QUADS>>, middle: ptr<function, array<vec4f, QUADS>>, after: ptr<function, array<vec4f, QUADS>>) -> vec2f {
    if !HAS_FRONT {
        return vec2f(1.0);
    }
    let u = vec3f((*before)[FRONT_SLOT / 4u][FRONT_SLOT % 4u], (*middle)[FRONT_SLOT / 4u][FRONT_SLOT % 4u], (*after)[FRONT_SLOT / 4u][FRONT_SLOT % 4u]);
    if HAS_MIDDLES {
        return vec2f(mean_share(u.x, u.y), mean_share(u.y, u.z));
    }
    return vec2f(mean_share(u.x, u.z));
}

// Two times the mean density of a gas over a segment, and over its first half as a part of the whole, given the density at the
// beginning, the middle and the end.
// twin: barnard::backend::cpu::segment::Segment::twice_the_glow
fn twice_the_glow(density: vec3f, shares: vec2f) -> vec2f {
    if HAS_MIDDLES {
        let halves = 0.5 * shares * (density.xz + density.y);
        return vec2f(halves.x + halves.y, halves.x);
    }
    return vec2f(shares.x * (density.x + density.z), 0.0);
}

// The mean of a value over the light that the dust scatters, given both at the beginning, the middle and the end.
// twin: barnard::backend::cpu::segment::Segment::mean_over_dust
fn mean_over_dust(sigma: vec3f, value: vec3f) -> f32 {
    if !HAS_MIDDLES {
        return 0.5 * (value.x + value.z);
    }
    let all = sigma.x + 2.0 * sigma.y + sigma.z;
    let sum = fma(sigma.x, 2.0 * value.x + value.y, fma(sigma.y, value.x + 4.0 * value.y + value.z, sigma.z * (value.y + 2.0 * value.z)));
    return sum / select(1.0, 3.0 * all, all > 0.0);
}

// The mean depth from a segment's beginning of what all gas sends along it.
// twin: barnard::backend::cpu::segment::Segment::mean_depth
fn mean_depth_of_gas(step_span: StepSpan, growth: f32, before: ptr<function, array<vec4f, QUADS>>, middle: ptr<function, array<vec4f, QUADS>>, after: ptr<function, array<vec4f, QUADS>>) -> f32 {
    if !HAS_MIDDLES {
        return 0.5 * growth;
    }
    let shares = front_shares(before, middle, after);
    var all = 0.0;
    var early = 0.0;
    for (var e = 0u; e < EMITTERS; e++) { // written out
        let slot = EMITTER_SLOTS[e];
        let density = vec3f((*before)[slot / 4u][slot % 4u], (*middle)[slot / 4u][slot % 4u], (*after)[slot / 4u][slot % 4u]);
        let total = constants[EMITTED + e].x;
        let glow = twice_the_glow(density, select(vec2f(1.0), shares, FRONTED[e] > 0u));
        all = fma(total, glow.x, all);
        early = fma(total, glow.y, early);
    }
    let share = select(0.5, early / max(all, TINY), all > 0.0);
    var first = 0.0;
    if HAS_DUST {
        first = 0.25 * step_span.length * ((*before)[DUST_QUAD][DUST_LANE] + (*middle)[DUST_QUAD][DUST_LANE]);
    }
    return fma(0.5 * growth, 1.0 - share, 0.5 * first);
}

// Adds the light of one segment and moves the depth to its end.
// twin: barnard::backend::cpu::shading::add
fn segment(state: ptr<function, State>, ray: Ray, step_span: StepSpan, before: ptr<function, array<vec4f, QUADS>>, middle: ptr<function, array<vec4f, QUADS>>, after: ptr<function, array<vec4f, QUADS>>) {
    var growth = 0.0;
    if HAS_DUST {
        let dust = twice_the_mean((*before)[DUST_QUAD][DUST_LANE], (*middle)[DUST_QUAD][DUST_LANE], (*after)[DUST_QUAD][DUST_LANE]);
        growth = 0.5 * step_span.length * dust;
        if growth > 0.0 {
            if HAS_FIELD {
                accumulate_field(state, growth, before, after);
            } else {
                scatter_stars(state, ray, step_span, growth, before, middle, after);
            }
            if MANY_LIGHTS > 0u {
                let dust = vec2f((*before)[DUST_QUAD][DUST_LANE], (*after)[DUST_QUAD][DUST_LANE]);
                scatter_near_field(state, ray, step_span, growth, dust);
                // How deep the stars shine is known for all of them alone.
                (*state).deepest = max((*state).deepest, (*state).tau + growth + frame.depths.x);
            }
            if HAS_SCATTERED_FIELD {
                scatter_again(state, growth, before, middle, after);
            }
        }
    }
    let gas_depth = mean_depth_of_gas(step_span, growth, before, middle, after);
    let shares = front_shares(before, middle, after);
    for (var e = 0u; e < EMITTERS; e++) { // written out
        let slot = EMITTER_SLOTS[e];
        let density = vec3f((*before)[slot / 4u][slot % 4u], (*middle)[slot / 4u][slot % 4u], (*after)[slot / 4u][slot % 4u]);
        let light = 0.5 * step_span.length * twice_the_glow(density, select(vec2f(1.0), shares, FRONTED[e] > 0u)).x;
        if light > 0.0 {
            accumulate(state, SCATTERERS + e, vec2f(0.0), light, (*state).tau + gas_depth, 0.5 * growth);
        }
    }
    (*state).tau += growth;
}
