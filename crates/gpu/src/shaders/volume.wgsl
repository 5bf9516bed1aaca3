// All channels at a place, four in a texture, held at the borders as on the processor.

struct Lattice {
    // From places to texture coordinates.
    scale: vec4f,
    shift: vec4f,
    // What a stored one stands for, channel by channel.
    unit: vec4f,
    // The box, without the layer around it.
    low: vec4f,
    high: vec4f,
}

struct BrickGrid {
    // Its corner, and the shortest edge of a brick [pc].
    low: vec4f,
    per_pc: vec4f,
    // Bricks along each axis, and where its values start.
    dims: vec4u,
}

fn lattice(q: u32) -> Lattice {
    let i = LATTICES + 5u * q;
    return Lattice(constants[i], constants[i + 1u], constants[i + 2u], constants[i + 3u], constants[i + 4u]);
}

fn brick_grid(i: u32) -> BrickGrid {
    let at = BRICK_TABLE + 3u * i;
    return BrickGrid(constants[at], constants[at + 1u], vec4u(constants[at + 2u]));
}

// Where a place stands in an atlas of pages, both in texture coordinates.
// twin: barnard::volume::Pages::number
fn in_atlas(at: vec3f, paging: u32) -> vec3f {
    let voxels = constants[PAGING + 2u * paging];
    let atlas = constants[PAGING + 2u * paging + 1u].xyz;
    let place = clamp(at * voxels.xyz - 0.5, vec3f(0.0), voxels.xyz - 1.0);
    let page = vec3u(min(place, voxels.xyz - 2.0)) / PAGE;
    let pages = (vec3u(voxels.xyz) - 2u) / PAGE + 1u;
    let slot = brick_distances[u32(voxels.w) + (page.z * pages.y + page.y) * pages.x + page.x];
    let across = vec2u(atlas.xy);
    let own = vec3u(slot % across.x, slot / across.x % across.y, slot / (across.x * across.y));
    let side = f32(PAGE + 1u);
    return (vec3f(own) * side + place - vec3f(page * PAGE) + 0.5) / (atlas * side);
}

fn read_all(p: vec3f) -> array<vec4f, QUADS> {
    var values: array<vec4f, QUADS>;
    for (var q = 0u; q < QUADS; q++) { // written out
        let place = lattice(q);
        values[q] = read_quad(q, p * place.scale.xyz + place.shift.xyz) * place.unit;
    }
    if HAS_CLOUD {
        values[DUST_QUAD][DUST_LANE] = cloud(p);
    }
    return values;
}

fn read_dust(p: vec3f) -> f32 {
    if HAS_CLOUD {
        return cloud(p);
    }
    let place = lattice(DUST_QUAD);
    return read_quad(DUST_QUAD, p * place.scale.xyz + place.shift.xyz)[DUST_LANE] * place.unit[DUST_LANE];
}

// One for each quad of channels whose box holds `p`.
fn masks(p: vec3f) -> array<f32, QUADS> {
    var masks: array<f32, QUADS>;
    for (var q = 0u; q < QUADS; q++) { // written out
        masks[q] = f32(all(p >= lattice(q).low.xyz) && all(p <= lattice(q).high.xyz));
    }
    return masks;
}

// How far one may go from a place of a ray in any direction and stand in empty bricks [pc], and where the ray leaves
// the first of the bricks in which it may not.
fn clear_pc(ray: Ray, here: f32) -> vec2f {
    var clear = FAR;
    var leaves = here;
    for (var i = 0u; i < BRICK_GRIDS; i++) {
        let grid = brick_grid(i);
        let place = (ray.origin + here * ray.direction - grid.low.xyz) * grid.per_pc.xyz;
        let cell = clamp(vec3i(floor(place)), vec3i(0), vec3i(grid.dims.xyz) - 1);
        let index = (u32(cell.z) * grid.dims.y + u32(cell.y)) * grid.dims.x + u32(cell.x);
        let own = f32(brick_distances[grid.dims.w + index]) * grid.low.w;
        if own < clear {
            clear = own;
            let speed = ray.direction * grid.per_pc.xyz;
            let still = abs(speed) < vec3f(TINY);
            let ahead = select((vec3f(cell) + vec3f(speed > vec3f(0.0)) - place) / select(speed, vec3f(1.0), still), vec3f(FAR), still);
            leaves = here + min(min(ahead.x, ahead.y), ahead.z);
        }
    }
    return vec2f(clear, leaves);
}
