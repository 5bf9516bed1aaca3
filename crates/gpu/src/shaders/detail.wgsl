// Detail below the voxels, at every sample.

// A number whose highest bits look random.
// twin: barnard_scene::medium::detail::noise::mixed
fn detail_hash(h: u32) -> u32 {
    let a = (h ^ (h >> 15u)) * 0x2c1b3c6du;
    return (a ^ (a >> 12u)) * 0x297a2d39u;
}

// What a corner adds at a place seen from it.
// twin: barnard_scene::medium::detail::noise::single_corner
fn detail_corner(corner: vec3u, r: vec3f, seed: u32) -> f32 {
    let rows = corner * vec3u(0x8da6b343u, 0xd8163841u, 0xcb1ab31fu);
    let hash = detail_hash(rows.x ^ rows.y ^ rows.z ^ seed);
    let falloff = max(0.5 - dot(r, r), 0.0);
    let square = falloff * falloff;
    let signs = vec3u(hash, hash << 1u, hash << 2u) & vec3u(0x80000000u);
    let turned = bitcast<vec3f>(bitcast<vec3u>(r) ^ signs);
    return square * square * (turned.x + turned.y + turned.z);
}

// n(p), p in units of the noise's own scale.
// twin: barnard_scene::medium::detail::noise::single
fn detail_noise(p: vec3f, seed: u32) -> f32 {
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

// ln of the mean of e^(s n).
// twin: barnard_scene::medium::detail::noise::log_mean
fn detail_mean(s: vec4f) -> vec4f {
    let square = s * s;
    return square * (0.5 + square * (DETAIL_FOURTH / 24.0 + square * (DETAIL_SIXTH / 720.0)));
}

// How wide a pixel is at a distance along a ray.
fn detail_width(ray: Ray, t: f32) -> f32 {
    return max(constants[DETAIL].y + constants[DETAIL].x * (t - ray.first), TINY);
}

// The noise of an octave at a distance along a ray.
fn octave_at(octave: u32, ray: Ray, t: f32) -> f32 {
    let p = vec4f(ray.origin + t * ray.direction, 1.0);
    let turned = vec3f(dot(constants[octave], p), dot(constants[octave + 1u], p), dot(constants[octave + 2u], p));
    return detail_noise(turned, u32(constants[octave + 3u].y));
}

// The factor of dust at a distance along a ray.
// twin: barnard_scene::medium::detail::FineDetail::factor
fn dust_detail(ray: Ray, t: f32) -> f32 {
    let width = detail_width(ray, t);
    var exponent = 0.0;
    for (var j = 0u; j < DETAIL_OCTAVES; j++) { // written out
        let octave = DETAIL + 1u + j * DETAIL_OCTAVE;
        let s = constants[octave + 4u + DUST_QUAD][DUST_LANE] * clamp(0.5 * constants[octave + 3u].x / width - 1.5, 0.0, 1.0);
        if s > 0.0 {
            exponent += s * octave_at(octave, ray, t) - detail_mean(vec4f(s)).x;
        }
    }
    return exp(exponent);
}

// Multiplies dust and gas of a sample that stands for `stretch` of a ray around `t`.
// twin: barnard::backend::cpu::detail::multiply
fn add_detail(values: ptr<function, array<vec4f, QUADS>>, ray: Ray, t: f32, stretch: f32) {
    if is_dark(values) {
        return;
    }
    let width = detail_width(ray, t);
    var seen: array<f32, DETAIL_ROOM>;
    var places: array<u32, DETAIL_ROOM>;
    var noise: array<f32, DETAIL_ROOM>;
    var most = 0u;
    for (var j = 0u; j < DETAIL_OCTAVES; j++) { // written out
        let length = constants[DETAIL + 1u + j * DETAIL_OCTAVE + 3u].x;
        let waves = stretch / length;
        let asked = clamp(floor(waves + 0.5), 1.0, f32(DETAIL_PLACES));
        // Places a wave apart vary more than the stretch does.
        let scale = sqrt(min(DETAIL_ALIKE * asked / waves, 1.0));
        seen[j] = scale * clamp(0.5 * length / width - 1.5, 0.0, 1.0);
        places[j] = select(0u, u32(asked), seen[j] > 0.0);
        most = max(most, places[j]);
    }
    if most == 0u {
        return;
    }
    var factor: array<vec4f, QUADS>;
    var mean: array<vec4f, QUADS>;
    for (var q = 0u; q < QUADS; q++) { // written out
        if DETAILED[q] == 1u {
            for (var j = 0u; j < DETAIL_OCTAVES; j++) { // written out
                mean[q] += detail_mean(constants[DETAIL + 5u + j * DETAIL_OCTAVE + q] * seen[j]);
            }
        }
    }
    turns += most;
    for (var place = 0u; place < most; place++) {
        for (var j = 0u; j < DETAIL_OCTAVES; j++) { // written out
            // Longer waves stay as they are over several places.
            let own = place * places[j] / most;
            if places[j] > 0u && (place == 0u || own != (place - 1u) * places[j] / most) {
                let at = t + ((f32(own) + 0.5) / f32(places[j]) - 0.5) * stretch;
                noise[j] = octave_at(DETAIL + 1u + j * DETAIL_OCTAVE, ray, at);
            }
        }
        for (var q = 0u; q < QUADS; q++) { // written out
            if DETAILED[q] == 1u {
                var exponent = -mean[q];
                for (var j = 0u; j < DETAIL_OCTAVES; j++) { // written out
                    exponent += constants[DETAIL + 5u + j * DETAIL_OCTAVE + q] * (seen[j] * noise[j]);
                }
                factor[q] += exp(exponent);
            }
        }
    }
    for (var q = 0u; q < QUADS; q++) { // written out
        if DETAILED[q] == 1u {
            (*values)[q] *= factor[q] / f32(most);
        }
    }
}
