//! The search for a limit that is only known by trying: a bracket around it, and whether what lies below it holds.

use super::StudyError;
use crate::math::Real;

/// Where the search ended: the largest step that passed and the least that failed above it, in CFL steps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bracket {
    /// The one.
    pub pass: Option<Real>,
    /// The other.
    pub fail: Option<Real>,
    /// A step below the largest that passed fails.
    pub ragged: bool,
}

/// Steps tried lie between these, in CFL steps.
const LEAST: Real = 1.0 / 4096.0;
const MOST: Real = 2.0;

/// How to search.
#[derive(Clone, Copy, Debug)]
pub struct Search<'a> {
    /// The step tried first.
    pub first: Real,
    /// By what the second differs from it; the stride is squared each time, up to 2.
    pub stride: Real,
    /// How narrow the bracket is to be.
    pub ratio: Real,
    /// Shares of what passed that are tried in the end: stability need not be monotone.
    pub below: &'a [Real],
}

/// Brackets the largest step that `passes`.
pub fn search(
    search: Search,
    mut passes: impl FnMut(Real) -> Result<bool, StudyError>,
) -> Result<Bracket, StudyError> {
    let mut bracket = Bracket::default();
    let (mut step, mut stride) = (search.first, search.stride);
    while (LEAST..=MOST).contains(&step) {
        if passes(step)? {
            bracket.pass = Some(step);
            if bracket.fail.is_some() {
                break;
            }
            step *= stride;
        } else {
            bracket.fail = Some(step);
            if bracket.pass.is_some() {
                break;
            }
            step /= stride;
        }
        stride = (stride * stride).min(2.0);
    }
    while let Bracket {
        pass: Some(pass),
        fail: Some(fail),
        ..
    } = bracket
    {
        if fail / pass <= search.ratio {
            break;
        }
        let middle = (pass * fail).sqrt();
        if passes(middle)? {
            bracket.pass = Some(middle);
        } else {
            bracket.fail = Some(middle);
        }
    }
    // A step that fails below one that passed counts.
    let Some(found) = bracket.pass else {
        return Ok(bracket);
    };
    let mut shares = search.below.to_vec();
    while let Some(share) = shares.pop() {
        let step = share * found;
        if passes(step)? {
            bracket.pass = bracket.pass.or(Some(step));
        } else {
            (bracket.pass, bracket.fail, bracket.ragged) = (None, Some(step), true);
        }
        if shares.is_empty() && bracket.pass.is_none() && step >= LEAST {
            shares.push(0.5 * share);
        }
    }
    Ok(bracket)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDE: Search = Search {
        first: 0.25,
        stride: 2.0,
        ratio: 1.05,
        below: &[0.5, 0.7],
    };

    #[test]
    fn the_search_brackets_a_limit_wherever_it_is() {
        for limit in [0.001, 0.02, 0.25, 0.9, 1.7] {
            let bracket = search(WIDE, |step| Ok(step <= limit)).expect("no run fails");
            let (pass, fail) = (bracket.pass.expect("passes"), bracket.fail.expect("fails"));
            assert!(
                pass <= limit && limit < fail && fail / pass <= 1.05,
                "{limit}"
            );
            assert!(!bracket.ragged);
        }
        let always = search(WIDE, |_| Ok(true)).expect("no run fails");
        assert_eq!((always.pass, always.fail), (Some(MOST), None));
        assert_eq!(
            search(WIDE, |_| Ok(false)).expect("no run fails").pass,
            None
        );
    }

    #[test]
    fn a_limit_with_a_hole_below_is_called_ragged_and_the_smaller_step_counts() {
        let holed = |step: Real| Ok(step <= 1.0 && !(0.6..0.8).contains(&step));
        let bracket = search(WIDE, holed).expect("no run fails");
        assert!(bracket.ragged);
        assert_eq!(bracket.pass, Some(0.5));
        let lower = |step: Real| Ok(step <= 1.0 && !(0.3..0.6).contains(&step));
        let bracket = search(Search { first: 1.0, ..WIDE }, lower).expect("no run fails");
        assert!(bracket.ragged);
        assert_eq!((bracket.pass, bracket.fail), (Some(0.25), Some(0.5)));
    }

    #[test]
    fn a_good_guess_is_all_but_confirmed_and_a_bad_one_costs_little_more() {
        let mut tried = 0;
        let mut bracket = |first: Real| {
            tried = 0;
            let guess = Search {
                first,
                stride: 1.05,
                below: &[],
                ..WIDE
            };
            let bracket = search(guess, |step| {
                tried += 1;
                Ok(step <= 0.3)
            });
            let bracket = bracket.expect("no run fails");
            let (pass, fail) = (bracket.pass.expect("passes"), bracket.fail.expect("fails"));
            assert!(
                pass <= 0.3 && 0.3 < fail && fail / pass <= 1.0501,
                "{first}"
            );
            tried
        };
        assert_eq!(bracket(0.299), 2);
        assert_eq!([bracket(0.01), bracket(1.9)], [13, 11]);
    }
}
