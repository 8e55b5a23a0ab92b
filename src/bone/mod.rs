//! A bone's mesh → cortical shell, trabeculae, porosity that varies in space.

pub mod landmarks;
pub mod vertebra;
