//! What holds a signal at a level holds it there: rounding takes nothing past a limit, a stop or
//! rest, so that who compares with that very level sees what is there.

use crate::TAU;
use crate::bench::Bench;
use crate::roots::integral;

/// All methods; what happens does so between their fixed steps.
const METHODS: [&str; 4] = [
    "",
    "method = \"sdirk4\"",
    "method = \"runge-kutta-4\"\nstep = 0.01",
    "method = \"euler\"\nstep = 0.003",
];

/// Blocks that count how often the sum of `inputs` rises above a level, in `n_NAME`.
fn counted(name: &str, inputs: &str, level: f64) -> String {
    format!(
        "c_{name} = {{ kind = \"comparator\", in = [{inputs}], threshold = {level:?} }}\nn_{name} = {{ kind = \"counter\", in = [\"c_{name}\"] }}\n"
    )
}

#[test]
fn no_limit_is_passed() {
    // Levels whose tables round up, down and not at all.
    for (low, high, y0, y1) in
        [(-0.7, 0.45, -0.4, 0.9), (-0.25, 0.5, -3.0, 0.1), (-0.613, 0.3, 1.9, -0.7)]
    {
        let (least, greatest) = (f64::min(y0, y1), f64::max(y0, y1));
        let mut blocks = format!(
            r#"
            s = {{ kind = "signal-generator", wave = "sine", frequency = 1.7, phase = 0.3 }}
            one = {{ kind = "constant", value = 1.0 }}
            low = {{ kind = "gain", in = ["one"], k = {low:?} }}
            high = {{ kind = "gain", in = ["one"], k = {high:?} }}
            fixed = {{ kind = "limiter", in = ["s"], limits = [{low:?}, {high:?}] }}
            set = {{ kind = "limiter", in = ["s"], limits = ["low", "high"] }}
            table = {{ kind = "function", in = ["s"], x = [{low:?}, {high:?}], y = [{y0:?}, {y1:?}] }}
            surface = {{ kind = "function-2d", in = ["s", "s"], x = [{low:?}, {high:?}], y = [{low:?}, {high:?}], z = [[{y0:?}, {y0:?}], [{y1:?}, {y1:?}]] }}
            stopped = {{ kind = "integrator", in = ["20 * s"], limits = [{low:?}, {high:?}] }}
            "#
        );
        let all = [
            ("fixed", low, high),
            ("set", low, high),
            ("stopped", low, high),
            ("table", least, greatest),
            ("surface", least, greatest),
        ];
        for (name, least, greatest) in all {
            blocks += &counted(&format!("{name}_up"), &format!("\"{name}\""), greatest);
            blocks += &counted(&format!("{name}_down"), &format!("\"-1 * {name}\""), -least);
        }
        for integration in METHODS {
            let mut bench = Bench::with(integration, &blocks);
            bench.run(10.0);
            for (name, ..) in all {
                for way in ["up", "down"] {
                    let count = bench.net(&format!("n_{name}_{way}"));
                    assert_eq!(count, 0.0, "{integration}: {name} {way}, limits {low}, {high}");
                }
            }
        }
    }
}

#[test]
fn a_dead_zone_has_the_sign_of_its_input_or_none() {
    // Ten periods: so often the input leaves the zone on either side.
    for width in [0.3, 0.1, 0.477_013] {
        let mut blocks = format!(
            r#"
            s = {{ kind = "signal-generator", wave = "sine", phase = 0.05 }}
            w = {{ kind = "constant", value = {width:?} }}
            fixed = {{ kind = "dead-zone", in = ["s"], width = {width:?} }}
            set = {{ kind = "dead-zone", in = ["s"], width = "w" }}
            "#
        );
        for name in ["fixed", "set"] {
            blocks += &counted(&format!("{name}_up"), &format!("\"{name}\""), 0.0);
            blocks += &counted(&format!("{name}_down"), &format!("\"-1 * {name}\""), 0.0);
        }
        for integration in METHODS {
            let mut bench = Bench::with(integration, &blocks);
            bench.run(10.0);
            for net in ["n_fixed_up", "n_fixed_down", "n_set_up", "n_set_down"] {
                assert_eq!(bench.net(net), 10.0, "{integration}: {net}, ± {width}");
            }
        }
    }
}

