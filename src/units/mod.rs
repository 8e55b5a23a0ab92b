//! `"8 Pa.s"` → SI: one parser per dimension.
