//! Seeded randomness: the same numbers on every machine.

use super::{Real, Vec3};
use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng, SeedableRng},
};

/// A stream of random numbers that depends on its seed and on nothing else.
pub struct Stream(ChaCha8Rng);

impl Stream {
    /// The stream `name` of `seed`: streams of different names are independent.
    pub fn new(seed: u64, name: &str) -> Self {
        let mut mixed = seed ^ 0x9e37_79b9_7f4a_7c15;
        for byte in name.bytes() {
            mixed = splitmix(mixed ^ u64::from(byte));
        }
        Self(ChaCha8Rng::seed_from_u64(mixed))
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> Real {
        to_unit(self.0.next_u64())
    }

    /// Uniform in [low, high).
    pub fn between(&mut self, low: Real, high: Real) -> Real {
        low + (high - low) * self.unit()
    }

    /// Uniform in the cube [−1, 1)³.
    pub fn cube(&mut self) -> Vec3 {
        Vec3::new(
            self.between(-1.0, 1.0),
            self.between(-1.0, 1.0),
            self.between(-1.0, 1.0),
        )
    }
}

/// A uniform number in [0, 1) that belongs to a lattice cell.
pub fn hash_unit(seed: u64, cell: [i64; 3], channel: u64) -> Real {
    let mut mixed = splitmix(seed ^ channel.wrapping_mul(0xd6e8_feb8_6659_fd93));
    for coordinate in cell {
        mixed = splitmix(mixed ^ coordinate.cast_unsigned());
    }
    to_unit(mixed)
}

fn to_unit(bits: u64) -> Real {
    (bits >> 11) as Real / (1_u64 << 53) as Real
}

fn splitmix(state: u64) -> u64 {
    let mut z = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
