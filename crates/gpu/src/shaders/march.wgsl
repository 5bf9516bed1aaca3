// The march of one ray for each pixel and subpixel.

// The ray through a place of the image; its origin lies in the plane through the middle of the scene, where f32 is finest.
// twin: barnard::camera::Camera::ray
fn camera_ray(column: f32, row: f32) -> Ray {
    let size = vec2f(frame.size.xy);
    let at = vec2f(2.0 / size.x * (column - 0.5 * size.x), 2.0 / size.x * (0.5 * size.y - row));
    let origin = frame.middle.xyz + at.x * frame.across.xyz + at.y * frame.upwards.xyz;
    let direction = frame.forward.xyz + at.x * frame.turn_x.xyz + at.y * frame.turn_y.xyz;
    return Ray(origin, normalize(direction), -frame.middle.w * length(direction));
}

// Where a ray is inside of a box, as [near, far]; empty where far <= near.
// twin: barnard::geometry::Bounds::clip
fn clip(ray: Ray, low: vec3f, high: vec3f, first: f32) -> vec2f {
    // No component is zero: a ray along an axis is turned by nothing that matters.
    let safe = select(ray.direction, vec3f(1e-12), abs(ray.direction) < vec3f(1e-12));
    let a = (low - ray.origin) / safe;
    let z = (high - ray.origin) / safe;
    let nearest = min(a, z);
    let furthest = max(a, z);
    return vec2f(max(max(nearest.x, nearest.y), max(nearest.z, first)), min(furthest.x, min(furthest.y, furthest.z)));
}

