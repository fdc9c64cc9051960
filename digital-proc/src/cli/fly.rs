//! `digital-proc fly`: one long-period flight.

use super::{Context, Failure, LinkName, MachineArgs};
use crate::{
    console::Console,
    executive::Rate,
    flight::{self, AlphaPath, FlightFault, FlightPlan, trace},
    flight_mode::FlightMode,
    flight_summary::FlightSummary,
    progress::Progress,
    reference::FlightCase,
    report::flight_report,
    run_dir::{DEFAULT_BASE, PatchIdentity, RunDirectory, RunRecord, UtcSecond},
    vehicle::Vehicle,
    wind::{Wind, WindDirection},
};
use clap::ValueEnum;
use interface::{Tick, profile::Profile};
use std::{collections::BTreeMap, path::PathBuf, time::SystemTime};

/// Rows in one batch of the trace: what a crash may cost.
const BATCH_ROWS: usize = 64;

/// Fly the first stage from lift-off to burn-out.
#[derive(clap::Args)]
pub struct Fly {
    /// Mode of operation; a failure acts from --failure-at on
    #[arg(long, value_parser = flight_mode, default_value = "normal", value_name = "MODE",
          help = format!("Mode of operation: {}", FlightMode::ALL.map(FlightMode::name).join(", ")))]
    mode: FlightMode,
    /// Trajectory step, the slow frame of the digital side
    #[arg(long, default_value = "100ms", value_name = "TIME")]
    frame: Tick,
    /// Fast frames (aerodynamic functions) in one trajectory step
    #[arg(long, default_value_t = 5, value_name = "N")]
    fast: u64,
    /// Latency from sample to transfer, at most one fast frame [default: the profile's]
    #[arg(long, value_name = "TIME")]
    latency: Option<Tick>,
    /// Multiplexer skew between neighbouring ADC channels [default: the profile's]
    #[arg(long, value_name = "TIME")]
    skew: Option<Tick>,
    /// Stop before burn-out
    #[arg(long, value_name = "TIME")]
    until: Option<Tick>,
    /// Wind in the pitch plane, with its share across
    #[arg(long, value_enum, default_value = "none")]
    wind: WindName,
    /// Thrust misalignment in pitch, as a fraction of 3 sigma
    #[arg(long, default_value_t = 0.0, value_name = "FRACTION", allow_negative_numbers = true)]
    misalign_pitch: f64,
    /// Thrust misalignment in yaw, as a fraction of 3 sigma
    #[arg(long, default_value_t = 0.0, value_name = "FRACTION", allow_negative_numbers = true)]
    misalign_yaw: f64,
    /// Wind and misalignments of the vehicle's design case for failure modes
    #[arg(long, conflicts_with_all = ["wind", "misalign_pitch", "misalign_yaw"])]
    design_case: bool,
    /// When a failure mode begins
    #[arg(long, default_value = "0s", value_name = "TIME")]
    failure_at: Tick,
    /// How the angle of attack reaches the rotational equations
    #[arg(long, value_enum, default_value = "redundant")]
    alpha: AlphaName,
    /// Vehicle data set of your own [default: the shipped first stage]
    #[arg(long, value_name = "FILE")]
    vehicle: Option<PathBuf>,
    /// Directory for runs; each run makes its own directory there
    #[arg(long, default_value = DEFAULT_BASE, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    machine: MachineArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum WindName {
    /// Calm
    None,
    /// The synthetic profile against the flight
    Headwind,
    /// The synthetic profile with the flight
    Tailwind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum AlphaName {
    /// Redundant analog integrator, corrected at the trajectory's rate
    Redundant,
    /// From the flight-path angle held over a trajectory step
    Held,
}

fn flight_mode(text: &str) -> Result<FlightMode, String> {
    FlightMode::from_name(text).ok_or_else(|| {
        let names = FlightMode::ALL.map(FlightMode::name);
        let nearest = names.iter().min_by_key(|n| strsim::damerau_levenshtein(n, text));
        format!(
            "no such mode; did you mean `{}`? The modes are {}",
            nearest.unwrap_or(&""),
            names.join(", ")
        )
    })
}

