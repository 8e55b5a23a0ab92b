//! The output folder: what lies where, and whether it is ours.

use super::{FlowError, FrameRange, Stage};
use crate::scene::Document;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// An output folder.
#[derive(Clone, Debug)]
pub struct Folder {
    root: PathBuf,
}

impl Folder {
    /// Opens a folder for the recipe `name`, making it if need be. A folder that holds anything else is refused
    /// unless `force`.
    pub fn open(root: &Path, name: &str, force: bool) -> Result<Self, FlowError> {
        let folder = Self {
            root: root.to_owned(),
        };
        let occupied = |why: String| FlowError::Occupied {
            folder: root.to_owned(),
            why,
        };
        let empty = match fs::read_dir(root) {
            Ok(mut entries) => entries.next().is_none(),
            Err(e) if e.kind() == ErrorKind::NotFound => true,
            Err(e) => return Err(FlowError::io(root)(e)),
        };
        if !empty && !force {
            let lock = fs::read_to_string(folder.lock())
                .map_err(|_| occupied("is not empty and not an output folder".to_owned()))?;
            let owner = Document::parse("lock", &lock).and_then(|document| document.recipe());
            match owner {
                Ok(recipe) if recipe.name == name => {}
                Ok(recipe) => {
                    return Err(occupied(format!(
                        "holds the results of \"{}\"",
                        recipe.name
                    )));
                }
                Err(_) => return Err(occupied("holds the results of another version".to_owned())),
            }
        }
        fs::create_dir_all(root).map_err(FlowError::io(root))?;
        Ok(folder)
    }

    /// A folder that holds the results of some recipe.
    pub fn existing(root: &Path) -> Result<Self, FlowError> {
        let folder = Self {
            root: root.to_owned(),
        };
        if folder.lock().is_file() {
            Ok(folder)
        } else {
            Err(FlowError::NoResults(root.to_owned()))
        }
    }

    /// The folder itself.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// The recipe with everything filled in.
    pub fn lock(&self) -> PathBuf {
        self.root.join("recipe.lock.toml")
    }

    /// Version, machine, timings.
    pub fn run_info(&self) -> PathBuf {
        self.root.join("run.json")
    }

    /// One row a frame.
    pub fn stats(&self) -> PathBuf {
        self.root.join("stats.csv")
    }

    /// Readings of the probes, one row a frame.
    pub fn probes(&self) -> PathBuf {
        self.root.join("probes.csv")
    }

    /// Wall particles.
    pub fn walls(&self) -> PathBuf {
        self.root.join("boundary/walls.osf")
    }

    /// Signed distance of everything solid.
    pub fn solid(&self) -> PathBuf {
        self.root.join("boundary/solid.osf")
    }

    /// What the bone turned out to be.
    pub fn bone_report(&self) -> PathBuf {
        self.root.join("boundary/bone.json")
    }

    /// How wide the ways to its pores are.
    pub fn bone_throats(&self) -> PathBuf {
        self.root.join("boundary/throats.png")
    }

    /// Three slices through the bone.
    pub fn bone_slices(&self) -> PathBuf {
        self.root.join("boundary/slices.png")
    }

    /// How permeable the bone is.
    pub fn permeability(&self) -> PathBuf {
        self.root.join("permeability.json")
    }

    /// The bone's outer surface.
    pub fn bone_mesh(&self) -> PathBuf {
        self.root.join("boundary/bone.obj")
    }

    /// The bone's shell and trabeculae.
    pub fn inside_mesh(&self) -> PathBuf {
        self.root.join("boundary/trabeculae.obj")
    }

    /// Walls given as meshes.
    pub fn wall_mesh(&self) -> PathBuf {
        self.root.join("boundary/walls.obj")
    }

    /// The tubes of all cannulas.
    pub fn cannula_mesh(&self) -> PathBuf {
        self.root.join("boundary/cannula.obj")
    }

    /// Particles of the n-th wall that moves.
    pub fn mover_walls(&self, n: usize) -> PathBuf {
        self.root.join(format!("boundary/mover{n}.walls.osf"))
    }

    /// Signed distance of the n-th wall that moves, in its place at the start.
    pub fn mover_solid(&self, n: usize) -> PathBuf {
        self.root.join(format!("boundary/mover{n}.solid.osf"))
    }

    /// The n-th wall that moves, in its place at the start.
    pub fn mover_mesh(&self, n: usize) -> PathBuf {
        self.root.join(format!("boundary/mover{n}.obj"))
    }

    /// Bounds and signed distance of the n-th mesh that is full of fluid.
    pub fn filling(&self, n: usize) -> PathBuf {
        self.root.join(format!("boundary/body{n}.solid.osf"))
    }

    /// The state of a simulation that has not ended.
    pub fn restart(&self) -> PathBuf {
        self.root.join("restart/state.osf")
    }

    /// The state that was written before that.
    pub fn restart_before(&self) -> PathBuf {
        self.root.join("restart/before.osf")
    }

    /// What the states belong to.
    pub fn restart_origin(&self) -> PathBuf {
        self.root.join("restart/origin.json")
    }

    /// How the simulation went.
    pub fn simulation_report(&self) -> PathBuf {
        self.root.join("simulation.json")
    }