// Whether nothing behind can change any term by a part of the accuracy.
// twin: barnard::backend::cpu::march::March::ended
fn ended(state: ptr<function, State>, ray: Ray, here: f32, far: f32) -> bool {
    if (*state).tau * frame.limits.x < END_DEPTH {
        return false;
    }
    for (var c = 0u; c < TERM_QUADS; c++) {
        var behind = vec4f(0.0);
        for (var s = 0u; s < SCATTERERS; s++) {
            let star = tables[STARS + s].xyz;
            let foot = dot(star - ray.origin, ray.direction);
            let b = max(length(star - (ray.origin + foot * ray.direction)), CLOSEST);
            behind += tables[BRIGHTEST + s * TERM_QUADS + c] * frame.limits.z * (atan((far - foot) / b) - atan((here - foot) / b)) / b;
        }
        for (var e = 0u; e < EMITTERS; e++) {
            behind += tables[BRIGHTEST + (SCATTERERS + e) * TERM_QUADS + c] * (far - here);
        }
        if any(exp(-tables[EXTINCTION + c] * (*state).tau) * behind > frame.limits.y * (*state).sum[c]) {
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
    for (var e = 0u; e < EMITTERS; e++) {
        let slot = u32(tables[EMITTER_SLOTS + e].x);
        light = max(light, (*values)[slot / 4u][slot % 4u]);
    }
    return light <= 0.0;
}

fn masked(p: vec3f, mask: ptr<function, array<f32, QUADS>>) -> array<vec4f, QUADS> {
    var values = read_all(p);
    for (var q = 0u; q < QUADS; q++) {
        values[q] *= (*mask)[q];
    }
    return values;
}

// In how many parts the step from `start` must be marched.
fn parts_of(ray: Ray, start: f32, dt: f32) -> f32 {
    var most = 1.0;
    for (var s = 0u; s < SCATTERERS; s++) {
        let foot = dot(tables[STARS + s].xyz - ray.origin, ray.direction);
        let b = length(tables[STARS + s].xyz - (ray.origin + foot * ray.direction));
        most = max(most, parts(b, foot - start, dt, frame.steps.z));
    }
    return most;
}

// The part of a ray between two borders.
fn march_span(state: ptr<function, State>, ray: Ray, near: f32, far: f32, final_span: bool) {
    let fixed = frame.steps.y;
    let steps = select(max(ceil((far - near) * frame.steps.x), 1.0), fixed, fixed > 0.0);
    let dt = (far - near) / steps;
    var mask = masks(ray.origin + 0.5 * (near + far) * ray.direction);
    var before = masked(ray.origin + near * ray.direction, &mask);
    var step = 0.0;
    while step < steps {
        let start = near + step * dt;
        // Jump over empty space; the sample behind the jump starts anew.
        if is_dark(&before) {
            let jump = floor(clear_pc(ray.origin + start * ray.direction) / dt);
            if jump > 1.0 {
                step = min(step + jump, steps);
                before = masked(ray.origin + (near + step * dt) * ray.direction, &mask);
                continue;
            }
        }
        let count = parts_of(ray, start, dt);
        for (var part = 0.0; part < count; part += 1.0) {
            let stretch = Stretch(start + part * dt / count, dt / count);
            var after = masked(ray.origin + (stretch.start + stretch.length) * ray.direction, &mask);
            segment(state, ray, stretch, &before, &after);
            before = after;
        }
        step += 1.0;
        if final_span && u32(step) % END_EVERY == 0u && ended(state, ray, near + step * dt, far) {
            break;
        }
    }
}

// All of a ray: the borders of volumes that end within the occupied box cut it into spans.
fn march_ray(ray: Ray) -> State {
    var state: State;
    let whole = clip(ray, frame.low.xyz, frame.high.xyz, ray.first);
    if whole.y <= whole.x {
        return state;
    }
    var ends: array<f32, BORDERS>;
    ends[0] = whole.x;
    ends[1] = whole.y;
    for (var i = 0u; i < INNER; i++) {
        let inner = clip(ray, tables[INNER_BOXES + 2u * i].xyz, tables[INNER_BOXES + 2u * i + 1u].xyz, whole.x);
        let hit = inner.y > inner.x;
        ends[2u + 2u * i] = select(whole.y, clamp(inner.x, whole.x, whole.y), hit);
        ends[3u + 2u * i] = select(whole.y, clamp(inner.y, whole.x, whole.y), hit);
    }
    for (var i = 1u; i < BORDERS; i++) {
        let end = ends[i];
        var j = i;
        while j > 0u && ends[j - 1u] > end {
            ends[j] = ends[j - 1u];
            j--;
        }
        ends[j] = end;
    }
    for (var i = 0u; i + 1u < BORDERS; i++) {
        if ends[i + 1u] > ends[i] {
            march_span(&state, ray, ends[i], ends[i + 1u], i + 2u == BORDERS && !HAS_BACKGROUND);
        }
    }
    return state;
}

@compute @workgroup_size(WORKGROUP_X, WORKGROUP_Y)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let rows = frame.strip.y;
    if id.x >= frame.size.x || id.y >= rows {
        return;
    }
    let sub = frame.size.z;
    let pixel = id.y * frame.size.x + id.x;
    var bands: array<f32, BANDS>;
    for (var i = 0u; i < sub * sub; i++) {
        let column = f32(id.x) + (f32(i % sub) + 0.5) / f32(sub);
        let row = f32(frame.strip.x + id.y) + (f32(i / sub) + 0.5) / f32(sub);
        var state = march_ray(camera_ray(column, row));
        atomicMax(&found[0], bitcast<u32>(state.deepest));
        for (var t = 0u; t < TERMS; t++) {
            var light = state.sum[t / 4u][t % 4u];
            if HAS_BACKGROUND {
                light += tables[BACKGROUND + t / 4u][t % 4u] * exp(-tables[EXTINCTION + t / 4u][t % 4u] * state.tau);
            }
            bands[u32(tables[BAND_OF + t / 4u][t % 4u])] += light / f32(sub * sub);
        }
    }
    for (var b = 0u; b < BANDS; b++) {
        radiance[b * rows * frame.size.x + pixel] = bands[b];
    }
}
