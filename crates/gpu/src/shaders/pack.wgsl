// Swept depths into one channel of a texture: moved so that means over voxels are right, and carried on into the layer
// around the box.

struct Pack {
    // Voxels of the box; the channel.
    dims: vec4u,
    // Stored ones in a depth of one.
    scale: vec4f,
}

@group(0) @binding(0) var<uniform> pack: Pack;
@group(0) @binding(1) var<storage, read> swept: array<f32>;
// The same, moved.
@group(0) @binding(4) var<storage, read_write> settled: array<f32>;
@group(0) @binding(2) var before: texture_3d<f32>;
@group(0) @binding(3) var after: texture_storage_3d<rgba16float, write>;

fn index(p: vec3i) -> i32 {
    let d = vec3i(pack.dims.xyz);
    return (p.z * d.y + p.y) * d.x + p.x;
}

fn depth(p: vec3i) -> f32 {
    return swept[index(p)];
}

// Moved by a twelfth of the second difference along each axis, not past its neighbours.
// twin: barnard::plan::star_depths::match_means
fn match_mean(p: vec3i) -> f32 {
    let own = depth(p);
    var low = own;
    var high = own;
    var second = 0.0;
    for (var axis = 0u; axis < 3u; axis++) {
        let last = i32(pack.dims[axis]) - 1;
        if last < 2 {
            continue;
        }
        var at = p;
        at[axis] = clamp(p[axis], 1, last - 1);
        let b = depth(at);
        at[axis] -= 1;
        let a = depth(at);
        at[axis] += 2;
        let c = depth(at);
        second += a - 2.0 * b + c;
        low = min(low, min(a, min(b, c)));
        high = max(high, max(a, max(b, c)));
    }
    return clamp(own - second / 12.0, low, high);
}

@compute @workgroup_size(4, 4, 4)
fn settle(@builtin(global_invocation_id) id: vec3u) {
    if all(id < pack.dims.xyz) {
        settled[index(vec3i(id))] = match_mean(vec3i(id));
    }
}

fn matched(p: vec3i) -> f32 {
    return settled[index(p)];
}

// What goes on behind two voxels.
fn on(near: f32, far: f32) -> f32 {
    return max(2.0 * near - far, -abs(near));
}

// twin: barnard::volume::Volume::extrapolate
fn along_x(p: vec3i) -> f32 {
    let last = i32(pack.dims.x) + 1;
    let inner = p - vec3i(1);
    if p.x == 0 {
        return on(matched(inner + vec3i(1, 0, 0)), matched(inner + vec3i(2, 0, 0)));
    }
    if p.x == last {
        return on(matched(inner - vec3i(1, 0, 0)), matched(inner - vec3i(2, 0, 0)));
    }
    return matched(inner);
}

fn along_y(p: vec3i) -> f32 {
    let last = i32(pack.dims.y) + 1;
    if p.y == 0 {
        return on(along_x(p + vec3i(0, 1, 0)), along_x(p + vec3i(0, 2, 0)));
    }
    if p.y == last {
        return on(along_x(p - vec3i(0, 1, 0)), along_x(p - vec3i(0, 2, 0)));
    }
    return along_x(p);
}

fn along_z(p: vec3i) -> f32 {
    let last = i32(pack.dims.z) + 1;
    if p.z == 0 {
        return on(along_y(p + vec3i(0, 0, 1)), along_y(p + vec3i(0, 0, 2)));
    }
    if p.z == last {
        return on(along_y(p - vec3i(0, 0, 1)), along_y(p - vec3i(0, 0, 2)));
    }
    return along_y(p);
}

@compute @workgroup_size(4, 4, 4)
fn carry_on(@builtin(global_invocation_id) id: vec3u) {
    if any(id >= pack.dims.xyz + 2u) {
        return;
    }
    let p = vec3i(id);
    var values = textureLoad(before, p, 0);
    values[pack.dims.w] = clamp(along_z(p) * pack.scale.x, -65504.0, 65504.0);
    textureStore(after, p, values);
}
