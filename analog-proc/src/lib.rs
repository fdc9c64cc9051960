//! analog-proc
