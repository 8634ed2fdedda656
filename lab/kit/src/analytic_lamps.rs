//! Small bright lamps above floors whose light is an integral or a closed form.

use core::f32::consts::PI;

use bevy::{anti_alias::taa::TemporalAntiAliasing, prelude::*};
use bevy_lean_deferred::prelude::*;

use crate::{
    analytic_light::{Seen, camera, errors, light_at, seen, surface},
    analytic_mirrors::{GlowingQuad, metal},
    hdr::{keep_colors, light_target_app, target_light},
    headless::Headless,
    scenes::SceneBuilder,
};

/// A lamp and the floor beneath it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lamp {
    /// An upright quad 0.1 m wide above a metal of this roughness.
    OverMetal { light: f32, roughness: f32 },
    /// A ball 0.3 m wide above a diffuse floor.
    OverDiffuse { light: f32 },
}

const BALL_RADIUS: f32 = 0.15;
const BALL_HEIGHT: f32 = 0.35;
const ALBEDO: f32 = 0.5;

impl Lamp {
    pub fn light(self) -> f32 {
        match self {
            Self::OverMetal { light, .. } | Self::OverDiffuse { light } => light,
        }
    }

    pub fn roughness(self) -> Option<f32> {
        match self {
            Self::OverMetal { roughness, .. } => Some(roughness),
            Self::OverDiffuse { .. } => None,
        }
    }

    fn quad(light: f32) -> GlowingQuad {
        GlowingQuad {
            size: Vec2::splat(0.1),
            height: 0.35,
            light,
        }
    }

    fn spawn(self, s: &mut SceneBuilder) {
        let floor = Plane3d::default().mesh().size(12.0, 12.0);
        match self {
            Self::OverMetal { light, roughness } => {
                let quad = Self::quad(light);
                let place = Transform::from_xyz(0.0, quad.height + quad.size.y / 2.0, 0.0);
                s.mesh(Rectangle::from_size(quad.size), surface(0.0, light), place);
                s.mesh(floor, metal(roughness), Transform::default());
            }
            Self::OverDiffuse { light } => {
                let ball = Sphere::new(BALL_RADIUS).mesh().ico(6);
                let place = Transform::from_xyz(0.0, BALL_HEIGHT, 0.0);
                s.mesh(ball.expect("few subdivisions"), surface(0.0, light), place);
                s.mesh(floor, surface(ALBEDO, 0.0), Transform::default());
            }
        }
    }

    /// Light that the floor sends from `place` towards `eye`.
    fn floor_light(self, place: Vec3, eye: Vec3) -> f32 {
        match self {
            Self::OverMetal { light, roughness } => {
                lobe_over_quad(Self::quad(light), place, eye, roughness)
            }
            // E = πL · c r² / D³.
            Self::OverDiffuse { light } => {
                let distance = place.distance(Vec3::Y * BALL_HEIGHT);
                ALBEDO * light * BALL_HEIGHT * BALL_RADIUS * BALL_RADIUS / distance.powi(3)
            }
        }
    }

    /// True on floor in front of the lamp, and not beneath the ball.
    fn is_compared(self, place: Vec3) -> bool {
        let is_near = (0.02..1.8).contains(&place.z) && place.x.abs() < 1.5;
        let is_beneath = self.roughness().is_none() && place.length() < BALL_RADIUS;
        is_near && !is_beneath
    }
}

/// Light that a metal floor reflects from `quad` at `place` towards `eye`: the integral of GGX over points of the quad, with Smith's
/// correlated shadowing and Fresnel 1. `analytic_mirrors` integrates over the lobe, which meets small quads too rarely.
fn lobe_over_quad(quad: GlowingQuad, place: Vec3, eye: Vec3, roughness: f32) -> f32 {
    let view = (eye - place).normalize();
    let alpha = roughness * roughness;
    let a2 = alpha * alpha;
    let root = |cosine: f32| (a2 + (1.0 - a2) * cosine * cosine).sqrt();
    // Points are closer than the lobe is wide. Across the view it is narrower by the cosine of the view.
    let middle = Vec3::Y * (quad.height + quad.size.y / 2.0);
    let across = quad.size.x / place.distance(middle);
    let side = (across / (alpha * view.y)).ceil().clamp(12.0, 128.0) as u32;
    let area = quad.size.x * quad.size.y / (side * side) as f32;
    let of_point = |i: u32| {
        let u = (Vec2::new((i % side) as f32, (i / side) as f32) + 0.5) / side as f32;
        let at = Vec3::new(
            (u.x - 0.5) * quad.size.x,
            quad.height + u.y * quad.size.y,
            0.0,
        );
        let to_point = at - place;
        let l = to_point.normalize();
        let h = (l + view).normalize();
        let spread = h.x * h.x + h.z * h.z + a2 * h.y * h.y;
        let distribution = a2 / (PI * spread * spread);
        let lobe = distribution * l.y / (2.0 * (l.y * root(view.y) + view.y * root(l.y)));
        lobe * area * -l.z / to_point.length_squared()
    };
    quad.light * (0..side * side).map(of_point).sum::<f32>()
}

