//! The apps whose pipelines are recorded, and the shaders of theirs that are figures.

/// GPU families, as Mesa calls them, with what they are.
pub const FAMILIES: [(&str, &str); 3] = [
    ("vangogh", "AMD RDNA 2, the Steam Deck"),
    ("navi31", "AMD RDNA 3"),
    ("tgl", "Intel Gen12, Tiger Lake"),
];

/// A run of an app.
pub struct Case {
    pub name: &'static str,
    /// Name of a bench, example or test binary.
    pub program: &'static str,
    pub args: &'static str,
    /// The scene of a parity test; empty for other programs.
    pub parity_scene: &'static str,
    pub shaders: &'static [Wanted],
}

impl Case {
    /// The kind of the program, as cargo calls it.
    pub fn kind(&self) -> &'static str {
        match self.program {
            "pictures" => "test",
            "showcase" => "example",
            _ => "bench",
        }
    }

    /// A regular expression of the files with the wanted pipelines.
    pub fn labels(&self) -> String {
        let labels: Vec<&str> = self.shaders.iter().map(|wanted| wanted.label).collect();
        format!("^({})-[0-9a-f]{{8}}[.]pipeline$", labels.join("|"))
    }
}

/// A shader of a run.
pub struct Wanted {
    pub name: &'static str,
    /// Label of its pipeline.
    pub label: &'static str,
    pub stage: Stage,
    pub pick: Pick,
    /// Name of Bevy's counterpart.
    pub beside: Option<&'static str>,
    /// Share of an invocation's estimated cycles that one pixel takes.
    pub per_pixel: f64,
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    Compute,
    Fragment,
}

impl Stage {
    /// As the replayer prints it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Compute => "compute",
            Self::Fragment => "fragment",
        }
    }
}

/// The one of a run's pipelines of one label.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Pick {
    /// By the order in which they were made.
    Nth(usize),
    /// With the most instructions.
    Heaviest,
    /// With the fewest.
    Lightest,
}

const fn compute(name: &'static str, label: &'static str) -> Wanted {
    Wanted {
        name,
        label,
        stage: Stage::Compute,
        pick: Pick::Nth(0),
        beside: None,
        per_pixel: 1.0,
    }
}

const fn fragment(name: &'static str, label: &'static str) -> Wanted {
    Wanted {
        stage: Stage::Fragment,
        pick: Pick::Heaviest,
        ..compute(name, label)
    }
}

impl Wanted {
    const fn nth(self, number: usize) -> Self {
        Self {
            pick: Pick::Nth(number),
            ..self
        }
    }

    const fn heaviest(self) -> Self {
        Self {
            pick: Pick::Heaviest,
            ..self
        }
    }

    const fn lightest(self) -> Self {
        Self {
            pick: Pick::Lightest,
            ..self
        }
    }

    const fn per_pixel(self, share: f64) -> Self {
        Self {
            per_pixel: share,
            ..self
        }
    }

    const fn beside(self, bevys: &'static str) -> Self {
        Self {
            beside: Some(bevys),
            ..self
        }
    }
}

const LIGHTING: &str = "lean_deferred/lighting";
const GBUFFER: &str = "lean_deferred/gbuffer";
const OCCLUSION: &str = "lean_deferred/effects/ambient_occlusion/gather";
const FORWARD: &str = "pbr_opaque_mesh_pipeline";
const DEFERRED: &str = "deferred_lighting_pipeline";
const PREPASS: &str = "pbr_prepass_pipeline";

/// An invocation computes four pixels, in a loop that compilers count as eight iterations.
const OCCLUSION_PER_PIXEL: f64 = 4.0 / 8.0 / 4.0;

const DEFERRED_BOXES: &str = "Bevy's deferred lighting: boxes";
const DEFERRED_STREET: &str = "Bevy's deferred lighting: the street";

