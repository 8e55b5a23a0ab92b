//! From what a recipe says to what it means: SI, defaults, and checks across keys.

mod bone;
mod check;
mod place;
mod probe;
mod show;
mod time;
mod wall;

use super::{Document, Recipe, Scene, SceneError};
use crate::math::Real;
use crate::sim::{BodyShape, SimSettings};
use check::Checker;
use std::f64::consts::PI;
use std::path::Path;

/// More particles than this are a slip of the pen rather than a wish.
const MOST_PARTICLES: Real = 5e6;
/// More spacings than this along one edge of the domain likewise.
const MOST_SPACINGS: Real = 10_000.0;

/// Checks a recipe; mesh paths are taken relative to `folder`.
pub(super) fn resolve(
    document: &Document<'_>,
    recipe: &Recipe,
    folder: &Path,
) -> Result<Scene, SceneError> {
    let mut check = Checker::new(document);
    let c = &mut check;
    c.positive("spacing", recipe.spacing.si());
    c.within("support_ratio", recipe.support_ratio, 1.8..=4.0);
    c.within("jitter", recipe.jitter, 0.0..=0.5);
    c.require(!recipe.name.trim().is_empty(), "name", "must not be empty");
    let domain = c.bounds("domain", &recipe.domain);

    let (bodies, fillings) = place::bodies(c, recipe, &domain, folder);
    let inlets = place::inlets(c, recipe, &domain);
    c.require(
        !bodies.is_empty() || !inlets.is_empty(),
        "",
        "nothing flows: give at least one [[body]] or [[inlet]]",
    );
    let walls = wall::walls(c, recipe, folder);
    let bone = bone::bone(c, recipe, folder);

    let sim = SimSettings {
        scheme: recipe.scheme,
        stress: recipe.stress,
        elastic_waves: recipe.elastic_waves,
        theta: c.within(
            "theta",
            recipe.theta.unwrap_or(recipe.elastic_waves.theta()),
            0.5..=1.0,
        ),
        spacing: recipe.spacing.si(),
        support_ratio: recipe.support_ratio,
        duration: c.positive("duration", recipe.duration.si()),
        frames_per_second: c.positive("frames_per_second", recipe.frames_per_second.si()),
        gravity: recipe.gravity.map(crate::units::Acceleration::si).into(),
        periodic: time::periodic(c, recipe, &domain),
        domain,
        time_step: time::time_step(c, recipe),
        tolerance: c.within("tolerance", recipe.tolerance, 0.01..=100.0),
        cement: time::cement(c, recipe),
        bodies,
        inlets,
        seed: recipe.seed.into(),
        jitter: recipe.jitter,
        energy_balance: recipe.energy_balance,
        skip_unneeded: recipe.skip_unneeded,
    };
    time::frames(c, &sim);
    let particles = size(c, &sim);
    show::checked(c, "surface", recipe.surface.check());
    show::checked(c, "export", recipe.export.check());
    let scene = Scene {
        name: recipe.name.clone(),
        particles,
        shapes: walls.shapes,
        tubes: walls.tubes,
        meshes: walls.meshes,
        fillings,
        movers: walls.movers,
        probes: probe::probes(c, recipe),
        bone,
        surface: recipe.surface,
        export: recipe.export.clone(),
        preview: show::preview(c, recipe),
        warnings: Vec::new(),
        sim,
    };
    if check.errors.is_empty() {
        Ok(Scene {
            warnings: check.warnings,
            ..scene
        })
    } else {
        Err(SceneError::Keys(check.errors))
    }
}

/// How many particles the scene will hold at most, as far as the recipe alone can tell.
fn size(c: &mut Checker<'_>, sim: &SimSettings) -> u64 {
    let bodies: Real = sim.bodies.iter().map(|body| volume(&body.shape)).sum();
    let doses: Real = sim.inlets.iter().map(|inlet| inlet.dose).sum();
    let particles = (bodies + doses) / sim.spacing.powi(3);
    if particles > MOST_PARTICLES {
        c.error(
            "spacing",
            format!("gives {particles:.1e} particles, at most {MOST_PARTICLES:.0e} are allowed"),
        );
    }
    let longest = sim.domain.extent().max() / sim.spacing;
    if longest > MOST_SPACINGS {
        c.error(
            "domain",
            format!("is {longest:.1e} spacings long, at most {MOST_SPACINGS:.0e} are allowed"),
        );
    }
    particles.ceil() as u64
}

