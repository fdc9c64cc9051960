//! `digital-proc fly`: one long-period flight.

use super::{Context, MachineArgs, vehicle_args::VehicleArgs};
use crate::{
    console::Console,
    flight::{
        AlphaPath, FlightFault, Stage, Timing,
        channels::Sampled,
        plan_record::{Pace, PlanFault, PlanRecord, WindName},
        trace::{self, BATCH_ROWS, Recorder},
    },
    report::{
        flight::{FlightContext, flight_report},
        pacing::{pacing_section, pacing_text},
    },
};
use clap::ValueEnum;
use desk::failure::Failure;
use desk::{note, say};
use desk::{
    report::Summary,
    run_dir::{DEFAULT_BASE, PatchIdentity, RunDirectory, RunRecord, Seed, TRACE_FILE, UtcSecond},
};
use interface::{Tick, profile::Profile};
use std::{path::PathBuf, time::SystemTime};
use vehicle::{
    Vehicle, failure_file::FailureFile, flight_mode::FlightMode, flight_summary::FlightSummary,
};

/// Fly the first stage from lift-off to burn-out.
#[derive(clap::Args)]
pub struct Fly {
    /// Mode of operation
    #[arg(long, default_value = "normal", value_name = "MODE",
          help = format!("Mode of operation: {}, or one of --failures", FlightMode::ALL.map(FlightMode::name).join(", ")))]
    mode: String,
    /// Failure file of your own that scripts the modes [default: the shipped one]
    #[arg(long, value_name = "FILE")]
    failures: Option<PathBuf>,
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
    /// Who paces the flight; `digital-proc replay` repeats either to the last bit
    #[arg(long, value_enum, default_value = "lock-step")]
    clock: Pace,
    /// Stop before burn-out
    #[arg(long, value_name = "TIME")]
    until: Option<Tick>,
    /// Wind in the pitch plane, with its share across
    #[arg(long, value_enum, default_value = "none")]
    wind: WindName,
    /// Which member of the ensemble blows, with --wind ensemble
    #[arg(long, default_value_t = 0, value_name = "N")]
    seed: u64,
    /// Thrust misalignment in pitch, as a fraction of 3 sigma
    #[arg(long, default_value_t = 0.0, value_name = "FRACTION", allow_negative_numbers = true)]
    misalign_pitch: f64,
    /// Thrust misalignment in yaw, as a fraction of 3 sigma
    #[arg(long, default_value_t = 0.0, value_name = "FRACTION", allow_negative_numbers = true)]
    misalign_yaw: f64,
    /// Wind and misalignments of the vehicle's design case for failure modes
    #[arg(long, conflicts_with_all = ["wind", "misalign_pitch", "misalign_yaw"])]
    design_case: bool,
    /// No failure of the mode acts before this
    #[arg(long, default_value = "0s", value_name = "TIME")]
    failure_at: Tick,
    /// How the angle of attack reaches the rotational equations
    #[arg(long, value_enum, default_value = "redundant")]
    alpha: AlphaName,
    #[command(flatten)]
    vehicle: VehicleArgs,
    /// Directory for runs; each run makes its own directory there
    #[arg(long, default_value = DEFAULT_BASE, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    machine: MachineArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum AlphaName {
    /// Redundant analog integrator, corrected at the trajectory's rate
    Redundant,
    /// From the flight-path angle held over a trajectory step
    Held,
}

