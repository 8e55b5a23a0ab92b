//! The stages: what each depends on, and what belongs to it in the output folder.

use crate::scene::{Region, Scene};
use serde_json::{Value, json};
use std::fmt;
use std::path::Path;

/// One walk from files to files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Meshes and shapes → wall particles and signed distance.
    Voxelise,
    /// Walls → frames of particles.
    Simulate,
    /// Frames → triangle meshes.
    Surface,
    /// Frames → volumes, and files for other programs.
    Export,
    /// Frames and walls → pictures.
    Preview,
}

impl Stage {
    /// All, each after what it needs.
    pub const ALL: [Self; 5] = [
        Self::Voxelise,
        Self::Simulate,
        Self::Surface,
        Self::Export,
        Self::Preview,
    ];

    /// The verb that runs it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Voxelise => "voxelise",
            Self::Simulate => "simulate",
            Self::Surface => "surface",
            Self::Export => "export",
            Self::Preview => "preview",
        }
    }

    /// The stages whose files it reads.
    pub fn needs(self) -> &'static [Self] {
        match self {
            Self::Voxelise => &[],
            Self::Simulate => &[Self::Voxelise],
            Self::Surface | Self::Export | Self::Preview => &[Self::Voxelise, Self::Simulate],
        }
    }

    /// Files and folders in the output folder that are its own.
    pub(super) fn owns(self) -> &'static [&'static str] {
        match self {
            Self::Voxelise => &["boundary"],
            Self::Simulate => &["frames", "stats.csv", "probes.csv", "simulation.json"],
            Self::Surface => &["surface"],
            Self::Export => &[
                "vdb",
                "ply",
                "vtp",
                "usd",
                "scene.usda",
                "blender_import.py",
                "houdini.txt",
            ],
            Self::Preview => &["preview"],
        }
    }

    /// The part of the scene that its results depend on.
    pub(super) fn settings(self, scene: &Scene) -> Value {
        let sim = &scene.sim;
        match self {
            Self::Voxelise => json!({
                "shapes": scene.shapes,
                "tubes": scene.tubes,
                "meshes": scene.meshes,
                "fillings": scene.fillings,
                "movers": scene.movers,
                "duration": if scene.movers.is_empty() { 0.0 } else { sim.duration },
                "bone": scene.bone,
                "spacing": sim.spacing,
                "support_ratio": sim.support_ratio,
                "domain": sim.domain,
                "periodic": sim.periodic,
            }),
            Self::Simulate => json!([sim, scene.movers, scene.probes]),
            Self::Surface => json!(scene.surface),
            Self::Export => json!([scene.export, scene.surface]),
            Self::Preview => json!([scene.preview, scene.surface]),
        }
    }

    /// Files from outside that it reads.
    pub(super) fn files(self, scene: &Scene) -> Vec<&Path> {
        match self {
            Self::Voxelise => {
                let bone = scene.bone.iter().map(|bone| &bone.file);
                let volumes = scene.bone.iter().filter_map(|bone| bone.volume.as_ref());
                let movers = scene.movers.iter().filter_map(|mover| match &mover.region {
                    Region::Mesh(file) => Some(file),
                    Region::Shape(_) => None,
                });
                let files = bone
                    .chain(&scene.meshes)
                    .chain(&scene.fillings)
                    .chain(movers);
                files
                    .map(|file| file.path.as_path())
                    .chain(volumes.map(|volume| volume.path.as_path()))
                    .collect()
            }
            _ => Vec::new(),
        }
    }
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
