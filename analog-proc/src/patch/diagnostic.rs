//! Every fault that a patch can have, each with its place and a remedy.
//!
//! One variant a kind of fault; the code (`unknown-net`) names it for machines
//! and for `patch-files/bad/`, where one file shows each. The variants are
//! written as a list, because all of them carry the same four things: source
//! text, place, remedy, and the fields of the message. Faults found while a
//! patch runs (overload, non-finite state) are not patch faults.

use desk::reader::Fault;
use miette::{Diagnostic, LabeledSpan, NamedSource, SourceSpan};
use std::sync::Arc;
use thiserror::Error;

/// Name and text of one patch file, shared by all faults in it.
pub type Source = Arc<NamedSource<String>>;

macro_rules! patch_faults {
    ($(
        $(#[$doc:meta])*
        $name:ident $code:literal $message:literal, label $label:literal {
            $( $(#[$field_attribute:meta])* $field:ident: $type:ty ),* $(,)?
        }
    )*) => {
        /// One fault of a patch.
        #[derive(Clone, Debug, Error, Diagnostic)]
        #[allow(missing_docs)] // The fields are the words of the message.
        pub enum PatchFault {
            $(
                $(#[$doc])*
                #[error($message)]
                #[diagnostic(code($code), help("{help}"))]
                $name {
                    #[source_code]
                    src: Source,
                    #[label(primary, $label)]
                    at: SourceSpan,
                    help: String,
                    $( $(#[$field_attribute])* $field: $type, )*
                },
            )*
        }

        impl PatchFault {
            /// The codes of all kinds of fault.
            pub const CODES: &'static [&'static str] = &[$($code),*];

            /// Code of this kind of fault.
            pub fn code_name(&self) -> &'static str {
                match self { $( PatchFault::$name { .. } => $code, )* }
            }

            /// File and byte range.
            pub fn place(&self) -> (&Source, SourceSpan) {
                match self { $( PatchFault::$name { src, at, .. } => (src, *at), )* }
            }

            /// What to do about it.
            pub fn remedy(&self) -> &str {
                match self { $( PatchFault::$name { help, .. } => help, )* }
            }
        }
    };
}

patch_faults! {
    /// The file is not TOML.
    TomlSyntax "toml-syntax" "not valid TOML: {what}", label "here" { what: String }
    /// The file is of another kind.
    WrongKind "wrong-kind" "{what}", label "no patch has this" { what: String }
    /// The file is not UTF-8 text.
    NotUtf8 "not-utf8" "`{file}` is not UTF-8 text (byte {offset})", label "" { file: String, offset: usize }
    /// A file that is named cannot be read.
    MissingFile "missing-file" "cannot read `{file}`: {why}", label "named here" { file: String, why: String }
    /// A sub-patch uses itself, directly or through others.
    RecursiveUse "recursive-use" "sub-patches use each other in a circle: {chain}", label "closes the circle" { chain: String }
    /// The patch is larger than this program accepts.
    TooLarge "too-large" "the patch has more than {limit} {what}", label "here" { what: &'static str, limit: usize }
    /// No block at all.
    NoBlocks "no-blocks" "the patch has no blocks", label "" {}
    /// A key that the language does not know.
    UnknownKey "unknown-key" "unknown key `{key}` in {owner}", label "not known here" { key: String, owner: String }
    /// A word that its field does not know.
    UnknownWord "unknown-word" "`{field}` cannot be `{word}`", label "not known here" { field: String, word: String }
    /// A block kind that does not exist.
    UnknownKind "unknown-kind" "unknown block kind `{kind}`", label "no such kind" { kind: String }
    /// A field that must be given.
    MissingField "missing-field" "{owner} lacks `{field}`", label "needs `{field}`" { owner: String, field: String }
    /// A value of another type than its field takes.
    WrongType "wrong-type" "`{field}` takes {wanted}, not {found}", label "{found}" { field: String, wanted: &'static str, found: &'static str }
    /// A number that is infinite or not a number.
    NotFinite "not-finite" "`{field}` is not a finite number", label "not finite" { field: String }
    /// A number outside the range of its field.
    OutOfRange "out-of-range" "`{field}` = {value} is out of range: it must be {range}", label "must be {range}" { field: String, value: f64, range: String }
    /// A time constant, rate, delay, width or scale factor that is zero or negative.
    NotPositive "not-positive" "`{field}` = {value} must be positive", label "must be greater than 0" { field: String, value: f64 }
    /// A potentiometer set outside its turns.
    PotFraction "pot-fraction" "a pot cannot be set to {value}", label "must lie in 0 to 1" { value: f64 }
    /// Limits the wrong way round.
    InvertedLimits "inverted-limits" "`{field}` = [{low}, {high}]: the first must lie below the second", label "wrong way round" { field: String, low: f64, high: f64 }
    /// An initial condition beyond the integrator's limits.
    IcOutsideLimits "ic-outside-limits" "initial condition {ic} lies outside the limits [{low}, {high}]", label "outside [{low}, {high}]" { ic: f64, low: f64, high: f64 }
    /// Breakpoints that do not increase.
    Breakpoints "breakpoints" "breakpoints of `{field}` must increase: {value} follows {previous}", label "not above {previous}" { field: String, value: f64, previous: f64 }
    /// Table rows, columns or breakpoints that do not match.
    TableSize "table-size" "`{field}` has {found} entries where {wanted} are needed", label "{found} entries" { field: String, found: usize, wanted: String }
    /// An input or product that cannot be read.
    BadCoefficient "bad-coefficient" "cannot read `{text}`: {why}", label "{why}" { text: String, why: &'static str }
    /// A coefficient on a logic net.
    LogicCoefficient "logic-coefficient" "logic net `{net}` cannot take a coefficient", label "coefficient on a logic net" { net: String }
    /// A parameter that does not exist.
    UnknownParam "unknown-param" "unknown parameter `{param}`", label "no such parameter" { param: String }
    /// A net that does not exist.
    UnknownNet "unknown-net" "unknown net `{net}`", label "no block drives this" { net: String }
    /// A name with characters that names may not have.
    InvalidName "invalid-name" "`{name}` cannot be a name", label "not a name" { name: String }
    /// Two things of the same name.
    DuplicateName "duplicate-name" "`{name}` is named twice", label "again" { name: String, #[label(collection, "first")] first: Vec<LabeledSpan> }
    /// A parameter and a net of the same name.
    ParamNetClash "param-net-clash" "`{name}` is both a parameter and a net", label "net" { name: String, #[label(collection, "parameter")] first: Vec<LabeledSpan> }
    /// Too many or too few inputs.
    Arity "arity" "{owner} takes {wanted}, and has {found}", label "{found} here" { owner: String, wanted: String, found: usize }
    /// A block whose inputs are not wired.
    UnconnectedInput "unconnected-input" "the input of {owner} is not connected", label "nothing wired to it" { owner: String }
    /// A port of a sub-patch that its user does not bind.
    UnboundPort "unbound-port" "port `{port}` of `{file}` is not bound", label "nothing bound to `{port}`" { port: String, file: String }
    /// A binding to a port that the sub-patch does not have.
    UnknownPort "unknown-port" "`{file}` has no port `{port}`", label "no such port" { port: String, file: String }
    /// A logic net where an analog net is wanted.
    LogicForAnalog "logic-for-analog" "`{net}` is a logic net, and {owner} wants an analog one", label "logic" { net: String, owner: String }
    /// An analog net where a logic net is wanted.
    AnalogForLogic "analog-for-logic" "`{net}` is an analog net, and {owner} wants a logic one", label "analog" { net: String, owner: String }
    /// A closed path without any store in it.
    AlgebraicLoop "algebraic-loop" "algebraic loop: {cycle}", label "the loop passes here" { cycle: String, #[label(collection, "and here")] edges: Vec<LabeledSpan> }
    /// A closed path of logic without any store in it.
    LogicLoop "logic-loop" "combinational logic loop: {cycle}", label "the loop passes here" { cycle: String, #[label(collection, "and here")] edges: Vec<LabeledSpan> }
    /// A converter channel or line used by two blocks.
    ChannelTwice "channel-twice" "{what} {number} is used twice", label "again" { what: &'static str, number: u32, #[label(collection, "first")] first: Vec<LabeledSpan> }
    /// A converter channel or line that the linkage does not have.
    ChannelOutOfRange "channel-out-of-range" "there is no {what} {number}", label "0 to {last}" { what: &'static str, number: f64, last: u32 }
    /// A derivative is expected of a block that has none.
    NoDerivative "no-derivative" "`{net}` has no derivative to check", label "not an integrator" { net: String }
    /// The machine profile has fewer blocks of a class than the patch needs.
    TooManyBlocks "too-many-blocks" "profile `{profile}` has too few blocks for this patch\n{table}", label "the first that finds no place" { profile: String, table: String }
}

/// Faults that every file can have carry the same fields here.
macro_rules! shared_faults {
    ($($name:ident { $($field:ident),+ })+) => {
        impl PatchFault {
            /// A fault of a patch that other files can have too.
            pub(crate) fn shared(fault: Fault, src: Source, at: SourceSpan, help: String) -> Self {
                match fault {
                    $(Fault::$name { $($field),+ } => PatchFault::$name { src, at, help, $($field),+ },)+
                }
            }
        }
    };
}

shared_faults! {
    UnknownKey { key, owner }
    UnknownWord { field, word }
    MissingField { owner, field }
    WrongType { field, wanted, found }
    NotFinite { field }
    OutOfRange { field, value, range }
    NotPositive { field, value }
    InvertedLimits { field, low, high }
    Breakpoints { field, value, previous }
    TableSize { field, found, wanted }
}
