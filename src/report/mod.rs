//! Series, tables, plots, and runs that are kept: what a study leaves behind. Knows nothing of what its numbers mean.

mod axis;
mod plot;
mod runs;
mod table;

pub use axis::Axis;
pub use plot::{Look, Plot, Series};
pub use runs::Runs;
pub use table::{Cell, Table};
