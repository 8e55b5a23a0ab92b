//! `--frames 1..48`: from, to, both included.

use std::fmt;
use std::str::FromStr;

/// Frames `first` to `last`, both included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRange {
    /// The first.
    pub first: u32,
    /// The last.
    pub last: u32,
}

impl FrameRange {
    /// Whether frame `n` is one of them.
    pub fn contains(self, n: u32) -> bool {
        (self.first..=self.last).contains(&n)
    }
}

impl FromStr for FrameRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (first, last) = text.split_once("..").unwrap_or((text, text));
        match (first.trim().parse(), last.trim().parse()) {
            (Ok(first), Ok(last)) if first <= last => Ok(Self { first, last }),
            _ => Err("expected frames such as 1..48, or one such as 12".to_owned()),
        }
    }
}

impl fmt::Display for FrameRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}..{}", self.first, self.last)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_include_both_ends() {
        let range: FrameRange = "1..48".parse().unwrap();
        assert!(
            range.contains(1) && range.contains(48) && !range.contains(0) && !range.contains(49)
        );
        assert_eq!("7".parse(), Ok(FrameRange { first: 7, last: 7 }));
        for refused in ["", "..", "5..1", "-1..3", "1..2..3", "a"] {
            assert!(refused.parse::<FrameRange>().is_err(), "{refused}");
        }
    }
}
