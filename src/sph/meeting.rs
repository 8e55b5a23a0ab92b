//! What the kernel says of all that is near a point, several neighbours at once in wide registers.

use super::{Cells, Kernel};
use crate::math::{Real, Vec3, Wide, widest};

/// A point within the support radius of another.
pub(super) struct Met {
    /// Which one.
    pub number: usize,
    /// x − x_j [m].
    pub apart: Vec3,
    /// −W'(r)/r [1/m⁵].
    pub steepness: Real,
    /// W(r) [1/m³].
    pub w: Real,
}

/// Calls `visit` for every point within the radius of `x`, in the order of [`Cells::near`].
#[inline]
pub(super) fn meet(cells: &Cells, kernel: &Kernel, x: &Vec3, visit: impl FnMut(Met)) {
    widest(Meeting {
        cells,
        kernel,
        x,
        visit,
    });
}

const LANES: usize = 8;

/// Wide work of its own: as the closure of a method of `Cells` that is wide it takes a step 4 % longer.
struct Meeting<'a, F> {
    cells: &'a Cells,
    kernel: &'a Kernel,
    x: &'a Vec3,
    visit: F,
}

impl<F: FnMut(Met)> Wide for Meeting<'_, F> {
    type Out = ();

    #[inline(always)]
    fn run(mut self) {
        self.cells.bunches(self.x, |bunch| {
            for places in bunch.chunks(LANES) {
                let mut apart = [Vec3::zeros(); LANES];
                let [mut r, mut steepness, mut w] = [[0.0; LANES]; 3];
                for (lane, &place) in places.iter().enumerate() {
                    apart[lane] = self.cells.apart(self.x, place);
                    r[lane] = apart[lane].norm_squared();
                }
                for lane in 0..LANES {
                    r[lane] = r[lane].sqrt();
                    steepness[lane] = self.kernel.steepness(r[lane]);
                    w[lane] = self.kernel.w(r[lane]);
                }
                for (lane, &place) in places.iter().enumerate() {
                    (self.visit)(Met {
                        number: self.cells.number(place),
                        apart: apart[lane],
                        steepness: steepness[lane],
                        w: w[lane],
                    });
                }
            }
        });
    }
}
