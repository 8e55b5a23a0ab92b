//! What an OBJ file says beside its shape: colours of vertices, groups and materials of faces.

use super::{LengthUnit, TriMesh, UpAxis};
use crate::math::{Real, Vec3};
use std::collections::BTreeMap;

/// A mesh with its colours and parts.
#[derive(Clone, Debug, Default)]
pub struct Painted {
    /// The triangles as stored.
    pub mesh: TriMesh,
    /// sRGB colour of each vertex, 0 to 1; white where none is given.
    pub colour: Vec<[f32; 3]>,
    /// Whether the file gives any colour.
    pub coloured: bool,
    /// Names of groups, objects and materials.
    pub names: Vec<String>,
    /// Group of each triangle, or its material where it has one, as a place in `names`.
    pub part: Vec<u32>,
}

impl Painted {
    /// Reads the text of an OBJ file that [`super::read_obj`] has accepted.
    pub fn parse(text: &[u8], unit: LengthUnit, up: UpAxis) -> Self {
        let mut painted = Self::default();
        let mut numbers: BTreeMap<String, u32> = BTreeMap::new();
        let [mut group, mut material] = [String::new(), String::new()];
        for line in text.split(|byte| *byte == b'\n') {
            let line = String::from_utf8_lossy(line);
            let content = line.split('#').next().unwrap_or("");
            let mut words = content.split_whitespace();
            match words.next() {
                Some("v") => painted.vertex(words, unit, up),
                Some("g" | "o") => group = words.collect::<Vec<_>>().join(" "),
                Some("usemtl") => material = words.collect::<Vec<_>>().join(" "),
                Some("f") => {
                    let name = if material.is_empty() {
                        &group
                    } else {
                        &material
                    };
                    let next = painted.names.len() as u32;
                    let part = *numbers.entry(name.clone()).or_insert(next);
                    if part == next {
                        painted.names.push(name.clone());
                    }
                    painted.face(words, part);
                }
                _ => {}
            }
        }
        let count = painted.mesh.positions.len() as u32;
        let good: Vec<bool> = painted
            .mesh
            .triangles
            .iter()
            .map(|t| t.iter().all(|v| *v < count))
            .collect();
        let mut keep = good.iter();
        painted
            .mesh
            .triangles
            .retain(|_| keep.next() == Some(&true));
        let mut keep = good.iter();
        painted.part.retain(|_| keep.next() == Some(&true));
        painted
    }

    fn vertex<'a>(&mut self, words: impl Iterator<Item = &'a str>, unit: LengthUnit, up: UpAxis) {
        let numbers: Vec<Real> = words.map_while(|word| word.parse().ok()).collect();
        let at = |k: usize| numbers.get(k).copied().unwrap_or(0.0);
        self.mesh
            .positions
            .push(up.inward(&Vec3::new(at(0), at(1), at(2))) * unit.metres());
        self.coloured |= numbers.len() >= 6;
        let channel = |k: usize| numbers.get(k).map_or(1.0, |c| c.clamp(0.0, 1.0) as f32);
        self.colour.push(if numbers.len() >= 6 {
            [channel(3), channel(4), channel(5)]
        } else {
            [1.0; 3]
        });
    }

    fn face<'a>(&mut self, words: impl Iterator<Item = &'a str>, part: u32) {
        let count = self.mesh.positions.len() as i64;
        let index = |word: &str| {
            let number: i64 = word.split('/').next()?.parse().ok()?;
            u32::try_from(if number < 0 {
                count + number
            } else {
                number - 1
            })
            .ok()
        };
        let corners: Vec<u32> = words.map_while(index).collect();
        for k in 1..corners.len().saturating_sub(1) {
            self.mesh
                .triangles
                .push([corners[0], corners[k], corners[k + 1]]);
            self.part.push(part);
        }
    }

    /// The place of a group or material in `names`.
    pub fn part_named(&self, name: &str) -> Option<u32> {
        let at = self.names.iter().position(|given| given == name)?;
        Some(at as u32)
    }

    /// Mean of the three channels at a point of triangle `t` [1].
    pub fn brightness(&self, t: usize, point: &Vec3) -> Real {
        let [a, b, c] = self.mesh.corners(t);
        let normal = (b - a).cross(&(c - a));
        let whole = normal.norm_squared();
        let bright = |k: usize| {
            let colour = self.colour[self.mesh.triangles[t][k] as usize];
            Real::from(colour.iter().sum::<f32>()) / 3.0
        };
        if whole <= 0.0 {
            return bright(0);
        }
        let share = |u: &Vec3, v: &Vec3| (u - point).cross(&(v - point)).dot(&normal) / whole;
        let weights = [share(&b, &c), share(&c, &a), share(&a, &b)];
        (0..3)
            .map(|k| weights[k] * bright(k))
            .sum::<Real>()
            .clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_and_parts_are_read() {
        let text = b"v 0 0 0 0 0 0\nv 3 0 0 1 1 1\nv 0 3 0 0.5 0.5 0.5\nv 0 0 1\ng rim\nf 1 2 3\nusemtl lid\nf 1 3 4\nf -4//1 2 4 3\n";
        let painted = Painted::parse(text, LengthUnit::Millimetre, UpAxis::Z);
        assert_eq!(painted.names, ["rim", "lid"]);
        assert_eq!(painted.part, [0, 1, 1, 1]);
        assert_eq!(painted.mesh.triangles[2], [0, 1, 3]);
        assert!(painted.coloured && painted.part_named("lid") == Some(1));
        let middle = painted.brightness(0, &Vec3::new(1e-3, 1e-3, 0.0));
        assert!((middle - 0.5).abs() < 1e-12, "{middle}");
    }
}
