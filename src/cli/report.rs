//! What `check` says about a recipe.

use crate::bone::Struts;
use crate::math::Real;
use crate::scene::Scene;
use crate::sim::{Scheme, SimSettings, TimeStep, bounds_at_start};
use serde_json::json;
use std::fmt::Write;

/// For people.
pub(super) fn text(scene: &Scene) -> String {
    let sim = &scene.sim;
    let mut lines = String::new();
    let mut line = |name: &str, value: String| {
        // Writing into a string cannot fail.
        let _ = writeln!(lines, "{name:<12} {value}");
    };
    line("name", scene.name.clone());
    line("spacing", format!("{} mm", millimetres(sim.spacing)));
    line(
        "particles",
        format!("at most {} (walls not counted)", scene.particles),
    );
    line(
        "frames",
        format!(
            "{} after the start, over {} s",
            scene.last_frame(),
            sim.duration
        ),
    );
    let extent = sim.domain.extent().map(millimetres);
    line(
        "domain",
        format!("{} × {} × {} mm", extent.x, extent.y, extent.z),
    );
    line("numerics", numerics(sim));
    let mut fractions: Vec<Real> = sim.bodies.iter().map(|b| b.polymer_fraction).collect();
    fractions.extend(sim.inlets.iter().map(|inlet| inlet.polymer_fraction));
    fractions.sort_by(Real::total_cmp);
    fractions.dedup();
    for alpha in fractions {
        // What a slow shear feels; with λ → 0 the polymer is Newtonian.
        let cement = &sim.cement;
        let elastic = cement.modulus(alpha) * cement.linear_relaxation_time();
        let viscosity = match sim.scheme {
            Scheme::ImmCt => cement.liquid.viscosity + elastic,
            _ => cement.mixture_viscosity(alpha),
        };
        let percent = alpha * 100.0;
        line(
            "viscosity",
            format!("{viscosity:.3} Pa.s at {percent:.1} % polymer, sheared slowly"),
        );
    }
    for bound in bounds_at_start(sim) {
        let lifted = if bound.lifted {
            ", which this scheme lifts"
        } else {
            ""
        };
        let (name, dt) = (bound.limit.name(), bound.dt * 1e3);
        line("first step", format!("at most {dt:.4} ms ({name}){lifted}"));
    }
    for inlet in &sim.inlets {
        let percent = inlet.polymer_fraction * 100.0;
        let dose = inlet.dose * 1e6;
        let seconds = inlet.dose / inlet.flow_rate;
        let value = format!(
            "{}: {dose:.3} ml in {seconds:.2} s, {percent:.1} % polymer",
            inlet.name
        );
        line("inlet", value);
    }
    if let Some(bone) = &scene.bone {
        line("bone", bone.file.path.display().to_string());
        for region in &bone.settings.regions {
            let struts = match region.struts {
                Struts::Diameter(d) => format!("{} mm thick", millimetres(d)),
                Struts::Porosity(p) => format!("as thick as leaves {:.0} % open", p * 100.0),
                Struts::Varying(varying) => {
                    let [least, most] = varying.range().map(|p| p * 100.0);
                    format!("as thick as leaves {least:.0} to {most:.0} % open")
                }
            };
            let period = millimetres(region.period);
            let value = format!("{}: struts every {period} mm, {struts}", region.name);
            line("region", value);
        }
    }
    lines
}

/// To a nanometre, so that the last bits of a difference do not show.
fn millimetres(length: Real) -> Real {
    (length * 1e9).round() / 1e6
}

/// For programs.
pub(super) fn json(scene: &Scene) -> String {
    let warnings: Vec<String> = scene.warnings.iter().map(ToString::to_string).collect();
    let report = json!({
        "scene": scene,
        "warnings": warnings,
        "first_step": bounds_at_start(&scene.sim),
    });
    format!("{report:#}\n")
}

/// Scheme, step and solvers in a line.
fn numerics(sim: &SimSettings) -> String {
    let step = match sim.time_step {
        TimeStep::Fixed(dt) => format!("steps of {} ms", dt * 1e3),
        TimeStep::Adaptive { cfl, .. } => format!("cfl {cfl}"),
    };
    let (tolerance, support) = (sim.tolerance, sim.support_ratio);
    let (scheme, stress) = (sim.scheme.name(), sim.stress.name());
    format!("{scheme}, {stress}, {step}, tolerance {tolerance}, support radius {support} spacings")
}
