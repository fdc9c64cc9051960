//! The two short-period models of the paper's §2, side by side on the machine: the drift form
//! (20)–(22), whose flight-path state is ż (`pitch-loop.toml`), and the α form, which integrates
//! α̇ = θ̇ + z̈/V and finds ż = V(α − θ − α_w) from it (`pitch-loop-alpha.toml`).
//!
//! They are one system as long as the gust is held. Of a gust that ends the α form knows nothing:
//! it would need its rate, so that only the drift form holds there.

use super::{
    coefficients::{Disturbance, Settings},
    linear::{Root, model_roots},
    machine::Patches,
    metrics::worst_of,
    plan::Plan,
    point::FrozenPoint,
};
use crate::{
    flight::replace_block,
    linkage::console::{Console, ConsoleFault},
};
use desk::{
    outcome::Outcome,
    report::{
        Column, Table,
        plot::{Axis, LineChart, Series},
    },
};
use interface::{
    Tick,
    control::{ChannelKind, Clock, PatchBundle, RunSpec},
    frame::{Samples, Updates},
    profile::Profile,
};

/// When the gust ends that only the drift form can follow.
const GUST_ENDS: Tick = Tick(2 * Tick::SECOND.0);
/// Two adaptive integrations of one system at rtol 1e-7 over 12 s, each within some hundred steps'
/// tolerances of the truth: 1e-5 of the greatest value is left between them.
const WITHIN: f64 = 1e-5;
/// Eigenvalues of similar matrices with entries up to K_T/τ_T = 3e6 are found to 1e-9 1/s and their
/// condition, some ten; the slowest is 0.01 1/s.
const ROOTS_WITHIN: f64 = 1e-5;
/// What is compared.
const CHANNELS: [&str; 3] = ["pitch_attitude", "angle_of_attack", "drift"];

/// Which state the flight path has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    Drift,
    Alpha,
}

impl Form {
    const ALL: [Form; 2] = [Form::Drift, Form::Alpha];

    /// The shipped pitch loop; in the α form with the blocks of its flight path exchanged.
    fn patch(self) -> PatchBundle {
        let mut bundle = Patches::shipped().pitch;
        if self == Form::Alpha {
            ROOT.clone_into(&mut bundle.root);
            for (name, text) in &mut bundle.files {
                match name.as_str() {
                    "pitch-loop.toml" => (*name, *text) = (ROOT.to_owned(), alpha_loop(text)),
                    "sub/stage-plane.toml" => {
                        (*name, *text) = (PLANE.to_owned(), alpha_plane(text))
                    }
                    _ => {}
                }
            }
        }
        bundle
    }

    fn values(self, settings: &Settings) -> Vec<(&'static str, f64)> {
        let of = |(name, value)| match (self, name) {
            (Form::Alpha, "plane.drift_angle") => ("plane.drift_rate", 1.0 / value),
            _ => (name, value),
        };
        settings.values().into_iter().map(of).collect()
    }

    fn initial_conditions(self, settings: &Settings) -> Vec<(String, f64)> {
        match self {
            Form::Drift => Vec::new(),
            Form::Alpha => vec![("plane.alpha".to_owned(), settings.plane.gust)],
        }
    }
}

/// The α form's files.
const ROOT: &str = "pitch-loop-alpha.toml";
const PLANE: &str = "sub/stage-plane-alpha.toml";

/// What stands at their heads in place of what is said of the drift form.
const ROOT_HEAD: &str = "\
# Short-period pitch loop in the α form: pitch-loop.toml with the angle of attack in place of the
# drift rate as the state of the flight path (sub/stage-plane-alpha.toml).
#
# What to see: the same responses as in the drift form, as long as the gust is held
# (`digital-proc short-period forms` sets both to every trajectory point and compares them).
# Coefficients, converters and channels are those of pitch-loop.toml, but for coefficient unit 3,
# which holds V, and the initial condition of plane.alpha, which is the gust.
";
const PLANE_HEAD: &str = "\
# One plane of the stage as sub/stage-plane.toml has it, in the α form: the angle of attack is
# integrated and the drift rate follows from it. It is the short-period model for whom the angle
# of attack is of interest; the drift form (20) to (22) has the drift rate as its state.
#
#   alpha' = theta' + z''/V           z' = V (alpha - theta - alpha_w)
#
# The two are one as long as the gust is held: alpha starts at it (`ic`), and a gust that changes
# later would have to enter by its rate, which this form leaves out. Where V tends to zero the
# angle of attack has no meaning and this form no use.
#
";

/// A loop in the α form.
fn alpha_loop(text: &str) -> String {
    let from = text.find("title =").unwrap_or(0);
    let text = format!("{ROOT_HEAD}{}", &text[from..]);
    text.replacen("short period", "short period, alpha form", 1)
        .replace("sub/stage-plane.toml\"", &format!("{PLANE}\""))
}

