//! Camera, rasteriser, shading: pictures without a GPU.
