//! What the partition does to the flight: the same stage with α sampled, α redundant, or all
//! control digital.
//!
//! Three machines are made of the shipped stage patch, by exchanging single blocks:
//! * *redundant α*: the patch as it is; α is continuous, aerodynamic slopes come in fast frames;
//! * *conventional α*: the digital side computes α from the sampled attitude and its own
//!   flight-path angle, and a DAC holds it for the rotational equations;
//! * *digital control*: attitude and gyros are sampled, and errors, bending filter, gains and dead
//!   zone are computed by the digital side, which sends commands to tips and injection.
//!
//! Everything digital runs once a frame T and takes effect one frame late, except that the
//! redundant machine has five fast frames in T, as the paper's scheme has. Damping is that of the
//! answer to a small step of the attitude command at 20 s, found as the difference of two flights;
//! a flight is lost in pitch where the attitude is further than [`LOST_RAD`] from its command, and
//! ends there; it is lost in roll where it has rolled so far, and goes on, as does a flight whose
//! roll control has failed.
//!
//! Beside the machines stand *ways*: the redundant machine with an option of the flight, as `fly`
//! has them, so that what the laboratory finds of figure 1 for β, of axes and of function
//! generation is seen in flight.
//!
//! Long, since it brings machines and a law of its own, which no other experiment shares.

use super::{identify, modal_fit::ModalFit, *};
use crate::{
    flight::{
        AlphaPath, AxesName, FlightFault, FlightPlan, FrameResult, FunctionGeneration, Observer,
        Options, Stage, Timing, channels::StageChannels, replace_block, stage_patch,
    },
    linkage::{console::Console, executive::Rate},
};
use desk::run_dir::RunDirError;
use interface::{
    control::{ChannelKind, PatchBundle},
    frame::{ModeCommand, Samples, Updates},
    profile::Profile,
};
use std::path::PathBuf;
use vehicle::{Vehicle, flight_mode::FlightMode, reference::FlightCase};

/// A flight further than this from its command is lost, rad (20 degrees).
const LOST_RAD: f64 = 0.349_065_850_398_865_9;
/// Step of the attitude command for the damping, rad (0.1 degree): small against the dead zone and
/// the travel of the tips.
const STEP_RAD: f64 = 1.745_329_251_994_329_5e-3;
/// When it is given, s.
const STEP_AT_S: f64 = 20.0;
/// How long the answer is looked at, s: gains and plant change little in it.
const WINDOW_S: f64 = 5.0;
/// What the modes of an answer may leave of it (rms over rms) for a damping to be told. Machines
/// that are one slowly changing loop leave 0.001 to 0.01; with all control digital at 100 ms, where
/// the roll loop takes travel from the tips, 0.11 (ζ still within the loop's own 0.44 to 0.37); at
/// 150 and 200 ms, where the tips do little but swing, 0.4 and 0.6: no decay at all.
const WORST_FIT: f64 = 0.2;
/// Slowest sampling of the answer that still shows the loop of about 5 rad/s, s.
const ANSWER_PERIOD_S: f64 = 0.05;

/// The long-period flight with sampled alpha, redundant alpha and all control digital
///
/// The long-period flight on three machines, over the frame period: alpha redundant, alpha
/// conventionally sampled, and all control digital.
///
/// Wind and misalignments are those of the design case. The damping of the pitch loop comes from a
/// small step of the attitude command at 20 s, as the difference of two flights. Digital parts take
/// effect one frame late; the redundant machine has five fast frames in a frame. A flight is lost
/// in roll where it has rolled by 20 degrees, and in pitch, where it ends, where the attitude leaves
/// its command by as much. No damping is told of an answer that is no decay.
#[derive(clap::Args)]
pub struct Flight {
    /// Frame periods
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "5ms,10ms,20ms,50ms,100ms,150ms,200ms",
        value_name = "TIME"
    )]
    frame: Vec<Tick>,
    /// End of each flight, after 25 s
    #[arg(long, default_value = "40s", value_name = "TIME")]
    until: Tick,
    /// Vehicle data set of your own [default: the shipped first stage]
    #[arg(long, value_name = "FILE")]
    vehicle: Option<PathBuf>,
}