impl Fly {
    pub fn execute(self, context: &Context) -> Result<(), Failure> {
        let vehicle = self.vehicle.load()?;
        let plan_record = self.plan_record(&vehicle)?;
        let plan = plan_record.plan(&vehicle)?;
        let started = UtcSecond::from_system(SystemTime::now());
        let mut machine = self.machine.start(context)?;
        let mut console = Console::new(machine.port());
        let mut stage = Stage::load(&mut console, &vehicle, &plan.profile)?;

        let directory = RunDirectory::create(&self.out, &format!("fly-{}", self.mode), started)?;
        let keep = |failure: Failure| {
            failure
                .and(format!("what was recorded up to there is in {}", directory.path().display()))
        };
        let record = self.record(&plan_record, started, console.patch_hash())?;
        directory.write_record(&record)?;
        let rows = directory.create_stream(TRACE_FILE, &trace::columns(), BATCH_ROWS)?;
        let mut recorder = Recorder::new(rows, plan.stop);
        let timing = match self.clock {
            Pace::LockStep => Timing::LockStep,
            Pace::Wall => {
                recorder = recorder.paced(&directory, plan_record.fast_frame()?)?;
                Timing::Wall
            }
        };
        let flown = stage.fly(&mut console, &vehicle, &plan, timing, &mut recorder);
        let paced = recorder.pacing.clone();
        let kept = recorder.finish();
        let summary = flown.map_err(|fault| {
            let failure = keep(fault.into());
            match &paced {
                Some(pacing) => failure.and(pacing_text(pacing)),
                None => failure,
            }
        })?;
        let (pacing, saturations) = kept?;
        let overloads = console.diagnose()?.overloads;
        let saturated = saturations.names(console.channels());
        console.bye()?;
        drop(machine);

        let trace = directory.read_trace_thinned()?;
        let results = results(&vehicle, &summary);
        let mut json = results.json();
        let mut context = self.report_context(&vehicle);
        if let Some(pacing) = &pacing {
            json["pacing"] = pacing.json();
            context.further.push(pacing_section(pacing));
        }
        directory.write_summary(&json)?;
        let html = flight_report(&context, &results, &trace, &record).map_err(Failure::input)?;
        let report = directory.write_report(&html)?;
        if self.machine.json {
            say!("{json:#}");
        } else {
            say!("{}", context.title);
            say!("{}", results.text());
            for o in &overloads {
                say!("overload: {} at {:.4} s ({:.4})", o.block, o.time_s, o.value);
            }
            if !saturated.is_empty() {
                say!("saturated: {}", saturated.join(", "));
            }
            for (table, edge) in summary.edges.iter() {
                say!("table edge: {} {edge:?}; its end value was held", table.label());
            }
            if let Some(pacing) = &pacing {
                say!("{}", pacing_text(pacing).trim_end());
            }
            say!("report: {}", report.display());
        }
        Ok(())
    }

    fn report_context(&self, vehicle: &Vehicle) -> FlightContext {
        let case =
            if self.design_case { "; wind and misalignments of the design case" } else { "" };
        FlightContext {
            title: format!("First-stage flight, mode {}{case}", self.mode),
            lead: "Control dynamics on the analog processor, trajectory on the digital one, joined by sampled converters.".into(),
            q_alpha_limit_pa_rad: Some(vehicle.data().limits.q_alpha_padeg.to_radians()),
            marks: Vec::new(),
            further: Vec::new(),
        }
    }

    /// The command line as everything that the flight follows from.
    fn plan_record(&self, vehicle: &Vehicle) -> Result<PlanRecord, Failure> {
        let profile = Profile::load(&self.machine.profile).map_err(Failure::input)?;
        let own =
            self.failures.as_deref().map(FailureFile::load).transpose().map_err(Failure::input)?;
        let script = own
            .as_ref()
            .unwrap_or_else(|| FailureFile::shipped())
            .mode(&self.mode)
            .map_err(Failure::input)?;
        let data = vehicle.data();
        let burn_out = Tick::from_secs(data.mass.burn_time_s)
            .ok_or_else(|| Failure::input("the vehicle's burn time is out of range"))?;
        let case = &data.long_period_case;
        let (wind, misalign_pitch, misalign_yaw) = if self.design_case {
            (WindName::DesignCase, case.misalign_pitch, case.misalign_yaw)
        } else {
            (self.wind, self.misalign_pitch, self.misalign_yaw)
        };
        let mut record = PlanRecord {
            clock: self.clock,
            frame: self.frame,
            fast: self.fast,
            latency: Tick::ZERO,
            skew: self.skew.unwrap_or_else(|| profile.skew()),
            stop: self.until.map_or(burn_out, |t| t.min(burn_out)),
            alpha: match self.alpha {
                AlphaName::Redundant => AlphaPath::Redundant,
                AlphaName::Held => AlphaPath::Held,
            },
            wind,
            wind_seed: Seed(self.seed),
            misalign_pitch,
            misalign_yaw,
            failure_at: self.failure_at,
            mode: script.clone(),
            profile,
            vehicle: data.clone(),
        };
        let fast_frame = record.fast_frame()?;
        let (latency, whole) = record.profile.latency_within(Sampled::COUNT, fast_frame);
        record.latency = self.latency.unwrap_or(latency);
        if let (None, Some(whole)) = (self.latency, whole) {
            note!(
                "note: profile {} takes {whole} from sample to transfer, longer than a fast frame; flown with {latency}",
                record.profile.name
            );
        }
        if let Some(until) = self.until.filter(|t| *t > burn_out) {
            note!("note: the flight ends at burn-out, {burn_out}, before --until {until}");
        }
        Ok(record)
    }

