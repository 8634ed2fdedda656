// What the invocations of a workgroup tell one another.
#define_import_path bevy_lean_deferred::workgroup

/// All that set it write the same.
var<workgroup> any_flag: u32;

/// Whether `condition` holds for any invocation of the workgroup. A barrier, also for its other memory.
fn is_any(condition: bool, invocation: u32) -> bool {
    if invocation == 0u {
        any_flag = 0u;
    }
    workgroupBarrier();
    if condition {
        any_flag = 1u;
    }
    return workgroupUniformLoad(&any_flag) != 0u;
}
