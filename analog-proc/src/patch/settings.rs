//! The section `[integration]`: method, tolerances, overload policy, time scale.

use super::fields::Fields;
use engine::integration::{Integration, Method, OverloadPolicy};

/// Reads `[integration]`.
pub(crate) fn integration(f: &mut Fields<'_, '_>) -> Option<Integration> {
    let default = Integration::default();
    let method = f.word(
        "method",
        Some(default.method),
        &[
            ("dormand-prince", Method::DormandPrince),
            ("runge-kutta-4", Method::RungeKutta4),
            ("euler", Method::Euler),
            ("sdirk4", Method::Sdirk4),
        ],
    );
    // Below 1e-15 an f64 cannot tell the error from rounding.
    let rtol =
        f.ranged("rtol", Some(default.rtol), "from 1e-15 to 0.1", |v| (1e-15..=0.1).contains(&v));
    let atol = f.positive("atol", Some(default.atol));
    let step_s = f.positive("step", Some(default.step_s));
    let max_step_s = f.positive("max-step", Some(default.max_step_s));
    let overload = f.word(
        "overload",
        Some(default.overload),
        &[
            ("continue", OverloadPolicy::Continue),
            ("hold", OverloadPolicy::Hold),
            ("stop", OverloadPolicy::Stop),
        ],
    );
    let time_scale = f.positive("time-scale", Some(default.time_scale));
    Some(Integration {
        method: method?,
        rtol: rtol?,
        atol: atol?,
        step_s: step_s?,
        max_step_s: max_step_s?,
        overload: overload?,
        time_scale: time_scale?,
    })
}
