//! Probes.

use super::check::{Checker, point};
use crate::math::Real;
use crate::scene::recipe::Recipe;
use crate::sim::{Gauge, Probe};

/// A table has at most this many columns of one probe.
const MOST_PARTS: u32 = 1000;

pub(super) fn probes(c: &mut Checker<'_>, recipe: &Recipe) -> Vec<Probe> {
    c.distinct("probe", recipe.probe.iter().map(|p| p.name.as_str()));
    let mut probes = Vec::new();
    for (n, probe) in recipe.probe.iter().enumerate() {
        let key = format!("probe[{n}]");
        let given = [
            probe.pressure.is_some(),
            probe.flux.is_some(),
            probe.extents,
            probe.profile.is_some(),
        ];
        let names = ["pressure", "flux", "extents", "profile"];
        if c.exactly_one(&key, &names, &given).is_none() {
            continue;
        }
        let gauge = if let Some(ball) = &probe.pressure {
            Gauge::Pressure {
                centre: point(ball.centre),
                radius: c.positive(&format!("{key}.pressure.radius"), ball.radius.si()),
            }
        } else if let Some(disc) = &probe.flux {
            Gauge::Flux {
                point: point(disc.point),
                normal: c.direction(&format!("{key}.flux.normal"), disc.normal),
                radius: c.positive(&format!("{key}.flux.radius"), disc.radius.si()),
            }
        } else if let Some(line) = &probe.profile {
            let (from, to) = (point(line.from), point(line.to));
            let key = format!("{key}.profile");
            c.require(from != to, &key, "begins where it ends");
            c.within(
                &format!("{key}.parts"),
                line.parts.into(),
                1.0..=Real::from(MOST_PARTS),
            );
            Gauge::Profile {
                from,
                to,
                radius: c.positive(&format!("{key}.radius"), line.radius.si()),
                direction: c.direction(&format!("{key}.direction"), line.direction),
                parts: line.parts as usize,
            }
        } else {
            Gauge::Extents
        };
        probes.push(Probe {
            name: probe.name.clone(),
            gauge,
        });
    }
    probes
}
