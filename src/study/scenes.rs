//! Small scenes that cases and studies share: fluids, boxes, plates and pipes at any place on the voxels.

use super::StudyError;
use crate::fluid::{Cement, PerPhase, PhaseMaterial};
use crate::math::{Aabb, Mat3, Real, Stream, Vec3, lattice};
use crate::sim::{
    Body, BodyShape, ElasticWaves, Motion, MovingSolid, Path, Scheme, SimSettings, Simulation,
    StressStep, TimeStep,
};
use crate::solid::{Shape, Solid, wall_particles};
use crate::sph::WallParticles;

/// A Newtonian cement: both phases alike.
pub fn newtonian(density: Real, viscosity: Real) -> Cement {
    let phase = PhaseMaterial { density, viscosity };
    Cement {
        liquid: phase,
        polymer: phase,
        relaxation_time: 0.0,
        thinning: 0.0,
        rest_drag: 0.5,
        diffusion: 0.0,
        normalised_bonding: false,
        literal_modulus: false,
        slip_relaxation: None,
    }
}

/// A cement whose polymer phase, alone, is an Oldroyd-B fluid (Giesekus with solvent if `thinning` > 0): solvent
/// viscosity η_s, polymer viscosity η_p = G λ [Pa·s].
pub fn viscoelastic(
    density: Real,
    solvent: Real,
    polymer: Real,
    relaxation_time: Real,
    thinning: Real,
) -> Cement {
    Cement {
        liquid: PhaseMaterial {
            density,
            viscosity: solvent,
        },
        polymer: PhaseMaterial {
            density,
            viscosity: polymer,
        },
        relaxation_time,
        thinning,
        ..newtonian(density, polymer)
    }
}

/// Support radius of cases, in spacings.
pub const SUPPORT: Real = 2.4;

/// What a case starts from: no gravity, no fluid, one coupled solve a step.
pub fn settings(spacing: Real, domain: Aabb) -> SimSettings {
    SimSettings {
        scheme: Scheme::Dfsph,
        stress: StressStep::Coupled,
        spacing,
        support_ratio: SUPPORT,
        elastic_waves: ElasticWaves::Damped,
        theta: 1.0,
        duration: 1.0,
        frames_per_second: 10.0,
        gravity: Vec3::zeros(),
        periodic: [false; 3],
        domain,
        time_step: TimeStep::Adaptive {
            min: 1e-9,
            max: 1.0,
            cfl: 0.4,
        },
        tolerance: 1.0,
        cement: newtonian(1000.0, 1.0),
        bodies: Vec::new(),
        inlets: Vec::new(),
        seed: 1,
        jitter: 0.0,
        energy_balance: false,
        skip_unneeded: true,
    }
}

/// A shape full of fluid at rest.
pub fn body(shape: BodyShape, polymer_fraction: Real) -> Body {
    Body {
        shape,
        polymer_fraction,
        velocity: Vec3::zeros(),
        saturated: false,
    }
}

/// Box from the origin.
pub fn boxed(size: Vec3) -> Aabb {
    Aabb {
        min: Vec3::zeros(),
        max: size,
    }
}

/// A place to flow in.
#[derive(Clone, Debug)]
pub struct Place {
    /// What a case changes before it starts.
    pub settings: SimSettings,
    /// What is solid.
    pub solid: Solid,
    /// The wall particles of it.
    pub walls: WallParticles,
    /// What moves.
    pub moving: Vec<MovingSolid>,
}

impl Place {
    /// A run at its start, filled with polymer on a lattice cut off at the walls themselves: on average as much
    /// fluid as there is room, where bodies of recipes keep a little off curved walls.
    pub fn start_full(mut self, name: &str) -> Result<Simulation, StudyError> {
        self.settings.bodies.clear();
        let (domain, dx) = (self.settings.domain, self.settings.spacing);
        let solid = self.solid.clone();
        let mut simulation = self.start(name)?;
        for corner in lattice(&domain.extent().map(|e| (e / dx).round())) {
            let position = domain.min + corner.add_scalar(0.5) * dx;
            if solid.phi(&position) > 0.0 {
                let id = simulation.fluid.len() as u32;
                simulation.fluid.push(position, Vec3::zeros(), 1.0, id, 0);
            }
        }
        Ok(simulation)
    }

