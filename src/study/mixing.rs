//! Fig. 7 and 8 of [IMM-CT]: three schemes mix liquid and polymer at three viscosity ratios, all with the CFL step.
//!
//! Reached with `--level quick` (2 mm, 2 s): dfsph and imm fall over at 1 : 1000 and leave 0.27 to 0.36 of the segregation at
//! 1 : 10 and 1 : 100; imm_ct is stable at all three and leaves 0.20, 0.05 and 0.17: thin liquids part again in the whirl,
//! as the polymer is a quarter heavier. At 1 : 100 it is 90 % mixed after 0.48 s.
//!
//! With `--level full` (1 mm, 4 s, one start): dfsph and imm run away but at 1 : 10, where they leave 0.21 and 0.012 (90 % after
//! 1.74 s); imm_ct is stable at all three and leaves 0.011, 0.008 and 0.129, 90 % mixed after 0.44 s, 0.52 s and not in 4 s.

use super::scenes::SUPPORT;
use super::tank::{Fan, Fate, LIQUID, Tank, cfl_step};
use super::{Bench, Findings, Study, StudyError};
use crate::ink;
use crate::math::{Aabb, Real, Vec3};
use crate::preview::{
    Camera, FELL_OVER, Lettering, PictureSettings, Row, Scene, Sphere, WELL, colour, contact_sheet,
    render,
};
use crate::report::{Axis, Cell, Look, Plot, Series, Table};
use crate::sim::{Scheme, StressStep};
use image::RgbImage;
use serde_json::json;

pub(super) const STUDY: Study = Study {
    name: "mixing",
    about: "a tank stirred by a fan: three schemes, three viscosity ratios (Fig. 7, 8)",
    answer,
};

const SCHEMES: [(&str, Scheme, StressStep); 3] = [
    ("dfsph", Scheme::Dfsph, StressStep::Explicit),
    ("imm", Scheme::Imm, StressStep::Explicit),
    ("imm_ct", Scheme::ImmCt, StressStep::Coupled),
];
/// Viscosities of the polymer [Pa·s].
const VISCOSITIES: [Real; 3] = [0.1, 1.0, 10.0];
const LOOKS: [Look; 3] = [Look::Curve, Look::Dashes, Look::Chain];
/// Share of the segregation at the start that is left when a tank counts as mixed.
const MIXED: Real = 0.1;

fn answer(bench: &Bench) -> Result<Findings, StudyError> {
    let spacing = bench.level.pick(2e-3, 1e-3);
    let duration = bench.level.pick(2.0, 4.0);
    let step = cfl_step(spacing);
    let mut table = Table::new(&[
        "scheme",
        "viscosity ratio",
        "how it ended",
        "time reached [s]",
        "segregation at the end",
        "90 % mixed after [s]",
        "seconds a simulated second",
    ]);
    let mut plot = Plot {
        title: "Intensity of segregation in the stirred tank".into(),
        x: Axis::linear("time [s]"),
        y: Axis::linear("intensity of segregation").between(0.0, 1.0),
        series: Vec::new(),
    };
    let fan = Fan::new(spacing, SUPPORT)?;
    let tanks: Vec<(String, Tank)> = SCHEMES
        .into_iter()
        .flat_map(|scheme| VISCOSITIES.map(|viscosity| (scheme, viscosity)))
        .map(|((name, scheme, stress), viscosity)| {
            let tank = Tank {
                scheme,
                stress,
                viscosity,
                relaxation_time: if scheme == Scheme::ImmCt { 0.05 } else { 0.0 },
                thinning: 0.5,
                spacing,
                step: Some(step),
                seed: 1,
                duration,
                most_steps: None,
                tolerance: 1.0,
                support_ratio: SUPPORT,
            };
            (format!("{name}-{viscosity}"), tank)
        })
        .collect();
    let fates = bench.side_by_side(&tanks, |(run, tank)| {
        let (fate, _) = bench.run(run, tank, || tank.run(run, &fan))?;
        Ok(fate)
    })?;
    let mut fates = fates.into_iter();
    let mut rows = Vec::new();
    let mut facts = Vec::new();
    for (colour, (name, ..)) in SCHEMES.into_iter().enumerate() {
        let mut pictures = Vec::new();
        for ((n, viscosity), fate) in VISCOSITIES.into_iter().enumerate().zip(fates.by_ref()) {
            let mixed = mixed_after(&fate);
            let left = fate.segregation.last().map_or(1.0, |entry| entry[1]);
            let ended = fate.collapse.map(|why| why.to_string());
            let ended = ended.unwrap_or_else(|| "stable".into());
            table.row(vec![
                name.into(),
                (viscosity / LIQUID).into(),
                ended.into(),
                fate.time.into(),
                left.into(),
                mixed.map_or(Cell::None, Into::into),
                fate.cost.into(),
            ]);
            facts.push(json!({
                "scheme": name,
                "ratio": viscosity / LIQUID,
                "collapse": fate.collapse,
                "segregation": left,
                "mixed_after": mixed,
            }));
            let frame = if fate.collapse.is_some() {
                FELL_OVER
            } else {
                WELL
            };
            pictures.push((picture(&fate, spacing), frame));
            plot.series.push(Series {
                name: format!("{name} 1:{}", viscosity / LIQUID),
                points: fate.segregation,
                look: LOOKS[n],
                colour,
            });
        }
        rows.push(Row {
            title: format!("{name}, viscosities 1:10, 1:100, 1:1000"),
            pictures,
        });
    }
    let stable = facts.iter().filter(|f| f["collapse"].is_null()).count();
    Ok(Findings {
        summary: format!(
            "{stable} of {} tanks are stable at the CFL step of {:.2} ms",
            facts.len(),
            step * 1e3
        ),
        tables: vec![(String::new(), table)],
        pictures: vec![
            (String::new(), plot.to_png()),
            ("sheet".to_owned(), png(&contact_sheet(&rows))?),
        ],
        facts: json!({ "step": step, "tanks": facts }),
    })
}

/// When nine tenths of the segregation are gone for good [s].
fn mixed_after(fate: &Fate) -> Option<Real> {
    let first = fate.segregation.first()?[1];
    let above = fate
        .segregation
        .iter()
        .rposition(|e| e[1] > MIXED * first)?;
    let entry = fate.segregation.get(above + 1)?;
    fate.collapse.is_none().then_some(entry[0])
}

/// The particles at the last moment, seen from the side, coloured by polymer fraction.
fn picture(fate: &Fate, spacing: Real) -> RgbImage {
    let finite = fate
        .last
        .iter()
        .filter(|(x, _)| x.iter().all(|c| c.is_finite()));
    let balls: Vec<Sphere> = finite
        .map(|(x, alpha)| Sphere {
            centre: Vec3::new(x[0].into(), x[1].into(), x[2].into()),
            radius: 0.5 * spacing,
            colour: colour::scale(Real::from(*alpha)),
        })
        .collect();
    let tank = Aabb {
        min: Vec3::new(-0.02, -0.02, 0.0),
        max: Vec3::new(0.02, 0.02, 0.04),
    };
    let scene = Scene {
        meshes: Vec::new(),
        spheres: &balls,
        camera: Camera::framing(&tank, 0.35, 0.45, 0.5),
        lettering: Lettering::default(),
    };
    let settings = PictureSettings {
        width: 400,
        height: 320,
        ..PictureSettings::default()
    };
    render(&scene, &settings)
}

fn png(picture: &RgbImage) -> Result<Vec<u8>, StudyError> {
    ink::png(picture).map_err(|error| StudyError::Scene(error.to_string()))
}
