//! Both links under one battery, and two real processes under misfortune.
#![allow(clippy::unwrap_used)]

mod battery;
mod processes;
