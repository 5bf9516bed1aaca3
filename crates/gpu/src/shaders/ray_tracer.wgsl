// Light of a star on its way through gas that is known, and where it comes; see ionisation::transport. Lengths are in
// shortest edges of a voxel. One invocation follows one ray up to where it parts or ends; its parts are the next
// generation.

struct Star {
    // Its place from the cloud's lowest corner; the flux of all its photons at a distance of one [s⁻¹ cm⁻²].
    place: vec4f,
    // Edges of a voxel; what one is [cm].
    edges: vec4f,
    // What makes parts of a voxel's largest cross section of an area; that cross section in parts of a cube's face; where
    // light is used up, in parts of all; what ionises of all its photons.
    scales: vec4f,
    // Voxels along x, y and z; nodes.
    dims: vec4u,
    // Rays that there is room for; whether anything is known of the gas; number of the next star, as places of rates.
    counts: vec4u,
}

struct Generation {
    number: u32,
}

struct Ray {
    // By node, in parts of the star's within the ray's solid angle.
    photons: array<vec4f, QUADS>,
    // How far it has come; tangents of its middle on the face of a cube; what is left that ionises.
    way: vec4f,
    // That face, its level, and the voxel that the whole of it met last.
    patch_of: vec4u,
}

@group(0) @binding(0) var<uniform> star: Star;
@group(0) @binding(1) var<uniform> generation: Generation;
// By node the cross section of hydrogen [cm²], one where photons ionise it, the opacity of neutral gas for a nucleus [cm²];
// then by level of patches tangents of half of its half width and of that divided by √3, and the half width.
@group(0) @binding(2) var<storage, read> spectrum: array<vec4f>;
// Of each voxel: opacity by node [cm⁻¹]; photons that it makes [cm⁻³ s⁻¹], opacity of dust, Γ [s⁻¹], the part of light that it
// absorbs, the depth that does so, the part of its hydrogen that is ionised, nuclei of that [cm⁻³], the sixth number of photons.
@group(0) @binding(3) var<storage, read> voxels: array<vec4f>;
// Γ by the light of all other stars [s⁻¹].
@group(0) @binding(4) var<storage, read_write> others: array<f32>;
// Of each voxel: flux by node, what stands behind it, area.
@group(0) @binding(5) var<storage, read_write> sums: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read> coming: array<Ray>;
@group(0) @binding(7) var<storage, read_write> going: array<Ray>;
// Rays by generation; then whether there was no room for some, and the part of photons that stays.
@group(0) @binding(8) var<storage, read_write> counters: array<atomic<u32>>;
@group(0) @binding(9) var<storage, read_write> flux: array<f32>;
@group(0) @binding(10) var<storage, read_write> rates: array<f32>;
@group(0) @binding(11) var<storage, read_write> all_rates: array<f32>;

const SIGMA = 0u;
const IONISES = QUADS;
const DARK = 2u * QUADS;
const LEVELS = 3u * QUADS;
const KEPT_UNITS = 1073741824.0;

// The middle of a patch.
fn direction(face: u32, u: f32, v: f32) -> vec3f {
    let d = vec3f(select(-1.0, 1.0, face % 2u == 0u), u, v);
    return normalize(select(select(d.yzx, d.zxy, face < 4u), d, face < 2u));
}

// By two Gauss points along each angle.
fn solid_angle(u: f32, v: f32, level: u32) -> f32 {
    let t = spectrum[LEVELS + level];
    let a = vec2f(u - t.y, u + t.y) / vec2f(1.0 + u * t.y, 1.0 - u * t.y);
    let b = vec2f(v - t.y, v + t.y) / vec2f(1.0 + v * t.y, 1.0 - v * t.y);
    let squares = vec4f(a * a, b * b);
    let mixed = 1.0 + vec4f(squares.x + squares.z, squares.x + squares.w, squares.y + squares.z, squares.y + squares.w);
    let tops = (1.0 + squares.xxyy) * (1.0 + squares.zwzw);
    let all = tops * inverseSqrt(mixed) / mixed;
    return t.z * t.z * (all.x + all.y + all.z + all.w);
}