interface::named! {
    /// In the order of the tables.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Partition, name {
        /// Redundant analog integrator, five fast frames in T.
        RedundantAlpha "redundant α"
        /// α computed digitally and held.
        ConventionalAlpha "conventional α"
        /// All control laws digital.
        DigitalControl "digital control"
    }
}

impl Partition {
    /// The stage patch with this machine's blocks in place of the shipped ones.
    fn patch(self) -> PatchBundle {
        let mut bundle = stage_patch();
        let Some((_, text)) = bundle.files.first_mut() else {
            return bundle;
        };
        match self {
            Partition::RedundantAlpha => {}
            Partition::ConventionalAlpha => {
                *text = replace_block(
                    text,
                    "alpha_held",
                    "{ kind = \"dac\", channel = 20, max = 1.0, note = \"angle of attack from the digital side\" }",
                );
            }
            Partition::DigitalControl => {
                for (name, block) in [
                    ("limit_p", "{ kind = \"limiter\", in = [\"tvc_p\"], limit = \"force_max\" }"),
                    ("limit_y", "{ kind = \"limiter\", in = [\"tvc_y\"], limit = \"force_max\" }"),
                ] {
                    *text = replace_block(text, name, block);
                }
                for command in ["u_pitch", "u_2", "u_4"] {
                    *text = text.replace(
                        &format!("in = {{ command = \"{command}\" }}"),
                        &format!("in = {{ command = \"digital_{command}\" }}"),
                    );
                }
                *text = text.replace("[integration]", DIGITAL_BLOCKS);
            }
        }
        bundle
    }
}

/// A way in which the redundant machine shares out its work otherwise.
#[derive(Clone, Copy, Debug)]
struct Way {
    name: &'static str,
    options: Options,
    /// Fast frames in T.
    fast: u64,
}

const WAYS: [Way; 5] = [
    Way { name: "as shipped", options: Options::NONE, fast: 5 },
    Way {
        name: "β redundant",
        options: Options { beta: AlphaPath::Redundant, ..Options::NONE },
        fast: 5,
    },
    Way { name: "H frame", options: Options { axes: AxesName::HFrame, ..Options::NONE }, fast: 5 },
    Way {
        name: "moments digital, fast frames",
        options: Options { functions: FunctionGeneration::Digital, ..Options::NONE },
        fast: 5,
    },
    Way {
        name: "moments digital, slow frames",
        options: Options { functions: FunctionGeneration::Digital, ..Options::NONE },
        fast: 1,
    },
];

/// Channels of the digital control: commands out, gyros in.
const DIGITAL_BLOCKS: &str = r#"
digital_u_pitch = { kind = "dac", channel = 21, max = 1.0 }
digital_u_2     = { kind = "dac", channel = 22, max = 1.0 }
digital_u_4     = { kind = "dac", channel = 23, max = 1.0 }
tvc_p           = { kind = "dac", channel = 24, max = 1e6 }
tvc_y           = { kind = "dac", channel = 25, max = 1e6 }
adc_gyro_q      = { kind = "adc", channel = 15, in = ["gyro_q.y"], max = 2.0 }
adc_gyro_r      = { kind = "adc", channel = 16, in = ["gyro_r.y"], max = 2.0 }
adc_gyro_p      = { kind = "adc", channel = 17, in = ["gyro_p.y"], max = 5.0 }

[integration]"#;

/// The further digital task of a machine, and what its flight comes to.
struct Task {
    partition: Partition,
    slow: Rate,
    frame_s: f64,
    filter_s: f64,
    filtered: [f64; 2],
    theta_c: usize,
    step_rad: f64,
    channels: Extra,
    flown: Flown,
}

/// Channels beyond those of the shipped patch.
#[derive(Clone, Copy, Debug, Default)]
struct Extra {
    alpha: usize,
    tips: [usize; 3],
    tvc: [usize; 2],
    gyro: [usize; 3],
}

