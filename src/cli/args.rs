//! What can be typed.

use crate::bone::Preset;
use crate::bone::vertebra::Level as Vertebra;
use crate::flow::FrameRange;
use crate::mesh::{LengthUnit, UpAxis};
use crate::study::Level;
use crate::units::Length;
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Simulates bone cement: how it mixes, and how it flows from a needle into porous bone.
#[derive(Debug, Parser)]
#[command(version, max_term_width = 100)]
pub(super) struct Arguments {
    #[command(subcommand)]
    pub verb: Verb,
    #[command(flatten)]
    pub common: Common,
}

/// Each verb is one call into `scene`, `flow` or `study`.
#[derive(Debug, Subcommand)]
pub(super) enum Verb {
    /// Says what a recipe, a mesh (.obj) or a volume (.vdb) means, what is doubtful about it, and what a run will take.
    Check(CheckArguments),
    /// Turns bone, meshes, shapes and cannulas into walls: boundary/.
    Voxelise(BoneArguments),
    /// Lets the cement flow: frames/, stats.csv, simulation.json.
    Simulate(WorkArguments),
    /// Draws the cement's surface out of the particles: surface/*.obj.
    Surface(WorkArguments),
    /// Turns the particles into volumes: vdb/*.vdb.
    Export(WorkArguments),
    /// Makes pictures: preview/*.png.
    Preview(PreviewArguments),
    /// All of these in turn, each only if its results are missing or out of date.
    Run(BoneArguments),
    /// Puts the pictures of several runs on one sheet: a row each, columns of times, frames that say how they ended.
    Sheet(SheetArguments),
    /// Prints the JSON Schema of a recipe, for editors.
    Schema,
    /// Makes a mesh from formulas.
    #[command(subcommand)]
    Make(Shape),
    /// Holds the program against exact solutions: a table, and a plot a case.
    Verify {
        /// Cases, all if none is named; --list names them.
        cases: Vec<String>,
        #[command(flatten)]
        work: StudyArguments,
    },
    /// Answers a question about the method with a table and a picture; goes on where it was stopped.
    Study {
        /// Which; --list names them.
        #[arg(required_unless_present = "list")]
        name: Option<String>,
        #[command(flatten)]
        work: StudyArguments,
    },
}

/// How thorough to be, and where the results go.
#[derive(Debug, Args)]
pub(super) struct StudyArguments {
    /// Quick takes minutes, full an hour or more.
    #[arg(long, value_enum, default_value_t = LevelArgument::Quick)]
    pub level: LevelArgument,
    /// Folder of the results and of the runs behind them [default: out/verify, out/study-NAME].
    #[arg(short, long)]
    pub out: Option<PathBuf>,
    /// Says what there is, and runs nothing.
    #[arg(long)]
    pub list: bool,
}

/// How thorough a study is.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum LevelArgument {
    Quick,
    Full,
}

impl From<LevelArgument> for Level {
    fn from(level: LevelArgument) -> Self {
        match level {
            LevelArgument::Quick => Self::Quick,
            LevelArgument::Full => Self::Full,
        }
    }
}

/// What can be made.
#[derive(Debug, Subcommand)]
pub(super) enum Shape {
    /// A lumbar vertebra: closed, in millimetres, z up, origin in the centre of the body.
    Vertebra(VertebraArguments),
    /// A mixing fan: closed, in millimetres, turning about z, lowest edge at z = 0.
    Fan(FanArguments),
    /// The barrel of a syringe: closed, in millimetres, nozzle down, ending at z = 0.
    Syringe(SyringeArguments),
}

/// Size of a fan.
#[derive(Debug, Args)]
pub(super) struct FanArguments {
    /// The OBJ file to write.
    #[arg(short, long)]
    pub out: PathBuf,
    /// From blade tip to blade tip, such as "30 mm".
    #[arg(long, value_parser = |text: &str| between(text, "5 mm", "500 mm"))]
    pub diameter: Option<Length>,
    /// Height of the blades.
    #[arg(long, value_parser = |text: &str| between(text, "1 mm", "200 mm"))]
    pub height: Option<Length>,
    /// Width of the hub.
    #[arg(long, value_parser = |text: &str| between(text, "1 mm", "200 mm"))]
    pub hub: Option<Length>,
    /// Thickness of a blade.
    #[arg(long, value_parser = |text: &str| between(text, "0.5 mm", "50 mm"))]
    pub thickness: Option<Length>,
    /// How many blades.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=12))]
    pub blades: Option<u32>,
    /// Edge of the lattice that the surface is drawn on.
    #[arg(long, value_parser = |text: &str| between(text, "0.2 mm", "5 mm"))]
    pub resolution: Option<Length>,
}

