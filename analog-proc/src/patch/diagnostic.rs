//! Every fault that a patch can have, each with its place and a remedy.
//!
//! One variant a kind of fault; the code (`unknown-net`) names it for machines and for
//! `patch-files/bad/`, where one file shows each. Faults found while a patch runs (overload,
//! non-finite state) are not patch faults.

use desk::reader::Fault;
use miette::{Diagnostic, LabeledSpan, NamedSource, SourceCode, SourceSpan};
use std::{fmt, iter::once, sync::Arc};
use thiserror::Error;

/// Name and text of one patch file, shared by all faults in it.
pub type Source = Arc<NamedSource<String>>;

/// One fault of a patch.
#[derive(Clone, Debug)]
pub struct PatchFault {
    pub(crate) src: Source,
    pub(crate) at: SourceSpan,
    pub(crate) flaw: Flaw,
    /// What to do about it.
    pub(crate) help: String,
    /// Further places that have to do with it.
    pub(crate) beside: Vec<SourceSpan>,
}

macro_rules! flaws {
    (
        shared { $($shared:ident $shared_code:literal, label $shared_label:literal { $($part:ident),* })* }
        own { $($name:ident $code:literal $message:literal, label $label:literal { $($field:ident: $type:ty),* })* }
    ) => {
        /// What is wrong with a patch; the fields are the words of the message.
        #[derive(Clone, Debug, Error)]
        pub(crate) enum Flaw {
            $(#[error($message)] $name { $($field: $type),* },)*
            #[error(transparent)]
            Shared(#[from] Fault),
        }

        impl Flaw {
            #[allow(unused_variables)]
            fn code_and_label(&self) -> (&'static str, String) {
                match self {
                    $(Flaw::$name { $($field),* } => ($code, format!($label)),)*
                    $(Flaw::Shared(Fault::$shared { $($part),* }) => ($shared_code, format!($shared_label)),)*
                }
            }
        }

        impl PatchFault {
            /// The codes of all kinds of fault.
            pub const CODES: &'static [&'static str] = &[$($code,)* $($shared_code),*];
        }
    };
}

flaws! {
    shared {
        UnknownKey "unknown-key", label "not known here" { key, owner }
        UnknownWord "unknown-word", label "not known here" { field, word }
        MissingField "missing-field", label "needs `{field}`" { owner, field }
        WrongType "wrong-type", label "{found}" { field, wanted, found }
        NotFinite "not-finite", label "not finite" { field }
        OutOfRange "out-of-range", label "must be {range}" { field, value, range }
        NotPositive "not-positive", label "must be greater than 0" { field, value }
        InvertedLimits "inverted-limits", label "wrong way round" { field, low, high }
        Breakpoints "breakpoints", label "not above {previous}" { field, value, previous }
        TableSize "table-size", label "{found} entries" { field, found, wanted }
    }
    own {
        TomlSyntax "toml-syntax" "not valid TOML: {what}", label "here" { what: String }
        WrongKind "wrong-kind" "{what}", label "no patch has this" { what: String }
        NotUtf8 "not-utf8" "`{file}` is not UTF-8 text (byte {offset})", label "" { file: String, offset: usize }
        MissingFile "missing-file" "cannot read `{file}`: {why}", label "named here" { file: String, why: String }
        RecursiveUse "recursive-use" "sub-patches use each other in a circle: {chain}", label "closes the circle" { chain: String }
        TooLarge "too-large" "the patch has more than {limit} {what}", label "here" { what: &'static str, limit: usize }
        NoBlocks "no-blocks" "the patch has no blocks", label "" {}
        UnknownKind "unknown-kind" "unknown block kind `{kind}`", label "no such kind" { kind: String }
        PotFraction "pot-fraction" "a pot cannot be set to {value}", label "must lie in 0 to 1" { value: f64 }
        IcOutsideLimits "ic-outside-limits" "initial condition {ic} lies outside the limits [{low}, {high}]", label "outside [{low}, {high}]" { ic: f64, low: f64, high: f64 }
        BadCoefficient "bad-coefficient" "cannot read `{text}`: {why}", label "{why}" { text: String, why: &'static str }
        LogicCoefficient "logic-coefficient" "logic net `{net}` cannot take a coefficient", label "coefficient on a logic net" { net: String }
        UnknownParam "unknown-param" "unknown parameter `{param}`", label "no such parameter" { param: String }
        ParamCircle "param-circle" "parameters are made of each other in a circle: {chain}", label "closes the circle" { chain: String }
        UnknownNet "unknown-net" "unknown net `{net}`", label "no block drives this" { net: String }
        InvalidName "invalid-name" "`{name}` cannot be a name", label "not a name" { name: String }
        DuplicateName "duplicate-name" "`{name}` is named twice", label "again" { name: String }
        ParamNetClash "param-net-clash" "`{name}` is both a parameter and a net", label "net" { name: String }
        Arity "arity" "{owner} takes {wanted}, and has {found}", label "{found} here" { owner: String, wanted: String, found: usize }
        UnconnectedInput "unconnected-input" "the input of {owner} is not connected", label "nothing wired to it" { owner: String }
        UnboundPort "unbound-port" "port `{port}` of `{file}` is not bound", label "nothing bound to `{port}`" { port: String, file: String }
        UnknownPort "unknown-port" "`{file}` has no port `{port}`", label "no such port" { port: String, file: String }
        LogicForAnalog "logic-for-analog" "`{net}` is a logic net, and {owner} wants an analog one", label "logic" { net: String, owner: String }
        AnalogForLogic "analog-for-logic" "`{net}` is an analog net, and {owner} wants a logic one", label "analog" { net: String, owner: String }
        AlgebraicLoop "algebraic-loop" "algebraic loop: {cycle}", label "the loop passes here" { cycle: String }
        LogicLoop "logic-loop" "combinational logic loop: {cycle}", label "the loop passes here" { cycle: String }
        ChannelTwice "channel-twice" "{what} {number} is used twice", label "again" { what: &'static str, number: u32 }
        ChannelOutOfRange "channel-out-of-range" "there is no {what} {number}", label "0 to {last}" { what: &'static str, number: f64, last: u32 }
        NoDerivative "no-derivative" "`{net}` has no derivative to check", label "not an integrator" { net: String }
        TooManyBlocks "too-many-blocks" "profile `{profile}` has too few blocks for this patch\n{table}", label "the first that finds no place" { profile: String, table: String }
    }
}

impl PatchFault {
    /// Code of this kind of fault.
    pub fn code_name(&self) -> &'static str {
        self.flaw.code_and_label().0
    }
}

impl fmt::Display for PatchFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.flaw.fmt(f)
    }
}

impl std::error::Error for PatchFault {}

impl Diagnostic for PatchFault {
    fn code<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        Some(Box::new(self.code_name()))
    }

    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        Some(Box::new(&self.help))
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        Some(&self.src)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let label = self.flaw.code_and_label().1;
        let beside = match self.flaw {
            Flaw::ParamNetClash { .. } => "parameter",
            Flaw::AlgebraicLoop { .. } | Flaw::LogicLoop { .. } => "and here",
            _ => "first",
        };
        let of = move |at: &SourceSpan| LabeledSpan::new_with_span(Some(beside.to_owned()), *at);
        let here = LabeledSpan::new_primary_with_span(Some(label), self.at);
        Some(Box::new(once(here).chain(self.beside.iter().map(of))))
    }
}