// A voxel's cross section in parts of that of a cube's face, and the relative variance of ways.
// twin: ionisation::rays::Rays::met
fn met(direction: vec3f) -> vec2f {
    let cube = pow(star.edges.x * star.edges.y * star.edges.z, 1.0 / 3.0);
    let rates = abs(direction) * cube / star.edges.xyz;
    let area = rates.x + rates.y + rates.z;
    let longest = 1.0 / max(rates.x, max(rates.y, rates.z));
    let pairs = rates.x * rates.y + rates.y * rates.z + rates.z * rates.x;
    let shared_part = longest * (1.0 + longest * (-area / 2.0 + longest * (pairs / 3.0 - longest * rates.x * rates.y * rates.z / 4.0)));
    return vec2f(area, max(2.0 * shared_part * area - 1.0, 0.0));
}

fn mean_square(inner: f32, thickness: f32) -> f32 {
    let outer = inner + thickness;
    return (outer * outer + outer * inner + inner * inner) / 3.0;
}

// The square of a voxel's distance.
// twin: ionisation::rays::Rays::square
fn square(cell: vec3u) -> f32 {
    let low = vec3f(cell) * star.edges.xyz;
    let away = clamp(star.place.xyz, low, low + star.edges.xyz) - star.place.xyz;
    return max(dot(away, away), 0.25);
}

fn voxel_of(cell: vec3u) -> u32 {
    return (cell.z * star.dims.y + cell.y) * star.dims.x + cell.x;
}

// Places of sums that a voxel has.
fn room() -> u32 {
    return star.dims.w + BEHIND + 1u;
}

fn add(place: u32, value: f32) {
    let units = u32(value * UNITS + 0.5);
    if units > 0u {
        atomicAdd(&sums[place], units);
    }
}

// Adds a cross section.
// twin: ionisation::lit::area_in_units
fn add_area(place: u32, part: f32) {
    atomicAdd(&sums[place], max(u32(min(part, 1.0) * UNITS + 0.5), 1u));
}

// Has a ray enter a voxel.
// twin: ionisation::lit::Lit::meet
fn meet(voxel: u32, part: f32, photons: ptr<function, array<vec4f, QUADS>>, factor: f32, behind: vec3f) {
    let first = voxel * room();
    var all = 0.0;
    for (var q = 0u; q < QUADS; q++) { // written out
        let parts = (*photons)[q] * factor;
        all += dot(parts, vec4f(1.0));
        if 4u * q < star.dims.w { add(first + 4u * q, parts.x); }
        if 4u * q + 1u < star.dims.w { add(first + 4u * q + 1u, parts.y); }
        if 4u * q + 2u < star.dims.w { add(first + 4u * q + 2u, parts.z); }
        if 4u * q + 3u < star.dims.w { add(first + 4u * q + 3u, parts.w); }
    }
    let parts = all * behind;
    let place = first + star.dims.w;
    add(place, parts.x);
    add(place + 1u, parts.y);
    add(place + 2u, parts.z);
    add_area(place + BEHIND, part);
}

// The depth that absorbs a part of the light.
// twin: ionisation::voxel::absorbing
fn absorbing(part: f32) -> f32 {
    return select(-log(1.0 - part), part * (1.0 + part * (0.5 + part / 3.0)), part < 0.01);
}

