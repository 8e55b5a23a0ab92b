//! Colour field and marching cubes.