impl Fly {
    pub fn execute(self, context: &Context) -> Result<(), Failure> {
        let vehicle = match &self.vehicle {
            Some(path) => Vehicle::load(path),
            None => Vehicle::shipped(),
        }
        .map_err(Failure::input)?;
        let plan = self.plan(&vehicle)?;
        let started = UtcSecond::from_system(SystemTime::now());
        let mut machine = self.machine.start(context)?;
        let mut console = Console::open(machine.port())?;

        let directory = RunDirectory::create(&self.out, &format!("fly-{}", self.mode.name()), started)
            .map_err(Failure::input)?;
        let keep = |failure: Failure| {
            failure.and(format!("what was recorded up to there is in {}", directory.path().display()))
        };
        let mut rows = directory
            .create_trace(&trace::columns(), BATCH_ROWS)
            .map_err(Failure::input)?;
        let stop_s = plan.stop.secs();
        let mut progress = Progress::new(stop_s as u64, "s of flight");
        let mut samples = Vec::with_capacity(1 << 12);
        let flown = flight::fly(&mut console, &vehicle, &plan, |frame, result| {
            progress.at(result.sample.time_s as u64);
            samples.push(result.sample);
            rows.push(frame.tick, &trace::row(frame, result))
                .map_err(|e| FlightFault::Observer(e.to_string()))
        });
        progress.done();
        let record = self.record(&vehicle, &plan, started, console.patch_hash());
        directory.write_record(&record).map_err(Failure::input)?;
        let closed = rows.finish();
        let summary = flown.map_err(|fault| keep(fault.into()))?;
        closed.map_err(Failure::input)?;
        let overloads = console.diagnose()?.overloads;
        console.bye()?;
        drop(machine);

        directory.write_summary(&summary_json(&plan, &vehicle, &summary)).map_err(Failure::input)?;
        let html = flight_report::render(&vehicle, &record, &summary, &samples);
        let report = directory.write_report(&html).map_err(Failure::input)?;
        if self.machine.json {
            println!("{:#}", summary_json(&plan, &vehicle, &summary));
        } else {
            println!("{}", flight_report::screen(self.mode, &vehicle, &summary));
            for o in &overloads {
                println!("overload: {} at {:.4} s ({:.4})", o.block, o.time_s, o.value);
            }
            println!("report: {}", report.display());
        }
        Ok(())
    }

    fn plan(&self, vehicle: &Vehicle) -> Result<FlightPlan, Failure> {
        let profile = Profile::named(&self.machine.profile).map_err(Failure::input)?;
        let mut case = if self.design_case {
            FlightCase::design(vehicle, self.mode).map_err(Failure::input)?
        } else {
            let wind = match self.wind {
                WindName::None => Wind::Calm,
                WindName::Headwind => Wind::synthetic(vehicle, WindDirection::Head).map_err(Failure::input)?,
                WindName::Tailwind => Wind::synthetic(vehicle, WindDirection::Tail).map_err(Failure::input)?,
            };
            FlightCase {
                mode: self.mode,
                wind,
                pitch_misalignment: self.misalign_pitch,
                yaw_misalignment: self.misalign_yaw,
                ..FlightCase::undisturbed()
            }
        };
        case.failure_start_s = self.failure_at.secs();
        let finite = [case.pitch_misalignment, case.yaw_misalignment].iter().all(|m| m.is_finite());
        if !finite {
            return Err(Failure::input("--misalign-pitch and --misalign-yaw must be finite"));
        }
        let slow = Rate::every(self.fast)
            .ok_or_else(|| Failure::input("--fast must be at least 1"))?;
        let burn_out = Tick::from_secs(vehicle.data().mass.burn_time_s)
            .ok_or_else(|| Failure::input("the vehicle's burn time is out of range"))?;
        let fast_frame = slow.fast_period(self.frame).filter(|t| *t > Tick::ZERO).ok_or_else(|| {
            Failure::input(format!(
                "--frame {} is not {} fast frames of whole nanoseconds; choose another --frame or --fast",
                self.frame, self.fast
            ))
        })?;
        let latency = self.latency.unwrap_or_else(|| profile.latency().min(fast_frame));
        Ok(FlightPlan {
            case,
            step: self.frame,
            slow,
            latency,
            skew: self.skew.unwrap_or_else(|| profile.skew()),
            stop: self.until.map_or(burn_out, |t| t.min(burn_out)),
            alpha: match self.alpha {
                AlphaName::Redundant => AlphaPath::Redundant,
                AlphaName::Held => AlphaPath::Held,
            },
            profile,
        })
    }

