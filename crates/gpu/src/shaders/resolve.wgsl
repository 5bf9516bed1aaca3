// From band radiances to display colour: a separate last step that never touches the radiance.

struct Display {
    // Black, the inverse of what lies between it and white, gaps of the stretch's table.
    levels: vec4f,
    // Pixels along a row, rows, bands.
    size: vec4u,
}

@group(0) @binding(0) var<uniform> display: Display;
// A column of the palette for each band, and the stretch at equal steps of the fourth root behind them.
@group(0) @binding(1) var<storage, read> tone: array<vec4f>;
@group(0) @binding(2) var<storage, read> light: array<f32>;
@group(0) @binding(3) var colours: texture_storage_2d<rgba8unorm, write>;

// twin: spectra::colour::Stretch::apply
fn stretched(x: f32) -> f32 {
    let u = sqrt(sqrt(clamp(x, 0.0, 1.0))) * display.levels.z;
    let gap = min(floor(u), display.levels.z - 1.0);
    let row = tone[display.size.z + u32(gap)];
    return mix(row.x, row.y, u - gap);
}

// twin: spectra::colour::Stretch::apply_rgb
fn stretched_rgb(rgb: vec3f) -> vec3f {
    let brightest = max(rgb.x, max(rgb.y, rgb.z));
    if brightest <= 0.0 {
        return vec3f(0.0);
    }
    let bright = max(rgb, vec3f(0.0)) * (stretched(brightest) / brightest);
    return bright + (1.0 - 1.0 / max(brightest, 1.0)) * (1.0 - bright);
}

// twin: spectra::colour::srgb_encode
fn srgb_encode(linear: vec3f) -> vec3f {
    let v = clamp(linear, vec3f(0.0), vec3f(1.0));
    return select(1.055 * pow(v, vec3f(1.0 / 2.4)) - 0.055, 12.92 * v, v <= vec3f(0.0031308));
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= display.size.xy) {
        return;
    }
    var rgb = vec3f(0.0);
    for (var b = 0u; b < display.size.z; b++) {
        rgb += tone[b].xyz * light[(b * display.size.y + id.y) * display.size.x + id.x];
    }
    let scaled = (rgb - display.levels.x) * display.levels.y;
    textureStore(colours, id.xy, vec4f(srgb_encode(stretched_rgb(scaled)), 1.0));
}
