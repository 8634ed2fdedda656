// Communication between the invocations of a workgroup.
#define_import_path bevy_lean_deferred::workgroup

/// All invocations that set it write the same value.
var<workgroup> any_flag: u32;

/// True if `condition` holds for any invocation of the workgroup. Also a barrier for its other memory.
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
