// Sums over a workgroup of 256 invocations: by subgroups, with shared memory only between them, or by a tree in shared
// memory. Neither asks for a subgroup size, nor that all are alike.
#define_import_path bevy_lean_deferred::auto_exposure::reduction

const WORKGROUP: u32 = 256u;

// One array for each part, so that neighbouring invocations touch neighbouring banks.
var<workgroup> shared_x: array<f32, 256>;
var<workgroup> shared_y: array<f32, 256>;

#ifdef SUBGROUPS
var<workgroup> shared_count: u32;

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

/// Sums the first `count` entries into the first. `count` is the same for all invocations.
fn sum_shared(invocation: u32, count: u32) {
    for (var n = count; n > 1u; n = (n + 1u) / 2u) {
        let half = (n + 1u) / 2u;
        if invocation < n - half {
            shared_x[invocation] += shared_x[invocation + half];
            shared_y[invocation] += shared_y[invocation + half];
        }
        workgroupBarrier();
    }
}

/// The sum of `value` over the workgroup; called in uniform control flow.
fn workgroup_sum(place: Place, value: vec2<f32>) -> vec2<f32> {
    // What was there before has been read.
    workgroupBarrier();
#ifdef SUBGROUPS
    let sum = subgroupAdd(value);
    if place.in_subgroup == 0u {
        shared_x[place.subgroup] = sum.x;
        shared_y[place.subgroup] = sum.y;
    }
    if place.invocation == 0u {
        shared_count = place.subgroups;
    }
    sum_shared(place.invocation, workgroupUniformLoad(&shared_count));
#else
    shared_x[place.invocation] = value.x;
    shared_y[place.invocation] = value.y;
    workgroupBarrier();
    sum_shared(place.invocation, WORKGROUP);
#endif
    return vec2(shared_x[0], shared_y[0]);
}
