//! A picture of how wide the ways to the pores are: `boundary/throats.png`.

use crate::bone::{ACROSS, BoneReport};
use crate::math::Real;
use crate::report::{Axis, Look, Plot, Series};

/// Throats by their share of the pores behind them, and what balls of growing size fill of the pores; a spacing is
/// `spacing` [m].
pub(super) fn plot(report: &BoneReport, spacing: Real) -> Plot {
    let mut bars = Vec::new();
    for (from, to, share) in report.throats() {
        let to = to.unwrap_or(from + 1.0);
        bars.extend([[from, 0.0], [from, share], [to, share], [to, 0.0]]);
    }
    let widest = report.reach.last().map_or(1.0, |r| r.ball_in_spacings) + 1.0;
    let balls = |share: fn(&crate::bone::Reach) -> Real| {
        let reach = report.reach.iter();
        reach.map(|r| [r.ball_in_spacings, share(r)]).collect()
    };
    let series = |name: &str, points, look, colour| Series {
        name: name.to_owned(),
        points,
        look,
        colour,
    };
    Plot {
        title: format!("Throats of the pores, {:.3} mm a spacing", spacing * 1e3),
        x: Axis::linear("ball or throat [spacings]").between(0.0, widest),
        y: Axis::linear("share of the pores").between(0.0, 1.0),
        series: vec![
            series("behind throats so wide", bars, Look::Curve, 0),
            series("filled by balls", balls(|r| r.fits), Look::Chain, 2),
            series("from the inlet", balls(|r| r.reached), Look::Chain, 1),
            series(
                "resolved beyond",
                vec![[ACROSS, 0.0], [ACROSS, 1.0]],
                Look::Dashes,
                7,
            ),
        ],
    }
}
