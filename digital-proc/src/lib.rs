//! digital-proc