// Has photons go through a voxel; returns which part is left that ionises.
// twin: ionisation::voxel::cross
fn cross_voxel(voxel: u32, photons: ptr<function, array<vec4f, QUADS>>, inner: f32, thickness: f32, square: f32) -> f32 {
    let first = voxel * VOXEL;
    let undimmed = star.place.w / square;
    var rate = 0.0;
    for (var q = 0u; q < QUADS; q++) { // written out
        rate += dot((*photons)[q], spectrum[SIGMA + q]);
    }
    rate *= undimmed;
    // Own light 5, dust, Γ, absorbed; depth, ionised, hydrogen, own light 6.
    let own = voxels[first + QUADS];
    let told = voxels[first + QUADS + 1u];
    let more = voxels[first + QUADS + 2u];
    let all = others[voxel] + rate;
    var response = 1.0;
    var made = 0.0;
    let is_lit = told.z > 0.0;
    if is_lit && all > 0.0 {
        let brighter = all / told.z;
        let fills = select(brighter, max(brighter * more.y, 1.0), brighter > 1.0);
        let absorbed = min(told.w / fills, ALL);
        response = clamp(absorbing(absorbed) / more.x, 1.0 / CHANGE, CHANGE);
        made = min(brighter * absorbed / told.w * (rate / all) * min(thickness * star.edges.w / undimmed, MOST_MADE), MOST_MADE);
    }
    let way = thickness * star.edges.w;
    // DETOUR of crates/ionisation/src/light.rs.
    let detour = 0.5 * (inner + 0.5 * thickness) * star.edges.w;
    var left = 0.0;
    for (var q = 0u; q < QUADS; q++) { // written out
        let known = select(spectrum[DARK + q] * more.z, voxels[first + q], is_lit);
        let opacity = told.y + max(known - told.y, vec4f(0.0)) * response;
        var depth = opacity * way;
        var light = (*photons)[q];
        if q == 0u {
            depth *= 1.0 + opacity * detour;
        }
        if q == 1u {
            depth = vec4f(depth.xy * (1.0 + opacity.xy * detour), depth.zw);
        }
        let decay = exp(-min(depth, vec4f(87.0)));
        light *= decay;
        if q < 2u {
            let series = 1.0 - depth * (0.5 - depth * (1.0 / 6.0 - depth / 24.0));
            let mean = select(series, (1.0 - decay) / max(depth, vec4f(0.03)), depth > vec4f(0.03));
            light += select(vec4f(told.x, more.w, 0.0, 0.0), own, q == 0u) * mean * made;
        }
        light = select(vec4f(0.0), light, light > vec4f(NONE));
        (*photons)[q] = light;
        left += dot(light, spectrum[IONISES + q]);
    }
    return left;
}