    /// A run at its start.
    pub fn start(self, name: &str) -> Result<Simulation, StudyError> {
        Simulation::with_movers(self.settings, self.solid, self.walls, self.moving)
            .map_err(StudyError::run(name))
    }
}

/// A run without walls whose fluid starts with `velocity` [m/s] of each place [m].
pub fn flowing(
    name: &str,
    settings: SimSettings,
    velocity: impl Fn(&Vec3) -> Vec3,
) -> Result<Simulation, StudyError> {
    let mut simulation = Simulation::new(settings, Solid::default(), WallParticles::default())
        .map_err(StudyError::run(name))?;
    let fluid = &mut simulation.fluid;
    for (x, phases) in fluid.position.iter().zip(&mut fluid.phase_velocity) {
        let v = velocity(x);
        *phases = PerPhase {
            liquid: v,
            polymer: v,
        };
    }
    Ok(simulation)
}

/// How the voxels that walls are made of lie to the walls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lie {
    /// Turned about z by the angle of the triangle 3-4-5, which closes after five voxels.
    pub turned: bool,
    /// Seed of the offset, a random point of a voxel.
    pub seed: u64,
}

/// Voxel walls of `solid`, given in the scene's frame: made on a lattice that lies as said, then brought back.
fn walls(solid: &Solid, region: &Aabb, settings: &SimSettings, lie: Lie) -> WallParticles {
    let spacing = settings.spacing;
    let mut random = Stream::new(lie.seed, "voxels");
    let offset = (random.cube().add_scalar(1.0)) * (0.5 * spacing);
    let (c, s) = if lie.turned { (0.8, 0.6) } else { (1.0, 0.0) };
    let turn = Mat3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0);
    let there = |x: &Vec3| turn * (x + offset);
    let shapes = solid.shapes.iter().map(|shape| match shape {
        Shape::HalfSpace { point, normal } => Shape::HalfSpace {
            point: there(point),
            normal: turn * normal,
        },
        Shape::Cylinder {
            base,
            axis,
            length,
            radius,
            hollow,
        } => Shape::Cylinder {
            base: there(base),
            axis: turn * axis,
            length: *length,
            radius: *radius,
            hollow: *hollow,
        },
        other => other.clone(),
    });
    let turned = Solid {
        shapes: shapes.collect(),
        grids: Vec::new(),
    };
    let corners = (0..8).map(|k| {
        let pick = |axis: usize| {
            if k >> axis & 1 == 0 {
                region.min[axis]
            } else {
                region.max[axis]
            }
        };
        there(&Vec3::new(pick(0), pick(1), pick(2)))
    });
    let (mut low, mut high) = (
        Vec3::repeat(Real::INFINITY),
        Vec3::repeat(Real::NEG_INFINITY),
    );
    for corner in corners {
        (low, high) = (low.inf(&corner), high.sup(&corner));
    }
    let around = Aabb {
        min: low,
        max: high,
    }
    .grown(spacing);
    let depth = (settings.support_ratio - 0.4) * spacing;
    let made = wall_particles(&turned, &around, spacing, depth);
    let mut kept = WallParticles::default();
    for (x, &volume) in made.position.iter().zip(&made.volume) {
        let position = turn.transpose() * x - offset;
        // Half-open where the scene wraps around, so that no wall particle is there twice.
        let inside = (0..3).all(|a| {
            let edge = 1e-6 * spacing;
            !settings.periodic[a]
                || (region.min[a] - edge <= position[a] && position[a] < region.max[a] - edge)
        });
        if inside {
            kept.position.push(position);
            kept.volume.push(volume);
        }
    }
    kept
}

/// Plates at y = ± gap/2, `across` spacings apart; periodic along x (10 spacings) and z (7).
pub fn channel(gap: Real, across: u32, lie: Lie) -> Place {
    channel_with(gap, across, lie, SUPPORT)
}

