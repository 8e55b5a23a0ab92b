//! scratch
#[path = "physics/scenes.rs"]
mod scenes;
use scenes::{newtonian, settings, walls};
use osteoflow::math::{Aabb, Vec3};
use osteoflow::sim::{ElasticWaves, Inlet, Scheme, Simulation, TimeStep};
use osteoflow::solid::{Shape, Solid};

const RADIUS: f64 = 1.195e-3;
const FLOW_RATE: f64 = 2e-7;

fn env(name: &str, default: f64) -> f64 {
    std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(default)
}

#[test]
fn needle() {
    let length = env("LEN", 8.0) * 1e-3;
    let dx = env("DX", 0.5) * 1e-3;
    let outer = RADIUS + 1.2e-3;
    let solid = Solid {
        shapes: vec![Shape::Tube { base: Vec3::new(0.0, 0.0, -2e-3), axis: Vec3::z(), length: length + 2e-3, inner: RADIUS, outer }],
        grids: Vec::new(),
    };
    let domain = Aabb { min: Vec3::new(-3e-2, -3e-2, -3e-3), max: Vec3::new(3e-2, 3e-2, 6e-2) };
    let region = Aabb { min: Vec3::new(-outer, -outer, -2e-3), max: Vec3::new(outer, outer, length) };
    let mut s = settings(dx, domain);
    let eta = env("ETA", 4.4);
    if env("WAVES", 0.0) > 0.0 { s.elastic_waves = ElasticWaves::Resolved; }
    s.cement = newtonian(1070.0, eta);
    if env("CT", 0.0) > 0.0 {
        s.scheme = Scheme::ImmCt;
        s.cement.polymer.viscosity = 8.0;
        s.cement.liquid.viscosity = 0.01;
        s.cement.relaxation_time = env("LAMBDA", 0.05);
        s.cement.thinning = env("GAMMA", 0.5);
    }
    s.inlets = vec![Inlet { name: "needle".into(), position: Vec3::zeros(), direction: Vec3::z(), diameter: 2.0 * RADIUS, flow_rate: FLOW_RATE, polymer_fraction: 0.55, dose: 1e-5 }];
    let dt = env("DT", 0.0);
    s.time_step = if dt > 0.0 { TimeStep::Fixed(dt) } else { TimeStep::Adaptive { min: 1e-7, max: 5e-3, cfl: env("CFL", 0.4) } };
    let particles = walls(&solid, region.grown(dx), Vec3::repeat(0.11e-3), dx, 2.0 * dx);
    let mut simulation = Simulation::new(s, solid, particles).unwrap();
    let (mut sum, mut sq, mut time) = (0.0, 0.0, 0.0);
    let (mut steps, mut its, mut un) = (0, 0, 0);
    let (mut lo, mut hi) = (f64::INFINITY, 0.0_f64);
    let start = std::time::Instant::now();
    let end = env("END", 0.4);
    let from = env("FROM", 0.25);
    let pool = rayon::ThreadPoolBuilder::new().build().unwrap();
    while simulation.time < end {
        let mut last = 0.0;
        let t = simulation.time;
        let r = pool.install(|| simulation.step(1e9).map(|r| { simulation.time += r.dt; steps += 1; its += r.iterations; un += r.retries; last = r.dt; }));
        if let Err(e) = r { eprintln!("{e}"); break; }
        let p = simulation.inlets[0].pressure;
        if std::env::var("TRACE").is_ok() { eprintln!("t {:.5} dt {:.2e} p {:.0} trav {:.2}", t, last, p, simulation.inlets[0].travelled / dx); }
        if t > from { sum += p * last; sq += p * p * last; time += last; lo = lo.min(p); hi = hi.max(p); }
    }
    let ledger = simulation.ledger();
    let mean = sum / time;
    eprintln!("poiseuille {:.0} | p mean {mean:.0} sd {:.0} min {lo:.0} max {hi:.0} | steps {steps} its {:.1} unconv {un} | particles {} compression {:?} in walls {} | {:.1} s",
        8.0 * eta * length * FLOW_RATE / (std::f64::consts::PI * RADIUS.powi(4)), (sq / time - mean * mean).sqrt(), f64::from(its as i32) / f64::from(steps), simulation.fluid.len(), ledger.compression, ledger.in_walls, start.elapsed().as_secs_f64());
}