// twin: ionisation::transport::follow
@compute @workgroup_size(64)
fn follow(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= min(atomicLoad(&counters[generation.number]), star.counts.x) {
        return;
    }
    let way = coming[id.x].way;
    let own = coming[id.x].patch_of;
    var photons = coming[id.x].photons;
    let d = direction(own.x, way.y, way.z);
    let angle = solid_angle(way.y, way.z, own.y);
    let all = star.scales.w;
    var left = way.w;
    let extent = vec3f(star.dims.xyz) * star.edges.xyz;
    let a = -star.place.xyz / d;
    let b = (extent - star.place.xyz) / d;
    let low = min(a, b);
    let high = max(a, b);
    let near = max(max(low.x, low.y), max(low.z, 0.0));
    let far = min(high.x, min(high.y, high.z));
    let widest = sqrt(WIDEST / angle);
    let beyond = BEYOND * length(star.edges.xyz);
    let area = met(d);
    var at = max(way.x, near);
    var little = 1e-5 + 4e-7 * at;
    let forward = vec3i(select(vec3f(0.0), vec3f(1.0), d > vec3f(0.0)));
    let entry = floor((star.place.xyz + (at + little) * d) / star.edges.xyz);
    var cell = clamp(vec3i(entry), vec3i(0), vec3i(star.dims.xyz) - 1);
    var last = own.z;
    var dark_since = -1.0;
    while far > near && at < far * (1.0 - 1e-6) {
        if dark_since < 0.0 {
            if at > widest {
                let slot = atomicAdd(&counters[generation.number + 1u], 4u);
                if slot + 4u > star.counts.x {
                    atomicStore(&counters[GENERATIONS], 1u);
                    return;
                }
                let t = spectrum[LEVELS + own.y].x;
                for (var i = 0u; i < 4u; i++) {
                    let s = vec2f(select(-t, t, (i & 1u) == 1u), select(-t, t, i > 1u));
                    let turned = (way.yz + s) / (1.0 - way.yz * s);
                    going[slot + i].photons = photons;
                    going[slot + i].way = vec4f(at, turned, left);
                    going[slot + i].patch_of = vec4u(own.x, own.y + 1u, last, 0u);
                }
                return;
            }
            if left <= star.scales.z * all {
                dark_since = at;
            }
        }
        if dark_since >= 0.0 && at - dark_since > beyond {
            break;
        }
        let next = (vec3f(cell + forward) * star.edges.xyz - star.place.xyz) / d;
        let exit = max(min(next.x, min(next.y, next.z)), at + little);
        let voxel = voxel_of(vec3u(cell));
        if voxels[voxel * VOXEL + QUADS + 2u].z > 0.0 {
            let thickness = min(exit, far) - at;
            let squared = mean_square(at, thickness);
            let part = angle * squared * star.scales.x;
            if dark_since >= 0.0 {
                add_area(voxel * room() + star.dims.w + BEHIND, part);
            } else {
                if voxel != last {
                    let nearest = square(vec3u(cell));
                    let distance = (at + 0.5 * thickness) / (sqrt(nearest) + length(star.edges.xyz));
                    meet(voxel, part, &photons, nearest / squared * part, vec3f(distance, area.x / star.scales.y, area.y));
                }
                if star.counts.y == 1u {
                    left = cross_voxel(voxel, &photons, at, thickness, squared);
                }
            }
        }
        last = voxel;
        at = exit;
        little = 1e-5 + 4e-7 * at;
        cell += select(vec3i(0), 2 * forward - 1, next <= vec3f(at + little));
        if any(cell < vec3i(0)) || any(cell >= vec3i(star.dims.xyz)) {
            break;
        }
    }
    atomicAdd(&counters[GENERATIONS + 1u], u32(KEPT_UNITS * angle / SPHERE * select(0.0, clamp(1.0 - left / all, 0.0, 1.0), all > 0.0) + 0.5));
}

// Adds the mean flux of a star's rays in each voxel to that of all, and has the sums begin anew.
// twin: ionisation::lit::Lit::add_to
@compute @workgroup_size(64)
fn sum_up(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let voxel = id.y * groups.x * 64u + id.x;
    let cells = star.dims.x * star.dims.y * star.dims.z;
    if voxel >= cells {
        return;
    }
    let nodes = star.dims.w;
    let first = voxel * room();
    let area = f32(atomicLoad(&sums[first + nodes + BEHIND]));
    var rate = 0.0;
    if area > 0.0 {
        let cell = vec3u(voxel % star.dims.x, voxel / star.dims.x % star.dims.y, voxel / (star.dims.x * star.dims.y));
        let nearest = square(cell);
        let undimmed = star.place.w / (nearest * area);
        let most = vec3f((sqrt(nearest) + length(star.edges.xyz)) * star.edges.w / PARSEC_CM, star.scales.y, 1.0);
        let row = voxel * (nodes + BEHIND);
        for (var node = 0u; node < nodes; node++) {
            let value = f32(atomicExchange(&sums[first + node], 0u)) * undimmed;
            flux[row + node] += value;
            rate += value * spectrum[SIGMA + node / 4u][node % 4u];
        }
        for (var i = 0u; i < BEHIND; i++) {
            flux[row + nodes + i] += f32(atomicExchange(&sums[first + nodes + i], 0u)) * undimmed * most[i];
        }
        atomicStore(&sums[first + nodes + BEHIND], 0u);
    }
    let place = star.counts.z * cells + voxel;
    let all = all_rates[voxel] + rate - rates[place];
    rates[place] = rate;
    all_rates[voxel] = all;
    others[voxel] = max(all - rates[star.counts.w * cells + voxel], 0.0);
}
