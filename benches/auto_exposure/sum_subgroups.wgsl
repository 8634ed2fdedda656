struct Invocation {
    @builtin(local_invocation_index) index: u32,
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(subgroup_invocation_id) in_subgroup: u32,
    @builtin(subgroup_id) subgroup: u32,
    @builtin(num_subgroups) subgroups: u32,
}

var<workgroup> sums: array<f32, 256>;

/// Sums over the workgroup by subgroups. The first invocation adds their sums, and alone gets the result.
fn workgroup_sum(at: Invocation, value: f32, invocations: u32) -> f32 {
    let own = subgroupAdd(value);
    if at.in_subgroup == 0u {
        sums[at.subgroup] = own;
    }
    workgroupBarrier();
    var sum = 0.0;
    if at.index == 0u {
        for (var i = 0u; i < at.subgroups; i++) {
            sum += sums[i];
        }
    }
    return sum;
}

