//! Command lines of programs.

/// The arguments in a line. The value of an option, `--name value`, goes up to the next option.
pub fn arguments(line: &str) -> Vec<String> {
    let mut parts = line.split("--").map(str::trim);
    let first = parts.next().unwrap_or_default();
    let mut arguments: Vec<String> = first.split_whitespace().map(Into::into).collect();
    for option in parts {
        let (name, value) = option.split_once(' ').unwrap_or((option, ""));
        arguments.push(format!("--{name}"));
        if !value.is_empty() {
            arguments.push(value.into());
        }
    }
    arguments
}

#[test]
fn values_may_have_blanks() {
    let line = "tests::one --exact --contender Bevy High;lean --size 64x36";
    let expected = [
        "tests::one",
        "--exact",
        "--contender",
        "Bevy High;lean",
        "--size",
        "64x36",
    ];
    assert_eq!(arguments(line), expected);
}
