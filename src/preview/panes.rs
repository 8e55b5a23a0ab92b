//! Glass: the nearest panes of every sample, whatever is behind them.

use super::{
    Material,
    geometry::Geometry,
    layers::{Binned, Seen},
    raster::{BAND_ROWS, Band, Samples},
};
use rayon::prelude::*;
use std::sync::Arc;

/// Panes of glass that one sample can tell apart; those farther away are left out, which keeps lattices readable.
pub(super) const PANES: usize = 3;

/// The panes, band by band; bands without changes are shared.
pub(super) struct Panes {
    bands: Vec<Arc<BandPanes>>,
}

/// Row of a sample: `panes[first[s]..first[s + 1]]`, from near to far; `first` is empty if the band has no glass.
#[derive(Default, PartialEq)]
struct BandPanes {
    first: Vec<u32>,
    panes: Vec<Seen>,
}

impl Panes {
    /// Of all glass in `geometry`.
    pub fn new(geometry: &Geometry, samples: &Samples) -> Self {
        let bands = geometry.view.height.div_ceil(BAND_ROWS);
        let none = Self {
            bands: vec![Arc::default(); bands],
        };
        none.with(geometry, 0, samples)
    }

    /// With the glass among the meshes from `first` on as well.
    pub fn with(&self, geometry: &Geometry, first: usize, samples: &Samples) -> Self {
        let glass: Vec<_> = (first..geometry.meshes.len())
            .filter(|&m| matches!(geometry.meshes[m].layer.material, Material::Glass { .. }))
            .map(|m| Binned::new(geometry, m))
            .collect();
        let bands = self.bands.par_iter().enumerate().map(|(index, before)| {
            if glass.iter().all(|mesh| mesh.is_empty_in(index)) {
                return before.clone();
            }
            let band = Band::new(index, &geometry.view);
            let mut panes = before.spread(band.pixels() * samples.count());
            for mesh in &glass {
                mesh.glass(geometry, &band, index, samples, &mut panes);
            }
            Arc::new(BandPanes::gathered(&panes))
        });
        Self {
            bands: bands.collect(),
        }
    }

    /// Of a sample, from near to far.
    pub fn of(&self, band: usize, sample: usize) -> &[Seen] {
        self.bands[band].of(sample)
    }

    /// Whether a pixel has other panes than in `other`.
    pub fn differ(&self, other: &Self, pixel: usize, width: usize, count: usize) -> bool {
        let index = pixel / (BAND_ROWS * width);
        let (here, there) = (&self.bands[index], &other.bands[index]);
        let first = (pixel - index * BAND_ROWS * width) * count;
        !Arc::ptr_eq(here, there) && (first..first + count).any(|s| here.of(s) != there.of(s))
    }
}

impl BandPanes {
    fn of(&self, sample: usize) -> &[Seen] {
        match self.first.get(sample..sample + 2) {
            Some(ends) => &self.panes[ends[0] as usize..ends[1] as usize],
            None => &[],
        }
    }

    fn spread(&self, samples: usize) -> Vec<[Seen; PANES]> {
        (0..samples)
            .map(|s| {
                let row = self.of(s);
                std::array::from_fn(|k| row.get(k).copied().unwrap_or(Seen::NOTHING))
            })
            .collect()
    }

    fn gathered(rows: &[[Seen; PANES]]) -> Self {
        let mut gathered = Self {
            first: Vec::with_capacity(rows.len() + 1),
            panes: Vec::new(),
        };
        gathered.first.push(0);
        for row in rows {
            let there = row.iter().filter(|pane| **pane != Seen::NOTHING);
            gathered.panes.extend(there);
            gathered.first.push(gathered.panes.len() as u32);
        }
        gathered
    }
}
