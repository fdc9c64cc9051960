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
    /// A signal touched a switching surface within tolerance.
    #[error(
        "`{block}` came within tolerance of switching at t = {t_s} s and was taken not to ({times} such \
         moments in all): whether it would is below the accuracy of the run (`rtol`)"
    )]
    Grazed {
        /// The block of the first such moment.
        block: String,
        /// Its problem time, s.
        t_s: f64,
        /// How often it happened.
        times: u64,
    },
}
