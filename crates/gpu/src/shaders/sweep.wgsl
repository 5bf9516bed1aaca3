// Star depths by rays through a frustum that has the star at its apex; see
// barnard::plan::star_depths::frustum_sweep. One invocation
// follows one ray through all planes.

struct Sweep {
    // From voxels along u, v and w to coordinates of the dust's texture: of the star, and along each axis.
    apex: vec4f,
    along_u: vec4f,
    along_v: vec4f,
    along_w: vec4f,
    // Where the star is along u and v [voxels]; what a stored one of dust stands for.
    star: vec4f,
    // Slopes of ray 1, from ray to ray, and the distance at which rays enter through the nearest face.
    slopes: vec4f,
    // Edges of a voxel along u, v, w [pc]; distance of the first plane.
    edge: vec4f,
    // Ways to the sides through which rays come in along u and v, none if zero.
    sides: vec4f,
    // Rays along u and v; the first plane that is kept, and the one behind the last.
    counts: vec4u,
    // Voxels along u and v; number of the first plane; channel of dust.
    dims: vec4u,
    // From voxel to voxel along u, v and w, in the order in which rays meet them.
    strides: vec4i,
}

@group(0) @binding(0) var<uniform> sweep: Sweep;
@group(0) @binding(1) var dust: texture_3d<f32>;
@group(0) @binding(2) var linear: sampler;
// Kept planes × v × u.
@group(0) @binding(3) var<storage, read_write> rays: array<f32>;
@group(0) @binding(4) var<storage, read_write> swept: array<f32>;

fn sigma(slope: vec2f, w: f32) -> f32 {
    let at = sweep.apex.xyz + w * (slope.x * sweep.along_u.xyz + slope.y * sweep.along_v.xyz + sweep.along_w.xyz);
    return textureSampleLevel(dust, linear, at, 0.0)[sweep.dims.w] * sweep.star.z;
}

// Parsecs along a ray of this slope from plane to plane.
fn edge_along(slope: vec2f) -> f32 {
    return length(vec3f(slope, 1.0) * sweep.edge.xyz);
}

// Depth of a ray between two distances, by two Gauss points.
// twin: barnard::plan::star_depths::frustum_sweep::FrustumSweep::advance
fn gain(slope: vec2f, start: f32, to: f32) -> f32 {
    let range = to - start;
    return 0.5 * range * edge_along(slope) * (sigma(slope, start + GAUSS_LOW * range) + sigma(slope, start + GAUSS_HIGH * range));
}

// Distance at which a ray of this slope is past the sides' borders; infinite if it never is.
// twin: barnard::plan::star_depths::frustum::Frustum::enters
fn enters(slope: vec2f) -> f32 {
    var at = 0.0;
    for (var axis = 0u; axis < 2u; axis++) {
        let way = sweep.sides[axis];
        if way != 0.0 {
            at = max(at, select(FAR, way / slope[axis], way * slope[axis] > 0.0));
        }
    }
    return at;
}

// What a ray collects before it comes in through a side.
fn before_entry(slope: vec2f, planes: u32) -> f32 {
    let at = enters(slope);
    var depth = 0.0;
    var start = sweep.slopes.w;
    for (var n = 0u; n < planes; n++) {
        let to = sweep.edge.w + f32(n);
        let own = gain(slope, start, to);
        depth += own;
        let part = (at - start) / (to - start);
        if part > 0.0 && (part <= 1.0 || n + 1u == planes) {
            return select(FAR, depth + (part - 1.0) * own, part < BEYOND);
        }
        start = to;
    }
    return 0.0;
}

@compute @workgroup_size(8, 8)
fn follow(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= sweep.counts.xy) {
        return;
    }
    let slope = sweep.slopes.xy + (vec2f(id.xy) - 1.0) * sweep.slopes.z;
    let planes = sweep.counts.w;
    var depth = 0.0;
    if any(sweep.sides.xy != vec2f(0.0)) {
        depth = -before_entry(slope, u32(sweep.sides.z));
    }
    var start = sweep.slopes.w;
    for (var n = 0u; n < planes; n++) {
        let to = sweep.edge.w + f32(n);
        depth += gain(slope, start, to);
        if n >= sweep.counts.z {
            rays[((n - sweep.counts.z) * sweep.counts.y + id.y) * sweep.counts.x + id.x] = depth;
        }
        start = to;
    }
}

// The cubic through four depths, never outside of the middle two.
// twin: barnard::plan::star_depths::between_rays::cubic
fn cubic(values: vec4f, t: f32) -> f32 {
    let v = min(values, vec4f(OPAQUE));
    let value = v.y + 0.5 * t * (v.z - v.x + t * (2.0 * v.x - 5.0 * v.y + 4.0 * v.z - v.w + t * (3.0 * (v.y - v.z) + v.w - v.x)));
    return clamp(value, min(v.y, v.z), max(v.y, v.z));
}

// Depth up to a distance by midpoints a quarter of a plane apart, where no cubic follows the rays.
fn exact(slope: vec2f, distance: f32) -> f32 {
    let start = min(max(sweep.slopes.w, enters(slope)), distance);
    let count = ceil(4.0 * (distance - start));
    var depth = 0.0;
    for (var i = 0.0; i < count; i += 1.0) {
        depth += sigma(slope, start + (distance - start) * (i + 0.5) / count);
    }
    return depth * edge_along(slope) * (distance - start) / max(count, 1.0);
}

// twin: barnard::plan::star_depths::frustum_sweep::FrustumSweep::plane_values
@compute @workgroup_size(8, 8)
fn collect(@builtin(global_invocation_id) id: vec3u) {
    let n = sweep.counts.z + id.z;
    if any(id.xy >= sweep.dims.xy) || n >= sweep.counts.w {
        return;
    }
    let distance = sweep.edge.w + f32(n);
    let from_star = vec2f(id.xy) - sweep.star.xy;
    // Voxels on an edge between frustums belong to both: rounding must not leave them to none.
    if any(abs(from_star) > vec2f(distance * 1.00001)) {
        return;
    }
    let slope = from_star / distance;
    // The rays around a voxel: the second of its four, and where it stands between that and the third.
    let at = (slope - sweep.slopes.xy) / sweep.slopes.z + 1.0;
    let second = clamp(floor(at), vec2f(1.0), vec2f(sweep.counts.xy) - 3.0);
    let f = at - second;
    var low = FAR;
    var high = -FAR;
    var mixed: vec4f;
    for (var i = 0u; i < 4u; i++) {
        var column: vec4f;
        for (var j = 0u; j < 4u; j++) {
            column[j] = rays[(id.z * sweep.counts.y + u32(second.y) - 1u + j) * sweep.counts.x + u32(second.x) - 1u + i];
        }
        low = min(low, min(min(column.x, column.y), min(column.z, column.w)));
        high = max(high, max(max(column.x, column.y), max(column.z, column.w)));
        mixed[i] = cubic(column, f.y);
    }
    var depth = max(cubic(mixed, f.x), 0.0);
    if any(sweep.sides.xy != vec2f(0.0)) && low < -max(high, 0.0) {
        depth = min(exact(slope, distance), OPAQUE);
    }
    let plane = i32(sweep.dims.z) + i32(n) * sign(sweep.strides.w);
    swept[i32(id.x) * sweep.strides.x + i32(id.y) * sweep.strides.y + plane * sweep.strides.z] = depth;
}
