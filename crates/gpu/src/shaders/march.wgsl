// The march of one ray for each pixel and subpixel.

// A place of the image in halves of its width: from its own middle where it lies in a plane, from the axis of view where it
// does not.
// twin: barnard_scene::picture::camera::Camera::image_place
fn image_place(column: f32, row: f32) -> vec2f {
    let size = vec2f(frame.size.xy);
    let at = vec2f(2.0 / size.x * (column - 0.5 * size.x), 2.0 / size.x * (0.5 * size.y - row));
    return select(at, at + frame.turn_x.xy, SIGHT != PLANE);
}

// The direction at a place of an image of all around.
// twin: barnard_scene::picture::camera::panorama::PanoramaLayout::direction
fn panorama_direction(at: vec2f) -> vec3f {
    let axes = mat3x3f(frame.forward.xyz, frame.across.xyz, frame.upwards.xyz);
    if SIGHT == DOME {
        let angle = length(at);
        let aside = select(sin(angle) / angle, 1.0 - angle * angle / 6.0, angle < 1e-3);
        return normalize(axes * vec3f(cos(angle), aside * at));
    }
    if SIGHT == SPHERE {
        return normalize(axes * vec3f(cos(at.y) * cos(at.x), cos(at.y) * sin(at.x), sin(at.y)));
    }
    let below = CUBE_FACES - at.y;
    let face = clamp(floor(0.5 * below), 0.0, CUBE_FACES - 1.0);
    var faces = CUBE_AXES;
    let first = 3u * u32(face);
    let within = vec2f(at.x, 2.0 * face + 1.0 - below);
    return normalize(axes * (faces[first] + within.x * faces[first + 1u] + within.y * faces[first + 2u]));
}

// Where the eye stands that sees a direction, from the camera [pc].
// twin: barnard_scene::picture::camera::stereo::Eye::offset
fn eye_offset(direction: vec3f) -> vec3f {
    let up = vec3f(frame.across.w, frame.upwards.w, frame.forward.w);
    let side = cross(direction, up);
    let height = atan2(abs(dot(direction, up)), length(side));
    let fade = cos(HALF_PI * clamp((height - frame.turn_y.z) / (frame.turn_y.w - frame.turn_y.z), 0.0, 1.0));
    return frame.turn_y.x * fade / max(length(side), TINY) * side;
}

// Whether there is a ray through a place of the image.
// twin: barnard_scene::picture::camera::Camera::sees
fn sees(column: f32, row: f32) -> bool {
    let at = frame.turn_x.z * image_place(column, row);
    if SIGHT == DOME {
        return length(at) <= frame.turn_x.w;
    }
    if SIGHT == SPHERE {
        return abs(at.x) <= 2.0 * HALF_PI && abs(at.y) <= HALF_PI;
    }
    return SIGHT != CUBE || (abs(at.x) <= 1.0 && abs(at.y) <= CUBE_FACES);
}

// The ray through a place of the image; its origin lies in the plane through the middle of the scene, where f32 is
// finest.
// twin: barnard_scene::picture::camera::Camera::ray
fn camera_ray(column: f32, row: f32) -> Ray {
    let at = image_place(column, row);
    if SIGHT != PLANE {
        let towards = panorama_direction(frame.turn_x.z * at);
        let offset = eye_offset(towards);
        let direction = normalize(towards - frame.turn_y.y * offset);
        let ahead = max(-dot(frame.middle.xyz + offset, direction), 0.0);
        return Ray(frame.middle.xyz + offset + ahead * direction, direction, -ahead);
    }
    let origin = frame.middle.xyz + at.x * frame.across.xyz + at.y * frame.upwards.xyz;
    let direction = frame.forward.xyz + at.x * frame.turn_x.xyz + at.y * frame.turn_y.xyz;
    return Ray(origin, normalize(direction), -frame.middle.w * length(direction));
}

// Where a ray is inside of a box, as [near, far]; empty where far <= near.
// twin: barnard_scene::base::geometry::Bounds::clip
fn clip(ray: Ray, low: vec3f, high: vec3f, first: f32) -> vec2f {
    // No component is zero: a ray along an axis is turned by nothing that matters.
    let safe = select(ray.direction, vec3f(1e-12), abs(ray.direction) < vec3f(1e-12));
    let a = (low - ray.origin) / safe;
    let z = (high - ray.origin) / safe;
    let nearest = min(a, z);
    let furthest = max(a, z);
    return vec2f(max(max(nearest.x, nearest.y), max(nearest.z, first)), min(furthest.x, min(furthest.y, furthest.z)));
}