    fn record(
        &self,
        vehicle: &Vehicle,
        plan: &FlightPlan,
        started: UtcSecond,
        patch_hash: &str,
    ) -> RunRecord {
        let mut parameters = toml::Table::new();
        let mut set = |name: &str, value: toml::Value| parameters.insert(name.to_owned(), value);
        set("mode", self.mode.name().into());
        set("frame", plan.step.to_string().into());
        set("fast", (self.fast as i64).into());
        set("latency", plan.latency.to_string().into());
        set("skew", plan.skew.to_string().into());
        set("stop", plan.stop.to_string().into());
        set("misalign-pitch", plan.case.pitch_misalignment.into());
        set("misalign-yaw", plan.case.yaw_misalignment.into());
        set("failure-at", plan.case.failure_start_s.into());
        set("alpha", format!("{:?}", plan.alpha).to_lowercase().into());
        let wind = match self.wind {
            _ if self.design_case => "design-case",
            WindName::None => "none",
            WindName::Headwind => "headwind",
            WindName::Tailwind => "tailwind",
        };
        set("wind", wind.into());
        if let Ok(data) = toml::Value::try_from(vehicle.data()) {
            set("vehicle", data);
        }
        let link = match (&self.machine.attach, self.machine.link) {
            (Some(_), _) | (None, LinkName::Shm) => "shm",
            (None, LinkName::Memory) => "memory",
        };
        RunRecord {
            command: format!("fly {}", self.mode.name()),
            command_line: std::env::args().collect(),
            started: started.to_string(),
            profile: plan.profile.name.clone(),
            link: link.to_owned(),
            versions: BTreeMap::from([(
                "hybrid-computer".to_owned(),
                env!("CARGO_PKG_VERSION").to_owned(),
            )]),
            patch: Some(PatchIdentity {
                name: "long-period.toml".to_owned(),
                sha256: patch_hash.to_owned(),
            }),
            seeds: BTreeMap::new(),
            parameters,
        }
    }
}

impl From<FlightFault> for Failure {
    fn from(fault: FlightFault) -> Failure {
        match fault {
            FlightFault::Console(fault) => fault.into(),
            other => Failure::input(other),
        }
    }
}

/// The summary for machines, SI units and degrees in the names.
fn summary_json(plan: &FlightPlan, vehicle: &Vehicle, s: &FlightSummary) -> serde_json::Value {
    serde_json::json!({
        "mode": plan.case.mode.name(),
        "max-q": {
            "pa": s.max_dynamic_pressure.value,
            "time-s": s.max_dynamic_pressure.time_s,
            "mach": s.max_dynamic_pressure.mach,
            "altitude-m": s.max_dynamic_pressure.altitude_m,
        },
        "burn-out": {
            "time-s": s.end_time_s,
            "velocity-mps": s.end.speed_mps,
            "flight-path-angle-deg": s.end.path_angle_rad.to_degrees(),
            "altitude-m": s.end.altitude_m,
            "range-m": s.range_m,
        },
        "max-q-alpha": {
            "pa-deg": s.max_q_alpha.value,
            "time-s": s.max_q_alpha.time_s,
            "limit-pa-deg": vehicle.data().limits.q_alpha_padeg,
        },
        "max-roll-deg": s.max_roll_rad.to_degrees(),
        "tvc-impulse-pitch-ns": s.tvc_pitch_impulse_ns,
        "tvc-impulse-yaw-ns": s.tvc_yaw_impulse_ns,
        "injectant-kg": s.injectant_kg,
        "table-edges": s.edges.iter().map(|(t, e)| format!("{} {e:?}", t.label())).collect::<Vec<_>>(),
    })
}
