//! Faces that share a material and become one mesh.

use core::f32::consts::TAU;

use bevy::{
    asset::RenderAssetUsages,
    mesh::{Indices, PrimitiveTopology},
    prelude::*,
};

/// Faces that share a material. Positions are in metres. So are texture coordinates, to keep the size of tiling
/// textures, except for those of [`Geometry::picture`], which run from 0 to 1.
#[derive(Default)]
pub struct Geometry {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    tangents: Vec<Vec4>,
    uvs: Vec<Vec2>,
    indices: Vec<u32>,
}

impl Geometry {
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Adds a rectangle, by its middle and the halves of its sides; it faces along their cross product.
    pub fn rectangle(&mut self, middle: Vec3, half_right: Vec3, half_up: Vec3) {
        let size = 2.0 * Vec2::new(half_right.length(), half_up.length());
        // Continues the texture where a wall continues.
        let start = Vec2::new(
            (middle - half_right).dot(half_right.normalize_or_zero()),
            -(middle + half_up).dot(half_up.normalize_or_zero()),
        );
        self.patch(middle, half_right, half_up, start, start + size);
    }

    /// Adds a rectangle with the part of a texture between two corners.
    pub fn picture(&mut self, middle: Vec3, half_right: Vec3, half_up: Vec3, uv: Rect) {
        self.patch(middle, half_right, half_up, uv.min, uv.max);
    }

    fn patch(&mut self, middle: Vec3, right: Vec3, up: Vec3, from: Vec2, to: Vec2) {
        let normal = right.cross(up).normalize_or_zero();
        let tangent = right.normalize_or_zero().extend(1.0);
        let first = self.positions.len() as u32;
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            let share = Vec2::new(x, -y) * 0.5 + 0.5;
            let uv = from + (to - from) * share;
            self.vertex(middle + right * x + up * y, normal, tangent, uv);
        }
        self.indices
            .extend([0, 1, 2, 0, 2, 3].map(|corner| first + corner));
    }

    fn vertex(&mut self, position: Vec3, normal: Vec3, tangent: Vec4, uv: Vec2) {
        self.positions.push(position);
        self.normals.push(normal);
        self.tangents.push(tangent);
        self.uvs.push(uv);
    }

    /// Adds a box between two corners.
    pub fn cuboid(&mut self, low: Vec3, high: Vec3) {
        let (low, high) = (low.min(high), low.max(high));
        self.turned_cuboid((low + high) / 2.0, high - low, Quat::IDENTITY);
    }

    /// Adds a box that is rotated around its middle.
    pub fn turned_cuboid(&mut self, middle: Vec3, size: Vec3, turn: Quat) {
        let half = size / 2.0;
        let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| turn * (axis * half.dot(axis)));
        for (right, up, out) in [
            (-z, y, x),
            (z, y, -x),
            (x, -z, y),
            (x, z, -y),
            (x, y, z),
            (-x, y, -z),
        ] {
            self.rectangle(middle + out, right, up);
        }
    }

    /// Adds a round bar between two points, open at its ends.
    pub fn bar(&mut self, from: Vec3, to: Vec3, radius: f32, sides: u32) {
        self.cone(from, to, [radius, radius], sides);
    }

    /// Adds a bar that is thicker at one end.
    pub fn cone(&mut self, from: Vec3, to: Vec3, radii: [f32; 2], sides: u32) {
        let along = to - from;
        let (across, other) = along.normalize_or(Vec3::Y).any_orthonormal_pair();
        let slope = (radii[0] - radii[1]) / along.length().max(1e-4);
        let first = self.positions.len() as u32;
        for side in 0..=sides {
            let angle = TAU * side as f32 / sides as f32;
            let out = across * angle.cos() + other * angle.sin();
            let normal = (out + along.normalize_or_zero() * slope).normalize_or_zero();
            let tangent = (other * angle.cos() - across * angle.sin()).extend(1.0);
            let u = angle * radii[0].max(radii[1]);
            self.vertex(from + out * radii[0], normal, tangent, Vec2::new(u, 0.0));
            let end = Vec2::new(u, along.length());
            self.vertex(to + out * radii[1], normal, tangent, end);
        }
        for side in 0..sides {
            let corner = first + 2 * side;
            self.indices
                .extend([0, 2, 1, 1, 2, 3].map(|next| corner + next));
        }
    }

    /// Adds a ball, squeezed along the axes.
    pub fn ball(&mut self, middle: Vec3, radii: Vec3, sides: u32) {
        let first = self.positions.len() as u32;
        let rings = sides / 2;
        for ring in 0..=rings {
            let polar = core::f32::consts::PI * ring as f32 / rings as f32;
            for side in 0..=sides {
                let angle = TAU * side as f32 / sides as f32;
                let out = Vec3::new(
                    polar.sin() * angle.sin(),
                    polar.cos(),
                    polar.sin() * angle.cos(),
                );
                let normal = (out / radii).normalize_or_zero();
                let tangent = Vec3::new(angle.cos(), 0.0, -angle.sin()).extend(1.0);
                let uv = Vec2::new(angle * radii.x, polar * radii.y);
                self.vertex(middle + out * radii, normal, tangent, uv);
            }
        }
        for ring in 0..rings {
            for side in 0..sides {
                let corner = first + ring * (sides + 1) + side;
                let below = corner + sides + 1;
                self.indices
                    .extend([corner, below, corner + 1, corner + 1, below, below + 1]);
            }
        }
    }

    pub fn vertices(&self) -> usize {
        self.positions.len()
    }

    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    pub fn mesh(self) -> Mesh {
        Mesh::new(
            PrimitiveTopology::TriangleList,
            RenderAssetUsages::default(),
        )
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, self.positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, self.normals)
        .with_inserted_attribute(Mesh::ATTRIBUTE_TANGENT, self.tangents)
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, self.uvs)
        .with_inserted_indices(Indices::U32(self.indices))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each triangle faces along its normals.
    #[test]
    fn faces_are_turned_outwards() {
        let mut geometry = Geometry::default();
        geometry.cuboid(Vec3::ZERO, Vec3::new(1.0, 2.0, 3.0));
        geometry.bar(Vec3::ZERO, Vec3::new(0.3, 1.0, 0.2), 0.1, 8);
        geometry.cone(Vec3::ZERO, Vec3::Y, [0.4, 0.1], 8);
        geometry.ball(Vec3::ZERO, Vec3::new(1.0, 0.5, 0.7), 12);
        for corners in geometry.indices.chunks(3) {
            let [a, b, c] = [0, 1, 2].map(|i| geometry.positions[corners[i] as usize]);
            let face = (b - a).cross(c - a);
            let normal: Vec3 = (corners.iter().map(|i| geometry.normals[*i as usize])).sum();
            // Triangles at the poles of a ball have no area.
            assert!(
                face.length() < 1e-6 || face.dot(normal) > 0.0,
                "{a} {b} {c}: {face} against {normal}"
            );
        }
    }
}
