struct Invocation {
    @builtin(local_invocation_index) index: u32,
    @builtin(workgroup_id) workgroup: vec3<u32>,
}

var<workgroup> sums: array<f32, 256>;

/// Sums over the workgroup by a tree in shared memory. `invocations` is a power of two.
fn workgroup_sum(at: Invocation, value: f32, invocations: u32) -> f32 {
    sums[at.index] = value;
    workgroupBarrier();
    for (var half = invocations / 2u; half > 0u; half /= 2u) {
        if at.index < half {
            sums[at.index] += sums[at.index + half];
        }
        workgroupBarrier();
    }
    return sums[0];
}