// Whether nothing behind can change any band by a part of the accuracy.
// twin: barnard::backend::cpu::march::March::ended
fn ended(state: ptr<function, State>, ray: Ray, here: f32, far: f32) -> bool {
    if (*state).tau * frame.limits.x < END_DEPTH {
        return false;
    }
    for (var b = 0u; b < BANDS; b++) { // written out
        var behind = 0.0;
        for (var s = 0u; s < SCATTERERS; s++) {
            let view = star_view(ray, s);
            let distance = max(sqrt(view.square), CLOSEST);
            let sky = (atan((far - view.foot) / distance) - atan((here - view.foot) / distance)) / distance;
            behind += left(s, b, (*state).tau) * frame.limits.z * sky;
        }
        for (var e = 0u; e < EMITTERS; e++) {
            behind += left(SCATTERERS + e, b, (*state).tau) * (far - here);
        }
        if HAS_SCATTERED_FIELD {
            for (var t = FIRST_TERM[b]; t < FIRST_TERM[b] + TERMS_OF[b]; t++) {
                // ∫ k σ e^(-k τ) ds is less than one.
                behind += numbers[4u * SCATTERED_LARGEST + t] * exp(-extinction(t) * (*state).tau);
            }
        }
        if behind > frame.limits.y * band_of(state, b) {
            return false;
        }
    }
    return true;
}

fn is_dark(values: ptr<function, array<vec4f, QUADS>>) -> bool {
    var light = 0.0;
    if HAS_DUST {
        light = (*values)[DUST_QUAD][DUST_LANE];
    }
    for (var e = 0u; e < EMITTERS; e++) { // written out
        light = max(light, (*values)[EMITTER_SLOTS[e] / 4u][EMITTER_SLOTS[e] % 4u]);
    }
    return light <= 0.0;
}

// All channels at a distance along a ray; star depths are marched `again` where the method does so.
fn sampled(ray: Ray, t: f32, mask: ptr<function, array<f32, QUADS>>, again: bool) -> array<vec4f, QUADS> {
    var p = ray.origin + t * ray.direction;
    if HAS_DETAIL {
        p = displaced(ray, t);
    }
    var values = read_all(p);
    if INNER > 0u {
        for (var q = 0u; q < QUADS; q++) { // written out
            values[q] *= (*mask)[q];
        }
    }
    if STAR_MARCH && again {
        for (var s = 0u; s < SCATTERERS; s++) { // written out
            values[STAR_SLOTS[s] / 4u][STAR_SLOTS[s] % 4u] = depth_again(constants[STARS + s].xyz, p);
        }
    }
    return values;
}

// The stretch of a ray in which steps of `dt` are long beside their distance to a star, as [near, far]; Barrès &
// Neyret's own form takes its samples and no more.
fn long_steps(ray: Ray, dt: f32) -> vec2f {
    var stretch = vec2f(FAR, -FAR);
    if STAR_MARCH {
        return stretch;
    }
    // A little more, whatever rounding says: how many parts there are is asked again.
    let reach = 1.001 * dt / PART_DISTANCE;
    for (var s = 0u; s < SCATTERERS; s++) {
        let view = star_view(ray, s);
        let square = fma(reach, reach, -view.square);
        if square > 0.0 {
            stretch = vec2f(min(stretch.x, view.foot - sqrt(square)), max(stretch.y, view.foot + sqrt(square)));
        }
    }
    return stretch;
}

// In how many parts the step from `start` must be marched.
fn parts_of(ray: Ray, start: f32, dt: f32) -> f32 {
    var most = 1.0;
    for (var s = 0u; s < SCATTERERS; s++) {
        let view = star_view(ray, s);
        most = max(most, parts(sqrt(view.square), view.foot - start, dt, frame.steps.z));
    }
    return most;
}

// How many of the voxels that are shortest along a direction there are in a pc.
// twin: barnard::plan::SpatialPlan::voxel_along
fn voxels_along(direction: vec3f) -> f32 {
    var most = 0.0;
    for (var i = 0u; i < VOXEL_KINDS; i++) {
        most = max(most, length(direction * constants[VOXELS + i].xyz));
    }
    // Cubes have one edge, whatever rounding says.
    return select(most, 1.0 / frame.steps.z, most * frame.steps.z > 0.999999);
}

