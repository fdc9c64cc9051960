//! `digital-proc fly`: one long-period flight.

use super::{Context, MachineArgs, failure_file, vehicle_args::VehicleArgs};
use crate::{
    flight::{
        AlphaPath, AxesName, FlightFault, FlightPlan, FunctionGeneration, Keeping, Stage, Timing,
        channels::Sampled,
        pacing::Pacing,
        plan_record::{Pace, PlanFault, PlanRecord, WindName},
        trace::{self, BATCH_ROWS, Recorder},
    },
    linkage::console::{Console, ConsoleFault},
    report::{block_diagram, flight::variables, pacing},
    study::bending_moment::{
        self, BendingMoments,
        flight::{Beside, FlightMoments},
    },
};
use desk::{
    failure::Failure,
    note,
    outcome::{Figure, Outcome, Run},
    report::Summary,
    run_dir::{CHECKPOINT_FILE, DEFAULT_BASE, RECORD_FILE, Seed, TRACE_FILE, TRANSFERS_FILE},
    user_file::read_text,
};
use interface::{Tick, control::Overload};
use std::{fs::File, path::PathBuf};
use vehicle::{
    Vehicle,
    flight_mode::FlightMode,
    flight_summary::FlightSummary,
    range_safety::GroundPoint,
    structure::{Structure, StructureError},
};

/// Fly the first stage from lift-off to burn-out.
#[derive(clap::Args)]
#[command(next_help_heading = "Flight")]
pub struct Fly {
    /// Mode of operation
    #[arg(long, default_value = "normal", value_name = "MODE",
          help = format!("Mode of operation: {}, or one of --failures", FlightMode::ALL.map(FlightMode::name).join(", ")))]
    mode: String,
    /// Failure file of your own that scripts the modes [default: the shipped one]
    #[arg(help_heading = "Disturbances", long, value_name = "FILE")]
    failures: Option<PathBuf>,
    /// Trajectory step, the slow frame of the digital side
    #[arg(long, default_value = "100ms", value_name = "TIME")]
    frame: Tick,
    /// Fast frames (aerodynamic functions) in one trajectory step
    #[arg(long, default_value_t = 5, value_name = "N")]
    fast: u64,
    /// Latency from sample to transfer, at most one fast frame [default: the profile's]
    #[arg(help_heading = "Machine", long, value_name = "TIME")]
    latency: Option<Tick>,
    /// Multiplexer skew between neighbouring ADC channels [default: the profile's]
    #[arg(help_heading = "Machine", long, value_name = "TIME")]
    skew: Option<Tick>,
    /// Who paces the flight; `digital-proc replay` repeats either to the last bit
    #[arg(help_heading = "Machine", long, value_enum, default_value = "lock-step")]
    clock: Pace,
    /// Problem time between two checkpoints, for `digital-proc resume` [default: none are kept]
    #[arg(help_heading = "Output", long, value_name = "TIME")]
    checkpoint: Option<Tick>,
    /// Stop before burn-out
    #[arg(long, value_name = "TIME")]
    until: Option<Tick>,
    /// Wind in the pitch plane, with its share across
    #[arg(help_heading = "Disturbances", long, value_enum, default_value = "none")]
    wind: WindName,
    /// Which member of the ensemble blows, with --wind ensemble
    #[arg(help_heading = "Disturbances", long, default_value_t = 0, value_name = "N")]
    seed: u64,
    /// Thrust misalignment in pitch, as a fraction of 3 sigma
    #[arg(
        help_heading = "Disturbances",
        long,
        default_value_t = 0.0,
        value_name = "FRACTION",
        allow_negative_numbers = true
    )]
    misalign_pitch: f64,
    /// Thrust misalignment in yaw, as a fraction of 3 sigma
    #[arg(
        help_heading = "Disturbances",
        long,
        default_value_t = 0.0,
        value_name = "FRACTION",
        allow_negative_numbers = true
    )]
    misalign_yaw: f64,
    /// Wind and misalignments of the vehicle's design case for failure modes
    #[arg(help_heading = "Disturbances", long, conflicts_with_all = ["wind", "misalign_pitch", "misalign_yaw"])]
    design_case: bool,
    /// No failure of the mode acts before this
    #[arg(help_heading = "Disturbances", long, default_value = "0s", value_name = "TIME")]
    failure_at: Tick,
    /// How the angle of attack reaches the rotational equations
    #[arg(long, value_enum, default_value = "redundant")]
    alpha: AlphaPath,
    /// How the yaw incidence does: by figure 1's scheme too, or from the held crosswind angle
    #[arg(long, value_enum, default_value = "held")]
    beta: AlphaPath,
    /// Axes of the translational equations on the digital side
    #[arg(long, value_enum, default_value = "flight-path")]
    axes: AxesName,
    /// Where the aerodynamic moments are formed
    #[arg(long, value_enum, default_value = "hybrid")]
    functions: FunctionGeneration,
    #[command(flatten)]
    vehicle: VehicleArgs,
    /// Directory for runs; each run makes its own directory there
    #[arg(help_heading = "Output", long, default_value = DEFAULT_BASE, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    machine: MachineArgs,
}

