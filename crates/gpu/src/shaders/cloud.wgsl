// Density as fractional Brownian motion on simplex noise, at every sample.

fn mixed(h: u32) -> u32 {
    let a = (h ^ (h >> 16u)) * 0x7feb352du;
    let b = (a ^ (a >> 15u)) * 0x846ca68bu;
    return b ^ (b >> 16u);
}

// twin: barnard_scene::medium::field::simplex::hash
fn hash(p: vec3i, seed: u32) -> u32 {
    let u = bitcast<vec3u>(p);
    return mixed(u.x ^ mixed(u.y ^ mixed(u.z ^ mixed(seed))));
}

// The contribution of one corner at distance r.
// twin: barnard_scene::medium::field::simplex::Simplex::corner
fn noise_corner(corner: vec3i, r: vec3f, seed: u32) -> f32 {
    let falloff = max(0.6 - dot(r, r), 0.0);
    let square = falloff * falloff;
    // One of the twelve edges of a cube: two axes, and a sign along each. A table would lie in private memory.
    let edge = hash(corner, seed) % 12u;
    let first = select(r.x, r.y, edge >= 8u);
    let second = select(r.y, r.z, edge >= 4u);
    return square * square * (select(first, -first, (edge & 1u) != 0u) + select(second, -second, (edge & 2u) != 0u));
}

// n(p), p in units of the noise's own scale.
// twin: barnard_scene::medium::field::simplex::Simplex::at
fn simplex(p: vec3f, seed: u32) -> f32 {
    // Skew to find the simplex, unskew to measure distances.
    let cell = floor(p + (p.x + p.y + p.z) / 3.0);
    let d = p - (cell - (cell.x + cell.y + cell.z) / 6.0);
    let corner = vec3i(cell);
    let xy = d.x >= d.y;
    let yz = d.y >= d.z;
    let xz = d.x >= d.z;
    let second = vec3i(i32(xy && xz), i32(!xy && yz), i32(!xz && !yz));
    let third = vec3i(i32(xy || xz), i32(!xy || yz), i32(!xz || !yz));
    return 32.0 * (noise_corner(corner, d, seed) + noise_corner(corner + second, d - vec3f(second) + 1.0 / 6.0, seed)
        + noise_corner(corner + third, d - vec3f(third) + 1.0 / 3.0, seed) + noise_corner(corner + vec3i(1), d - 0.5, seed));
}

// sigma at V.
// twin: barnard_scene::medium::field::fbm::Fbm::at
fn cloud(p: vec3f) -> f32 {
    let place = constants[CLOUD];
    let octaves = constants[CLOUD + 1u];
    let shape = constants[CLOUD + 2u];
    var q = p - place.xyz;
    let r = length(q) / place.w;
    if r >= 1.0 {
        return 0.0;
    }
    turns += 3u + u32(octaves.y);
    if shape.z != 0.0 {
        let u = q * octaves.x;
        var bent = vec3f(0.0);
        for (var i = 0u; i < 3u; i++) {
            bent += simplex(u, frame.seeds[i + 1u]) * vec3f(vec3u(i) == vec3u(0u, 1u, 2u));
        }
        q += shape.z * bent;
    }
    var frequency = octaves.x;
    var amplitude = 1.0;
    var sum = shape.x;
    for (var i = 0.0; i < octaves.y; i += 1.0) {
        let n = simplex(q * frequency, frame.seeds.x);
        sum += amplitude * select(n, 1.0 - 2.0 * abs(n), shape.y > 0.0);
        frequency *= octaves.z;
        amplitude *= octaves.w;
    }
    let edge = clamp((r - 0.5) / 0.5, 0.0, 1.0);
    return shape.w * max(sum, 0.0) * (1.0 - edge * edge * (3.0 - 2.0 * edge));
}