#[test]
fn giesekus() {
    use osteoflow::sim::{Body, BodyShape};
    let across = env("N", 16.0);
    let gap = 2.0;
    let dx = gap / across;
    let bounds = Aabb { min: Vec3::zeros(), max: Vec3::new(7.0 * dx, gap, 7.0 * dx) };
    let solid = Solid {
        shapes: vec![
            Shape::HalfSpace { point: Vec3::zeros(), normal: Vec3::y() },
            Shape::HalfSpace { point: Vec3::new(0.0, gap, 0.0), normal: -Vec3::y() },
        ],
        grids: Vec::new(),
    };
    let domain = Aabb { min: bounds.min - Vec3::y() * 4.0 * dx, max: bounds.max + Vec3::y() * 4.0 * dx };
    let mut s = settings(dx, domain);
    s.periodic = [true, false, true];
    s.scheme = Scheme::ImmCt;
    s.gravity = Vec3::new(3.0, 0.0, 0.0);
    s.jitter = env("JITTER", 0.0);
    if env("WAVES", 0.0) > 0.0 { s.elastic_waves = ElasticWaves::Resolved; }
    s.cement = newtonian(1.0, 1.0);
    s.cement.relaxation_time = 1.0;
    s.cement.thinning = env("GAMMA", 1.0);
    s.cement.liquid.viscosity = 0.1;
    s.cement.polymer.viscosity = 1.8;
    s.bodies = vec![Body { shape: BodyShape::Box(bounds), polymer_fraction: 1.0, velocity: Vec3::zeros() }];
    s.time_step = TimeStep::Adaptive { min: 1e-9, max: 1.0, cfl: env("CFL", 0.4) };
    let region = Aabb { min: domain.min, max: domain.max - Vec3::new(1e-9, 0.0, 1e-9) };
    let particles = walls(&solid, region, Vec3::new(0.0, 0.27 * dx - dx, 0.0), dx, 2.4 * dx);
    let mut sim = Simulation::new(s, solid, particles).unwrap();
    let pool = rayon::ThreadPoolBuilder::new().build().unwrap();
    let (mut steps, mut its) = (0, 0);
    for k in 1..=8 {
        let end = env("END", 8.0) * f64::from(k) / 8.0;
        if let Err(e) = pool.install(|| sim.advance_to(end, |r| { steps += 1; its += r.iterations; })) { eprintln!("{e}"); break; }
        let v = sim.velocity();
        let q: f64 = v.iter().map(|v| v.x).sum::<f64>() * sim.rest_volume / (49.0 * dx * dx);
        let top = v.iter().map(|v| v.x).fold(0.0, f64::max);
        let l = sim.ledger();
        if k == 8 { profile(&sim, gap, 16); virial(&sim, gap, 16, dx); }
        eprintln!("t {end:.2} Q {q:.3} (exact 6.2546) top {top:.3} (4.131) steps {steps} its {its} stretch {:?} kin {:.3}", l.stretch, l.kinetic);
    }
}

pub fn profile(sim: &Simulation, gap: f64, n: usize) {
    let v = sim.velocity();
    let mut bins = vec![[0.0; 8]; n];
    for i in 0..sim.fluid.len() {
        let y = sim.fluid.position[i].y;
        let b = ((y / gap * n as f64) as isize).clamp(0, n as isize - 1) as usize;
        let u = sim.fluid.conformation[i].to_matrix();
        for (k, x) in [1.0, v[i].x, v[i].y * v[i].y, u[(0, 1)], u[(0, 0)], u[(1, 1)], v[i].x * v[i].x, sim.fluid.pressure[i][0]].iter().enumerate() { bins[b][k] += x; }
    }
    let mean: Vec<[f64; 8]> = bins.iter().map(|b| b.map(|x| x / b[0])).collect();
    for b in 0..n / 2 {
        let y = (b as f64 + 0.5) / n as f64 * gap;
        let h = gap / n as f64;
        let rate = if b == 0 { (mean[1][1] + mean[0][1]) / 2.0 / h } else { (mean[b + 1][1] - mean[b - 1][1]) / 2.0 / h };
        let stress = 1.8 * mean[b][3] + 0.1 * rate;
        eprintln!("y {y:.3} u {:.3} (sd {:.3}) vy rms {:.4} rate {rate:.3} Uxy {:.3} Uxx {:.3} Uyy {:.3} stress {stress:.3} needed {:.3} p {:.3}", mean[b][1], (mean[b][6] - mean[b][1] * mean[b][1]).max(0.0).sqrt(), mean[b][2].sqrt(), mean[b][3], mean[b][4], mean[b][5], 3.0 * (gap / 2.0 - y), mean[b][7]);
    }
}

pub fn virial(sim: &Simulation, gap: f64, n: usize, dx: f64) {
    let k = osteoflow::sph::Kernel::new(2.4 * dx);
    let f = &sim.fluid;
    let v = sim.rest_volume;
    let mut bins = vec![[0.0; 5]; n];
    for i in 0..f.len() {
        let b = ((f.position[i].y / gap * n as f64) as isize).clamp(0, n as isize - 1) as usize;
        bins[b][0] += 1.0;
        for j in 0..f.len() {
            if i == j { continue; }
            let mut x = f.position[i] - f.position[j];
            x.x -= (x.x / (7.0 * dx)).round() * 7.0 * dx;
            x.z -= (x.z / (7.0 * dx)).round() * 7.0 * dx;
            if x.norm() < 2.4 * dx {
                let g = k.gradient(&x) * v;
                let p = f.pressure[i][0] + f.pressure[j][0];
                bins[b][1] += 0.5 * p * g.x * x.y;
                bins[b][2] += 0.5 * p * g.y * x.y;
                bins[b][3] += 0.5 * p * g.x * x.x;
                bins[b][4] += 0.5 * p * g.z * x.z;
            }
        }
    }
    for b in 1..n / 2 { let m = bins[b].map(|x| x / bins[b][0]); eprintln!("virial bin {b} xy {:.3} xx {:.2} yy {:.2} zz {:.2}", m[1], m[3], m[2], m[4]); }
}