impl Fly {
    pub fn execute(self, context: &Context) -> Result<(), Failure> {
        let vehicle = self.vehicle.load()?;
        let plan_record = self.plan_record(&vehicle)?;
        let plan = plan_record.plan(&vehicle)?;
        let parameters = plan_record.to_parameters().map_err(Failure::input)?;
        let every = self.frames_between_checkpoints(&plan_record)?;
        let mut machine = self.machine.start(context)?;
        let mut console = Console::new(&mut machine);
        let mut stage =
            Stage::load_patch(&mut console, &vehicle, &plan.profile, plan.options.patch())?;

        let (command, link) = (format!("fly {}", self.mode), self.machine.join.link_name());
        let mut run = Run::begin(&self.out, &command, &plan.profile.name, link)?;
        run.patch("long-period.toml", console.patch_hash());
        run.record.parameters = parameters;
        run.directory.write_record(&run.record)?;
        let stream =
            |name: &str, columns: &[_]| run.directory.create_stream(name, columns, BATCH_ROWS);
        let mut recorder = Recorder::new(stream(TRACE_FILE, &trace::columns())?, plan.stop);
        let timing = match self.clock {
            Pace::LockStep => Timing::LockStep,
            Pace::Wall => {
                let transfers = stream(TRANSFERS_FILE, &trace::transfer_columns())?;
                recorder = recorder.paced(transfers, plan_record.fast_frame()?);
                Timing::Wall
            }
        };
        if let Some(every) = every {
            let path = run.directory.file(RECORD_FILE);
            let record = read_text(&path)
                .map_err(|e| Failure::input(format!("cannot read `{}`: {e}", path.display())))?;
            recorder = recorder.keeping(run.directory.file(CHECKPOINT_FILE), every, record);
        }
        let keeping = Keeping { every, from: None };
        let flight =
            Flight { run: &run, plan_record: &plan_record, plan: &plan, vehicle: &vehicle };
        let flown = flight.fly(console, &mut stage, (timing, keeping), recorder)?;
        drop(machine);
        flight.publish(flown, self.machine.json)
    }

    /// Fast frames from one checkpoint to the next, if any are to be kept.
    fn frames_between_checkpoints(&self, record: &PlanRecord) -> Result<Option<u64>, Failure> {
        let Some(between) = self.checkpoint else {
            return Ok(None);
        };
        if between <= Tick::ZERO {
            return Err(Failure::input("--checkpoint must be positive"));
        }
        if self.clock == Pace::Wall {
            return Err(Failure::input(
                "--checkpoint is for flights in lock-step: the wall clock goes on while one is down",
            ));
        }
        let fast = record.fast_frame()?;
        Ok(Some((between.0 as u64).div_ceil(fast.0 as u64)))
    }

    /// The command line as everything that the flight follows from.
    fn plan_record(&self, vehicle: &Vehicle) -> Result<PlanRecord, Failure> {
        let profile = desk::profile::load(&self.machine.profile)?;
        let failures = failure_file(self.failures.as_deref())?;
        let script = failures.mode(&self.mode)?;
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
            alpha: self.alpha,
            beta: self.beta,
            axes: self.axes,
            functions: self.functions,
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
}

/// A flight and where it is kept.
pub(super) struct Flight<'a> {
    pub run: &'a Run,
    pub plan_record: &'a PlanRecord,
    pub plan: &'a FlightPlan,
    pub vehicle: &'a Vehicle,
}

