//! Pictures against those of a folder that somebody looked at and found good.

use super::{FlowError, Job, preview::png};
use crate::cache;
use crate::preview::{Comparison, compare, side_by_side};
use image::RgbImage;
use serde_json::json;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

/// How pictures are compared.
#[derive(Clone, Debug)]
pub struct Golden {
    /// The folder of the good ones.
    pub folder: PathBuf,
    /// Whether every byte counts, or only what can be seen.
    pub exact: bool,
}

impl Job {
    /// Makes the pictures of this run (of the chosen frames) the good ones. Gives how many there are.
    pub fn bless(&self, golden: &Golden) -> Result<usize, FlowError> {
        let pictures = self.pictures()?;
        for (name, path) in &pictures {
            let bytes = fs::read(path).map_err(FlowError::io(path))?;
            cache::write(&golden.folder.join(name), &bytes)?;
        }
        Ok(pictures.len())
    }

    /// Compares the pictures of this run (of the chosen frames) with the good ones. For each that differs,
    /// `golden/<name>` in the output folder shows both and the difference, and `golden/golden.html` shows all of these.
    pub fn compare(&self, golden: &Golden) -> Result<usize, FlowError> {
        let good = |name: &str| golden.folder.join(name);
        let mine: Vec<_> = (self.pictures()?.into_iter())
            .filter(|(name, _)| good(name).exists())
            .collect();
        if mine.is_empty() {
            return Err(FlowError::NoGolden(golden.folder.clone()));
        }
        let out = self.folder.root().join("golden");
        self.folder.clear(&["golden"])?;
        let mut differences = Vec::new();
        for (name, path) in &mine {
            let (was, is) = (read(&good(name))?, read(path)?);
            let found = compare(&was, &is);
            let fine = found == Comparison::Same || !golden.exact && found.looks_same();
            if !fine {
                let shown = out.join(name);
                cache::write(&shown, &png(&shown, &side_by_side(&was, &is))?)?;
                differences.push((name, found.to_string()));
            }
        }
        let Some((name, what)) = differences.first() else {
            return Ok(mine.len());
        };
        let mut page = "<!doctype html><meta charset=\"utf-8\"><title>Golden images</title>\n\
                        <p>Good, now, and eight times the difference.</p>\n"
            .to_owned();
        for (name, what) in &differences {
            let _ = writeln!(
                page,
                "<h3>{name}: {what}</h3><img src=\"{name}\" style=\"width:100%\">"
            );
        }
        cache::write(&out.join("golden.html"), page.as_bytes())?;
        let report: Vec<_> = (differences.iter())
            .map(|(name, what)| json!({ "picture": name, "difference": what }))
            .collect();
        cache::write_json(&out.join("golden.json"), &report)?;
        Err(FlowError::Differs {
            count: differences.len(),
            of: mine.len(),
            first: format!("{name}: {what}"),
            page: out.join("golden.html"),
        })
    }

    /// Names and paths of the pictures of the chosen frames.
    fn pictures(&self) -> Result<Vec<(String, PathBuf)>, FlowError> {
        let mut pictures = Vec::new();
        for n in self.folder.frames(self.frames)? {
            for view in &self.scene.preview.views {
                let path = self.folder.picture(&view.name, n);
                let name = path
                    .file_name()
                    .map(|name| name.to_string_lossy().into_owned());
                if let Some(name) = name.filter(|_| path.exists()) {
                    pictures.push((name, path));
                }
            }
        }
        Ok(pictures)
    }
}

fn read(path: &Path) -> Result<RgbImage, FlowError> {
    let failed = |e| FlowError::io(path)(std::io::Error::other(e));
    Ok(image::open(path).map_err(failed)?.into_rgb8())
}
