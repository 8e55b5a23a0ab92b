//! Runs that are kept on disk, so that a study that was stopped goes on where it was.

use crate::cache::{self, CacheError};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// A folder of finished runs, one file each, whole or absent.
#[derive(Clone, Debug)]
pub struct Runs {
    folder: PathBuf,
    made_by: String,
}

#[derive(Serialize, Deserialize)]
struct Kept {
    made_by: String,
    settings: Value,
    seconds: f64,
    result: Value,
}

impl Runs {
    /// Runs of this very program in `folder`; those that another build left are made again.
    pub fn open(folder: &Path) -> Self {
        Self {
            folder: folder.to_owned(),
            made_by: format!("{} {:08x}", env!("CARGO_PKG_VERSION"), program()),
        }
    }

    /// The result of a run and the seconds that it took: as kept under `name` if it was made with the same
    /// settings, else by `work`.
    pub fn keep<S, T, E>(
        &self,
        name: &str,
        settings: &S,
        work: impl FnOnce() -> Result<T, E>,
    ) -> Result<(T, f64), E>
    where
        S: Serialize,
        T: Serialize + DeserializeOwned,
        E: From<CacheError>,
    {
        let path = self.folder.join(format!("{name}.json"));
        let value = |v: Result<Value, serde_json::Error>| {
            v.map_err(|e| CacheError::Damaged {
                path: path.clone(),
                what: format!("not to be written as JSON: {e}"),
            })
        };
        let settings = value(serde_json::to_value(settings))?;
        if let Some(kept) = self.kept(&path).filter(|kept| kept.settings == settings)
            && let Ok(result) = serde_json::from_value(kept.result)
        {
            return Ok((result, kept.seconds));
        }
        let start = Instant::now();
        let result = work()?;
        let kept = Kept {
            made_by: self.made_by.clone(),
            settings,
            seconds: start.elapsed().as_secs_f64(),
            result: value(serde_json::to_value(&result))?,
        };
        cache::write_json(&path, &kept)?;
        Ok((result, kept.seconds))
    }

    fn kept(&self, path: &Path) -> Option<Kept> {
        let text = fs::read(path).ok()?;
        let kept: Kept = serde_json::from_slice(&text).ok()?;
        (kept.made_by == self.made_by).then_some(kept)
    }
}

/// CRC-32 of the running program: a rebuilt one may compute something else under the same version.
fn program() -> u32 {
    let mut sum = crc32fast::Hasher::new();
    let file = std::env::current_exe().and_then(fs::File::open);
    let Ok(mut file) = file else { return 0 };
    let mut buffer = vec![0; 1 << 20];
    while let Ok(n @ 1..) = file.read(&mut buffer) {
        sum.update(&buffer[..n]);
    }
    sum.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_made_once_and_again_when_its_settings_or_its_program_change() {
        let folder = tempfile::tempdir().unwrap();
        let mut runs = Runs::open(folder.path());
        let mut made = 0;
        let mut run = |runs: &Runs, dt: f64| {
            let result = runs.keep("wave", &("wave", dt), || {
                made += 1;
                Ok::<_, CacheError>(vec![dt, 0.1 + 0.2])
            });
            (result.unwrap().0, made)
        };
        assert_eq!(run(&runs, 0.5), (vec![0.5, 0.1 + 0.2], 1));
        assert_eq!(run(&runs, 0.5), (vec![0.5, 0.1 + 0.2], 1));
        assert_eq!(run(&runs, 0.25), (vec![0.25, 0.1 + 0.2], 2));
        runs.made_by = "another build".into();
        assert_eq!(run(&runs, 0.25).1, 3);
        // A file that was cut or written by something else is no result.
        std::fs::write(folder.path().join("wave.json"), "{\"made_by\": ").unwrap();
        assert_eq!(run(&runs, 0.25).1, 4);
    }

    #[test]
    fn a_run_that_fails_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let runs = Runs::open(folder.path());
        let failed = runs.keep("a", &1, || {
            Err::<f64, _>(CacheError::Damaged {
                path: "x".into(),
                what: "y".into(),
            })
        });
        assert!(failed.is_err());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
