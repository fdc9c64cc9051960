//! The kinds of block: what they are called and how many inputs each takes; and the
//! numbers of converters and lines that the linkage has.

/// ADC channels of the linkage.
pub const ADC_CHANNELS: u32 = 64;
/// DAC (and MDAC) channels.
pub const DAC_CHANNELS: u32 = 64;
/// Digital coefficient units.
pub const DCU_CHANNELS: u32 = 128;
/// Sense lines.
pub const SENSE_LINES: u32 = 64;
/// Control lines.
pub const CONTROL_LINES: u32 = 64;
/// Interrupt lines.
pub const INTERRUPT_LINES: u32 = 32;

/// How many inputs a kind takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Arity {
    pub(crate) least: usize,
    pub(crate) most: Option<usize>,
    /// What they are, in order, where that matters.
    roles: &'static str,
}

impl Arity {
    pub(crate) fn words(self) -> String {
        let count = match (self.least, self.most) {
            (0, _) => "no input".to_owned(),
            (1, Some(1)) => "one input".to_owned(),
            (least, Some(most)) if least == most => format!("{least} inputs"),
            (least, Some(most)) => format!("{least} or {most} inputs"),
            (1, None) => "one or more inputs".to_owned(),
            (least, None) => format!("{least} or more inputs"),
        };
        format!("{count}{}", self.roles)
    }
}

const fn exactly(count: usize, roles: &'static str) -> Arity {
    Arity { least: count, most: Some(count), roles }
}

const fn at_least(least: usize) -> Arity {
    Arity { least, most: None, roles: "" }
}

const KINDS: &[(&str, Arity)] = &[
    ("integrator", at_least(1)),
    ("summer", at_least(1)),
    ("inverter", at_least(1)),
    ("square", at_least(1)),
    ("square-root", at_least(1)),
    ("abs", at_least(1)),
    ("sine", at_least(1)),
    ("cosine", at_least(1)),
    ("gain", at_least(1)),
    ("pot", exactly(1, "")),
    ("dcu", at_least(1)),
    ("mdac", at_least(1)),
    ("dac", exactly(0, "")),
    ("adc", at_least(1)),
    ("multiplier", at_least(2)),
    ("min", at_least(2)),
    ("max", at_least(2)),
    ("divider", exactly(2, " (dividend, divisor)")),
    ("arctangent", exactly(2, " (y, x)")),
    ("resolver", exactly(3, " (x, y, angle)")),
    ("function", at_least(1)),
    ("function-2d", exactly(2, " (x, y)")),
    ("digital-function", at_least(1)),
    ("dead-zone", at_least(1)),
    ("limiter", at_least(1)),
    ("rate-limiter", at_least(1)),
    ("backlash", at_least(1)),
    ("dry-friction", exactly(2, " (velocity, applied force)")),
    ("relay", at_least(1)),
    ("comparator", at_least(1)),
    ("switch", exactly(2, " (when 1, when 0)")),
    ("track-store", at_least(1)),
    ("transport-delay", at_least(1)),
    ("lag", at_least(1)),
    ("signal-generator", exactly(0, "")),
    ("noise", exactly(0, "")),
    ("and", at_least(2)),
    ("or", at_least(2)),
    ("not", exactly(1, "")),
    ("flip-flop", exactly(2, " (set, reset)")),
    ("one-shot", exactly(1, "")),
    ("counter", Arity { least: 1, most: Some(2), roles: " (clock, reset)" }),
    ("sense", exactly(1, "")),
    ("control", exactly(0, "")),
    ("interrupt", exactly(1, "")),
    ("constant", exactly(0, "")),
    ("time", exactly(0, "")),
];

/// All kind names.
pub(crate) fn names() -> impl Iterator<Item = &'static str> {
    KINDS.iter().map(|(name, _)| *name)
}

/// Inputs of a kind; `None` for a word that is not a kind.
pub(crate) fn arity(kind: &str) -> Option<Arity> {
    KINDS.iter().find(|(name, _)| *name == kind).map(|(_, arity)| *arity)
}