    fn record(
        &self,
        plan: &PlanRecord,
        started: UtcSecond,
        patch_hash: &str,
    ) -> Result<RunRecord, Failure> {
        let command = format!("fly {}", self.mode);
        let link = self.machine.join.link_name();
        Ok(RunRecord {
            patch: Some(PatchIdentity {
                name: "long-period.toml".to_owned(),
                sha256: patch_hash.to_owned(),
            }),
            parameters: plan.to_parameters().map_err(Failure::input)?,
            ..RunRecord::begin(command, started, &plan.profile.name, link)
        })
    }
}

impl From<PlanFault> for Failure {
    fn from(fault: PlanFault) -> Failure {
        Failure::input(fault)
    }
}

impl From<FlightFault> for Failure {
    fn from(fault: FlightFault) -> Failure {
        match fault {
            FlightFault::Console(fault) => fault.into(),
            FlightFault::Trace(fault) => fault.into(),
            other => Failure::input(other),
        }
    }
}

/// The one-screen results of a flight.
fn results(vehicle: &Vehicle, s: &FlightSummary) -> Summary {
    let mut results = Summary::new();
    let mut add = |key: &str, label: &str, value: f64, digits: usize, unit: &str, note: String| {
        results.add(key, label, value, digits, unit, note);
    };
    let q = &s.max_dynamic_pressure;
    let at = format!("at {:.1} s, Mach {:.2}, {:.2} km", q.time_s, q.mach, q.altitude_m / 1e3);
    add("max_q_pa", "Maximum dynamic pressure", q.value, 5, "Pa", at);
    add("max_q_time_s", "  its time", q.time_s, 4, "s", String::new());
    add("max_q_mach", "  its Mach number", q.mach, 4, "", String::new());
    add("max_q_altitude_m", "  its altitude", q.altitude_m, 5, "m", String::new());
    let end = format!("at {:.2} s", s.end_time_s);
    add("burn_out_velocity_m_s", "Burn-out velocity", s.end.speed_mps, 6, "m/s", end);
    let gamma = s.end.path_angle_rad.to_degrees();
    add(
        "burn_out_flight_path_angle_deg",
        "Burn-out flight-path angle",
        gamma,
        5,
        "deg",
        String::new(),
    );
    add("burn_out_altitude_m", "Burn-out altitude", s.end.altitude_m, 6, "m", String::new());
    add("burn_out_range_m", "Burn-out range", s.range_m, 6, "m", String::new());
    let limit = vehicle.data().limits.q_alpha_padeg;
    let margin = format!(
        "at {:.1} s; {:.0} % of the limit {limit:.4e}",
        s.max_q_alpha.time_s,
        100.0 * s.max_q_alpha.value / limit
    );
    add("max_q_alpha_pa_deg", "Maximum Q alpha", s.max_q_alpha.value, 5, "Pa deg", margin);
    add("max_roll_deg", "Maximum roll", s.max_roll_rad.to_degrees(), 4, "deg", String::new());
    add(
        "tvc_impulse_pitch_n_s",
        "TVC impulse, pitch",
        s.tvc_pitch_impulse_ns,
        5,
        "N s",
        String::new(),
    );
    add("tvc_impulse_yaw_n_s", "TVC impulse, yaw", s.tvc_yaw_impulse_ns, 5, "N s", String::new());
    add("injectant_kg", "Injectant used", s.injectant_kg, 4, "kg", String::new());
    results
}
