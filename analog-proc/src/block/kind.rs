//! The kinds of block: the one list of them, and what is asked of each.
//!
//! All of a kind stands in its file here: its fields and how they are read, its line in
//! patch-files/README.md, its inputs, wires, channels and equipment, what it is lowered
//! to and how it is drawn. That is asked while a patch is loaded, never within a step.

/// Declares a kind: its fields and how each is read, or who reads them; its name, what it gives,
/// its fields and an example in the words of patch-files/README.md; and what else is true of all
/// its blocks.
macro_rules! kind {
    ($(#[$about:meta])* $kind:ident($f:ident) {
        $($field:ident: $type:ty = $read:expr),+ $(,)?
    } $($facts:tt)+) => {
        kind! { @ [$(#[$about])*] $kind [{ $(pub $field: $type),+ }] [|$f| {
            $(let $field = $read;)+
            Some($kind { $($field: $field?),+ })
        }] $($facts)+ }
    };
    ($(#[$about:meta])* $kind:ident($read:ident) { $($field:ident: $type:ty),+ } $($facts:tt)+) => {
        kind! { @ [$(#[$about])*] $kind [{ $(pub $field: $type),+ }] [$read] $($facts)+ }
    };
    ($(#[$about:meta])* $kind:ident $($facts:tt)+) => {
        kind! { @ [$(#[$about])*] $kind [;] [|_| Some($kind)] $($facts)+ }
    };
    (@ [$($about:tt)*] $kind:ident [$($body:tt)+] [$read:expr]
        $name:literal, $output:literal, $fields:literal, $example:literal
        $(, $fact:ident: $value:expr)* $(,)?) => {
        #[doc = concat!("`", $name, "`: ", $output, ". ", $fields)]
        #[doc = ""]
        $($about)*
        #[allow(missing_docs)]
        #[derive(Clone, Debug, PartialEq)]
        pub struct $kind $($body)+

        impl $kind {
            pub(super) const READ: fn(&mut Fields<'_, '_>) -> Option<Self> = $read;
            pub(super) const FACTS: Facts = Facts {
                name: $name,
                output: $output,
                fields: $fields,
                example: $example,
                $($fact: $value,)*
                ..Facts::ANALOG
            };
        }
    };
}

mod angle;
mod comparator;
mod converter;
mod delay;
mod diode;
mod follower;
mod friction;
mod function;
mod gate;
mod integrator;
mod limiter;
mod line;
mod product;
mod pulse;
mod source;
mod sum;
mod switch;

pub use source::Wave;

use super::lowering::Lowering;
use crate::draw::{Pen, number};
use crate::net::{Block, Input, Level};
use crate::patch::{Fields, Flaw};
use engine::id::NetId;
use engine::op::{Op, Slot, Term};
use interface::control::ChannelKind;
use interface::frame;
use interface::profile::BlockClass;

/// Reads the fields of a block. `None` after faults, which have been told.
type Read = fn(&mut Fields<'_, '_>) -> Option<Kind>;

macro_rules! kinds {
    ($($file:ident::$kind:ident)+) => {
        $(pub use $file::$kind;)+

        /// What a block does; each kind is documented at its type. There `Σ` is the weighted
        /// sum of its inputs, `in0`, `in1` are single weighted inputs; logic nets carry 0 or 1.
        #[derive(Clone, Debug, PartialEq)]
        #[allow(missing_docs)]
        pub enum Kind {
            $($kind($kind),)+
        }

        impl Kind {
            pub(crate) fn component(&self) -> &dyn Component {
                match self {
                    $(Kind::$kind(component) => component,)+
                }
            }

            pub(crate) fn facts(&self) -> &'static Facts {
                match self {
                    $(Kind::$kind(_) => &$kind::FACTS,)+
                }
            }
        }

        /// All kinds: what is true of each, and the reader of its fields.
        pub(crate) const KINDS: &[(Facts, Read)] =
            &[$(($kind::FACTS, |f| $kind::READ(f).map(Kind::$kind)),)+];
    };
}

// In the order of the table in patch-files/README.md.
kinds! {
    integrator::Integrator
    sum::Summer sum::Inverter sum::Gain sum::Pot
    product::Multiplier product::Divider product::Square product::SquareRoot
    diode::Abs diode::Min diode::Max
    angle::Sine angle::Cosine angle::Arctangent angle::Resolver
    function::Function function::Function2d function::DigitalFunction
    limiter::DeadZone limiter::Limiter
    follower::RateLimiter follower::Backlash
    friction::DryFriction comparator::Relay
    follower::Lag delay::TransportDelay
    source::Generator source::Noise source::Constant source::Time
    comparator::Comparator switch::Switch switch::TrackStore
    gate::And gate::Or gate::Not
    pulse::FlipFlop pulse::OneShot pulse::Counter
    converter::Adc converter::Dac converter::Mdac converter::Dcu
    line::Sense line::Control line::Interrupt
}

impl Kind {
    /// What the patch language calls it.
    pub fn name(&self) -> &'static str {
        self.facts().name
    }

    /// Whether the output is logic (0 or 1).
    pub fn is_logic(&self) -> bool {
        self.facts().gives_logic
    }

    /// Whether the output is a stored value, so that no input reaches it within an instant.
    ///
    /// Flip-flops, one-shots and counters store: they change at events, after their inputs.
    pub fn is_store(&self) -> bool {
        self.facts().storage != Storage::None
    }
}

/// The kind of a name.
pub(crate) fn named(name: &str) -> Option<&'static (Facts, Read)> {
    KINDS.iter().find(|(facts, _)| facts.name == name)
}

/// What a kind does; as defaults, what the plainest of them do.
pub(crate) trait Component {
    /// Nets read by fields other than the inputs (levels, mode control).
    fn sides(&self) -> Vec<Side> {
        Vec::new()
    }

    /// Channels or lines of the linkage that are its own.
    fn claim(&self) -> Option<Claim> {
        None
    }

    /// Wires the output `o`; not asked where that is a state of the integration.
    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        to.weighted(o, block, 1.0);
    }

    /// Wires what a store reads, once every net is in place; gives a state its initial value.
    fn lower_inputs(&self, _to: &mut Lowering, _block: &Block, _o: Slot) {}

    /// Text above the symbol: initial condition, limits, setting.
    fn caption(&self) -> Option<String> {
        None
    }

    /// Draws what is not the same for all blocks of the kind.
    fn symbol(&self, _pen: &mut Pen) {}
}

/// What is true of every block of a kind.
pub(crate) struct Facts {
    pub(crate) name: &'static str,
    /// What it gives, its fields, and a block with them, as patch-files/README.md tells it.
    pub(crate) output: &'static str,
    pub(crate) fields: &'static str,
    pub(crate) example: &'static str,
    pub(crate) inputs: Inputs,
    pub(crate) takes_logic: bool,
    pub(crate) gives_logic: bool,
    /// Ends of the names of its nets, where it drives several.
    pub(crate) outputs: &'static [&'static str],
    pub(crate) storage: Storage,
    /// What it takes from a machine; `None` for what every machine has without number.
    pub(crate) class: Option<BlockClass>,
    pub(crate) symbol: fn(&mut Pen),
    /// Least width and height of its symbol.
    pub(crate) size: (f64, f64),
}

impl Facts {
    const ANALOG: Facts = Facts {
        name: "",
        output: "",
        fields: "",
        example: "",
        inputs: Inputs::at_least(1),
        takes_logic: false,
        gives_logic: false,
        outputs: &[],
        storage: Storage::None,
        class: None,
        symbol: |_| {},
        size: (52.0, 48.0),
    };
}

/// What a kind keeps from one instant to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Storage {
    None,
    /// A value that does not follow its inputs within an instant.
    Value,
    /// A state of the integration; its output has a derivative.
    State,
}

/// How many inputs a kind takes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Inputs {
    pub(crate) least: usize,
    pub(crate) most: Option<usize>,
    /// What they are and how they are marked in a drawing, in order, where that matters.
    pub(crate) roles: &'static [(&'static str, &'static str)],
}

impl Inputs {
    const fn exactly(count: usize) -> Inputs {
        Inputs { least: count, most: Some(count), roles: &[] }
    }

    const fn at_least(least: usize) -> Inputs {
        Inputs { least, most: None, roles: &[] }
    }

    const fn named(roles: &'static [(&'static str, &'static str)]) -> Inputs {
        Inputs { roles, ..Inputs::exactly(roles.len()) }
    }

    pub(crate) fn words(self) -> String {
        let count = match (self.least, self.most) {
            (0, _) => "no input".to_owned(),
            (1, Some(1)) => "one input".to_owned(),
            (least, Some(most)) if least == most => format!("{least} inputs"),
            (least, Some(most)) => format!("{least} or {most} inputs"),
            (1, None) => "one or more inputs".to_owned(),
            (least, None) => format!("{least} or more inputs"),
        };
        if self.roles.is_empty() {
            return count;
        }
        let roles: Vec<&str> = self.roles.iter().map(|role| role.0).collect();
        format!("{count} ({})", roles.join(", "))
    }
}

/// A net that a field names, and its mark in a drawing.
pub(crate) struct Side {
    pub(crate) mark: &'static str,
    pub(crate) net: NetId,
    pub(crate) coefficient: f64,
    pub(crate) is_logic: bool,
}

impl Side {
    fn logic(mark: &'static str, net: NetId) -> Side {
        Side { mark, net, coefficient: 1.0, is_logic: true }
    }

    fn level(mark: &'static str, level: Level) -> Option<Side> {
        let Level::Net(net) = level else { return None };
        Some(Side { is_logic: false, ..Side::logic(mark, net) })
    }
}

/// Channels of the linkage, one after another from `first` on.
pub(crate) struct Claim {
    pub(crate) kind: ChannelKind,
    pub(crate) first: u32,
    /// The value of each before the first transfer.
    pub(crate) initial: Vec<f64>,
    /// Largest coefficient that a coefficient unit is scaled for; the profile's where left out.
    pub(crate) range: Option<f64>,
}

impl Claim {
    fn one(kind: ChannelKind, first: u32, initial: f64) -> Option<Claim> {
        Some(Claim { kind, first, initial: vec![initial], range: None })
    }
}

/// What a channel of the linkage is called, and how many there are.
pub(crate) fn linkage(kind: ChannelKind) -> (&'static str, usize) {
    match kind {
        ChannelKind::Adc => ("ADC channel", frame::ADC_CHANNELS),
        ChannelKind::Dac => ("DAC channel", frame::DAC_CHANNELS),
        ChannelKind::Dcu => ("DCU", frame::DCU_CHANNELS),
        ChannelKind::Sense => ("sense line", frame::SENSE_LINES),
        ChannelKind::Control => ("control line", frame::CONTROL_LINES),
        ChannelKind::Interrupt => ("interrupt line", frame::INTERRUPT_LINES),
    }
}

/// The table of kinds in patch-files/README.md.
pub fn table() -> String {
    let mut table = String::from("| kind | output | fields | example |\n|---|---|---|---|\n");
    for (n, (Facts { name, output, fields, example, .. }, _)) in (1..).zip(KINDS) {
        let comma = if example.is_empty() { "" } else { ", " };
        let line = format!("x{n} = {{ kind = \"{name}\"{comma}{example} }}");
        let row = format!("| `{name}` | {output} | {fields} | `{line}` |\n");
        table.push_str(&row.replace("|  |", "| |"));
    }
    table
}

#[cfg(test)]
mod tests {
    use crate::patch::compile;
    use interface::control::PatchBundle;

    /// On a difference, put what is printed in the place of the README's table.
    #[test]
    fn the_readme_has_the_table_of_kinds() {
        let readme = include_str!("../../../patch-files/README.md");
        let table = super::table();
        assert!(readme.contains(&format!("\n\n{table}\n")), "patch-files/README.md lacks\n{table}");
    }

    #[test]
    fn the_examples_of_the_table_compile_and_start() {
        let mut text = String::from("[blocks]\nt = { kind = \"time\" }\n");
        for (net, value) in [("a", 1.0), ("b", 2.0), ("c", 3.0)] {
            text += &format!("{net} = {{ kind = \"constant\", value = {value:?} }}\n");
        }
        for net in ["p", "q"] {
            text += &format!("{net} = {{ kind = \"comparator\", in = [\"t\"] }}\n");
        }
        for row in super::table().lines().skip(2) {
            let line = row.trim_end_matches("` |").rsplit("| `").next();
            text += &format!("{}\n", line.unwrap());
        }
        let files = vec![("table.toml".to_owned(), text)];
        let bundle = PatchBundle { root: "table.toml".to_owned(), files };
        compile(&bundle, &[]).map_err(|faults| faults.render()).unwrap().simulation().unwrap();
    }
}
