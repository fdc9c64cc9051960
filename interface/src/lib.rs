//! The linkage between the analog and the digital processor.
//!
//! It depends on neither. It defines problem time ([`Tick`]), the frames that
//! cross at sampled rates ([`frame`]), the slow control plane ([`control`]),
//! and two links behind one pair of traits ([`link`]).
// What only the link between processes needs is not dead where that is left out.
#![cfg_attr(not(feature = "shm"), allow(dead_code, unused_imports))]
// Names carry their units; what a name says has no sentence beside it.
#![allow(missing_docs)]
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::disallowed_methods))]

/// An enum whose values have a name each, with `ALL` of them in the order of the list:
/// `pub enum Side, name { Analog "analog-proc" … }`.
#[macro_export]
macro_rules! named {
    ($(#[$about:meta])* pub enum $type:ident, $name:ident { $($(#[$what:meta])* $value:ident $text:literal)+ }) => {
        $(#[$about])*
        pub enum $type { $($(#[$what])* $value,)+ }

        impl $type {
            pub const ALL: [$type; [$($text),+].len()] = [$($type::$value),+];

            pub fn $name(self) -> &'static str {
                match self { $($type::$value => $text,)+ }
            }
        }
    };
}

pub mod control;
pub mod converter;
pub mod deviate;
pub mod frame;
pub mod hold;
pub mod link;
pub mod processor;
pub mod profile;
pub mod protocol;
pub mod session;
pub mod tick;

pub use protocol::Side;
pub use tick::Tick;
