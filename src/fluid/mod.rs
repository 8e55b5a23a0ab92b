//! Phases, mixture, transfer, bonding network, conformation tensor, stress; knows no time loop.