// The part of a ray between two borders, from where its state is; whether it came to the end. Steps start `offset` of
// one early, held to the span.
fn march_span(state: ptr<function, State>, ray: Ray, near: f32, far: f32, offset: f32, final_span: bool) -> bool {
    let fixed = frame.steps.y;
    let whole = select(max(ceil((far - near) * voxels_along(ray.direction) * frame.steps.x), 1.0), fixed, fixed > 0.0);
    let dt = (far - near) / whole;
    let steps = whole + ceil(offset);
    let long = long_steps(ray, dt);
    var mask = masks(ray.origin + 0.5 * (near + far) * ray.direction);
    var before: array<vec4f, QUADS>;
    // At the border, behind a jump, and where the ray paused, what is before a step is read first.
    var fresh = true;
    var unclear = near;
    while (*state).step < steps {
        turns += STEP_TURNS;
        let start = clamp(near + ((*state).step - offset) * dt, near, far);
        let length = clamp(near + ((*state).step + 1.0 - offset) * dt, near, far) - start;
        var count = 1.0;
        if start < long.y && start + length > long.x {
            count = parts_of(ray, start, length);
        }
        // A brick that holds something is left before another one is asked.
        if !fresh && (*state).part == 0.0 && start >= unclear && is_dark(&before) {
            let clear = clear_pc(ray, start);
            let jump = floor(clear.x / dt);
            if jump > 1.0 {
                (*state).step = min((*state).step + jump, steps);
                fresh = true;
                continue;
            }
            unclear = clear.y;
        }
        while (*state).part < count {
            turns += PART_TURNS;
            let step_span = StepSpan(start + (*state).part * length / count, length / count);
            let ahead = select(step_span.length, 0.0, fresh);
            var after = sampled(ray, step_span.start + ahead, &mask, !fresh || (*state).part > 0.0);
            if fresh {
                before = after;
                fresh = false;
                if (*state).part == 0.0 {
                    break;
                }
                continue;
            }
            var middle: array<vec4f, QUADS>;
            if HAS_MIDDLES {
                middle = sampled(ray, step_span.start + 0.5 * step_span.length, &mask, false);
            }
            segment(state, ray, step_span, &before, &middle, &after);
            before = after;
            (*state).part += 1.0;
            if PAUSES && turns > frame.size.z {
                return false;
            }
        }
        if (*state).part < count {
            // It may be dark here.
            continue;
        }
        (*state).part = 0.0;
        (*state).step += 1.0;
        if final_span && u32((*state).step) % END_EVERY == 0u && ended(state, ray, near + ((*state).step - offset) * dt, far) {
            break;
        }
    }
    return true;
}

// All of a ray: the borders of volumes that end within the occupied box cut it into spans; whether it came to the end.
fn march_ray(state: ptr<function, State>, ray: Ray, offset: f32) -> bool {
    let whole = clip(ray, frame.low.xyz, frame.high.xyz, ray.first);
    if whole.y <= whole.x {
        return true;
    }
    var ends: array<f32, BORDERS>;
    ends[0] = whole.x;
    ends[1] = whole.y;
    for (var i = 0u; i < INNER; i++) { // written out
        let inner = clip(ray, constants[INNER_BOXES + 2u * i].xyz, constants[INNER_BOXES + 2u * i + 1u].xyz, whole.x);
        let hit = inner.y > inner.x;
        ends[2u + 2u * i] = select(whole.y, clamp(inner.x, whole.x, whole.y), hit);
        ends[3u + 2u * i] = select(whole.y, clamp(inner.y, whole.x, whole.y), hit);
    }
    turns += BORDERS * BORDERS;
    for (var i = 0u; i < INNER_BORDERS; i++) { // written out
        for (var j = 0u; j < SPANS; j++) { // written out
            let nearer = min(ends[j], ends[j + 1u]);
            ends[j + 1u] = max(ends[j], ends[j + 1u]);
            ends[j] = nearer;
        }
    }
    while (*state).span < SPANS {
        var near = ends[0];
        var far = ends[1];
        for (var i = 0u; i < SPANS; i++) { // written out
            if i == (*state).span {
                near = ends[i];
                far = ends[i + 1u];
            }
        }
        if far > near && !march_span(state, ray, near, far, offset, far >= ends[BORDERS - 1u] && !HAS_BACKGROUND) {
            return false;
        }
        (*state).span += 1u;
        (*state).step = 0.0;
    }
    return true;
}