/// What a flight has left besides its trace.
pub(super) struct Flown {
    summary: FlightSummary,
    moments: Result<BendingMoments<2>, StructureError>,
    saturated: Vec<String>,
    overloads: Vec<Overload>,
    paced: Option<Pacing>,
}

impl Flight<'_> {
    /// Flies from the start or from a checkpoint, and ends the session.
    pub fn fly(
        &self,
        mut console: Console<'_>,
        stage: &mut Stage,
        how: (Timing<'_>, Keeping),
        mut recorder: Recorder<File>,
    ) -> Result<Flown, Failure> {
        let directory = &self.run.directory;
        let structure = Structure::new(self.vehicle);
        let case = &self.plan.case;
        let misalignment = [case.pitch_misalignment, case.yaw_misalignment];
        let mut moments = FlightMoments::new(&structure, misalignment);
        if let Some(found) = how.1.from.as_ref().and_then(|from| from.moments.clone()) {
            moments.resume(found);
        }
        let mut watched = Beside { observer: &mut recorder, moments };
        let flown = stage.fly_kept(&mut console, self.vehicle, self.plan, how, &mut watched);
        let moments = watched.moments.finish();
        let paced = recorder.pacing.clone();
        let closed = recorder.finish();
        let summary = flown.map_err(|fault| {
            let path = directory.path();
            let kept = format!("what was recorded up to there is in {}", path.display());
            // What lies in the flight itself would befall it again.
            let is_from_outside = matches!(
                fault,
                FlightFault::Console(ConsoleFault::Link(_)) | FlightFault::Trace(_)
            );
            let mut failure = Failure::from(fault).and(kept);
            failure.run = Some(path.to_owned());
            if is_from_outside && directory.file(CHECKPOINT_FILE).exists() {
                let name = path.display();
                failure = failure.and(format!("go on with: digital-proc resume {name}"));
            }
            match &paced {
                Some(paced) => failure.and(pacing::text(paced)),
                None => failure,
            }
        })?;
        let saturated = closed?.names(console.channels());
        let overloads = console.diagnose()?.overloads;
        console.bye()?;
        Ok(Flown { summary, moments, saturated, overloads, paced })
    }

    /// Tells what the flight came to.
    pub fn publish(&self, flown: Flown, json: bool) -> Result<(), Failure> {
        let Flown { summary, moments, saturated, overloads, paced } = flown;
        let (run, vehicle) = (self.run, self.vehicle);
        let case = match self.plan_record.wind {
            WindName::DesignCase => "; wind and misalignments of the design case",
            _ => "",
        };
        let mut outcome = Outcome::new(
            format!("First-stage flight, mode {}{case}", self.plan_record.mode.name),
            "Control dynamics on the analog processor, trajectory on the digital one, joined by sampled converters.",
        );
        add_results(vehicle, &summary, &mut outcome.results);
        let figures = variables(&run.directory.read_trace_thinned()?, vehicle.data())?;
        outcome.section("The monitored variables").beside(figures);
        bending_moment::flight::fill(&moments, &mut outcome);
        outcome.section("Partition").figure(Figure::new(
            "partition",
            "Who computes what: control dynamics in the analog processor, trajectory dynamics in the digital one.",
            block_diagram(),
        ));
        if let Some(paced) = &paced {
            pacing::tell(paced, &mut outcome);
        }
        let overloads = overloads
            .iter()
            .map(|o| format!("overload: {} at {:.4} s ({:.4})", o.block, o.time_s, o.value));
        outcome.remarks.extend(overloads);
        if !saturated.is_empty() {
            outcome.remarks.push(format!("saturated: {}", saturated.join(", ")));
        }
        let edges = summary.edges.iter().map(|(table, edge)| {
            format!("table edge: {} {edge:?}; its end value was held", table.label())
        });
        outcome.remarks.extend(edges);
        outcome.publish(run, json)?;
        // It has ended; what may be left of it does no harm.
        let _ = std::fs::remove_file(run.directory.file(CHECKPOINT_FILE));
        Ok(())
    }
}

