//! What `check` says about a recipe.

use crate::bone::BoneReport;
use crate::bone::Struts;
use crate::flow::Forecast;
use crate::math::Real;
use crate::scene::Scene;
use crate::sim::{Scheme, SimSettings, TimeStep, bounds_at_start};
use serde_json::json;
use std::fmt::Write;

/// For people.
pub(super) fn text(scene: &Scene, forecast: Option<&Forecast>) -> String {
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
    if let Some(forecast) = forecast {
        lines.push_str(&expected(forecast));
    }
    lines
}

/// What was asked of each region of a bone and what was made, below a line that says what is what.
pub(super) fn regions(bone: &BoneReport) -> Vec<String> {
    let built = bone.regions.iter().filter(|region| region.volume > 0.0);
    let rows = built.map(|region| {
        let asked = region.asked_porosity;
        format!(
            "{:<18} {:>14} {:>7.3} {:>10.3} {:>7.2} mm {:>11.1} {:>13.1e} m² {:>8.1}",
            region.name,
            asked.map_or("–".to_owned(), |p| format!("{p:.3}")),
            region.porosity,
            region.resolvable_porosity,
            region.throat_diameter * 1e3,
            region.throat_in_spacings,
            region.kozeny_permeability,
            region.kozeny_constant
        )
    });
    let head = format!(
        "{:<18} {:>14} {:>7} {:>10} {:>10} {:>11} {:>16} {:>8}",
        "region",
        "porosity asked",
        "made",
        "resolvable",
        "throats",
        "in spacings",
        "Kozeny–Carman",
        "constant"
    );
    [head].into_iter().chain(rows).collect()
}

/// The bone as built, and what a run is expected to take.
fn expected(forecast: &Forecast) -> String {
    let mut lines = String::new();
    let mut line = |name: &str, value: String| {
        // Writing into a string cannot fail.
        let _ = writeln!(lines, "{name:<12} {value}");
    };
    if let Some(bone) = &forecast.bone {
        for (n, row) in regions(bone).iter().enumerate() {
            line(if n == 0 { "bone" } else { "" }, row.clone());
        }
    }
    let [start, end] = forecast.particles;
    let walls = forecast.wall_particles;
    line(
        "particles",
        format!("{start} at the start, {end} at the end; {walls} of walls"),
    );
    line("steps", format!("about {}", forecast.steps));
    if let Some(bytes) = forecast.memory_bytes {
        line("memory", format!("about {:.0} MB", bytes as Real * 1e-6));
    }
    line(
        "disk",
        format!("about {:.0} MB", forecast.disk_bytes as Real * 1e-6),
    );
    let stages: Vec<String> = (forecast.stages.iter())
        .map(|of| format!("{} {}", of.stage, duration(of.seconds)))
        .collect();
    line(
        "time",
        format!(
            "about {} on this machine ({})",
            duration(forecast.seconds),
            stages.join(", ")
        ),
    );
    lines
}

/// To two or three digits.
fn duration(seconds: Real) -> String {
    match seconds {
        s if s < 10.0 => format!("{s:.1} s"),
        s if s < 300.0 => format!("{s:.0} s"),
        s if s < 2.0 * 3600.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

/// To a nanometre, so that the last bits of a difference do not show.
fn millimetres(length: Real) -> Real {
    (length * 1e9).round() / 1e6
}

/// For programs.
pub(super) fn json(scene: &Scene, forecast: Option<&Forecast>) -> String {
    let warnings: Vec<String> = scene.warnings.iter().map(ToString::to_string).collect();
    let report = json!({
        "scene": scene,
        "warnings": warnings,
        "first_step": bounds_at_start(&scene.sim),
        "forecast": forecast,
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
