//! Stages: files in, files out.
