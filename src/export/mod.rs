//! OpenVDB files.
