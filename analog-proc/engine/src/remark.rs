//! What a finished run says of its own numbers, beside its results.

/// Something that the reader of a result should know.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Remark {
    /// The error of a state was judged by the absolute tolerance alone.
    #[error(
        "`{block}` never exceeded {largest:e}: beside its `max`, or the other integrators, that is so \
         little that its error was held to {atol:e}, not to a part of its own size; state a `max` that fits it"
    )]
    Unresolved {
        /// The block.
        block: String,
        /// The greatest magnitude of its output.
        largest: f64,
        /// The absolute tolerance, problem units.
        atol: f64,
    },
    /// A state has decayed to what the absolute tolerance leaves undecided.
    #[error(
        "`{block}` ends at {value:e}, having decayed to where its error of {atol:e} a step counts; \
         with `atol = 0` it is followed to any size"
    )]
    Faded {
        /// The block.
        block: String,
        /// Its output.
        value: f64,
        /// The absolute tolerance, problem units.
        atol: f64,
    },
    /// Fixed steps did not resolve a state.
    #[error(
        "the fixed steps leave an error of about {error:.1e} in `{block}`, beside a greatest value of \
         {largest:e}; shorten `step`, or take a method that controls its error"
    )]
    Coarse {
        /// The block.
        block: String,
        /// The estimate of its error, problem units.
        error: f64,
        /// The greatest magnitude of its output.
        largest: f64,
    },
}
