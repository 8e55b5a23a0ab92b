//! A recipe as it is written: one field a key, units kept, nothing checked but the type.
//!
//! Serialised again with all defaults filled in it is `recipe.lock.toml`, which is itself a recipe.

use super::accuracy::Accuracy;
use super::bone::BoneRecipe;
use super::place::{BodyRecipe, BoxRecipe, InletRecipe, WallRecipe};
use super::probe::ProbeRecipe;
use super::show::PreviewRecipe;
use crate::export::ExportSettings;
use crate::math::Real;
use crate::sim::{ElasticWaves, Scheme, StressStep};
use crate::surface::SurfaceSettings;
use crate::units::{
    Acceleration, Density, Diffusion, Frequency, Length, Quoted, Rate, Time, Viscosity, Volume,
};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error as _};
use std::borrow::Cow;
use std::path::Path;

/// A whole recipe.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Recipe {
    /// What reports call it.
    pub name: String,
    /// Which list of terms a step is: `"imm_ct"`, `"imm"` or `"dfsph"`.
    #[serde(default = "default_scheme")]
    pub scheme: Scheme,
    /// `"fast"`, `"balanced"` or `"accurate"`: sets what is not given of `stress`, `support_ratio` and
    /// `time_step.cfl` as `study accuracy` found best. The spacing stays as it is.
    pub accuracy: Option<Accuracy>,
    /// `"coupled"` (steps at the CFL limit), `"explicit"`, or `"auto"` (coupled where the explicit limits bind).
    #[serde(default = "default_stress")]
    pub stress: StressStep,
    /// What a coupled step does with elastic waves: `"damped"` (creeping flow) or `"resolved"`.
    #[serde(default)]
    pub elastic_waves: ElasticWaves,
    /// θ of a coupled step: forces act on the velocity at its start (0) to its end (1), 0.5 to 1. 1 damps what the step does
    /// not resolve; 0.55, the default with resolved waves, is nearly of second order and rings a little.
    pub theta: Option<Real>,
    /// Distance between particles at rest.
    pub spacing: Length,
    /// Support radius of the kernel, in spacings.
    #[serde(default = "default_support_ratio")]
    pub support_ratio: Real,
    /// How far the solvers go, as a multiple of their usual goals: below 1 is more exact and slower.
    #[serde(default = "default_tolerance")]
    pub tolerance: Real,
    /// Simulated time.
    pub duration: Time,
    /// Frames per simulated second.
    pub frames_per_second: Frequency,
    /// Body acceleration.
    #[serde(default = "default_gravity")]
    pub gravity: [Acceleration; 3],
    /// Axes that wrap around at the domain.
    #[serde(default)]
    pub periodic: Vec<Axis>,
    /// Seed of everything random.
    #[serde(default = "default_seed")]
    pub seed: u32,
    /// Start jitter of the lattice, in spacings.
    #[serde(default)]
    pub jitter: Real,
    /// Keeps account of where the energy comes from and goes, in `stats.csv`; some passes over the pairs more a step.
    #[serde(default)]
    pub energy_balance: bool,
    /// Skip what a scene does not need; changes speed, never bits.
    #[serde(default = "default_skip")]
    pub skip_unneeded: bool,
    /// Where the simulation takes place.
    pub domain: BoxRecipe,
    /// Time-step control.
    #[serde(default)]
    pub time_step: TimeStepRecipe,
    /// What flows.
    #[serde(default)]
    pub cement: CementRecipe,
    /// Fluid at the start.
    #[serde(default)]
    pub body: Vec<BodyRecipe>,
    /// Solids other than the bone.
    #[serde(default)]
    pub wall: Vec<WallRecipe>,
    /// The bone.
    pub bone: Option<BoneRecipe>,
    /// Fluid that comes in.
    #[serde(default)]
    pub inlet: Vec<InletRecipe>,
    /// Gauges.
    #[serde(default)]
    pub probe: Vec<ProbeRecipe>,
    /// How the cement's surface is drawn out of the particles.
    #[serde(default)]
    pub surface: SurfaceSettings,
    /// How volumes are written.
    #[serde(default)]
    pub export: ExportSettings,
    /// Pictures.
    #[serde(default)]
    pub preview: PreviewRecipe,
}