impl Extra {
    fn resolve(console: &Console<'_>, partition: Partition) -> Result<Extra, FlightFault> {
        let dac = |name| console.channel(ChannelKind::Dac, name);
        let adc = |name| console.channel(ChannelKind::Adc, name);
        Ok(match partition {
            Partition::RedundantAlpha => Extra::default(),
            Partition::ConventionalAlpha => Extra { alpha: dac("alpha_held")?, ..Extra::default() },
            Partition::DigitalControl => Extra {
                alpha: 0,
                tips: [dac("digital_u_pitch")?, dac("digital_u_2")?, dac("digital_u_4")?],
                tvc: [dac("tvc_p")?, dac("tvc_y")?],
                gyro: [adc("adc_gyro_q")?, adc("adc_gyro_r")?, adc("adc_gyro_p")?],
            },
        })
    }
}

impl Observer for Task {
    fn task(&mut self, samples: &Samples, result: &FrameResult, updates: &mut Updates) {
        let command = result.sample.pitch_command_rad
            + if result.sample.time_s >= STEP_AT_S { self.step_rad } else { 0.0 };
        updates.set_dac(self.theta_c, command);
        match self.partition {
            Partition::RedundantAlpha => {}
            Partition::ConventionalAlpha => {
                updates.set_dac(self.channels.alpha, result.sample.incidence_rad);
            }
            Partition::DigitalControl => self.control(samples, result, command, updates),
        }
        let away = (result.sample.angle_rad[0] - result.sample.pitch_command_rad).abs();
        if away > LOST_RAD || away.is_nan() {
            self.flown.lost = true;
            updates.mode = ModeCommand::End as u32;
            updates.effective = samples.tick;
        }
    }

    fn flown(&mut self, samples: &Samples, result: &FrameResult) -> Result<(), RunDirError> {
        let (s, flown) = (&result.sample, &mut self.flown);
        if self.slow.due(samples.frame) {
            flown.pitch_rad.push(s.angle_rad[0]);
        }
        let away = (s.angle_rad[0] - s.pitch_command_rad).abs();
        flown.worst_error_rad = flown.worst_error_rad.max(away);
        let roll = result.attitude.angle_rad[2].abs();
        flown.worst_roll_rad = flown.worst_roll_rad.max(roll);
        if roll > LOST_RAD {
            flown.lost_in_roll_s.get_or_insert(s.time_s);
        }
        flown.end_s = s.time_s;
        flown.path_angle_rad = s.trajectory.path_angle_rad;
        let apart = (result.attitude.yaw_incidence_rad - s.yaw_incidence_rad).abs();
        flown.worst_yaw_incidence_rad = flown.worst_yaw_incidence_rad.max(apart);
        Ok(())
    }
}

impl Task {
    /// Errors, bending filter, gains and dead zone, as the analog blocks have them.
    fn control(
        &mut self,
        samples: &Samples,
        result: &FrameResult,
        command: f64,
        updates: &mut Updates,
    ) {
        let [theta, psi, phi] = result.attitude.angle_rad;
        let [q, r, p] = self.channels.gyro.map(|n| samples.adc[n]);
        let (s, c) = libm::sincos(phi);
        let (error_theta, error_psi) = (command - theta, -psi);
        let errors = [error_theta * c + error_psi * s, error_psi * c - error_theta * s];
        let settings = &result.settings;
        let gains = &settings.gains;
        // The lag's answer to a held input over one frame.
        let keep = libm::exp(-self.frame_s / self.filter_s);
        let mut tvc = [0.0; 2];
        for (i, rate) in [q, r].into_iter().enumerate() {
            let input = errors[i] - gains.ftc_lead_s * rate;
            self.filtered[i] = keep * self.filtered[i] + (1.0 - keep) * input;
            let e = errors[i] - gains.tvc_lead_s * rate;
            let beyond = e - e.clamp(-gains.dead_zone_rad, gains.dead_zone_rad);
            tvc[i] = gains.tvc_gain_nprad * beyond;
        }
        let u = self.filtered.map(|f| gains.ftc_gain * f);
        let roll = settings.roll_gain * (-phi - settings.roll_lead_s * p);
        for (channel, value) in self
            .channels
            .tips
            .into_iter()
            .zip([u[0], u[1] + roll, u[1] - roll])
            .chain(self.channels.tvc.into_iter().zip(tvc))
        {
            updates.set_dac(channel, value);
        }
    }
}

