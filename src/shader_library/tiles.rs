//! The 8×8 tiles in which compute passes cover a view, and their row order on software drivers.

use bevy::{prelude::*, render::renderer::RenderAdapterInfo};
use wgpu::DeviceType;

/// Pixels per side of the tile that one workgroup covers.
pub const TILE_SIDE: u32 = 8;

/// Workgroups that cover `size` pixels.
pub(crate) fn count(size: UVec2) -> UVec2 {
    UVec2::new(size.x.div_ceil(TILE_SIDE), size.y.div_ceil(TILE_SIDE))
}

/// Order of the rows of tiles.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RowOrder {
    /// Top to bottom. GPUs dispatch workgroups one by one, and neighbours share caches.
    TopDown,
    /// Consecutive rows lie far apart. llvmpipe gives each thread a contiguous range of workgroups: from top to bottom, one thread would
    /// get the sky and another all of the lit floor, which made lighting 1.8 × slower on 2 threads.
    Spread,
}

impl RowOrder {
    pub(crate) fn from_world(world: &World) -> Self {
        match world.get_resource::<RenderAdapterInfo>() {
            Some(info) if info.device_type == DeviceType::Cpu => Self::Spread,
            _ => Self::TopDown,
        }
    }

    /// Factor by which the shader multiplies the number of a row, modulo `rows`.
    pub(crate) fn stride(self, rows: u32) -> u32 {
        match self {
            Self::TopDown => 1,
            Self::Spread => spreading_stride(rows),
        }
    }
}

/// The number nearest to the golden section of `rows` that is coprime to it: its multiples reach every row once, and any run of
/// consecutive ones is spread evenly (Weyl 1916, "Über die Gleichverteilung von Zahlen mod. Eins").
fn spreading_stride(rows: u32) -> u32 {
    let golden = (rows as f32 * 0.618_034) as u32;
    (0..rows)
        .flat_map(|distance| [golden + distance, golden.saturating_sub(distance)])
        .find(|&stride| greatest_common_divisor(stride, rows) == 1)
        .unwrap_or(1)
}

fn greatest_common_divisor(a: u32, b: u32) -> u32 {
    if b == 0 {
        a
    } else {
        greatest_common_divisor(b, a % b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_is_reached_once() {
        for rows in 1..=2048 {
            let stride = RowOrder::Spread.stride(rows);
            let mut reached = vec![false; rows as usize];
            for row in 0..rows {
                // In 32 bits, as in the shader.
                reached[(row.wrapping_mul(stride) % rows) as usize] = true;
            }
            assert!(
                reached.iter().all(|&row| row),
                "{rows} rows, stride {stride}"
            );
        }
    }

    #[test]
    fn each_thread_gets_rows_from_everywhere() {
        for rows in [45, 90, 135, 270] {
            let stride = RowOrder::Spread.stride(rows);
            for threads in [2, 4, 8] {
                let share = rows / threads;
                for thread in 0..threads {
                    let order =
                        (thread * share..(thread + 1) * share).map(|row| row * stride % rows);
                    let upper = order.filter(|&row| row < rows / 2).count() as f32;
                    let part = upper / share as f32;
                    assert!(
                        (0.3..=0.7).contains(&part),
                        "{rows} rows, {threads} threads: {part}"
                    );
                }
            }
        }
    }
}
