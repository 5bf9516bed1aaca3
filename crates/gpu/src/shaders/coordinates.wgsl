// Coordinates of e^(-a k) in a basis, read from a table: the half difference of depth up to which a segment is its
// middle and a curvature; value, growth to the next entry, a sixth of the curvature and its growth, gap × element; and
// what is left behind the beginning of each gap, as two numbers that add up, gap × element.

// The mean coordinates over depths between middle - half and middle + half; the head holds entries per unit of depth,
// gaps, where they start, and elements.
// twin: barnard::backend::cpu::terms::CoordinateTable::means
fn mean_coordinates(head: vec4f, middle: f32, half: f32) -> array<f32, MAX_ELEMENTS> {
    var means: array<f32, MAX_ELEMENTS>;
    let size = u32(head.w);
    let rows = u32(head.z) + 1u;
    if abs(half) <= tables[rows - 1u].x {
        let place = cell(middle * head.x, head.y);
        let first = rows + u32(place.x) * size;
        for (var e = 0u; e < ELEMENTS; e++) { // written out
            let row = tables[first + e];
            means[e] = fma(fma(row.w, place.y, row.z), half * half, fma(row.y, place.y, row.x));
        }
        return means;
    }
    let low = (middle - abs(half)) * head.x;
    let high = (middle + abs(half)) * head.x;
    let first = cell(low, head.y);
    let last = cell(high, head.y);
    // Beyond the table its last entry is held.
    let held = max(high, head.y) - max(low, head.y);
    let left = rows + u32(head.y) * size;
    for (var e = 0u; e < ELEMENTS; e++) { // written out
        let front = tables[rows + u32(first.x) * size + e];
        let back = tables[rows + u32(last.x) * size + e];
        let in_front = fma(front.y, first.y, front.x);
        let behind = fma(back.y, last.y, back.x);
        var within = 0.5 * (last.y - first.y) * (in_front + behind);
        var gaps = last.y - first.y;
        if first.x < last.x {
            let after = tables[left + (u32(first.x) + 1u) * size + e].xy - tables[left + u32(last.x) * size + e].xy;
            let ends = 0.5 * (1.0 - first.y) * (in_front + front.x + front.y) + 0.5 * last.y * (back.x + behind);
            within = fma(after.x + after.y, head.x, ends);
            gaps = (1.0 - first.y) + (last.x - first.x - 1.0) + last.y;
        }
        means[e] = (within + held * behind) / (gaps + held);
        if first.x == last.x && held == 0.0 {
            means[e] = 0.5 * (in_front + behind);
        }
    }
    return means;
}
