// Displacement below the voxels, at every sample.

// A number whose highest bits look random.
// twin: barnard_scene::medium::detail::noise::mixed
fn detail_hash(h: u32) -> u32 {
    let a = (h ^ (h >> 15u)) * 0x2c1b3c6du;
    return (a ^ (a >> 12u)) * 0x297a2d39u;
}

// What a corner adds to both components at a place seen from it.
// twin: barnard_scene::medium::detail::noise::single_corner
fn detail_corner(corner: vec3u, r: vec3f, seed: u32) -> vec2f {
    let rows = corner * vec3u(0x8da6b343u, 0xd8163841u, 0xcb1ab31fu);
    let hash = detail_hash(rows.x ^ rows.y ^ rows.z ^ seed);
    let falloff = max(0.5 - dot(r, r), 0.0);
    let cube = falloff * falloff * falloff;
    let signs = vec3u(hash, hash << 1u, hash << 2u) & vec3u(0x80000000u);
    let diagonal = bitcast<vec3f>(vec3u(0x3f800000u) ^ signs);
    let derivative = cube * (falloff * diagonal - 8.0 * dot(diagonal, r) * r);
    return vec2f(derivative.y, -derivative.x);
}

// Both components at p, in units of the noise's own scale.
// twin: barnard_scene::medium::detail::noise::single
fn detail_noise(p: vec3f, seed: u32) -> vec2f {
    // Skew to find the simplex, unskew to measure distances.
    let cell = floor(p + (p.x + p.y + p.z) / 3.0);
    let d = p - (cell - (cell.x + cell.y + cell.z) / 6.0);
    let corner = bitcast<vec3u>(vec3i(cell));
    let xy = d.x >= d.y;
    let yz = d.y >= d.z;
    let xz = d.x >= d.z;
    let second = vec3u(u32(xy && xz), u32(!xy && yz), u32(!xz && !yz));
    let third = vec3u(u32(xy || xz), u32(!xy || yz), u32(!xz || !yz));
    return DETAIL_NORM * (detail_corner(corner, d, seed) + detail_corner(corner + second, d - vec3f(second) + 1.0 / 6.0, seed)
        + detail_corner(corner + third, d - vec3f(third) + 1.0 / 3.0, seed) + detail_corner(corner + vec3u(1u), d - 0.5, seed));
}

// How wide a pixel is at a distance along a ray.
fn detail_width(ray: Ray, t: f32) -> f32 {
    return max(constants[DETAIL].y + constants[DETAIL].x * (t - ray.first), TINY);
}

// The place that is read at a distance along a ray.
// twin: barnard_scene::medium::detail::FineDetail::displacement
fn displaced(ray: Ray, t: f32) -> vec3f {
    let place = ray.origin + t * ray.direction;
    let width = detail_width(ray, t);
    var displacement = vec3f(0.0);
    for (var j = 0u; j < DETAIL_OCTAVES; j++) { // written out
        let octave = DETAIL + 1u + j * DETAIL_OCTAVE;
        let seen = clamp(0.5 * constants[octave + 3u].x / width - 1.5, 0.0, 1.0);
        if seen > 0.0 {
            turns += 1u;
            let p = vec4f(place, 1.0);
            let turned = vec3f(dot(constants[octave], p), dot(constants[octave + 1u], p), dot(constants[octave + 2u], p));
            let components = detail_noise(turned, u32(constants[octave + 3u].y));
            displacement += seen * (components.x * constants[octave + 4u].xyz + components.y * constants[octave + 5u].xyz);
        }
    }
    return place + displacement;
}
