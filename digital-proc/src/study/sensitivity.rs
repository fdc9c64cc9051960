//! Sensitivity of the pitch loop to dispersions (objectives i to iii of the paper's §4).
//!
//! Aerodynamic coefficients, actuator time constants, gyro location and dynamics,
//! bending frequency and damping are dispersed one at a time, run by run on the
//! patched pitch loop, and all together at the corners: every corner by the
//! eigenvalues of the linearised loop, the worst of each point on the machine. Frequency and
//! damping of the gyro, and of the structure, are also followed together ([`pairs`]).

pub mod dispersion_file;
pub mod outcome;
pub(crate) mod pairs;
pub mod run;