impl Recipe {
    /// As text, everything filled in: a recipe that means the same.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("a recipe holds nothing that TOML cannot say")
    }

    /// The same coarser by 1.5 and cut to a third of its time and doses: a look at where it leads.
    ///
    /// A periodic axis has to hold a whole number of spacings and two support radii: where that leaves no coarser
    /// spacing, it stays.
    #[must_use]
    pub fn quick(&self) -> Self {
        let mut recipe = self.coarsened(1.5);
        recipe.name.push_str(" (quick)");
        recipe.duration = Time::from_si(self.duration.si() / 3.0);
        for inlet in &mut recipe.inlet {
            inlet.dose = Volume::from_si(inlet.dose.si() / 3.0);
        }
        recipe
    }

    /// The same on particles about `times` as large, where periodic axes let it be.
    #[must_use]
    pub fn coarsened(&self, times: Real) -> Self {
        let mut recipe = self.clone();
        recipe.spacing = Length::from_si(self.coarser(times));
        recipe
    }

    fn coarser(&self, times: Real) -> Real {
        let (fine, domain) = (self.spacing.si(), &self.domain);
        let wanted = times * fine;
        let along: Vec<Real> = self
            .periodic
            .iter()
            .map(|&axis| domain.max[axis as usize].si() - domain.min[axis as usize].si())
            .collect();
        let Some(&first) = along.first() else {
            return wanted;
        };
        let fits = |spacing: &Real| {
            along.iter().all(|length| {
                let count = length / spacing;
                (count - count.round()).abs() < 1e-6 * count
                    && count >= 2.0 * self.support_ratio + 1.0
            })
        };
        let fewest = (first / wanted).round().clamp(1.0, 1e6);
        let counts = (0..64).map(|more| first / (fewest + Real::from(more)));
        counts
            .take_while(|&dx| dx > fine)
            .find(fits)
            .unwrap_or(fine)
    }

    /// The recipe with its mesh paths made absolute, so that it can be stored anywhere; they were relative to
    /// `folder`.
    #[must_use]
    pub fn anchored(&self, folder: &Path) -> Self {
        let anchor = |path: &mut String| {
            if let Ok(whole) = std::path::absolute(folder.join(&*path)) {
                *path = whole.display().to_string();
            }
        };
        let mut recipe = self.clone();
        if let Some(bone) = &mut recipe.bone {
            anchor(&mut bone.mesh);
            bone.volume
                .iter_mut()
                .for_each(|volume| anchor(&mut volume.path));
        }
        let walls = recipe.wall.iter_mut().filter_map(|wall| wall.mesh.as_mut());
        let bodies = recipe.body.iter_mut().filter_map(|body| body.mesh.as_mut());
        let meshes = walls.chain(bodies);
        meshes.for_each(|mesh| anchor(&mut mesh.path));
        recipe
    }
}

/// An axis of space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// To the patient's left in the anatomical frame.
    X,
    /// To the back in the anatomical frame.
    Y,
    /// Up.
    Z,
}

/// Either `fixed`, or an adaptive step between `min` and `max`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimeStepRecipe {
    /// Always this step.
    pub fixed: Option<Time>,
    /// Never below; 1 µs if not given.
    pub min: Option<Time>,
    /// Never above; 20 ms if not given.
    pub max: Option<Time>,
    /// Fraction of a spacing that a particle may move in a step; 0.4 if not given.
    pub cfl: Option<Real>,
}

impl TimeStepRecipe {
    /// With the defaults of an adaptive step, unless it is fixed.
    #[must_use]
    pub fn filled(self) -> Self {
        if self.fixed.is_some() {
            return self;
        }
        let (min, max, cfl) = self.limits();
        Self {
            fixed: None,
            min: Some(min),
            max: Some(max),
            cfl: Some(cfl),
        }
    }