/// Errors as shares of the brightest light of the floor.
#[derive(Clone, Copy, Debug)]
pub struct LampErrors {
    pub rmse: f32,
    pub bias: f32,
    /// Largest difference between the floor's light at one place under an upright and under a rolled camera, as a share of its light and
    /// of a fiftieth of the brightest. Sees what is aligned with the pixels: squares and hatching.
    pub rotation: f32,
}

/// Rolls of the camera, in degrees.
const ROLLS: [f32; 2] = [30.0, 45.0];

struct Place {
    pixel: UVec2,
    position: Vec3,
    truth: f32,
}

/// An app of a lamp above a floor.
pub struct LampScene {
    headless: Headless,
    camera: Entity,
    upright: Transform,
    /// Every third pixel of the floor along both axes.
    places: Vec<Place>,
}

impl LampScene {
    pub fn new(lamp: Lamp, size: UVec2, dress: impl FnOnce(&mut EntityWorldMut)) -> Self {
        let mut headless = light_target_app(size);
        let mut s = SceneBuilder {
            headless: &mut headless,
        };
        lamp.spawn(&mut s);
        let upright = Transform::from_xyz(0.0, 1.2, 3.0);
        let upright = upright.looking_at(Vec3::new(0.0, 0.3, 0.0), Vec3::Y);
        let camera = camera(&mut s, upright, 0.0, ());
        let mut entity = s.world().entity_mut(camera);
        keep_colors(&mut entity);
        dress(&mut entity);
        if let Some(mut effect) = entity.get_mut::<LeanScreenSpaceReflections>() {
            // Rays that pass behind the quad must miss it.
            effect.thickness = 0.02;
            effect.advanced.edge_fade = 0.0;
        }
        if let Some(mut effect) = entity.get_mut::<LeanScreenSpaceGi>() {
            // The closed form has no end.
            effect.radius = 100.0;
            effect.advanced.falloff = 0.1;
        }
        headless.settle();
        let light = target_light(&headless);
        let seen = seen(&mut headless, light);
        let floor = seen.on_plane(Vec3::ZERO, Vec3::Y);
        let compared = floor.filter(|(pixel, position, _)| {
            pixel.x.is_multiple_of(3) && pixel.y.is_multiple_of(3) && lamp.is_compared(*position)
        });
        let places = compared.map(|(pixel, position, _)| Place {
            pixel,
            position,
            truth: lamp.floor_light(position, upright.translation),
        });
        let places = places.collect();
        Self {
            headless,
            camera,
            upright,
            places,
        }
    }

    pub fn headless(&self) -> &Headless {
        &self.headless
    }

    /// Errors `frames` frames after a cut.
    pub fn errors(&mut self, frames: usize) -> LampErrors {
        let upright = self.see(0.0, frames);
        let places = self.places.iter();
        let peak = places.clone().map(|place| place.truth).fold(0.0, f32::max);
        let (rmse, bias) = errors(places.map(|place| upright.at(place.pixel) - place.truth));
        let mut rotation: f32 = 0.0;
        for roll in ROLLS {
            let rolled = self.see(roll.to_radians(), frames);
            for place in &self.places {
                if let Some(light) = light_at(&mut self.headless, &rolled, place.position) {
                    let off = (light - upright.at(place.pixel)).abs();
                    rotation = rotation.max(off / (place.truth + 0.02 * peak));
                }
            }
        }
        LampErrors {
            rmse: rmse / peak,
            bias: bias / peak,
            rotation,
        }
    }

    fn see(&mut self, roll: f32, frames: usize) -> Seen {
        let mut rolled = self.upright;
        rolled.rotate_local_z(roll);
        let mut camera = self.headless.world().entity_mut(self.camera);
        camera.insert((rolled, CameraCut));
        if let Some(mut taa) = camera.get_mut::<TemporalAntiAliasing>() {
            taa.reset = true;
        }
        self.headless.frames(frames);
        let light = target_light(&self.headless);
        seen(&mut self.headless, light)
    }
}