fn volume(shape: &BodyShape) -> Real {
    match shape {
        BodyShape::Box(bounds) => bounds.extent().product(),
        BodyShape::Sphere { radius, .. } => 4.0 / 3.0 * PI * radius.powi(3),
        BodyShape::Cylinder { length, radius, .. } => PI * radius.powi(2) * length,
        // As much as is inside the file.
        BodyShape::Mesh(_) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use crate::math::Vec3;
    use crate::scene::{Scene, SceneError, read};
    use crate::sim::TimeStep;
    use crate::solid::Shape;
    use std::path::Path;

    const RECIPE: &str = r#"
name = "block"
spacing = "0.5 mm"
duration = "10 s"
frames_per_second = "8 1/s"

[domain]
min = ["-20 mm", "-20 mm", "-20 mm"]
max = ["20 mm", "20 mm", "20 mm"]

[[body]]
sphere = { centre = ["0 mm", "0 mm", "0 mm"], radius = "2 mm" }
polymer_fraction = 0.3

[[wall]]
box = { min = ["-15 mm", "-15 mm", "-15 mm"], max = ["15 mm", "15 mm", "15 mm"] }
hollow = true

[bone]
mesh = "bone.obj"
unit = "mm"
up = "z"
cortex = "1 mm"

[[bone.region]]
name = "core"
box = { min = ["-5 mm", "-5 mm", "-5 mm"], max = ["5 mm", "5 mm", "5 mm"] }
strut_period = "2 mm"
strut_diameter = "0.5 mm"

[[bone.region]]
name = "rest"
strut_period = "2 mm"
porosity = 0.8

[[inlet]]
name = "needle"
position = ["0 mm", "0 mm", "3 mm"]
direction = [0, 0, -2]
diameter = "2 mm"
cannula = { length = "4 mm", outer_diameter = "4 mm", clearance = "1 mm" }
flow_rate = "6 ml/min"
ratio = "1:3"
dose = "0.5 ml"

[[preview.view]]
name = "front"
"#;

    fn with(overrides: &[&str]) -> Result<Scene, SceneError> {
        let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
        read("r.toml", RECIPE, Path::new("folder"), &overrides).map(|(_, scene)| scene)
    }

    #[test]
    fn a_recipe_becomes_si() {
        let scene = with(&[]).unwrap();
        assert_eq!(scene.sim.cement.relaxation_time, 0.05);
        assert_eq!(scene.sim.support_ratio, 2.4);
        let inlet = &scene.sim.inlets[0];
        assert_eq!(inlet.polymer_fraction, 0.75);
        assert!((inlet.flow_rate - 0.1e-6).abs() < 1e-20);
        assert_eq!(inlet.direction, -Vec3::z());
        assert!((inlet.position - Vec3::new(0.0, 0.0, 7e-3)).norm() < 1e-15);
        let Shape::Tube {
            base,
            axis,
            length,
            inner,
            outer,
        } = &scene.shapes[1]
        else {
            panic!("{:?}", scene.shapes);
        };
        assert!((base + axis * *length - Vec3::new(0.0, 0.0, 3e-3)).norm() < 1e-15);
        assert!((length - (4e-3 + 1.2e-3)).abs() < 1e-15);
        assert_eq!((*inner, *outer), (1e-3, 2e-3));
        let bone = scene.bone.unwrap();
        assert_eq!(bone.file.path, Path::new("folder").join("bone.obj"));
        assert!((bone.channels[0].radius - 1e-3).abs() < 1e-15);
        assert!((bone.channels[0].length - (length + 1e-3)).abs() < 1e-15);
        // Dose 500 mm³ and ball 32 π/3 mm³, eight particles a mm³.
        assert_eq!(
            scene.particles,
            (8.0_f64 * (500.0 + 32.0 / 3.0 * std::f64::consts::PI)).ceil() as u64
        );
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        let fixed = with(&["time_step.fixed=1 ms"]).unwrap();
        assert_eq!(fixed.sim.time_step, TimeStep::Fixed(1e-3));
    }

    /// Each override alone breaks the recipe at the key named.
    #[test]
    fn what_makes_no_sense_is_refused_at_its_key() {
        for (set, key) in [
            ("spacing=0 mm", "spacing"),
            ("spacing=1 um", "spacing"),
            ("spacing=1 mm", "inlet[0].diameter"),
            ("support_ratio=nan", "support_ratio"),
            ("jitter=-0.1", "jitter"),
            ("duration=-1 s", "duration"),
            ("duration=4 s", "inlet[0].dose"),
            ("frames_per_second=1000000 1/s", "frames_per_second"),
            ("frames_per_second=0.01 1/s", "frames_per_second"),
            ("domain.max[2]=-30 mm", "domain"),
            ("domain.max[2]=5 mm", "inlet[0].position"),
            ("domain.max[0]=1 mm", "body[0]"),
            ("domain.max[0]=1 km", "domain"),
            ("periodic=[\"x\", \"x\"]", "periodic"),
            ("time_step.min=1 s", "time_step.min"),
            ("time_step.cfl=0", "time_step.cfl"),
            (
                "time_step={ fixed = \"1 ms\", max = \"1 ms\" }",
                "time_step",
            ),
            ("cement.rest_drag=1.5", "cement.rest_drag"),
            ("cement.relaxation_time=0 s", "cement.relaxation_time"),
            ("cement.slip_relaxation=0 s", "cement.slip_relaxation"),
            ("cement.diffusion=-1 m2/s", "cement.diffusion"),
            ("body[0].polymer_fraction=1.1", "body[0].polymer_fraction"),
            ("body[0].sphere.radius=-1 mm", "body[0].sphere.radius"),
            (
                "body[0].box={ min = [\"0 m\", \"0 m\", \"0 m\"], max = [\"1 mm\", \"1 mm\", \"1 mm\"] }",
                "body[0]",
            ),
            (
                "wall[0].plane={ point = [\"0 m\", \"0 m\", \"0 m\"], normal = [0, 0, 1] }",
                "wall[0]",
            ),
            (
                "wall[0].turning={ point = [\"0 m\", \"0 m\", \"0 m\"], axis = [0, 0, 0], rate = \"1 1/s\" }",
                "wall[0].turning.axis",
            ),
            (
                "wall[0].moving={ velocity = [\"1 m/s\", \"0 m/s\", \"0 m/s\"] }",
                "wall[0].moving",
            ),
            (
                "wall[0].oscillating={ amplitude = [\"1 m\", \"0 m\", \"0 m\"], frequency = \"0 1/s\" }",
                "wall[0].oscillating.frequency",
            ),
            ("bone.cortex=-1 mm", "bone.cortex"),
            (
                "bone.region[0].strut_diameter=2 mm",
                "bone.region[0].strut_diameter",
            ),
            ("bone.region[0].porosity=0.5", "bone.region[0]"),
            ("bone.region[1].porosity=0", "bone.region[1].porosity"),
            ("bone.region[1].name=core", "bone.region[1].name"),
            ("inlet[0].direction=[0, 0, 0]", "inlet[0].direction"),
            ("inlet[0].direction=[0, inf, 0]", "inlet[0].direction"),
            ("inlet[0].polymer_fraction=0.5", "inlet[0]"),
            (
                "inlet[0].cannula.outer_diameter=2 mm",
                "inlet[0].cannula.outer_diameter",
            ),
            ("surface.threshold=1", "surface.threshold"),
            ("export.velocity_grid=a b", "export.velocity_grid"),
            ("preview.width=1", "preview.width"),
            ("preview.view[0].name=../up", "preview.view[0].name"),
            ("preview.view[0].bone=cut", "preview.view[0].bone"),
            ("preview.view[0].zoom=0", "preview.view[0].zoom"),
        ] {
            match with(&[set]) {
                Err(SceneError::Keys(findings)) => {
                    assert!(findings.iter().any(|f| f.key == key), "{set}: {findings:?}");
                }
                other => panic!("{set}: {other:?}"),
            }
        }
        let error = with(&["body=[]", "inlet=[]"]).unwrap_err().to_string();
        assert!(error.contains("nothing flows"), "{error}");
    }

    #[test]
    fn walls_of_cannulas_are_thick_enough_to_hold_and_drawn_as_thick_as_they_are() {
        let scene = with(&["inlet[0].cannula.outer_diameter=2.5 mm"]).unwrap();
        let wall = |shape: &Shape| match shape {
            Shape::Tube { inner, outer, .. } => Some((*inner, *outer)),
            _ => None,
        };
        assert_eq!(scene.shapes.iter().find_map(wall), Some((1e-3, 2e-3)));
        assert_eq!(scene.tubes.iter().find_map(wall), Some((1e-3, 1.25e-3)));
    }

    #[test]
    fn what_is_unlikely_to_be_meant_is_said() {
        let warned = |set: &str| with(&[set]).unwrap().warnings.remove(0).to_string();
        assert!(warned("bone.region[0].strut_diameter=1 mm").contains("2.0 spacings"));
    }

    #[test]
    fn periodic_axes_must_hold_the_lattice_and_two_supports() {
        let error = |set: &str| {
            with(&["periodic=[\"y\"]", set])
                .map(|_| ())
                .unwrap_err()
                .to_string()
        };
        with(&["periodic=[\"y\"]"]).unwrap();
        assert!(error("domain.max[1]=19.9 mm").contains("make it whole"));
        assert!(error("domain.max[1]=-18 mm").contains("two support radii"));
    }
}