#[derive(Default)]
struct Flown {
    /// θ at the frames of T, rad.
    pitch_rad: Vec<f64>,
    /// Greatest |Qα|, Pa·deg.
    max_q_alpha_padeg: f64,
    /// Greatest |θ − θ_c|, rad.
    worst_error_rad: f64,
    /// Greatest |φ|, rad.
    worst_roll_rad: f64,
    /// When |φ| first was beyond [`LOST_RAD`], s.
    lost_in_roll_s: Option<f64>,
    /// Whether the flight ended because θ was.
    lost: bool,
    end_s: f64,
    /// γ at the end, rad.
    path_angle_rad: f64,
    /// Greatest distance of the α_y that the rotational equations have from the true one, rad.
    worst_yaw_incidence_rad: f64,
}

impl Flown {
    /// What became of the flight.
    fn words(&self) -> String {
        let of = |axis: &str, t: f64| format!("lost in {axis} at {t:.1} s");
        let roll = self.lost_in_roll_s.map(|t| of("roll", t));
        let pitch = self.lost.then(|| of("pitch", self.end_s));
        let lost: Vec<String> = roll.into_iter().chain(pitch).collect();
        if lost.is_empty() { "held".to_owned() } else { lost.join(", ") }
    }
}

/// A machine at one frame, from a flight and a flight with a step.
struct Row {
    machine: Partition,
    frame_s: f64,
    /// Root of the answer to the step, if it oscillates and the flight came so far.
    root: Option<C64>,
    flown: Flown,
    /// The design limit of |Qα|, Pa·deg.
    limit_padeg: f64,
}

impl Row {
    fn max_q_alpha_kpadeg(&self) -> f64 {
        1e-3 * self.flown.max_q_alpha_padeg
    }
}

impl Flight {
    /// Flies one machine; a lost flight is a result.
    fn fly(
        &self,
        console: &mut Console<'_>,
        (vehicle, case): (&Vehicle, &FlightCase),
        (partition, way): (Partition, Way),
        frame: Tick,
        step_rad: f64,
    ) -> Result<Flown, FlightFault> {
        let fast = if partition == Partition::RedundantAlpha { way.fast } else { 1 };
        let slow = Rate::every(fast).unwrap_or(Rate::FAST);
        let fast_frame = slow
            .fast_period(frame)
            .ok_or(FlightFault::Periods { step: frame, fast_frames: fast })?;
        let plan = FlightPlan {
            case: case.clone(),
            step: frame,
            slow,
            latency: fast_frame,
            skew: Tick::ZERO,
            stop: self.until,
            alpha: match partition {
                Partition::ConventionalAlpha => AlphaPath::Held,
                _ => AlphaPath::Redundant,
            },
            options: way.options,
            profile: Profile::ideal(),
        };
        let patch = match partition {
            Partition::RedundantAlpha => way.options.patch(),
            _ => partition.patch(),
        };
        let mut stage = Stage::load_patch(console, vehicle, &plan.profile, patch)?;
        let theta_c = StageChannels::resolve(console)?.dac.theta_c;
        let mut task = Task {
            partition,
            frame_s: frame.secs(),
            filter_s: 1.0 / vehicle.data().bending.filter_corner_radps,
            filtered: [0.0; 2],
            theta_c,
            step_rad,
            channels: Extra::resolve(console, partition)?,
            slow,
            flown: Flown::default(),
        };
        match stage.fly(console, vehicle, &plan, Timing::LockStep, &mut task) {
            Ok(summary) => task.flown.max_q_alpha_padeg = summary.max_q_alpha.value,
            // A tumbling stage leaves the trajectory's range: lost as well.
            Err(FlightFault::Trajectory(_)) => task.flown.lost = true,
            Err(fault) => return Err(fault),
        }
        Ok(task.flown)
    }

    /// Two flights of one machine: damping, loads, and whether it holds.
    fn run(
        &self,
        bench: &mut Bench<'_, '_>,
        flight: (&Vehicle, &FlightCase),
        (machine, way): (Partition, Way),
        frame: Tick,
    ) -> Result<Row, LabError> {
        let console = bench.console(&stage_patch().root);
        let flown = self.fly(console, flight, (machine, way), frame, 0.0)?;
        let stepped = self.fly(console, flight, (machine, way), frame, STEP_RAD)?;
        let frame_s = frame.secs();
        let from = (STEP_AT_S / frame_s).ceil() as usize + 1;
        let window = (WINDOW_S / frame_s).ceil() as usize;
        let both = flown.pitch_rad.iter().zip(&stepped.pitch_rad);
        let answer: Vec<f64> = both.skip(from).take(window).map(|(a, b)| b - a).collect();
        let limit_padeg = flight.0.data().limits.q_alpha_padeg;
        Ok(Row { machine, frame_s, root: dominant(&answer, frame_s), flown, limit_padeg })
    }
}