/// A plane in the α form.
fn alpha_plane(text: &str) -> String {
    let from = text.find("# Ports:").unwrap_or(0);
    let text = format!("{PLANE_HEAD}{}", &text[from..])
        .replace(
            "drift_angle     3  1/V                  rad per m/s",
            "drift_rate      3  V                    m/s per rad",
        )
        .replace("stage, trajectory frozen", "stage in the alpha form, trajectory frozen");
    let left_out = |line: &&str| !line.starts_with("drift_rate ");
    let mut text = text.lines().filter(left_out).collect::<Vec<_>>().join("\n");
    for (name, block) in [("drift_angle", DRIFT), ("alpha", ALPHA)] {
        text = replace_block(&text, name, block);
    }
    text.replace("drift_angle = ", "drift_rate = ")
}

const DRIFT: &str = r#"{ kind = "dcu", channel = 3, range = 1250, in = ["alpha", "-theta", "-gust"], max = 200.0, note = "z' = V (alpha - theta - alpha_w), m/s" }"#;
const ALPHA: &str = r#"{ kind = "integrator", in = ["alpha_rate"], ic = 0.0, max = 1.5, note = "incidence, rad; starts at the gust" }"#;

/// θ, α and ż at the samples.
type Responses = [Vec<f64>; 3];

/// What one form does at one point.
struct Answer {
    roots: Vec<Root>,
    held: Responses,
    ended: Responses,
}

/// The two forms at one point.
pub struct Apart {
    pub point: String,
    pub time_s: f64,
    pressure_pa: f64,
    /// Greatest difference of θ, α and ż over the greatest value, the gust held.
    held: [f64; 3],
    /// The same, the gust ended.
    ended: [f64; 3],
    /// Greatest difference of an eigenvalue of the machines' linear models over its magnitude.
    roots: f64,
    /// For the figure: each form's answer with the gust held and ended.
    answers: [[Responses; 2]; 2],
}

/// Runs both forms at every point of a plan.
pub fn run(
    console: &mut Console<'_>,
    plan: &Plan,
    vehicle: &vehicle::Vehicle,
    disturbance: &Disturbance,
    profile: &Profile,
    mut progress: impl FnMut(usize),
) -> Result<Vec<Apart>, ConsoleFault> {
    let mut answers = Vec::new();
    let mut done = 0;
    for form in Form::ALL {
        console.load(form.patch(), Vec::new(), profile.clone())?;
        let mut of_form = Vec::with_capacity(plan.points.len());
        for point in &plan.points {
            let gains = &point.slice.settings.gains;
            let frozen = FrozenPoint::new(vehicle, &point.slice, gains);
            let settings = Settings::pitch(&frozen, disturbance, plan.step_rad);
            of_form.push(answer(console, form, plan, &settings)?);
            done += 1;
            progress(done);
        }
        answers.push(of_form);
    }
    let mut both = answers.into_iter();
    let (drift, alpha) = (both.next().unwrap_or_default(), both.next().unwrap_or_default());
    let pairs = plan.points.iter().zip(drift.into_iter().zip(alpha));
    Ok(pairs
        .map(|(point, (d, a))| Apart {
            point: point.name.clone(),
            time_s: point.slice.time_s,
            pressure_pa: point.slice.airframe.dynamic_pressure_pa,
            held: apart(&d.held, &a.held),
            ended: apart(&d.ended, &a.ended),
            roots: roots_apart(&d.roots, &a.roots),
            answers: [[d.held, d.ended], [a.held, a.ended]],
        })
        .collect())
}

fn answer(
    console: &mut Console<'_>,
    form: Form,
    plan: &Plan,
    settings: &Settings,
) -> Result<Answer, ConsoleFault> {
    console.set_ics(form.initial_conditions(settings))?;
    let updates = console.settings(&form.values(settings))?;
    console.preset(&updates)?;
    let model = console.linearise(&[], &[])?;
    let roots = model_roots(&model);
    let held = respond(console, plan, None)?;
    let ended = respond(console, plan, Some(GUST_ENDS))?;
    // The converter keeps what it was given last.
    console.preset(&updates)?;
    Ok(Answer { roots, held, ended })
}

fn respond(
    console: &mut Console<'_>,
    plan: &Plan,
    gust_ends: Option<Tick>,
) -> Result<Responses, ConsoleFault> {
    let gust = console.channel(ChannelKind::Dac, "plane.gust")?;
    let mut adc = [0; 3];
    for (number, name) in adc.iter_mut().zip(CHANNELS) {
        *number = console.channel(ChannelKind::Adc, name)?;
    }
    let spec = RunSpec {
        frame: plan.sample,
        latency: Tick::ZERO,
        skew: Tick::ZERO,
        stop: plan.sample * plan.samples() as i64,
        from_ic: true,
        clock: Clock::LockStep,
    };
    let mut found = Responses::default();
    console.run(&spec, &mut |samples: &Samples, updates: &mut Updates| {
        for (column, number) in found.iter_mut().zip(adc) {
            column.push(samples.adc[number]);
        }
        if gust_ends.is_some_and(|at| samples.tick >= at) {
            updates.set_dac(gust, 0.0);
        }
    })?;
    Ok(found)
}

fn apart(one: &Responses, other: &Responses) -> [f64; 3] {
    std::array::from_fn(|k| {
        let greatest = one[k].iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let pairs = one[k].iter().zip(&other[k]);
        pairs.fold(0.0_f64, |m, (a, b)| m.max((a - b).abs())) / greatest
    })
}

