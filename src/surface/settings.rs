//! How the surface is found.

use crate::math::Real;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the surface is found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SurfaceSettings {
    /// Support radius of the colour field's kernel [spacings]. 2 is four particle radii, splashsurf's habit.
    pub smoothing: Real,
    /// Edge of a marching cube [spacings].
    pub cube: Real,
    /// Value of the colour field on the surface [1]. At the default smoothing, 0.6 keeps volume: faces of a filled
    /// box lie within 0.02 spacings of where they should, and a single particle still shows as 0.9 of its volume.
    pub threshold: Real,
    /// How far the surface reaches into what is solid [spacings]. The simulation lets particles in by 0.3: a surface
    /// that ended at the wall itself would lose their volume.
    pub wall_overlap: Real,
    /// Rounds of smoothing [1], which take the bumps of single particles out of closed surfaces and leave threads and
    /// drops alone; 0 shows the colour field as it is.
    pub rounds: u32,
    /// Whether the surface is moved in or out, by half a spacing at most, until it encloses the volume of the
    /// particles.
    pub keep_volume: bool,
    /// Pieces that enclose less are left out, and said in `surface.json` [particles at rest]. 0 keeps all.
    pub smallest_piece: Real,
}

impl Default for SurfaceSettings {
    fn default() -> Self {
        Self {
            smoothing: 2.0,
            cube: 0.5,
            threshold: 0.6,
            wall_overlap: 0.3,
            rounds: 10,
            keep_volume: true,
            smallest_piece: 0.0,
        }
    }
}

impl SurfaceSettings {
    /// What is out of range, if anything: outside it, memory explodes or the surface leaves the particles.
    pub fn check(&self) -> Result<(), String> {
        for (key, value, range) in [
            ("smoothing", self.smoothing, 1.0..=4.0),
            ("cube", self.cube, 0.1..=1.0),
            ("threshold", self.threshold, 0.05..=0.95),
            ("wall_overlap", self.wall_overlap, 0.0..=0.5),
            ("rounds", self.rounds.into(), 0.0..=100.0),
            ("smallest_piece", self.smallest_piece, 0.0..=1e6),
        ] {
            if !range.contains(&value) {
                let (low, high) = range.into_inner();
                return Err(format!(
                    "{key}: expected a number from {low} to {high}, found {value}"
                ));
            }
        }
        Ok(())
    }
}