/// The oscillation of an answer between 1 and 15 rad/s that has the most energy; the plant's slow
/// change stands below the floor of 1e-3. None where the modes do not describe the answer.
fn dominant(answer: &[f64], frame_s: f64) -> Option<C64> {
    let stride = (ANSWER_PERIOD_S / frame_s).round().max(1.0) as usize;
    let thinned: Vec<f64> = answer.iter().step_by(stride).copied().collect();
    let changes: Vec<f64> = thinned.windows(2).map(|w| w[1] - w[0]).collect();
    let period_s = stride as f64 * frame_s;
    // As in a loop study: modes of the first two thirds, judged on all.
    let part = changes.get(..(2 * changes.len() / 3).max(identify::SHORTEST))?;
    let fit = ModalFit::new(&changes, &identify::factors(part, 1e-3).ok()?)?;
    if fit.residual > WORST_FIT {
        return None;
    }
    let roots = identify::poles(&changes, period_s, 1e-3).ok()?;
    identify::strongest(&changes, period_s, &roots, |s| {
        s.im > 0.0 && (1.0..15.0).contains(&s.modulus())
    })
}

impl Experiment for Flight {
    const NAME: &'static str = "flight";
    const TITLE: &'static str = "The flight against the frame period";
    const LEAD: &'static str = "The same stage in the same wind on three machines: what is sampled \
        decides what frame period the flight can bear.";

    fn measure(&self, bench: &mut Bench<'_, '_>, outcome: &mut Outcome) -> Result<(), Failure> {
        let own = self.vehicle.as_deref().map(Vehicle::load);
        let vehicle = own.unwrap_or_else(Vehicle::shipped)?;
        if self.until < Tick::SECOND * 25 {
            return Err(Failure::input(
                "--until must be at least 25s, the step of the command comes at 20 s",
            ));
        }
        if let Some(bad) = self.frame.iter().find(|f| f.0 < 1_000_000 || f.0 > 500_000_000) {
            return Err(Failure::input(format!("--frame {bad} is not between 1ms and 500ms")));
        }
        let case =
            FlightCase::design(&vehicle, FlightMode::Normal.script()).map_err(Failure::input)?;
        outcome.set("until", self.until.to_string());
        let cases = Partition::ALL.into_iter().flat_map(|m| self.frame.iter().map(move |f| (m, f)));
        let rows = bench.each(cases, |bench, (machine, frame)| {
            self.run(bench, (&vehicle, &case), (machine, WAYS[0]), *frame)
        })?;
        let columns = [
            Column::new("machine", "", |r: &Row| r.machine.name().into()),
            Column::new("frame", "ms", |r| (1e3 * r.frame_s).into()),
            Column::new("flight", "", |r| r.flown.words().into()),
            Column::of("zeta", "", 3, |r| r.root.map(damping_ratio).into()),
            Column::of("omega", "rad/s", 3, |r| r.root.map(|s| s.modulus()).into()),
            Column::new("greatest Q alpha", "kPa deg", |r| r.max_q_alpha_kpadeg().into()),
            Column::of("of the limit", "%", 3, |r| {
                (100.0 * r.flown.max_q_alpha_padeg / r.limit_padeg).into()
            }),
            Column::of("greatest attitude error", "deg", 3, |r| {
                r.flown.worst_error_rad.to_degrees().into()
            }),
            Column::of("greatest roll", "deg", 3, |r| r.flown.worst_roll_rad.to_degrees().into()),
        ];
        let caption = "Three machines over the frame period.";
        outcome.section("Numbers").table("flight", caption, Table::of(&columns, &rows));
        let chart = |title: &str, y: Axis, value: fn(&Row) -> f64| {
            let series = Partition::ALL.map(|machine| {
                let of = rows.iter().filter(|r| r.machine == machine);
                let points = of.map(|r| (1e3 * r.frame_s, value(r)));
                Series::of(machine.name(), points).draw(Draw::LineAndMarkers)
            });
            LineChart::new(title, Axis::new("frame period", "ms").log(), y, series.into())
        };
        let limit = 1e-3 * vehicle.data().limits.q_alpha_padeg;
        let q_alpha = Axis::new("greatest |Qα|", "kPa·°").log();
        for (id, caption, chart) in [
            (
                "damping",
                "Damping of the pitch loop at 20 s, from the answer to a small step of the command; a missing marker is an answer that is no decay, or one without an oscillation between 1 and 15 rad/s.",
                chart("What may be digital", damping_axis(), |r| {
                    r.root.map_or(f64::NAN, damping_ratio)
                })
                .limit(0.0, "stability"),
            ),
            (
                "q-alpha",
                "Greatest |Qα| of the flight; a lost flight counts up to where it was lost.",
                chart("Load indicator Qα", q_alpha, Row::max_q_alpha_kpadeg)
                    .limit(limit, "design limit"),
            ),
            (
                "attitude-error",
                "Greatest distance of the pitch attitude from its command; a flight is lost at 20°.",
                chart("Attitude error", Axis::new("greatest |θ − θc|", "°").log(), |r| {
                    r.flown.worst_error_rad.to_degrees()
                }),
            ),
            (
                "roll",
                "Greatest roll angle. The roll loop is the fastest of the three: sampled one frame late it oscillates long before the pitch loop is lost, within the limits of its tips, and takes their travel from pitch and yaw.",
                chart("Roll", Axis::new("greatest |φ|", "°").log(), |r| {
                    r.flown.worst_roll_rad.to_degrees()
                }),
            ),
        ] {
            outcome.section("Figures").chart(id, caption, &chart);
        }
        self.ways(bench, (&vehicle, &case), outcome)
    }
}

