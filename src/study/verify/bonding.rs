//! The bonding network on a lattice: C_d against the exact sum.

use super::series::{curve, dots};
use super::{Bench, Case, Figure, Goal, Measured, StudyError};
use crate::fluid::{FluidParticles, bonding};
use crate::math::{Real, Vec3};
use crate::report::{Axis, Plot};
use crate::sph::{Domain, Kernel, Neighbourhood};
use crate::study::scenes::{boxed, newtonian};

pub(super) const CASE: Case = Case {
    name: "bonding",
    about: "bonding network (Eq. 10) on lattices of any polymer fraction",
    measure,
};

const REST_DRAG: Real = 0.3;
const FRACTIONS: [Real; 6] = [0.0, 0.2, 0.4, 0.6, 0.8, 1.0];
const SUPPORTS: [Real; 3] = [2.0, 2.4, 3.0];

/// Support ratio, fraction, C_d as printed, exact, C_d normalised, exact.
type Row = (Real, Real, [Real; 4]);

fn measure(bench: &Bench) -> Result<Measured, StudyError> {
    let (rows, seconds): (Vec<Row>, _) =
        bench.run("bonding", &(FRACTIONS, SUPPORTS), || Ok(lattices()))?;
    let worst = |k: usize| {
        let errors = rows.iter().map(|row| (row.2[k] / row.2[k + 1] - 1.0).abs());
        errors.fold(0.0, Real::max)
    };
    let pure = rows.iter().filter(|row| row.1 == 1.0);
    let short_of_one = pure.map(|row| (row.2[2] - 1.0).abs()).fold(0.0, Real::max);
    let figure = |what: &str, reached: Real| Figure {
        what: what.into(),
        resolution: "18 lattices".into(),
        reached,
        goal: Goal::AtMost(1e-12),
        seconds,
    };
    let mut plot = Plot {
        title: "Bonding network on a lattice, rest drag 0.3".into(),
        x: Axis::linear("polymer fraction"),
        y: Axis::linear("drag coefficient"),
        series: Vec::new(),
    };
    for (colour, support) in SUPPORTS.into_iter().enumerate() {
        let of: Vec<&Row> = rows.iter().filter(|row| row.0 == support).collect();
        let line = of.iter().map(|row| [row.1, row.2[1]]).collect();
        plot.series
            .push(curve(&format!("support {support} spacings"), colour, line));
        let points = of.iter().map(|row| [row.1, row.2[0]]).collect();
        plot.series.push(dots(colour, points));
    }
    Ok(Measured {
        figures: vec![
            figure("C_d as printed, relative", worst(0)),
            figure("C_d normalised, relative", worst(2)),
            figure("C_d normalised in pure polymer, less 1", short_of_one),
        ],
        plot,
    })
}

fn lattices() -> Vec<Row> {
    let mut rows = Vec::new();
    for support in SUPPORTS {
        let n = 8;
        let kernel = Kernel::new(support);
        let volume = kernel.rest_volume(1.0);
        let domain = Domain {
            bounds: boxed(Vec3::repeat(Real::from(n))),
            periodic: [true; 3],
        };
        let mut fluid = FluidParticles::default();
        for k in 0..n * n * n {
            let place = [k / (n * n), k / n % n, k % n];
            let x = Vec3::from(place.map(|p| Real::from(p) + 0.5));
            fluid.push(x, Vec3::zeros(), 0.0, k as u32, 0);
        }
        let near = Neighbourhood::without_walls(&fluid.position, 1.0, &kernel, &domain);
        // Σ_{j≠i} V₀ W over the lattice, exactly.
        let mut others = 0.0;
        for x in -3..=3_i32 {
            for y in -3..=3_i32 {
                for z in -3..=3_i32 {
                    if (x, y, z) != (0, 0, 0) {
                        others += volume * kernel.w(Real::from(x * x + y * y + z * z).sqrt());
                    }
                }
            }
        }
        for fraction in FRACTIONS {
            fluid.polymer_fraction.fill(fraction);
            let mut cement = newtonian(1000.0, 1.0);
            cement.rest_drag = REST_DRAG;
            let drag = |normalised: bool| {
                let mut cement = cement;
                cement.normalised_bonding = normalised;
                bonding::drag(&cement, &fluid, &near, &kernel, &domain)[0]
            };
            let exact = |share: Real| REST_DRAG + (1.0 - REST_DRAG) * fraction * share;
            let entries = [drag(false), exact(others), drag(true), exact(1.0)];
            rows.push((support, fraction, entries));
        }
    }
    rows
}
