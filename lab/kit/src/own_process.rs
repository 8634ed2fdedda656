//! Runs tests in processes of their own: because they count or search process-wide state, or because they render many frames, of each of
//! which Mesa's llvmpipe keeps some megabytes until the process ends.

use std::{io::Write, process::Command, time::Instant};

/// Set in such a process.
const ALONE: &str = "LEAN_TEST_ALONE";

/// Runs a test's body in a process of its own, so that its logs, ids and threads are this test's alone. To be called from the test itself,
/// with a closure.
pub fn in_own_process<F: FnOnce()>(body: F) {
    let name = test_name::<F>();
    if is_alone(name) {
        body();
    } else {
        run_alone(name, &[]);
    }
}

/// As [`in_own_process`], once per value of the environment variable, one after another.
pub fn in_own_processes<F: FnOnce()>(
    variable: &str,
    values: impl IntoIterator<Item = String>,
    body: F,
) {
    let name = test_name::<F>();
    if is_alone(name) {
        return body();
    }
    for value in values {
        println!("{name}, {variable}={value}");
        run_alone(name, &[(variable, value)]);
    }
}

fn is_alone(name: &str) -> bool {
    std::env::var_os(ALONE).is_some_and(|alone| alone == *name)
}

fn run_alone(name: &str, environment: &[(&str, String)]) {
    let program = std::env::current_exe().expect("a test is a program");
    let start = Instant::now();
    let output = Command::new(program)
        // Nightly tests are ignored unless asked for.
        .args([name, "--exact", "--nocapture", "--include-ignored"])
        .env(ALONE, name)
        .envs(
            environment
                .iter()
                .map(|(variable, value)| (variable, value)),
        )
        .output()
        .expect("it runs again");
    let text = String::from_utf8_lossy(&output.stdout);
    let errors = String::from_utf8_lossy(&output.stderr);
    print!("{text}");
    eprint!("{errors}");
    // Unlike `eprintln`, this is not captured: slow tests show in every run.
    let seconds = start.elapsed().as_secs_f32();
    let _ = writeln!(std::io::stderr(), "{name}: {seconds:.1} s");
    assert!(output.status.success(), "{name}: {}", output.status);
    assert!(text.contains("1 passed"), "no test has the name {name}");
}

/// Name of the function that contains the closure `F`, as the test harness writes it: without the crate.
fn test_name<F>() -> &'static str {
    let closure = core::any::type_name::<F>();
    let path = closure.split_once("::").map_or(closure, |(_, path)| path);
    path.strip_suffix("::{{closure}}").unwrap_or(path)
}