impl Flight {
    /// The redundant machine with the options of a flight.
    fn ways(
        &self,
        bench: &mut Bench<'_, '_>,
        flight: (&Vehicle, &FlightCase),
        outcome: &mut Outcome,
    ) -> Result<(), Failure> {
        let cases = WAYS.into_iter().flat_map(|way| self.frame.iter().map(move |f| (way, f)));
        let rows = bench.each(cases, |bench, (way, frame)| {
            let row = self.run(bench, flight, (Partition::RedundantAlpha, way), *frame)?;
            Ok::<_, LabError>((way.name, row))
        })?;
        let columns = [
            Column::new("way", "", |(name, _): &(&str, Row)| (*name).into()),
            Column::new("frame", "ms", |(_, r)| (1e3 * r.frame_s).into()),
            Column::new("flight", "", |(_, r)| r.flown.words().into()),
            Column::of("zeta", "", 3, |(_, r)| r.root.map(damping_ratio).into()),
            Column::new("greatest Q alpha", "kPa deg", |(_, r)| r.max_q_alpha_kpadeg().into()),
            Column::of("greatest error of alpha_y", "deg", 3, |(_, r)| {
                r.flown.worst_yaw_incidence_rad.to_degrees().into()
            }),
            Column::of("path angle at the end", "deg", 6, |(_, r)| {
                r.flown.path_angle_rad.to_degrees().into()
            }),
        ];
        let caption = "The machine with redundant α, its work shared out otherwise: yaw incidence by a redundant integrator too, translation in the H frame, aerodynamic moments formed on the digital side at sampled angles in place of slopes times the angle.";
        outcome.section("Numbers").table("ways", caption, Table::of(&columns, &rows));
        let series = WAYS.map(|way| {
            let of = rows.iter().filter(|(name, _)| *name == way.name);
            let points = of.map(|(_, r)| (1e3 * r.frame_s, r.root.map_or(f64::NAN, damping_ratio)));
            Series::of(way.name, points).draw(Draw::LineAndMarkers)
        });
        let x = Axis::new("frame period", "ms").log();
        let chart = LineChart::new("Options of a flight", x, damping_axis(), series.into());
        let caption = "Damping of the pitch loop at 20 s. Moments formed at a sampled angle cost phase, hybrid function generation none.";
        outcome.section("Figures").chart("ways", caption, &chart);
        Ok(())
    }
}