// The part of a step in which a pixel's ray starts, another for each pixel and picture.
fn start_of(pixel: vec2u) -> f32 {
    if frame.jitter.z < 0.0 {
        return 0.0;
    }
    // Interleaved gradient noise (Jimenez 2014).
    let noise = fract(52.9829189 * fract(dot(vec2f(pixel), vec2f(0.06711056, 0.00583715))));
    return fract(noise + frame.jitter.z);
}

fn loops_turn() -> bool {
    var n = 0.0;
    while n < frame.depths.y {
        n += 1.0;
    }
    return n >= frame.depths.y;
}

// A ray goes on where it paused; false where it is done.
fn resumed(state: ptr<function, State>, ray: u32) -> bool {
    let rays = frame.size.x * frame.strip.w;
    var at = ray;
    if paused[at] < 0.0 {
        // It has not begun.
        return true;
    }
    (*state).span = u32(paused[at]);
    (*state).step = paused[at + rays];
    (*state).part = paused[at + 2u * rays];
    (*state).tau = paused[at + 3u * rays];
    (*state).deepest = paused[at + 4u * rays];
    at += 5u * rays;
    for (var s = 0u; s < SUMS; s++) { // written out
        (*state).sum[s] = paused[at + s * rays];
    }
    at += SUMS * rays;
    for (var c = 0u; c < FIELD_CHANNELS; c++) {
        (*state).field[c] = paused[at + c * rays];
    }
    return (*state).span < BORDERS;
}

fn pause(state: ptr<function, State>, ray: u32) {
    let rays = frame.size.x * frame.strip.w;
    var at = ray;
    paused[at] = f32((*state).span);
    paused[at + rays] = (*state).step;
    paused[at + 2u * rays] = (*state).part;
    paused[at + 3u * rays] = (*state).tau;
    paused[at + 4u * rays] = (*state).deepest;
    at += 5u * rays;
    for (var s = 0u; s < SUMS; s++) { // written out
        paused[at + s * rays] = (*state).sum[s];
    }
    at += SUMS * rays;
    for (var c = 0u; c < FIELD_CHANNELS; c++) {
        paused[at + c * rays] = (*state).field[c];
    }
}

@compute @workgroup_size(WORKGROUP_X, WORKGROUP_Y)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= frame.size.x || id.y >= frame.strip.y {
        return;
    }
    let y = frame.strip.x + id.y;
    let number = (y - frame.strip.z) * frame.size.x + id.x;
    var state: State;
    if PAUSES && frame.size.w > 0u && !resumed(&state, number) {
        return;
    }
    let at = vec2f(f32(id.x), f32(y)) + 0.5 + frame.jitter.xy;
    let seen = sees(at.x, at.y);
    var done = true;
    if seen {
        done = march_ray(&state, camera_ray(at.x, at.y), start_of(vec2u(id.x, y)));
    }
    if done && HAS_FIELD {
        resolve_field(&state);
    }
    if done && seen && HAS_BACKGROUND {
        accumulate(&state, SCATTERERS + EMITTERS, vec2f(0.0), 1.0, state.tau, 0.0);
    }
    if PAUSES {
        if !loops_turn() {
            // All since the last pause is worth nothing; no loop may say so.
            atomicMax(&stats[2], 1u);
            if frame.size.w == 0u {
                paused[number] = -1.0;
            }
            return;
        }
        if !done {
            atomicMax(&stats[1], 1u);
            pause(&state, number);
            return;
        }
    }
    atomicMax(&stats[0], bitcast<u32>(max(state.deepest, state.tau)));
    for (var b = 0u; b < BANDS; b++) { // written out
        let at = b * frame.size.x * frame.strip.w + number;
        var value = band_of(&state, b);
        if frame.jitter.w < 1.0 {
            value = mix(picture[at], value, frame.jitter.w);
        }
        picture[at] = value;
    }
    if PAUSES {
        state.span = BORDERS;
        pause(&state, number);
    }
}
