//! Turns recorded files into evenly sampled, filtered joint motions with efforts.
