// Means over a segment.

// sinh(y)/y up to |y| = 1.
// twin: barnard::packet::sinhc
fn sinhc(y2: f32) -> f32 {
    return fma(y2, fma(y2, fma(y2, 1.0 / 5040.0, 1.0 / 120.0), 1.0 / 6.0), 1.0);
}

// Mean of e^(-a) over a that is linear between middle - y and middle + y.
// twin: barnard::packet::mean_transmittance
fn mean_transmittance(middle: f32, y: f32) -> f32 {
    let size = abs(y);
    if size <= SERIES_LIMIT {
        return exp(-middle) * sinhc(y * y);
    }
    return (exp(size - middle) - exp(-size - middle)) / (2.0 * size);
}

// The cell that u lies in, of `count` from 0, and its place within, held at both ends.
// twin: barnard::packet::place
fn cell(u: f32, count: f32) -> vec2f {
    let held = clamp(u, 0.0, count);
    let cell = min(floor(held), count - 1.0);
    return vec2f(cell, held - cell);
}

// ln x for x > 0, relative error 2e-7: devices promise less of their own.
// twin: barnard::packet::ln
fn ln(x: f32) -> f32 {
    let root = bitcast<u32>(0.70710677f);
    let bits = bitcast<u32>(x) - root;
    let exponent = f32(bitcast<i32>(bits) >> 23u);
    let mantissa = bitcast<f32>((bits & 0x007fffffu) + root);
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    let s2 = s * s;
    let series = fma(s2, fma(s2, fma(s2, fma(s2, 1.0 / 9.0, 1.0 / 7.0), 1.0 / 5.0), 1.0 / 3.0), 1.0);
    return fma(exponent, 0.6931472, 2.0 * s * series);
}