/// Size of a syringe.
#[derive(Debug, Args)]
pub(super) struct SyringeArguments {
    /// The OBJ file to write.
    #[arg(short, long)]
    pub out: PathBuf,
    /// Inner width of the barrel, such as "10 mm".
    #[arg(long, value_parser = |text: &str| between(text, "2 mm", "100 mm"))]
    pub barrel: Option<Length>,
    /// Length of the barrel.
    #[arg(long, value_parser = |text: &str| between(text, "2 mm", "300 mm"))]
    pub length: Option<Length>,
    /// Inner width of the nozzle.
    #[arg(long, value_parser = |text: &str| between(text, "0.5 mm", "50 mm"))]
    pub nozzle: Option<Length>,
    /// Thickness of the wall.
    #[arg(long, value_parser = |text: &str| between(text, "0.2 mm", "20 mm"))]
    pub thickness: Option<Length>,
}

/// Size of a vertebra.
#[derive(Debug, Args)]
pub(super) struct VertebraArguments {
    /// The OBJ file to write.
    #[arg(short, long)]
    pub out: PathBuf,
    /// Writes beside it the bone section of a recipe (.toml): healthy, osteopenic or osteoporotic, by parts of the mesh.
    #[arg(long, value_parser = preset)]
    pub preset: Option<Preset>,
    /// Which lumbar vertebra: L1 to L5, in an adult's mean size [default: L3].
    #[arg(long, value_parser = level)]
    pub level: Option<Vertebra>,
    /// Share of its height that the front has lost, as in a wedge fracture: 0 to 0.6.
    #[arg(long, default_value_t = 0.0, value_parser = lost)]
    pub wedge: f64,
    /// Share of its height that the middle has lost, where an endplate has sunk in: 0 to 0.6.
    #[arg(long, default_value_t = 0.0, value_parser = lost)]
    pub collapse: f64,
    /// Width of the body, left to right, such as "45 mm".
    #[arg(long, value_parser = |text: &str| between(text, "10 mm", "200 mm"))]
    pub width: Option<Length>,
    /// Depth of the body, front to back.
    #[arg(long, value_parser = |text: &str| between(text, "10 mm", "200 mm"))]
    pub depth: Option<Length>,
    /// Height of the body.
    #[arg(long, value_parser = |text: &str| between(text, "10 mm", "200 mm"))]
    pub height: Option<Length>,
    /// Edge of the lattice that the surface is drawn on.
    #[arg(long, value_parser = |text: &str| between(text, "0.4 mm", "5 mm"))]
    pub resolution: Option<Length>,
}

fn preset(text: &str) -> Result<Preset, String> {
    let presets = [Preset::Healthy, Preset::Osteopenic, Preset::Osteoporotic];
    let found = presets.into_iter().find(|preset| preset.name() == text);
    found.ok_or_else(|| "expected healthy, osteopenic or osteoporotic".to_owned())
}

fn level(text: &str) -> Result<Vertebra, String> {
    let levels = [
        Vertebra::L1,
        Vertebra::L2,
        Vertebra::L3,
        Vertebra::L4,
        Vertebra::L5,
    ];
    let found = levels
        .into_iter()
        .find(|level| format!("{level:?}").eq_ignore_ascii_case(text));
    found.ok_or_else(|| "expected L1 to L5".to_owned())
}

fn lost(text: &str) -> Result<f64, String> {
    let share = text
        .parse()
        .ok()
        .filter(|share| (0.0..=0.6).contains(share));
    share.ok_or_else(|| "expected a share from 0 to 0.6".to_owned())
}

/// A length in a range that gives something to hold, and not a dust grain or a mountain.
fn between(text: &str, least: &str, most: &str) -> Result<Length, String> {
    let parse = |text: &str| text.parse::<Length>().map_err(|e| e.to_string());
    let length = parse(text)?;
    if (parse(least)?.si()..=parse(most)?.si()).contains(&length.si()) {
        Ok(length)
    } else {
        Err(format!("expected {least} to {most}"))
    }
}

/// What is looked at.
#[derive(Debug, Args)]
pub(super) struct CheckArguments {
    #[command(flatten)]
    pub recipe: RecipeArguments,
    /// What a 1 in a mesh is: m, cm or mm [default: m].
    #[arg(long, value_parser = unit)]
    pub unit: Option<LengthUnit>,
    /// Which axis of a mesh points up: y or z [default: z].
    #[arg(long, value_parser = up)]
    pub up: Option<UpAxis>,
    /// Draws a mesh here from the front, the left and above, as if its back were at y.
    #[arg(long, value_name = "PNG")]
    pub picture: Option<PathBuf>,
    /// Writes a mesh's triangles here, coloured by what is wrong with them.
    #[arg(long, value_name = "OBJ")]
    pub defects: Option<PathBuf>,
    /// Makes a recipe's walls here, as `voxelise` does: with slices through the bone, boundary/slices.png.
    #[arg(short, long, conflicts_with = "brief")]
    pub out: Option<PathBuf>,
    /// Builds and tries nothing of a recipe: only what it says by itself.
    #[arg(long)]
    pub brief: bool,
}