    /// `min`, `max` and `cfl` as given, or else their defaults.
    pub fn limits(self) -> (Time, Time, Real) {
        let min = self.min.unwrap_or(Time::from_si(1e-6));
        let max = self.max.unwrap_or(Time::from_si(0.02));
        (min, max, self.cfl.unwrap_or(0.4))
    }
}

/// The material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CementRecipe {
    /// The solvent (monomer).
    pub liquid: PhaseRecipe,
    /// The solute (polymer powder).
    pub polymer: PhaseRecipe,
    /// λ: how long the polymer remembers.
    pub relaxation_time: Time,
    /// γ: thinning factor.
    pub thinning: Rate,
    /// C_d⁰ [1].
    pub rest_drag: Real,
    /// C_f: phase diffusion coefficient.
    pub diffusion: Diffusion,
    /// Bonding network as printed, or divided by the kernel sum.
    pub bonding: Bonding,
    /// Modulus c η/λ, or c η as printed.
    pub modulus: Modulus,
    /// Time in which friction halts the slip between the phases; `"none"`: the paper's model.
    pub slip_relaxation: TimeOrNone,
}

/// One phase at rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PhaseRecipe {
    /// ρ_k⁰.
    pub density: Density,
    /// η_k.
    pub viscosity: Viscosity,
}

/// How the bonding network (Eq. 10) is summed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Bonding {
    /// As printed: saturates below 1.
    Literal,
    /// Divided by the kernel sum, so that it reaches 1 in pure polymer.
    Normalised,
}

/// The elastic modulus of (Eq. 13).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Modulus {
    /// c η/λ [Pa]: has the Newtonian limit.
    Physical,
    /// c η, as printed.
    Literal,
}

/// A time, or the word `"none"`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeOrNone(pub Option<Time>);

impl JsonSchema for TimeOrNone {
    fn schema_name() -> Cow<'static, str> {
        "TimeOrNone".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "type": "string",
            "description": "a time with its unit, or \"none\"",
            "examples": ["0.05 s", "none"],
        })
    }
}

impl Serialize for TimeOrNone {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            Some(time) => time.serialize(serializer),
            None => serializer.serialize_str("none"),
        }
    }
}

impl<'de> Deserialize<'de> for TimeOrNone {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let expected = Quoted("expected a time such as \"0.05 s\", or \"none\"");
        let text = deserializer.deserialize_any(expected)?;
        if text.trim() == "none" {
            return Ok(Self(None));
        }
        let time = text.parse().map_err(D::Error::custom)?;
        Ok(Self(Some(time)))
    }
}

/// PMMA cement in its first minutes, with the phase viscosities of [IMM-CT].
impl Default for CementRecipe {
    fn default() -> Self {
        Self {
            liquid: PhaseRecipe {
                density: Density::from_si(940.0),
                viscosity: Viscosity::from_si(0.01),
            },
            polymer: PhaseRecipe {
                density: Density::from_si(1180.0),
                viscosity: Viscosity::from_si(8.0),
            },
            relaxation_time: Time::from_si(0.05),
            thinning: Rate::from_si(0.5),
            rest_drag: 0.5,
            diffusion: Diffusion::from_si(1e-7),
            bonding: Bonding::Normalised,
            modulus: Modulus::Physical,
            slip_relaxation: TimeOrNone(None),
        }
    }
}

fn default_scheme() -> Scheme {
    Scheme::ImmCt
}

fn default_stress() -> StressStep {
    StressStep::Coupled
}

/// Balanced: 2.0 is faster, 3.0 more accurate; below 2.4 a resting column shows an odd–even pressure.
fn default_support_ratio() -> Real {
    2.4
}

fn default_tolerance() -> Real {
    1.0
}

fn default_gravity() -> [Acceleration; 3] {
    [0.0, 0.0, -9.81].map(Acceleration::from_si)
}

fn default_seed() -> u32 {
    1
}

fn default_skip() -> bool {
    true
}
