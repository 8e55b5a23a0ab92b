use super::*;
use crate::math::Stream;

fn frame_of(points: Vec<Vec3>, spacing: f64) -> Frame {
    let count = points.len();
    Frame {
        spacing,
        rest_volume: spacing.powi(3),
        support_radius: 2.0 * spacing,
        position: points.iter().map(|p| [p.x as f32, p.y as f32, p.z as f32]).collect(),
        velocity: vec![[0.0; 3]; count],
        polymer_fraction: vec![0.5; count],
        ..Frame::default()
    }
}

fn lattice(half: Vec3, shift: Vec3, inside: impl Fn(&Vec3) -> bool) -> Vec<Vec3> {
    let n = half.map(|h| h.ceil() as i32 + 1);
    let mut points = Vec::new();
    for x in -n.x..=n.x { for y in -n.y..=n.y { for z in -n.z..=n.z {
        let p = Vec3::new(x as f64, y as f64, z as f64) + shift;
        if inside(&p) { points.push(p); }
    }}}
    points
}

fn volume(mesh: &TriMesh) -> f64 {
    mesh.triangles.iter().map(|t| {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
        a.dot(&b.cross(&c)) / 6.0
    }).sum()
}

#[test]
fn probe() {
    for smoothing in [1.6, 2.0, 2.2, 2.4, 3.0] {
        for threshold in [0.4, 0.45, 0.5, 0.55, 0.6, 0.65, 0.7] {
            let mut line = format!("R {smoothing} T {threshold}: ");
            let settings = SurfaceSettings { smoothing, threshold, cube: 0.25 };
            for d in [10.0, 20.0] {
                let r = d / 2.0;
                for shift in [Vec3::repeat(0.5), Vec3::new(0.13, 0.27, 0.41)] {
                let pts = lattice(Vec3::repeat(r), shift, |p| p.norm() < r);
                let n = pts.len() as f64;
                let s = reconstruct(&frame_of(pts, 1.0), &settings);
                line += &format!("sph{d} {:+.2}% ", 100.0 * (volume(&s.mesh) / n - 1.0));
                }
            }
            let pts = lattice(Vec3::repeat(5.0), Vec3::repeat(0.5), |p| p.amax() < 5.0);
            let s = reconstruct(&frame_of(pts, 1.0), &settings);
            let top = s.mesh.positions.iter().filter(|p| p.x.abs() < 0.3 && p.y.abs() < 0.3 && p.z > 0.0).map(|p| p.z);
            let (lo, hi) = top.fold((9.0_f64, 0.0_f64), |a, z| (a.0.min(z), a.1.max(z)));
            line += &format!("box {:+.2}% face {:.3}..{:.3} ", 100.0 * (volume(&s.mesh) / 1000.0 - 1.0), lo-5.0, hi-5.0);
            let s = reconstruct(&frame_of(vec![Vec3::new(0.13,0.27,0.41)], 1.0), &settings);
            line += &format!("one {:.3} ", volume(&s.mesh));
            let s = reconstruct(&frame_of((0..20).map(|i| Vec3::new(0.13,0.27,0.41 + i as f64)).collect(), 1.0), &settings);
            line += &format!("thread {:.3} ", volume(&s.mesh) / 20.0);
            let s = reconstruct(&frame_of((0..400).map(|i| Vec3::new((i % 20) as f64,0.27, (i / 20) as f64)).collect(), 1.0), &settings);
            line += &format!("sheet {:.3} ", volume(&s.mesh) / 400.0);
            let mut random = Stream::new(5, "x");
            let jit: Vec<Vec3> = lattice(Vec3::repeat(10.0), Vec3::repeat(0.5), |p| p.norm() < 10.0).into_iter().map(|p| p + random.cube() * 0.2).collect();
            let n = jit.len() as f64;
            let s = reconstruct(&frame_of(jit, 1.0), &settings);
            line += &format!("jit20 {:+.2}% ", 100.0 * (volume(&s.mesh) / n - 1.0));
            eprintln!("{line}");
        }
    }
}
#[test]
fn timing() {
    let pts = lattice(Vec3::repeat(29.0), Vec3::repeat(0.5), |p| p.norm() < 28.8);
    eprintln!("{} particles", pts.len());
    let f = frame_of(pts, 1.0);
    for cube in [0.5, 0.25] {
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let t = std::time::Instant::now();
        let s = pool.install(|| reconstruct(&f, &SurfaceSettings { cube, ..SurfaceSettings::default() }));
        eprintln!("TIME cube {cube} threads {threads} {:?} {} triangles", t.elapsed(), s.mesh.triangles.len());
    }}
}
