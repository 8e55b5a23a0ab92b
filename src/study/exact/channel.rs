//! Steady flow of a thinning fluid between plates: the momentum balance at each height, then an integral.

use super::giesekus::steady_shear;
use crate::math::Real;

/// A fluid by its steady shear stress, σ(γ̇) = η_s γ̇ + G U_xy(γ̇).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thinning {
    /// η_s [Pa·s].
    pub solvent: Real,
    /// G [Pa].
    pub modulus: Real,
    /// λ [s].
    pub relaxation_time: Real,
    /// γ [1/s].
    pub thinning: Real,
}

impl Thinning {
    /// σ_xy [Pa] at a shear rate [1/s].
    pub fn stress(&self, rate: Real) -> Real {
        self.solvent * rate
            + self.modulus * steady_shear(self.relaxation_time, self.thinning, rate).xy
    }

    /// The shear rate [1/s] at which the shear stress is `stress` ≥ 0 [Pa]; the stress rises with the rate as long
    /// as there is solvent, or γ λ' ≤ 1/2.
    pub fn rate(&self, stress: Real) -> Real {
        let mut high = 1.0;
        while self.stress(high) < stress && high < 1e15 {
            high *= 2.0;
        }
        let mut low = 0.0;
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if self.stress(middle) < stress {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }
}

/// Heights from the middle to the wall [m] and the velocity there [m/s], between plates at ±`half` [m] under the
/// force `force` [N/m³]: σ_xy = f y, and γ̇ integrated from the wall inwards.
pub fn giesekus_channel(
    fluid: &Thinning,
    force: Real,
    half: Real,
    points: usize,
) -> Vec<[Real; 2]> {
    let y = |i: usize| half * i as Real / (points - 1) as Real;
    // Simpson's rule over each interval, with its middle.
    let rate = |y: Real| fluid.rate(force * y);
    let mut profile = vec![[half, 0.0]];
    let mut velocity = 0.0;
    for i in (0..points - 1).rev() {
        let (a, b) = (y(i), y(i + 1));
        velocity += (rate(a) + 4.0 * rate(0.5 * (a + b)) + rate(b)) * (b - a) / 6.0;
        profile.push([a, velocity]);
    }
    profile.reverse();
    profile
}

#[cfg(test)]
mod tests {
    use super::*;

    /// f = 3, h = 1, η_s = 0.1, G = 1.8, λ = γ = 1: u_max = 4.131150, Q = 6.254595 over both halves.
    #[test]
    fn sample_has_the_published_flow_rate() {
        let fluid = Thinning {
            solvent: 0.1,
            modulus: 1.8,
            relaxation_time: 1.0,
            thinning: 1.0,
        };
        let profile = giesekus_channel(&fluid, 3.0, 1.0, 401);
        assert!(
            (profile[0][1] - 4.131_150).abs() < 2e-6,
            "{}",
            profile[0][1]
        );
        let flow: Real = profile
            .windows(2)
            .map(|w| (w[0][1] + w[1][1]) * (w[1][0] - w[0][0]))
            .sum();
        assert!((flow - 6.254_595).abs() < 1e-4, "{flow}");
    }

    #[test]
    fn without_thinning_it_is_a_parabola() {
        let fluid = Thinning {
            solvent: 0.5,
            modulus: 3.0,
            relaxation_time: 0.5,
            thinning: 0.0,
        };
        for [y, u] in giesekus_channel(&fluid, 2.0, 0.1, 21) {
            assert!((u - 2.0 * (0.01 - y * y) / 4.0).abs() < 1e-12);
        }
    }
}