fn unit(text: &str) -> Result<LengthUnit, String> {
    let units = [
        LengthUnit::Metre,
        LengthUnit::Centimetre,
        LengthUnit::Millimetre,
    ];
    let found = units.into_iter().find(|unit| unit.to_string() == text);
    found.ok_or_else(|| "expected m, cm or mm".to_owned())
}

fn up(text: &str) -> Result<UpAxis, String> {
    let axes = [UpAxis::Y, UpAxis::Z];
    let found = axes.into_iter().find(|axis| axis.to_string() == text);
    found.ok_or_else(|| "expected y or z".to_owned())
}

/// A recipe, and where its results go.
#[derive(Debug, Args)]
pub(super) struct WorkArguments {
    #[command(flatten)]
    pub recipe: RecipeArguments,
    /// Folder of the results [default: out/ and the recipe's name].
    #[arg(short, long)]
    pub out: Option<PathBuf>,
    /// Only these frames, for example 1..48 (both included); for what comes after the simulation.
    #[arg(long, value_name = "FIRST..LAST")]
    pub frames: Option<FrameRange>,
    /// Goes on with a simulation that was stopped, at the last state that it saved.
    #[arg(long, conflicts_with = "force")]
    pub resume: bool,
    /// Works even on what is up to date, in a folder of something else, and with --frames on the frames of a
    /// simulation that did not reach its end.
    #[arg(long)]
    pub force: bool,
}

/// The same for what makes the bone.
#[derive(Debug, Args)]
pub(super) struct BoneArguments {
    #[command(flatten)]
    pub work: WorkArguments,
    /// Also measures how permeable a cube of the bone is, by a creeping flow: permeability.json.
    #[arg(long)]
    pub permeability: bool,
}

/// Pictures, and what they are compared with.
#[derive(Debug, Args)]
pub(super) struct PreviewArguments {
    #[command(flatten)]
    pub work: WorkArguments,
    /// Compares the pictures with those of the same names in this folder; ends with 5 if they look different.
    #[arg(long, value_name = "FOLDER")]
    pub golden: Option<PathBuf>,
    /// Takes the pictures as good: writes them to that folder.
    #[arg(long, requires = "golden")]
    pub bless: bool,
    /// Every byte counts, not only what can be seen.
    #[arg(long, requires = "golden")]
    pub exact: bool,
}

/// Runs side by side.
#[derive(Debug, Args)]
pub(super) struct SheetArguments {
    /// Output folders whose pictures are made.
    #[arg(required = true)]
    pub folders: Vec<PathBuf>,
    /// The PNG to write.
    #[arg(short, long)]
    pub out: PathBuf,
    /// Which view; the first of each run if not given.
    #[arg(long)]
    pub view: Option<String>,
    /// How many moments, from each run's start to its end.
    #[arg(long, default_value_t = 6, value_parser = clap::value_parser!(u8).range(1..=50))]
    pub times: u8,
}

/// A recipe, and changes to it.
#[derive(Debug, Args)]
pub(super) struct RecipeArguments {
    /// The recipe, a TOML file such as pipeline/vertebra.toml, or the folder of its results; for `check` also a mesh or
    /// a volume.
    pub recipe: PathBuf,
    /// Overrides a key of the recipe, for example --set 'inlet[0].flow_rate=4 ml/min'.
    #[arg(long = "set", value_name = "PATH=VALUE")]
    pub overrides: Vec<String>,
    /// Coarser by 1.5 and cut to a third of its time and doses: a first look.
    #[arg(long)]
    pub quick: bool,
}

/// What every verb understands.
#[derive(Debug, Args)]
pub(super) struct Common {
    /// Threads; results do not depend on how many [default: one a core].
    #[arg(short = 'n', long, global = true, value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Results as JSON on stdout.
    #[arg(long, global = true)]
    pub json: bool,
    /// Says nothing but errors.
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Says more: `check` prints the recipe with everything filled in.
    #[arg(short, long, global = true)]
    pub verbose: bool,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Arguments::command().debug_assert();
        let typed = [
            "osteoflow",
            "check",
            "a.toml",
            "--set",
            "a=1",
            "--set",
            "b=2",
            "-n",
            "2",
            "--json",
        ];
        let Arguments { verb, common } = Arguments::try_parse_from(typed).unwrap();
        let Verb::Check(CheckArguments { recipe, .. }) = verb else {
            panic!("{verb:?}");
        };
        assert_eq!(recipe.overrides, ["a=1", "b=2"]);
        assert_eq!(common.threads, Some(2));
        assert!(common.json);
    }
}