    /// What each surface encloses.
    pub fn surface_report(&self) -> PathBuf {
        self.root.join("surface/surface.json")
    }

    /// A frame of particles.
    pub fn frame(&self, n: u32) -> PathBuf {
        self.root.join(format!("frames/{n:06}.osf"))
    }

    /// A frame's surface.
    pub fn surface(&self, n: u32) -> PathBuf {
        self.root.join(format!("surface/cement.{n:04}.obj"))
    }

    /// A frame's volumes.
    pub fn vdb(&self, n: u32) -> PathBuf {
        self.root.join(format!("vdb/cement.{n:04}.vdb"))
    }

    /// A frame's surface with all that its vertices carry.
    pub fn ply(&self, n: u32) -> PathBuf {
        self.root.join(format!("ply/cement.{n:04}.ply"))
    }

    /// A frame's particles for ParaView.
    pub fn vtp(&self, n: u32) -> PathBuf {
        self.root.join(format!("vtp/cement.{n:04}.vtp"))
    }

    /// The whole take as a USD scene.
    pub fn usd_scene(&self) -> PathBuf {
        self.root.join("scene.usda")
    }

    /// What the layers of the frames animate.
    pub fn usd_manifest(&self) -> PathBuf {
        self.root.join("usd/manifest.usda")
    }

    /// A frame's surface as a layer of the scene.
    pub fn usd_layer(&self, n: u32) -> PathBuf {
        self.root.join(format!("usd/cement.{n:04}.usda"))
    }

    /// Opens the take in Blender.
    pub fn blender_script(&self) -> PathBuf {
        self.root.join("blender_import.py")
    }

    /// How to open the take in Houdini.
    pub fn houdini_note(&self) -> PathBuf {
        self.root.join("houdini.txt")
    }

    /// A frame's picture in one view.
    pub fn picture(&self, view: &str, n: u32) -> PathBuf {
        self.root.join(format!("preview/{view}.{n:04}.png"))
    }

    /// All views at some times on one picture.
    pub fn contact_sheet(&self) -> PathBuf {
        self.root.join("preview/contact.png")
    }

    /// All frames in one view, one after the other.
    pub fn animation(&self, view: &str) -> PathBuf {
        self.root.join(format!("preview/{view}.animation.png"))
    }

    /// The last frame of a view from all around.
    pub fn turntable(&self, view: &str) -> PathBuf {
        self.root.join(format!("preview/{view}.turntable.png"))
    }

    /// What `export` left of each frame, and of what it depends.
    pub fn exported(&self) -> PathBuf {
        self.root.join("stamps/export.frames.json")
    }

    /// What a stage noted when it finished.
    pub fn stamp(&self, stage: Stage) -> PathBuf {
        self.root.join(format!("stamps/{stage}.json"))
    }

    /// The frames that are there, ascending, within the range.
    pub fn frames(&self, range: Option<FrameRange>) -> Result<Vec<u32>, FlowError> {
        let number = |path: &str| {
            path.strip_prefix("frames/")?
                .strip_suffix(".osf")?
                .parse()
                .ok()
        };
        let files = self.files_of(&["frames"])?;
        let frames: Vec<u32> = files.iter().filter_map(|(path, _)| number(path)).collect();
        let chosen: Vec<u32> = frames
            .iter()
            .copied()
            .filter(|&n| range.is_none_or(|r| r.contains(n)))
            .collect();
        match (range, frames.first(), frames.last()) {
            (Some(range), Some(&first), Some(&last)) if chosen.is_empty() => {
                Err(FlowError::NoFrames { range, first, last })
            }
            _ => Ok(chosen),
        }
    }

    /// A path in this folder, relative to it, with `/` on every system.
    pub(super) fn name_of(&self, path: &Path) -> String {
        let inner = path.strip_prefix(&self.root).unwrap_or(path);
        let parts = inner.iter().map(|part| part.to_string_lossy());
        parts.collect::<Vec<_>>().join("/")
    }

    /// Files and their lengths under the given names, sorted; paths are relative with `/` on every system.
    pub(super) fn files_of(&self, names: &[&str]) -> Result<Vec<(String, u64)>, FlowError> {
        let mut files = Vec::new();
        for name in names {
            let path = self.root.join(name);
            let metadata = match fs::metadata(&path) {
                Ok(metadata) => metadata,
                Err(e) if e.kind() == ErrorKind::NotFound => continue,
                Err(e) => return Err(FlowError::io(path)(e)),
            };
            if metadata.is_file() {
                files.push(((*name).to_owned(), metadata.len()));
                continue;
            }
            for entry in fs::read_dir(&path).map_err(FlowError::io(&path))? {
                let entry = entry.map_err(FlowError::io(&path))?;
                let metadata = entry.metadata().map_err(FlowError::io(entry.path()))?;
                if metadata.is_file() {
                    let file = entry.file_name().to_string_lossy().into_owned();
                    files.push((format!("{name}/{file}"), metadata.len()));
                }
            }
        }
        files.sort();
        Ok(files)
    }

    /// Removes what a stage left earlier.
    pub(super) fn clear(&self, names: &[&str]) -> Result<(), FlowError> {
        for (file, _) in self.files_of(names)? {
            let path = self.root.join(file);
            fs::remove_file(&path).map_err(FlowError::io(&path))?;
        }
        Ok(())
    }
}
