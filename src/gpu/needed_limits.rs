//! Limits of the device that an effect needs.

use core::fmt;

use wgpu::Limits;

/// A limit and its least sufficient value.
#[derive(Clone, Copy, Debug)]
pub struct NeededLimit {
    /// Its name in `wgpu::Limits`.
    pub name: &'static str,
    /// The least sufficient value.
    pub least: u32,
    /// The field of that name.
    pub field: fn(&mut Limits) -> &mut u32,
}

/// Entries `name: least` of a table of [`NeededLimit`].
macro_rules! needed_limits {
    ($($name:ident: $least:expr),* $(,)?) => {
        [$($crate::gpu::needed_limits::NeededLimit {
            name: stringify!($name),
            least: $least,
            field: |limits| &mut limits.$name,
        }),*]
    };
}
pub(crate) use needed_limits;

impl NeededLimit {
    /// The value of a device with these `limits`.
    pub fn of(&self, limits: &Limits) -> u32 {
        *(self.field)(&mut limits.clone())
    }

    fn is_met(&self, limits: &Limits) -> bool {
        self.of(limits) >= self.least
    }
}

impl PartialEq for NeededLimit {
    fn eq(&self, other: &Self) -> bool {
        (self.name, self.least) == (other.name, other.least)
    }
}

/// Completes "The device lacks …".
impl fmt::Display for NeededLimit {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} of {}", self.name, self.least)
    }
}

/// The limits among those `needed` that are lower on a device with these `limits`.
pub(crate) fn unmet<'a>(
    needed: &'a [NeededLimit],
    limits: &Limits,
) -> impl Iterator<Item = &'a NeededLimit> {
    needed.iter().filter(|needed| !needed.is_met(limits))
}

/// Names those of the limits `needed` that are lower on a device with these `limits`, with its values.
pub(crate) fn lacking(needed: &[NeededLimit], limits: &Limits) -> impl Iterator<Item = String> {
    unmet(needed, limits).map(move |needed| format!("{needed} (it has {})", needed.of(limits)))
}

/// An error names the limits `needed` that are lower on a device with these `limits`.
pub(crate) fn check_limits(needed: &[NeededLimit], limits: &Limits) -> Result<(), String> {
    let lacking: Vec<String> = lacking(needed, limits).collect();
    if lacking.is_empty() {
        Ok(())
    } else {
        Err(lacking.join(", "))
    }
}