#[test]
fn an_extreme_is_never_below_what_it_chooses_from() {
    // A ramp that is held at the level where it switches a comparator off, and a sine that comes
    // back to it.
    for (slope, part, gain, frequency, level) in [
        (1.671, 0.41, 1.296, 1.58, 0.296),
        (0.831, 0.319, 1.236, 2.58, 0.157),
        (1.707, 0.43, 1.852, 1.79, 0.219),
    ] {
        let blocks = format!(
            r#"
            one = {{ kind = "constant", value = 1.0 }}
            s = {{ kind = "signal-generator", wave = "sine", frequency = {frequency:?}, phase = -2 }}
            held = {{ kind = "integrator", in = ["{slope:?} * one"], ic = -0.5, operate = "low" }}
            most = {{ kind = "max", in = ["{part:?} * held", "0.6 * s"] }}
            least = {{ kind = "min", in = ["-{part:?} * held", "-0.6 * s"] }}
            low = {{ kind = "comparator", in = ["-{gain:?} * most"], threshold = -{level:?} }}
            n_low = {{ kind = "counter", in = ["low"] }}
            {}
            "#,
            counted("least", &format!("\"{gain:?} * least\""), -level),
        );
        for integration in METHODS {
            let mut bench = Bench::with(integration, &blocks);
            bench.run(10.0);
            // The sine switches it off and on again until the ramp has come to the level.
            let before = bench.net("n_low");
            bench.run(20.0);
            let found = part * gain * bench.net("held");
            assert!((found - level).abs() < 1e-12, "{integration}: {found}");
            assert_eq!(bench.net("n_low"), before, "{integration}: slope {slope}");
            assert_eq!(bench.net("n_least"), before, "{integration}: slope {slope}");
        }
    }
}

#[test]
fn what_friction_stops_has_not_moved_back() {
    // In either order of the lines.
    let friction = "f = { kind = \"dry-friction\", in = [\"v\", \"zero\"], level = 0.71 }\n";
    let back = counted("back", "\"-1 * v\"", 0.0);
    for lines in [format!("{friction}{back}"), format!("{back}{friction}")] {
        for integration in METHODS {
            let mut bench = Bench::with(
                integration,
                &format!(
                    "zero = {{ kind = \"constant\", value = 0.0 }}\n{lines}v = {{ kind = \"integrator\", in = [\"f\"], ic = 1.3 }}"
                ),
            );
            bench.run(3.0);
            assert_eq!((bench.net("v"), bench.net("n_back")), (0.0, 0.0), "{integration}: {lines}");
        }
    }
}

#[test]
fn an_angle_on_the_cut_jumps_where_its_vector_crosses_it_and_nowhere_else() {
    // To the left of the origin: below, but for instants at which its square touches the cut
    // (`low`, also delayed); above, or at rest on the cut (`high`).
    let turn_s = 1.0 / 1.3;
    let x = |t: f64| (TAU * 1.3 * t + 0.3).sin();
    for integration in METHODS {
        let mut bench = Bench::with(
            integration,
            &format!(
                r#"
                one = {{ kind = "constant", value = 1.0 }}
                s = {{ kind = "signal-generator", wave = "sine", frequency = 1.3, phase = 0.3 }}
                square = {{ kind = "multiplier", in = ["s", "s"] }}
                low = {{ kind = "arctangent", in = ["-1 * square", "-1 * one"] }}
                late = {{ kind = "transport-delay", in = ["square"], delay = 0.37, initial = 1.0 }}
                late_low = {{ kind = "arctangent", in = ["-1 * late", "-1 * one"] }}
                zone = {{ kind = "dead-zone", in = ["square"], width = 0.4 }}
                high = {{ kind = "arctangent", in = ["zone", "-1 * one"] }}
                late_zone = {{ kind = "transport-delay", in = ["zone"], delay = 0.37, initial = 1.0 }}
                late_high = {{ kind = "arctangent", in = ["late_zone", "-1 * one"] }}
                area = {{ kind = "integrator", in = ["low"] }}
                {}{}{}{}
                "#,
                counted("low", "\"low\"", 0.0),
                counted("late_low", "\"late_low\"", 0.0),
                counted("high", "\"-1 * high\"", 0.0),
                counted("late_high", "\"-1 * late_high\"", 0.0),
            ),
        );
        bench.run(10.0 * turn_s);
        for net in ["n_low", "n_late_low", "n_high", "n_late_high"] {
            assert_eq!(bench.net(net), 0.0, "{integration}: {net}");
        }
        if integration.is_empty() {
            let angle = |t: f64| (-x(t) * x(t)).atan2(-1.0);
            let truth = 10.0 * integral(angle, 0.0, turn_s, 64);
            crate::close(bench.net("area"), truth, 1e-8, "the integral of the angle");
        }
    }
}