fn roots_apart(one: &[Root], other: &[Root]) -> f64 {
    if one.is_empty() || one.len() != other.len() {
        return f64::NAN;
    }
    let off = |a: &Root, b: &Root| {
        libm::hypot(a.real - b.real, a.imaginary - b.imaginary) / a.frequency_radps()
    };
    let nearest = |a: &Root| other.iter().map(|b| off(a, b)).fold(f64::INFINITY, f64::min);
    one.iter().map(nearest).fold(0.0, f64::max)
}

/// What the comparison came to.
pub fn outcome(all: &[Apart], sample_s: f64) -> Outcome {
    let mut out = Outcome::new(
        "The two short-period models",
        "The drift form, eqs. (20) to (22), and the α form of the pitch loop on the machine, under the same step, misalignment and gust.",
    );
    let columns = [
        Column::new("Point", "", |a: &Apart| a.point.as_str().into()),
        Column::of("Time", "s", 3, |a| a.time_s.into()),
        Column::of("Attitude differs by", "of its greatest", 2, |a| a.held[0].into()),
        Column::of("Incidence", "of its greatest", 2, |a| a.held[1].into()),
        Column::of("Drift", "of its greatest", 2, |a| a.held[2].into()),
        Column::of("Eigenvalues", "of their magnitude", 2, |a| a.roots.into()),
        Column::of("Attitude, the gust ended", "of its greatest", 2, |a| a.ended[0].into()),
        Column::of("Incidence, the gust ended", "of its greatest", 2, |a| a.ended[1].into()),
    ];
    out.section("Numbers").table(
        "forms",
        format!(
            "Greatest differences over the run, the gust held and ended at {} s, and of the eigenvalues of the machine's linear models. A gust that ends is nothing to the α form.",
            GUST_ENDS.secs()
        ),
        Table::of(&columns, all),
    );
    let responses = worst_of(all.iter().flat_map(|a| a.held));
    out.check(
        "responses",
        format!(
            "under a held gust both forms answer alike: worst {responses:.1e} of the greatest value"
        ),
        responses < WITHIN,
    );
    let roots = worst_of(all.iter().map(|a| a.roots));
    out.check(
        "eigenvalues",
        format!("and have the same eigenvalues: worst {roots:.1e}"),
        roots < ROOTS_WITHIN,
    );
    if let Some(shown) = all.iter().max_by(|a, b| a.pressure_pa.total_cmp(&b.pressure_pa)) {
        figures(shown, sample_s, &mut out);
    }
    out
}

fn figures(shown: &Apart, sample_s: f64, out: &mut Outcome) {
    for (channel, label, unit, factor) in [
        (1, "Angle of attack", "°", 1f64.to_degrees()),
        (2, "Drift rate", "m/s", 1.0),
        (0, "Pitch attitude", "°", 1f64.to_degrees()),
    ] {
        let mut series = Vec::new();
        for (form, of_form) in ["drift form", "α form"].into_iter().zip(&shown.answers) {
            for (gust, responses) in ["gust held", "gust ended"].into_iter().zip(of_form) {
                let points = responses[channel].iter().enumerate();
                let points = points.map(|(n, v)| (n as f64 * sample_s, factor * v));
                series.push(Series::of(format!("{form}, {gust}"), points));
            }
        }
        let title = format!("{label} at {}", shown.point);
        let chart = LineChart::new(title, Axis::new("time", "s"), Axis::new(label, unit), series);
        out.section("Figures").chart(
            format!("forms-{}", CHANNELS[channel].replace('_', "-")),
            "Where the gust is held the curves of both forms lie on one another; where it ends only the drift form follows.",
            &chart,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The α form as shipped is the drift form as shipped with its flight path exchanged.
    #[test]
    fn the_shipped_alpha_form_is_the_drift_form_with_its_flight_path_exchanged() {
        for (name, text) in Form::Alpha.patch().files {
            if [ROOT, PLANE].contains(&name.as_str()) {
                let path = format!("{}/../patch-files/{name}", env!("CARGO_MANIFEST_DIR"));
                if std::env::var_os("GOLDEN").is_some_and(|v| v == "write") {
                    std::fs::write(&path, &text).unwrap();
                }
                let shipped = std::fs::read_to_string(&path).unwrap();
                let how = "GOLDEN=write cargo test --release -p digital-proc --lib forms";
                assert!(shipped == text, "{name} is not that of the drift form; `{how}` writes it");
            }
        }
    }

    /// What is exchanged is there, and nothing of the drift form is left.
    #[test]
    fn the_alpha_form_integrates_alpha_and_not_the_drift() {
        let text = alpha_plane(&Patches::shipped().pitch.files[1].1);
        for (line, times) in [
            ("alpha = { kind = \"integrator\"", 1),
            ("drift_rate = { kind = \"dcu\", channel = 3", 1),
            ("drift_angle", 0),
            ("in = [\"drift_acceleration\"], ic", 0),
        ] {
            assert_eq!(text.matches(line).count(), times, "{line}");
        }
    }
}
