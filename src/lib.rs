//! osteoflow simulates bone cement: how its powder and liquid mix, and how the mix flows from a needle into
//! porous bone. It implements [IMM-CT] in smoothed particle hydrodynamics.
//!
//! # The house
//!
//! Rooms stand on floors; a room uses only rooms on lower floors (`tests/tidy.rs` holds it to that).
//!
//! | floor | room | holds |
//! |--:|---|---|
//! | 0 | [`math`] | scalar and vector names, symmetric tensors, order-fixed sums, seeded noise |
//! | 1 | [`units`] | `"8 Pa.s"` → SI |
//! | 1 | [`mesh`] | triangle meshes, OBJ, inspection, signed distance |
//! | 1 | [`grid`] | sparse fields in bricks |
//! | 1 | [`ink`] | lines and letters on pictures |
//! | 1 | [`sph`] | kernel, neighbour rows, wall particles, pair operators, pressure and linear solvers |
//! | 2 | [`solid`] | what is solid: signed distance of shapes and grids, wall particles from it; fan and syringe |
//! | 2 | [`fluid`] | phases, mixture, transfer, bonding network, conformation tensor, stress |
//! | 3 | [`bone`] | a bone's mesh → cortical shell, trabeculae, porosity |
//! | 3 | [`sim`] | state, the step of each scheme, time step, inlets, moving walls, health, ledger |
//! | 4 | [`cache`] | boundary files, frames, tables on disk |
//! | 5 | [`surface`] | colour field, marching cubes, smoothing |
//! | 5 | [`export`] | OpenVDB, PLY, VTP and USD files |
//! | 5 | [`preview`] | camera, rasteriser, shading |
//! | 5 | [`report`] | tables, plots, runs that are kept |
//! | 6 | [`scene`] | what a recipe says, then what it means |
//! | 7 | [`flow`] | stages: files in, files out |
//! | 8 | [`study`] | verification and studies: one question, one table, one picture |
//! | 9 | [`cli`] | arguments, progress, exit codes |
//!
//! # Where we leave the paper, and what shows it
//!
//! | paper | here | why | shown by |
//! |---|---|---|---|
//! | (Eq. 11) U∇v + (∇v)ᵀU with the Jacobian | L U + U Lᵀ | the printed order turns U backwards | `fluid::conformation` tests: rotation, sign of N₁ |
//! | (Eq. 13) c η (U − I) | c η/λ (U − I) | Pa, and λ → 0 is Newtonian | `tests/physics` slit with λ → 0 |
//! | (Eq. 16) ÷ α_k | one bounded form for pressure, viscosity, stress | no blow-up as α → 0, momentum exact | `fluid::mixture` tests |
//! | (Eq. 6) with the mass V ρ | effective mass V ρ/c | the solved velocity is reached | `fluid::mixture` tests |
//! | (Eq. 9) as printed | factor 2, pairwise limiter, momentum carried | D = C_f, volume and momentum kept to 1e-14 | `tests/physics` ledger |
//! | no drag between the phases | optional `slip_relaxation` | slip under gravity grew without bound and held the step of the main job at a tenth | main job with and without |
//! | explicit stress, pressure apart | also `StressStep::Coupled`: one solve | steps at the CFL limit | `tests/physics` waves, needle |
//! | (Eq. 6) after friction with walls | the last step's pressure acts while walls rub, then is solved anew | an explicit steady flow does not know its step | `verify steps`: cylinders 2.1 % without, 0.5 % with |
//! | all of the pressure acts on the packing | its level only as far as it evens it (`sim::solves`) | deep pipes stiffened like sand: 20 % too much pressure | `pressure_falls_evenly_along_a_deep_pipe` |
//! | the multiplier of ψ = 1 is called pressure | written and probed: the mean normal stress of the pairs | the multiplier is 2 % off on a lattice | `sph::pressure` tests: virtual work; `verify column` |
//!
//! In a closed body only differences of pressure mean anything, yet on a disordered lattice the level is felt a little
//! (P 1 ≠ 0), and a solve that may choose it holds particles in place with it: it stopped a vortex with 3e5 Pa and said
//! converged. There the level is taken off the guess and kept (`sph::coupled`), pressure may have either sign, what is
//! left of disorder is evened by shifting (`sim::shifting`), and pressure takes only a share of it. Measured with
//! `verify --level quick` before and after: Taylor-Green 74 % and 6.2 %, Giesekus channel 6.5 % and 4.8 %, spheres 6.9 % and
//! 5.0 %, needle 1.9 % and 1.3 %, flow rates over steps of 1 to 1000 explicit limits: channel 3.7 % and 0.5 %, cylinders
//! 15 % and 2.2 %. The level alone, without shifting: the shear cell is 13 % off. Shifting at free surfaces: a resting
//! column moves twice as fast.
//!
//! Strain draws a lattice out to 1.6 : 0.6 spacings, and plain sums over neighbours then weigh one direction more. Undone
//! on the pairs (`sph::straighten`) Taylor-Green at 32 across fell from 6.2 % to 2.6 %, the needle at 20 across from 1.3 %
//! to 0.8 % with order 1.9 in place of 1.25, cylinders from 2.2 % to 1.1 %, spheres from 5.0 % to 4.4 %; gradients matter
//! most, the Laplacian alone took Taylor-Green to 6.1 %. Half of what pressure took of the disorder in closed bodies (0.1
//! in place of 0.2 of it): spheres 3.8 %, Taylor-Green 2.2 %, cylinders 2.1 % (0.5 % since an
//! explicit step lets the last pressure act while walls rub: the coupled ones agreed to 0.8 % all along).
//! θ = 0.55 in place of 1: Oldroyd wave 4.4 % to 2.7 %, Waters-King 5.3 % to 3.3 %; with χ = 0.6 for the stabiliser
//! (`fluid::stress`), finer goals, steps and spacings 1.5 % and 1.7 %. The Giesekus channel at 28 across is 1.95 % off,
//! the shear cell 0.4 %. Taylor-Green stays at 1.6 % at 64 across with goals ten times finer and θ = 0.55: noise of the
//! packing, not the step. No effect: shifting three times as strong or weak.
//!
//! The needle of `tests/physics` (8 mm, five spacings across, Newtonian) at steps of 1, 1/10, 1/100 of the CFL limit: 8334,
//! 8354, 8503 Pa; viscoelastic 5194, 5229 Pa at 1 and 1/10 (before gaps under pressure were closed slowly and ringing was
//! damped, `sim::solves`; since then 8351, 8362 and 4186, 4189 Pa at 1 and 1/4); at 0.044, 0.44, 4.4, 44 Pa s its
//! pressure over viscosity is 1918, 1892, 1894, 1921 1/s. 27 to 42 MINRES iterations a step, of two passes over pairs each.
//!
//! Tried and left: viscosity with 2(d + 2) pairs (15 % too little on a lattice along its axes at support ratio 2.4: the
//! compact Laplacian is used everywhere); pressure that may pull in closed bodies without shifting (tensile instability in a shear wave);
//! only a share of the compression undone in a step (0.5, 0.25, 0.1: pressure at the inlet no steadier, compression
//! higher; undone over a *time* instead, `sim::solves`, the inlet pressure no longer depends on the step: needle of
//! 8 mm, steps of 1, 1/4, 1/10 of the CFL limit, 8351, 8353, 8351 Pa, where it was 8351, 8947, 9079 Pa with spikes of
//! 150 kPa); all gaps closed over that time as well (a sheared lattice locks: only those under pressure
//! are); particles held outside the true surface (see `sim::motion`); a guess of pressure drawn on by half of its last
//! change (2 % fewer iterations).
//!
//! Support ratio. Main job to 2 s, one thread: 49 285, 32 946, 29 542, 28 635 iterations and 48, 41, 47, 57 CPU s at 2.0,
//! 2.2, 2.4, 2.6. `verify --level quick` at 2.0 is better in flow past walls (needle 0.47 %, Giesekus 1.8 %, spheres 3.2 %,
//! cylinders 1.7 %) and far worse where packings are free to move (Taylor-Green 7.1 %). Other packings than the cubic
//! lattice have ψ = 1 at a density that is up to 0.3, 1.1, 0.6, −0.5 % higher, and at 2.6 the lattice of a column at rest
//! stays. 2.4 is what all figures here were measured with.
//!
//! # Citations
//!
//! | key | source |
//! |---|---|
//! | [IMM-CT] | "Visual simulation of bone cement blending and dynamic flow": implicit mixture model with conformation tensor |
//! | [Giesekus82] | H. Giesekus, "A simple constitutive equation for polymer fluids…", J. Non-Newtonian Fluid Mech. 11 (1982) |
//! | [DFSPH] | J. Bender, D. Koschier, "Divergence-free SPH for incompressible and viscous fluids", IEEE TVCG 23 (2017) |
//! | [Morris97] | J. Morris, P. Fox, Y. Zhu, "Modeling low Reynolds number incompressible flows using SPH", J. Comput. Phys. 136 (1997) |
//! | [Waters70] | N. Waters, M. King, "Unsteady flow of an elastico-viscous liquid", Rheologica Acta 9 (1970) |
//! | [Zalesak79] | S. Zalesak, "Fully multidimensional flux-corrected transport…", J. Comput. Phys. 31 (1979) |
//! | [Bonet99] | J. Bonet, T.-S. Lok, "Variational and momentum preservation aspects of smooth particle hydrodynamic formulations", Comput. Methods Appl. Mech. Eng. 180 (1999) |
//! | [Fatehi11] | R. Fatehi, M. Manzari, "Error estimation in smoothed particle hydrodynamics and a new scheme for second derivatives", Comput. Math. Appl. 61 (2011) |
//! | [Irving50] | J. Irving, J. Kirkwood, "The statistical mechanical theory of transport processes IV", J. Chem. Phys. 18 (1950) |
//! | [Barth89] | T. Barth, D. Jespersen, "The design and application of upwind schemes on unstructured meshes", AIAA Paper 89-0366 (1989) |
//! | [Lind12] | S. Lind, R. Xu, P. Stansby, B. Rogers, "Incompressible smoothed particle hydrodynamics for free-surface flows", J. Comput. Phys. 231 (2012) |
//! | [Paige75] | C. Paige, M. Saunders, "Solution of sparse indefinite systems of linear equations", SIAM J. Numer. Anal. 12 (1975) |
//! | [Lorensen87] | W. Lorensen, H. Cline, "Marching cubes", SIGGRAPH 1987 |
//! | [Baerentzen05] | J. A. Bærentzen, H. Aanæs, "Signed distance computation using the angle weighted pseudonormal", IEEE TVCG 11 (2005) |
//! | [Jacobson13] | A. Jacobson, L. Kavan, O. Sorkine, "Robust inside-outside segmentation using generalized winding numbers", ACM TOG 32 (2013) |
//! | [Barill18] | G. Barill et al., "Fast winding numbers for soups and clouds", ACM TOG 37 (2018) |
//! | [Oosterom83] | A. van Oosterom, J. Strackee, "The solid angle of a plane triangle", IEEE Trans. Biomed. Eng. 30 (1983) |
//! | [Barequet95] | G. Barequet, M. Sharir, "Filling gaps in the boundary of a polyhedron", Comput. Aided Geom. Des. 12 (1995) |
//! | [Anderson78] | B. Anderson, "Second-order convergent algorithms for the steady-state Riccati equation", Int. J. Control 28 (1978) |
//! | [Ericson05] | C. Ericson, "Real-time collision detection", Morgan Kaufmann (2005) |
//! | [Latecki95] | L. Latecki, U. Eckhardt, A. Rosenfeld, "Well-composed sets", Comput. Vis. Image Underst. 61 (1995) |
//! | [Baroud04] | G. Baroud et al., "Experimental and theoretical investigation of directional permeability of human vertebral cancellous bone for cement infiltration", J. Biomech. 37 (2004) |
//! | [Panjabi92] | M. Panjabi et al., "Human lumbar vertebrae: quantitative three-dimensional anatomy", Spine 17 (1992) |
//! | [Hildebrand99] | T. Hildebrand et al., "Direct three-dimensional morphometric analysis of human cancellous bone", J. Bone Miner. Res. 14 (1999) |
//! | [Happel59] | J. Happel, "Viscous flow relative to arrays of cylinders", AIChE J. 5 (1959) |
//! | [Ginzburg08] | I. Ginzburg, F. Verhaeghe, D. d'Humières, "Two-relaxation-time lattice Boltzmann scheme", Commun. Comput. Phys. 3 (2008) |
//! | [Zick82] | A. Zick, G. Homsy, "Stokes flow through periodic arrays of spheres", J. Fluid Mech. 115 (1982) |
//! | [Toussaint80] | G. Toussaint, "The relative neighbourhood graph of a finite planar set", Pattern Recognition 12 (1980) |
//! | [Martin52] | J. Martin, W. Moyce, "An experimental study of the collapse of liquid columns on a rigid horizontal plane", Phil. Trans. A 244 (1952) |
//! | [Loeschner23] | F. Löschner, T. Böttcher, S. Rhys Jeske, J. Bender, "Weighted Laplacian smoothing for surface reconstruction of particle-based fluids", VMV 2023 |
//! | [Wang04] | Z. Wang, A. Bovik, H. Sheikh, E. Simoncelli, "Image quality assessment: from error visibility to structural similarity", IEEE TIP 13 (2004) |
//! | [Museth13] | K. Museth, "VDB: high-resolution sparse volumes with dynamic topology", ACM TOG 32 (2013) |
#![cfg_attr(test, allow(clippy::unwrap_used))]

pub mod bone;
pub mod cache;
pub mod cli;
pub mod export;
pub mod flow;
pub mod fluid;
pub mod grid;
pub mod ink;
pub mod math;
pub mod mesh;
pub mod preview;
pub mod report;
pub mod scene;
pub mod sim;
pub mod solid;
pub mod sph;
pub mod study;
pub mod surface;
pub mod units;
