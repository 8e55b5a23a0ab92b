//! What can be wrong with a recipe, where, and what to write instead.

use std::fmt;
use std::path::PathBuf;

/// Why there is no scene.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The file cannot be read.
    #[error("cannot read the recipe {path}")]
    Read {
        /// The recipe.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The file is far too long for a recipe.
    #[error("{path} is longer than {most} bytes: no recipe")]
    TooLong {
        /// The recipe.
        path: PathBuf,
        /// The longest that is read.
        most: u64,
    },
    /// `--set` that names no place.
    #[error("--set {text}: {reason}")]
    Override {
        /// As written.
        text: String,
        /// Why it cannot be applied.
        reason: String,
    },
    /// One or more keys are wrong.
    #[error("{}", Lines(.0))]
    Keys(Vec<Finding>),
}

/// Something about one key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// `scene.toml:14`, or `--set spacing=4`.
    pub place: String,
    /// Key path such as `inlet[0].flow_rate`; empty for the file as a whole.
    pub key: String,
    /// What is wrong, and what would be right.
    pub message: String,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.place)?;
        if !self.key.is_empty() {
            write!(f, "{}: ", self.key)?;
        }
        f.write_str(&self.message)
    }
}

struct Lines<'a>(&'a [Finding]);

impl fmt::Display for Lines<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (n, finding) in self.0.iter().enumerate() {
            if n > 0 {
                f.write_str("\n")?;
            }
            finding.fmt(f)?;
        }
        Ok(())
    }
}
