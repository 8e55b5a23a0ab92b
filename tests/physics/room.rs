//! What is pressed in needs room.

use crate::scenes::settings;
use osteoflow::math::{Aabb, Vec3};
use osteoflow::sim::{Body, BodyShape, Inlet, SimError, Simulation};
use osteoflow::solid::{Shape, Solid};
use osteoflow::sph::WallParticles;

const DX: f64 = 1e-3;

/// A pot of 1 ml, 0.3 ml of it full, around an opening in its middle.
fn pot(dose: f64, open: bool) -> Result<(), SimError> {
    let domain = Aabb {
        min: Vec3::zeros(),
        max: Vec3::repeat(16.0 * DX),
    };
    let top = if open { 20.0 } else { 13.0 };
    let solid = Solid {
        shapes: vec![Shape::Box {
            min: Vec3::repeat(3.0 * DX),
            max: Vec3::new(13.0, 13.0, top) * DX,
            hollow: true,
        }],
        grids: Vec::new(),
    };
    let mut s = settings(DX, domain);
    s.duration = 10.0;
    s.bodies = vec![Body {
        shape: BodyShape::Box(Aabb {
            min: Vec3::repeat(3.0 * DX),
            max: Vec3::new(13.0, 13.0, 6.0) * DX,
        }),
        polymer_fraction: 0.5,
        velocity: Vec3::zeros(),
        saturated: false,
    }];
    s.inlets = vec![Inlet {
        name: "needle".into(),
        position: Vec3::repeat(8.0 * DX),
        direction: Vec3::x(),
        diameter: 2.0 * DX,
        flow_rate: 1e-6,
        polymer_fraction: 0.5,
        dose,
    }];
    Simulation::new(s, solid, WallParticles::default()).map(|_| ())
}

#[test]
fn a_closed_pot_takes_what_it_has_room_for_and_no_more() {
    assert_eq!(pot(0.6e-6, false), Ok(()));
    let Err(SimError::NoRoom { room, pressed, .. }) = pot(0.8e-6, false) else {
        panic!("0.8 ml do not fit into 0.7 ml");
    };
    assert!((room - 0.66e-6).abs() < 0.05e-6, "{room}");
    assert_eq!(pressed, 0.8e-6);
    assert_eq!(pot(0.8e-6, true), Ok(()), "it has a way out");
}
