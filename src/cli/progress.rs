//! One line a frame on stderr: rewritten in place on a terminal, plain lines elsewhere.

use super::report;
use crate::flow::{Event, FrameReport};
use std::fmt;
use std::io::{self, IsTerminal, Write};
use std::time::{Duration, Instant};

/// Steps are shown no more often than this where lines stay.
const PLAIN_PAUSE: Duration = Duration::from_secs(5);

/// Turns events into lines.
pub(super) struct Progress {
    quiet: bool,
    rewrite: bool,
    /// A line without its end is on the terminal.
    open: bool,
    /// When it was written.
    shown: Option<Instant>,
}

/// Steps are shown no more often than this.
const PAUSE: Duration = Duration::from_millis(200);

impl Progress {
    pub fn new(quiet: bool) -> Self {
        Self {
            quiet,
            rewrite: io::stderr().is_terminal(),
            open: false,
            shown: None,
        }
    }

    /// Shows an event.
    pub fn show(&mut self, event: &Event<'_>) {
        if self.quiet {
            return;
        }
        match event {
            Event::Warning(finding) => self.line(&format!("warning: {finding}")),
            Event::Started(stage) => self.line(&format!("{stage} …")),
            Event::Fresh(stage) => self.line(&format!("{stage} is up to date")),
            Event::Finished { stage, seconds } => {
                self.line(&format!("{stage} took {seconds:.1} s"));
            }
            Event::Picture(path) => self.line(&format!("the start is drawn: {}", path.display())),
            Event::Bone(path, bone) => {
                self.line(&format!("note: {}:", path.display()));
                for row in report::regions(bone) {
                    self.line(&format!("  {row}"));
                }
            }
            Event::Note(path, note) => self.line(&format!("note: {}: {note}", path.display())),
            Event::Step(report) | Event::Frame(report) if self.rewrite => {
                if self.shown.is_none_or(|shown| shown.elapsed() > PAUSE) {
                    // Back to the start, then clear what a longer line left behind.
                    put(&format!("\r{}\x1b[K", FrameLine(report)));
                    self.open = true;
                    self.shown = Some(Instant::now());
                }
            }
            // Off a terminal a plain line now and then: a frame may take an hour.
            Event::Step(report) => {
                if self.shown.get_or_insert_with(Instant::now).elapsed() > PLAIN_PAUSE {
                    self.line(&FrameLine(report).to_string());
                    self.shown = Some(Instant::now());
                }
            }
            Event::Frame(report) => {
                self.line(&FrameLine(report).to_string());
                self.shown = Some(Instant::now());
            }
        }
    }

    fn line(&mut self, text: &str) {
        let end = if self.open { "\n" } else { "" };
        self.open = false;
        put(&format!("{end}{text}\n"));
    }
}

/// A closed stderr is no reason to stop a simulation.
pub(super) fn put(text: &str) {
    let mut stderr = io::stderr().lock();
    let _ = stderr
        .write_all(text.as_bytes())
        .and_then(|()| stderr.flush());
}

impl Drop for Progress {
    fn drop(&mut self) {
        if self.open {
            put("\n");
        }
    }
}

struct FrameLine<'a>(&'a FrameReport);

impl fmt::Display for FrameLine<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let report = self.0;
        let [start, end] = report.span;
        let left = if report.time > start {
            clock(report.elapsed * (end - report.time) / (report.time - start))
        } else {
            "--:--".to_owned()
        };
        write!(
            f,
            "frame {}/{}  t={:.2} s  dt={:.2} ms ({})  it={}  compression {:.2} %  ETA {left}",
            report.frame,
            report.last,
            report.time,
            report.dt * 1e3,
            report.limit,
            report.iterations,
            report.compression * 100.0,
        )
    }
}

fn clock(seconds: f64) -> String {
    let seconds = seconds.round() as u64;
    let (hours, minutes, seconds) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
    if hours > 0 {
        format!("{hours}:{minutes:02}:{seconds:02}")
    } else {
        format!("{minutes:02}:{seconds:02}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_one_line() {
        let mut report = FrameReport {
            frame: 37,
            last: 250,
            time: 1.48,
            dt: 0.41e-3,
            limit: "elastic",
            iterations: 9,
            compression: 2.3e-3,
            span: [0.0, 10.0],
            elapsed: 37.0,
        };
        assert_eq!(
            FrameLine(&report).to_string(),
            "frame 37/250  t=1.48 s  dt=0.41 ms (elastic)  it=9  compression 0.23 %  ETA 03:33"
        );
        report.time = 0.0;
        assert!(FrameLine(&report).to_string().ends_with("ETA --:--"));
        assert_eq!(clock(3723.4), "1:02:03");
    }
}
