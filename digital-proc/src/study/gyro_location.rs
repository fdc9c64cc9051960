//! Where the rate gyro may stand, and what the bending filter is good for.
//!
//! At each frozen trajectory point the pitch loop is linearised with one to three free-free modes
//! ([`flexible`]): the damping of each mode against the station of the gyro, and the margins of the
//! bending modes with the loop opened at an actuator, with the bending filter and without it. The
//! machine's own linear model of the patch stands beside it for the first mode.

pub mod flexible;
pub mod margins;
pub mod outcome;
pub mod run;
