// Coordinates of e^(-a k) in a basis, read from a table: value, growth to the next entry, a sixth of the curvature and its growth, gap × element.

// Half difference of depth up to which a segment is its middle and a curvature.
const SHORT = 0.2;

// The mean coordinates over depths between middle - half and middle + half; the head holds entries per unit of depth, gaps, where they start, and elements.
// twin: barnard::backend::cpu::terms::CoordinateTable::means
fn mean_coordinates(head: vec4f, middle: f32, half: f32) -> array<f32, MAX_ELEMENTS> {
    var means: array<f32, MAX_ELEMENTS>;
    if abs(half) <= SHORT {
        add_coordinates(&means, head, middle, half * half, 1.0);
    } else {
        // The two points of Gauss.
        let offset = half * 0.57735026;
        add_coordinates(&means, head, middle - offset, 0.0, 0.5);
        add_coordinates(&means, head, middle + offset, 0.0, 0.5);
    }
    return means;
}

fn add_coordinates(means: ptr<function, array<f32, MAX_ELEMENTS>>, head: vec4f, depth: f32, half_squared: f32, share: f32) {
    let place = cell(depth * head.x, head.y);
    let size = u32(head.w);
    let first = u32(head.z) + u32(place.x) * size;
    for (var e = 0u; e < size; e++) {
        let row = tables[first + e];
        (*means)[e] += share * fma(fma(row.w, place.y, row.z), half_squared, fma(row.y, place.y, row.x));
    }
}
