// Second pass: one workgroup adds up the partial sums and adapts the exposure.
#import bevy_lean_deferred::effects::auto_exposure::adaptation::adapted
#import bevy_lean_deferred::effects::auto_exposure::bindings::{
    AWAITS_LIGHT, BINS, BINS_PER_STOP, ExposureState, LOG_OF_FIRST_BIN, bevy_view, state, view,
}
#import bevy_lean_deferred::effects::auto_exposure::luminance::log_luminance
#import bevy_lean_deferred::effects::auto_exposure::reduction::{Place, WORKGROUP, workgroup_sum}

#ifdef HISTOGRAM
#import bevy_lean_deferred::effects::auto_exposure::bindings::histogram
var<workgroup> bins: array<f32, 256>;
#else
#import bevy_lean_deferred::effects::auto_exposure::bindings::partials
#endif

#ifdef HISTOGRAM
/// Inclusive prefix sum of the bins up to the invocation's own, whose count is `own`.
fn prefix_sum(invocation: u32, own: f32) -> f32 {
    var sum = own;
    for (var distance = 1u; distance < BINS; distance *= 2u) {
        bins[invocation] = sum;
        workgroupBarrier();
        if invocation >= distance {
            sum += bins[invocation - distance];
        }
        workgroupBarrier();
    }
    bins[invocation] = sum;
    workgroupBarrier();
    return sum;
}

/// Contribution of the invocation's bin to the weighted sum and to the weight, without the trimmed tails. Bins count with their
/// centres.
fn trimmed(invocation: u32) -> vec2<f32> {
    let own = f32(atomicLoad(&histogram[invocation]));
    // Cleared for the next frame.
    atomicStore(&histogram[invocation], 0u);
    let above = prefix_sum(invocation, own);
    let all = bins[BINS - 1u];
    let weight = max(min(above, all * (1.0 - view.trim_high)) - max(above - own, all * view.trim_low), 0.0);
    let log_y = LOG_OF_FIRST_BIN + (f32(invocation) + 0.5) / BINS_PER_STOP;
#ifdef LOG_AVERAGE
    return vec2(log_y, 1.0) * weight;
#else
    return vec2(exp2(log_y), 1.0) * weight;
#endif
}
#else
/// Partial sum `i`; 0 past the end.
fn partial(i: u32) -> vec2<f32> {
    let count = arrayLength(&partials);
    return select(vec2(0.0), partials[min(i, count - 1u)], i < count);
}

/// Sum over every 256th of the partial sums, four at a time.
fn sum_of_partials(invocation: u32) -> vec2<f32> {
    var sum = vec2(0.0);
    for (var i = invocation; i < arrayLength(&partials); i += 4u * WORKGROUP) {
        let a = partial(i);
        let b = partial(i + WORKGROUP);
        let c = partial(i + 2u * WORKGROUP);
        let d = partial(i + 3u * WORKGROUP);
        sum += (a + b) + (c + d);
    }
    return sum;
}
#endif

/// Stops of the compensation curve at a metered logarithm.
fn compensation_at(log_y: f32) -> f32 {
    if view.curve_points == 0u {
        return 0.0;
    }
    var stops = view.curve[0].y;
    for (var i = 1u; i < view.curve_points; i++) {
        let a = view.curve[i - 1u];
        let b = view.curve[i];
        let t = saturate((log_y - a.x) / max(b.x - a.x, 1e-6));
        if log_y >= a.x {
            stops = mix(a.y, b.y, t);
        }
    }
    return stops;
}

/// Metered logarithm up to which a picture is black except for a few pixels.
const BLACK: f32 = -13.9;

/// Adapts the exposure. `sum` holds the weighted luminance (with LOG_AVERAGE its logarithm) and the weight.
fn adapt(last: ExposureState, sum: vec2<f32>) -> ExposureState {
    var y = last.luminance;
    var target_exposure = last.target_exposure;
    var has_light = false;
    // A view without metered pixels keeps its target.
    if sum.y > 0.0 {
#ifdef LOG_AVERAGE
        let log_y = sum.x / sum.y;
        y = exp2(log_y);
#else
        y = sum.x / sum.y;
        let log_y = log_luminance(y);
#endif
        let stops = clamp(view.log_target - log_y, view.min_exposure, view.max_exposure);
        target_exposure = stops + view.compensation + compensation_at(log_y);
        has_light = log_y > BLACK;
    }
    let begins = last.cuts_seen != view.cuts + 1u;
    let moved = adapted(
        last.exposure,
        target_exposure,
        view.seconds,
        view.speed_brighten,
        view.speed_darken,
        view.transition,
    );
    let exposure = select(moved, target_exposure, begins || view.instant != 0u);
    // Adaptation does not begin in the black of a loading scene: it would begin at the largest exposure.
    let awaits_light = select(0u, AWAITS_LIGHT, begins && !has_light);
    return ExposureState(y, exposure, target_exposure, (view.cuts + 1u) | awaits_light);
}

@compute @workgroup_size(256, 1, 1)
fn sum_and_adapt(
    @builtin(local_invocation_index) invocation: u32,
#ifdef SUBGROUPS
    @builtin(subgroup_invocation_id) in_subgroup: u32,
    @builtin(subgroup_id) subgroup: u32,
    @builtin(num_subgroups) subgroups: u32,
#endif
) {
#ifdef SUBGROUPS
    let place = Place(invocation, in_subgroup, subgroup, subgroups);
#else
    let place = Place(invocation);
#endif
    // Read before use, so that all memory reads are in flight at once.
    let last = state;
    let base = bevy_view.color_grading.exposure;
#ifdef HISTOGRAM
    let part = trimmed(invocation);
#else
    let part = sum_of_partials(invocation);
#endif
    let sum = workgroup_sum(place, part);
    if invocation == 0u {
        let now = adapt(last, sum);
        state = now;
        bevy_view.color_grading.exposure = base + now.exposure;
    }
}
