//! Arguments that all benches have, and lists on the command line.

use core::fmt::Display;
use std::process::exit;

/// Declares the arguments of a bench: its own, and those of all benches.
#[macro_export]
macro_rules! bench_args {
    ($(#[doc = $docs:literal])* struct $name:ident { $($own:tt)* }) => {
        #[derive(argh::FromArgs)]
        $(#[doc = $docs])*
        struct $name {
            $($own)*
            /// write the figures to this file
            #[argh(option)]
            json: Option<String>,

            /// given by cargo
            #[argh(switch)]
            #[expect(dead_code, reason = "cargo bench passes it")]
            bench: bool,
        }
    };
}

/// Parses values that commas separate. Exits with a message if one of them is wrong.
pub fn list<T, E: Display>(text: &str, parse: impl Fn(&str) -> Result<T, E>) -> Vec<T> {
    let values: Result<_, E> = text.split(',').map(|part| parse(part.trim())).collect();
    values.unwrap_or_else(|error| {
        eprintln!("{text}: {error}");
        exit(1)
    })
}