/// The same with another support radius, in spacings.
pub fn channel_with(gap: Real, across: u32, lie: Lie, support_ratio: Real) -> Place {
    let dx = gap / Real::from(across);
    let plate = |side: Real| Shape::HalfSpace {
        point: Vec3::new(0.0, 0.5 * side * gap, 0.0),
        normal: Vec3::y() * -side,
    };
    let solid = Solid {
        shapes: vec![plate(-1.0), plate(1.0)],
        grids: Vec::new(),
    };
    let bounds = Aabb {
        min: Vec3::new(0.0, -0.5 * gap, 0.0),
        max: Vec3::new(10.0 * dx, 0.5 * gap, 7.0 * dx),
    };
    let reach = Vec3::y() * 4.0 * dx;
    let domain = Aabb {
        min: bounds.min - reach,
        max: bounds.max + reach,
    };
    let mut settings = settings(dx, domain);
    settings.support_ratio = support_ratio;
    settings.periodic = [true, false, true];
    settings.bodies = vec![body(BodyShape::Box(bounds), 1.0)];
    let walls = walls(&solid, &domain, &settings, lie);
    Place {
        settings,
        solid,
        walls,
        moving: Vec::new(),
    }
}

/// The same with the upper plate moving along x at `speed` [m/s] from the start on, growing to it within `ramp` [s].
pub fn shear_cell(gap: Real, across: u32, lie: Lie, speed: Real, ramp: Real) -> Place {
    let mut place = channel(gap, across, lie);
    let (lower, upper) = (place.solid.shapes.remove(0), place.solid.shapes.remove(0));
    let all = std::mem::take(&mut place.walls);
    let mut over = WallParticles::default();
    for (x, volume) in all.position.into_iter().zip(all.volume) {
        let part = if x.y > 0.0 {
            &mut over
        } else {
            &mut place.walls
        };
        part.position.push(x);
        part.volume.push(volume);
    }
    place.solid.shapes = vec![lower];
    place.moving = vec![MovingSolid {
        motion: Motion {
            path: Path::Moving {
                velocity: Vec3::x() * speed,
                travel: None,
            },
            ramp,
        },
        solid: Solid {
            shapes: vec![upper],
            grids: Vec::new(),
        },
        particles: over,
    }];
    place
}

/// A pipe along z with its axis at the origin, `across` spacings wide; periodic along z (10 spacings).
pub fn pipe(radius: Real, across: u32, lie: Lie) -> Place {
    let dx = 2.0 * radius / Real::from(across);
    let length = 10.0 * dx;
    let solid = Solid {
        shapes: vec![Shape::Cylinder {
            base: Vec3::new(0.0, 0.0, -length),
            axis: Vec3::z(),
            length: 3.0 * length,
            radius,
            hollow: true,
        }],
        grids: Vec::new(),
    };
    let outer = radius + 4.0 * dx;
    let domain = Aabb {
        min: Vec3::new(-outer, -outer, 0.0),
        max: Vec3::new(outer, outer, length),
    };
    let mut settings = settings(dx, domain);
    settings.periodic = [false, false, true];
    let shape = BodyShape::Cylinder {
        base: Vec3::zeros(),
        axis: Vec3::z(),
        length,
        radius,
    };
    settings.bodies = vec![body(shape, 1.0)];
    let walls = walls(&solid, &domain, &settings, lie);
    Place {
        settings,
        solid,
        walls,
        moving: Vec::new(),
    }
}

/// A cell of `size` [m] with an obstacle in its middle, `across` spacings wide; periodic along all axes.
pub fn around(size: Vec3, spacing: Real, solid: Solid) -> Place {
    around_with(size, spacing, solid, SUPPORT)
}

/// The same with another support radius, in spacings.
pub fn around_with(size: Vec3, spacing: Real, solid: Solid, support_ratio: Real) -> Place {
    let domain = boxed(size);
    let mut settings = settings(spacing, domain);
    settings.support_ratio = support_ratio;
    settings.periodic = [true; 3];
    settings.bodies = vec![body(BodyShape::Box(domain), 1.0)];
    let walls = wall_particles(
        &solid,
        &domain,
        spacing,
        (settings.support_ratio - 0.4) * spacing,
    );
    Place {
        settings,
        solid,
        walls,
        moving: Vec::new(),
    }
}

/// Error and exact value, summed over what is compared.
#[derive(Clone, Copy, Debug, Default)]
pub struct Norm {
    error: Real,
    exact: Real,
}

impl Norm {
    /// Adds a comparison.
    pub fn add(&mut self, got: Real, exact: Real) {
        self.error += (got - exact) * (got - exact);
        self.exact += exact * exact;
    }

    /// ‖got − exact‖₂/‖exact‖₂.
    pub fn relative(&self) -> Real {
        (self.error / self.exact).sqrt()
    }
}
