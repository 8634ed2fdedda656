//! Occlusion of simple geometry in closed form.
//!
//! The unbounded forms are configuration factors (Howell, "A Catalog of Radiation Heat Transfer Configuration
//! Factors"). Those within a radius follow by the contour integral of the projected solid angle, or azimuth by azimuth.
//! Lengths are in metres, angles in radians. `height` and `radius` may be infinite.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Twice the area of the segment that a line at distance `t` from the centre cuts off the upper half of a unit disc.
fn segment(t: f64) -> f64 {
    if t < 1.0 {
        t.acos() - t * (1.0 - t * t).sqrt()
    } else {
        0.0
    }
}

/// Cosine of the elevation of the top of a wall `height` tall at `distance`: 0 for an infinite wall, 1 for none.
fn cosine_of_top(distance: f64, height: f64) -> f64 {
    distance / distance.hypot(height)
}

/// A floor at `distance` from a perpendicular wall of `height`.
pub fn wall(distance: f64, height: f64, radius: f64) -> f64 {
    let cosine = cosine_of_top(distance, height);
    let above = if cosine > 0.0 {
        cosine * segment(distance.hypot(height) / radius)
    } else {
        0.0
    };
    (segment(distance / radius) - above) / PI
}

/// The part of [`wall`] in directions between the wall's perpendicular and `azimuth`, 0 to π/2, from it to one side.
///
/// At azimuth φ the wall is L = distance / cos φ away. It occludes polar angles whose squared sine exceeds both
/// L² / (L² + height²) and L² / radius².
pub fn wall_sector(distance: f64, height: f64, radius: f64, azimuth: f64) -> f64 {
    // Azimuth up to which the top of the wall is within the radius, ...
    let top = if radius > height {
        (distance / (radius * radius - height * height).sqrt())
            .min(1.0)
            .acos()
    } else {
        0.0
    };
    let top = azimuth.min(top);
    // ... and up to which its foot is.
    let foot = azimuth.min((distance / radius).min(1.0).acos());
    let cosine = cosine_of_top(distance, height);
    let below_top = top - cosine * (cosine * top.tan()).atan();
    let within_radius = (foot - top) - (distance / radius).powi(2) * (foot.tan() - top.tan());
    (below_top + within_radius) / TAU
}

/// A point near a plane: the part of a spherical cap above the horizon. `angle`, 0 to π, is between the normal and the direction to the
/// plane's nearest point, `distance` away.
pub fn tilted_plane(angle: f64, distance: f64, radius: f64) -> f64 {
    if distance >= radius {
        return 0.0;
    }
    let half_angle = (distance / radius).acos();
    let ((sin, cos), (sin_half, cos_half)) = (angle.sin_cos(), half_angle.sin_cos());
    if angle + half_angle <= FRAC_PI_2 {
        return cos * sin_half * sin_half;
    }
    if angle - half_angle >= FRAC_PI_2 {
        return 0.0;
    }
    // Intersection of the cap's rim with the horizon: azimuth about the cap's axis, and about the normal.
    let rim = (cos * cos_half / (sin * sin_half)).clamp(-1.0, 1.0).acos();
    let horizon = (cos_half / sin).clamp(-1.0, 1.0).acos();
    (sin_half * sin_half * cos * (PI - rim) - cos_half * sin_half * sin * rim.sin() + horizon) / PI
}

/// A groove of infinite faces at `interior_angle`, `from_edge` away from the edge.
pub fn v_groove_within(interior_angle: f64, from_edge: f64, radius: f64) -> f64 {
    tilted_plane(interior_angle, from_edge * interior_angle.sin(), radius)
}

/// A floor under a sphere of `sphere_radius` whose centre is `height` ≥ `sphere_radius` above the floor and `offset`
/// to the side of the point.
pub fn floor_under_sphere(sphere_radius: f64, height: f64, offset: f64, radius: f64) -> f64 {
    let away = offset.hypot(height);
    if radius <= away - sphere_radius {
        return 0.0;
    }
    let tangent_squared = away * away - sphere_radius * sphere_radius;
    let sin_squared = if radius * radius >= tangent_squared {
        (sphere_radius / away).powi(2)
    } else {
        1.0 - ((radius * radius + tangent_squared) / (2.0 * radius * away)).powi(2)
    };
    height / away * sin_squared
}

/// A floor at distances `a` and `b` from two walls of `height` that meet at a right angle.
pub fn box_corner_within(a: f64, b: f64, height: f64, radius: f64) -> f64 {
    [(a, b), (b, a)]
        .into_iter()
        .map(|(distance, other)| {
            wall_sector(distance, height, radius, FRAC_PI_2)
                + wall_sector(distance, height, radius, other.atan2(distance))
        })
        .sum()
}

/// The floor of a cylindrical pit of `pit_radius` and `depth`, `offset` < `pit_radius` away from its axis.
pub fn pit(pit_radius: f64, depth: f64, offset: f64) -> f64 {
    let (rho, h, x) = (pit_radius.powi(2), depth.powi(2), offset.powi(2));
    0.5 * (1.0 + (x + h - rho) / ((x + h + rho).powi(2) - 4.0 * x * rho).sqrt())
}

/// As [`pit`], within `radius`. By the midpoint rule.
pub fn pit_within(pit_radius: f64, depth: f64, offset: f64, radius: f64) -> f64 {
    over_azimuth(|azimuth| {
        let (sin, cos) = azimuth.sin_cos();
        let chord = (pit_radius.powi(2) - (offset * sin).powi(2)).max(0.0);
        let away = (chord.sqrt() - offset * cos).powi(2);
        let sin_squared = (away / (away + depth * depth)).max(away / (radius * radius));
        (1.0 - sin_squared).max(0.0)
    })
}

/// The floor of an endless trench of `width` and `depth`, `from_side` away from one of its sides.
pub fn trench_within(width: f64, depth: f64, from_side: f64, radius: f64) -> f64 {
    wall(from_side, depth, radius) + wall(width - from_side, depth, radius)
}

/// Mean of `value` over the azimuth by the midpoint rule: within 1e-6 for values that are continuous.
fn over_azimuth(value: impl Fn(f64) -> f64) -> f64 {
    const SAMPLES: u32 = 4096;
    let samples = (0..SAMPLES).map(|i| value(TAU * (f64::from(i) + 0.5) / f64::from(SAMPLES)));
    samples.sum::<f64>() / f64::from(SAMPLES)
}