impl From<PlanFault> for Failure {
    fn from(fault: PlanFault) -> Failure {
        match fault {
            PlanFault::Vehicle(faults) => faults.into(),
            other => Failure::input(other),
        }
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
fn add_results(vehicle: &Vehicle, s: &FlightSummary, results: &mut Summary) {
    let q = &s.max_dynamic_pressure;
    let at = format!("at {:.1} s, Mach {:.2}, {:.2} km", q.time_s, q.mach, q.altitude_m / 1e3);
    let data = vehicle.data();
    let end = if s.end_time_s < data.mass.burn_time_s { "Last" } else { "Burn-out" };
    let end = |what: &str| format!("{end} {what}");
    let end_time = format!("at {:.2} s", s.end_time_s);
    let limit = data.limits.q_alpha_padeg;
    let load = &s.max_q_alpha;
    let of_limit = 100.0 * load.value / limit;
    let margin = format!("at {:.1} s; {of_limit:.0} % of the limit {limit:.4e}", load.time_s);
    let total = &s.max_total_q_alpha;
    let total_at = format!("at {:.1} s; with the yaw incidence", total.time_s);
    let azimuth_deg = s
        .end
        .azimuth_departure_rad()
        .map_or(f64::NAN, |departure| data.site.azimuth_deg + departure.to_degrees());
    let used = 100.0 * s.corridor_used;
    let corridor = match s.corridor_left_s {
        Some(left_s) => format!("outside its corridor from {left_s:.1} s on"),
        None => format!("uses {used:.0} % of its corridor"),
    };
    let impact = |of: fn(&GroundPoint) -> f64| s.impact.as_ref().map_or(f64::NAN, of);
    let gamma_deg = s.end.path_angle_rad.to_degrees();
    for (key, label, value, digits, unit, note) in [
        ("max_q_pa", "Maximum dynamic pressure".into(), q.value, 5, "Pa", at),
        ("max_q_time_s", "  its time".into(), q.time_s, 4, "s", String::new()),
        ("max_q_mach", "  its Mach number".into(), q.mach, 4, "", String::new()),
        ("max_q_altitude_m", "  its altitude".into(), q.altitude_m, 5, "m", String::new()),
        ("burn_out_velocity_m_s", end("velocity"), s.end.speed_mps, 6, "m/s", end_time),
        (
            "burn_out_flight_path_angle_deg",
            end("flight-path angle"),
            gamma_deg,
            5,
            "deg",
            String::new(),
        ),
        ("burn_out_altitude_m", end("altitude"), s.end.altitude_m, 6, "m", String::new()),
        ("burn_out_range_m", end("range"), s.range_m, 6, "m", String::new()),
        (
            "burn_out_cross_range_m",
            end("cross-range"),
            s.cross_range_m,
            4,
            "m",
            "starboard positive".into(),
        ),
        ("burn_out_azimuth_deg", end("azimuth"), azimuth_deg, 5, "deg", String::new()),
        (
            "impact_downrange_m",
            "Impact point, along the track".into(),
            impact(|i| i.downrange_m),
            5,
            "m",
            "in vacuum, at the end".into(),
        ),
        ("impact_cross_m", "  and across".into(), impact(|i| i.cross_m), 4, "m", corridor),
        ("max_q_alpha_pa_deg", "Maximum Q alpha".into(), load.value, 5, "Pa deg", margin),
        ("max_total_q_alpha_pa_deg", "  with alpha_y".into(), total.value, 5, "Pa deg", total_at),
        (
            "max_roll_deg",
            "Maximum roll".into(),
            s.max_roll_rad.to_degrees(),
            4,
            "deg",
            String::new(),
        ),
        (
            "tvc_impulse_pitch_n_s",
            "TVC impulse, pitch".into(),
            s.tvc_pitch_impulse_ns,
            5,
            "N s",
            String::new(),
        ),
        (
            "tvc_impulse_yaw_n_s",
            "TVC impulse, yaw".into(),
            s.tvc_yaw_impulse_ns,
            5,
            "N s",
            String::new(),
        ),
        ("injectant_kg", "Injectant used".into(), s.injectant_kg, 4, "kg", String::new()),
    ] {
        results.add(key, &label, value, digits, unit, note);
    }
}