/// All runs, small and short: only what is compiled matters. A shader's place here is its row in tables.
pub const CASES: &[Case] = &[
    Case {
        name: "lights",
        program: "pictures",
        args: "parity::lights_match_forward --exact --test-threads=1",
        // In their order in `lab/kit/src/scenes/lights.rs`.
        parity_scene: "directional_shadow_cascades,point_shadow,many_lights_of_all_kinds,reflection_probe",
        shaders: &[
            compute("lighting: a sun with shadows", LIGHTING).beside(DEFERRED_BOXES),
            compute("lighting: points with shadows", LIGHTING)
                .nth(1)
                .beside(DEFERRED_BOXES),
            compute("lighting: a sun, light probes", LIGHTING)
                .nth(2)
                .beside(DEFERRED_BOXES),
            compute("lighting: sun, points, spots with shadows", LIGHTING)
                .nth(3)
                .beside(DEFERRED_BOXES),
        ],
    },
    Case {
        name: "boxes",
        program: "frame_times",
        args: "--scene small_boxes_32 --size 64x36 --frames 1 --warm-up 1 --no-flip \
               --contender Bevy forward,Bevy deferred,lean",
        parity_scene: "",
        shaders: &[
            compute("lighting: a sun with shadows, points", LIGHTING).beside(DEFERRED_BOXES),
            fragment(DEFERRED_BOXES, DEFERRED),
            fragment("Bevy's forward: boxes", FORWARD),
            fragment("G-buffer: boxes", GBUFFER).beside("Bevy's deferred G-buffer: boxes"),
            fragment("Bevy's deferred G-buffer: boxes", PREPASS),
        ],
    },
    Case {
        name: "special",
        program: "frame_times",
        args: "--scene small_targets_all --size 64x36 --frames 1 --warm-up 1 --no-flip \
               --contender Bevy forward,Bevy deferred,lean",
        parity_scene: "",
        shaders: &[
            compute("lighting: special surfaces, all kinds", LIGHTING)
                .heaviest()
                .beside("Bevy's forward: special surfaces"),
            fragment("Bevy's forward: special surfaces", FORWARD),
            fragment("G-buffer: special surfaces", GBUFFER)
                .beside("Bevy's deferred G-buffer: special surfaces"),
            fragment("Bevy's deferred G-buffer: special surfaces", PREPASS),
        ],
    },
    Case {
        name: "blended",
        program: "frame_times",
        args: "--scene glass_cards --size 64x36 --frames 1 --warm-up 1 --no-flip \
               --contender Bevy forward,lean",
        parity_scene: "",
        shaders: &[
            fragment("blended meshes", "lean_deferred/lighting/forward")
                .beside("Bevy's forward: blended meshes"),
            fragment(
                "Bevy's forward: blended meshes",
                "pbr_alpha_blend_mesh_pipeline",
            ),
        ],
    },
    Case {
        name: "street",
        program: "showcase",
        args: "--headless showcase.png --size 160x90 --frames 1",
        parity_scene: "",
        shaders: &[
            compute("lighting: the street", LIGHTING).beside(DEFERRED_STREET),
            compute("lighting: the street, all effects", LIGHTING)
                .heaviest()
                .beside(DEFERRED_STREET),
            fragment(DEFERRED_STREET, DEFERRED),
            fragment("Bevy's forward: the street", FORWARD),
        ],
    },
    Case {
        name: "occlusion",
        program: "ambient_occlusion",
        // They are measured in this order.
        args: "--small --size 64x36 --frames 1 --warm-up 1 \
               --contender =Medium, indirect;=High, indirect;=Ultra, indirect;=Bevy High;=Bevy Ultra",
        parity_scene: "",
        shaders: &[
            // Each has another pipeline for scenes whose occlusion is known.
            compute("occlusion, Medium", OCCLUSION)
                .per_pixel(OCCLUSION_PER_PIXEL)
                .beside("Bevy's SSAO, High"),
            compute("occlusion, High", OCCLUSION)
                .nth(2)
                .per_pixel(OCCLUSION_PER_PIXEL)
                .beside("Bevy's SSAO, Ultra"),
            compute("occlusion, Ultra", OCCLUSION)
                .nth(4)
                .per_pixel(OCCLUSION_PER_PIXEL)
                .beside("Bevy's SSAO, Ultra"),
            compute("Bevy's SSAO, High", "ssao_ssao_pipeline"),
            compute("Bevy's SSAO, Ultra", "ssao_ssao_pipeline").nth(1),
            compute(
                "Bevy's SSAO, levels of depth",
                "ssao_preprocess_depth_pipeline",
            ),
            compute("Bevy's SSAO, denoise", "ssao_spatial_denoise_pipeline"),
        ],
    },
    Case {
        name: "screen_space",
        program: "screen_space",
        args: "--small --no-errors --size 64x36 --frames 1 --warm-up 1 \
               --contender GI, Medium, Half;reflections, Medium, Half;Bevy;scattering, High, All",
        parity_scene: "",
        shaders: &[
            compute("GI, levels", "lean_deferred/effects/diffuse_gi/levels"),
            compute("GI, gather", "lean_deferred/effects/diffuse_gi/gather"),
            compute("GI, filter", "lean_deferred/effects/diffuse_gi/filter"),
            compute("history", "lean_deferred/effects/history"),
            compute(
                "reflections, hi-z",
                "lean_deferred/effects/reflections/hi_z",
            ),
            compute(
                "reflections, trace",
                "lean_deferred/effects/reflections/trace",
            ),
            compute(
                "reflections, spatial filter",
                "lean_deferred/effects/reflections/spatial_filter",
            ),
            compute(
                "reflections, resolve",
                "lean_deferred/effects/reflections/resolve",
            ),
            fragment("Bevy's SSR", "SSR pipeline"),
            compute(
                "scattering, first",
                "lean_deferred/effects/subsurface/first",
            ),
            compute("scattering, down", "lean_deferred/effects/subsurface/down"),
            compute("scattering, turn", "lean_deferred/effects/subsurface/turn"),
            compute("scattering, up", "lean_deferred/effects/subsurface/up").heaviest(),
            compute(
                "scattering, picture",
                "lean_deferred/effects/subsurface/picture",
            ),
        ],
    },
    Case {
        name: "exposure",
        program: "auto_exposure",
        args: "--size 64x36 --frames 1 --warm-up 1 --ring-mb 1 --contender in an app",
        parity_scene: "",
        shaders: &[
            compute(
                "exposure, meter",
                "lean_deferred/effects/auto_exposure/meter",
            ),
            compute(
                "exposure, adapt",
                "lean_deferred/effects/auto_exposure/adapt",
            ),
            compute("Bevy's exposure, histogram", "luminance compute pipeline").lightest(),
            compute("Bevy's exposure, mean", "luminance compute pipeline").heaviest(),
        ],
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_counterparts_exist() {
        let all: Vec<&Wanted> = CASES.iter().flat_map(|case| case.shaders).collect();
        let count = |name: &str| all.iter().filter(|shader| shader.name == name).count();
        for shader in &all {
            assert_eq!(count(shader.name), 1, "{}", shader.name);
            if let Some(beside) = shader.beside {
                assert_eq!(count(beside), 1, "{beside}");
            }
        }
    }
}
