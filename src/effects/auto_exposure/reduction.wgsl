// Sums over a workgroup of 256 invocations: by subgroups, with shared memory only between them, or by a tree in shared memory.
// Neither assumes a subgroup size, or that all subgroups have the same.
#define_import_path bevy_lean_deferred::effects::auto_exposure::reduction

const WORKGROUP: u32 = 256u;

// One array per component avoids bank conflicts.
var<workgroup> shared_x: array<f32, 256>;
var<workgroup> shared_y: array<f32, 256>;

#ifdef SUBGROUPS
struct Place {
    invocation: u32,
    in_subgroup: u32,
    subgroup: u32,
    subgroups: u32,
}
#else
struct Place {
    invocation: u32,
}
#endif

/// Sum of `value` over the workgroup. Must be called in uniform control flow.
fn workgroup_sum(place: Place, value: vec2<f32>) -> vec2<f32> {
    // Waits until the previous results are read.
    workgroupBarrier();
#ifdef SUBGROUPS
    let own = subgroupAdd(value);
    if place.in_subgroup == 0u {
        shared_x[place.subgroup] = own.x;
        shared_y[place.subgroup] = own.y;
    }
    workgroupBarrier();
    // Subgroups are few, so each invocation adds them up.
    var sum = vec2(0.0);
    for (var i = 0u; i < place.subgroups; i++) {
        sum += vec2(shared_x[i], shared_y[i]);
    }
    return sum;
#else
    shared_x[place.invocation] = value.x;
    shared_y[place.invocation] = value.y;
    workgroupBarrier();
    for (var half = WORKGROUP / 2u; half > 0u; half /= 2u) {
        if place.invocation < half {
            shared_x[place.invocation] += shared_x[place.invocation + half];
            shared_y[place.invocation] += shared_y[place.invocation + half];
        }
        workgroupBarrier();
    }
    return vec2(shared_x[0], shared_y[0]);
#endif
}
