//! `digital-proc design-gains`: the gain schedules, designed on the machine.

use super::{
    Context, MachineArgs,
    study_run::{StudyArgs, StudyRun},
};
use crate::{
    console::Console,
    report::gain_design::{
        criteria_table, design_table, evaluation_table, gain_design_sections, merging_table,
    },
    study::{
        gain_design::{
            bench::PitchBench,
            criteria::Criteria,
            design::{Design, DesignFault, EFFORT, design},
            evaluate::{self, PointQuality, evaluate, worst},
            merge::{MergeFault, Merging, merge},
            schedule::as_toml,
            search::Effort,
            verdict::{Level, designed_section, fewest_accepted, none_accepted, reduced_sections},
        },
        long_period::run::LongPeriodPlan,
    },
};
use desk::failure::Failure;
use desk::{note, say};
use serde::Serialize;

/// Design the gain schedules: interval by interval on the short-period pitch loop,
/// then with fewer switchings by long-period flights, and back to the short period.
///
/// Prints the schedules as sections for a vehicle file; `--vehicle FILE` flies them. Exit code 1
/// when none with fewer switchings is accepted by the flights and by the short period.
#[derive(clap::Args)]
pub struct DesignGains {
    /// Most evaluations of the cost for one interval of the sequencer
    #[arg(long, default_value_t = EFFORT.evaluations, value_name = "N")]
    evaluations: usize,
    #[command(flatten)]
    study: StudyArgs,
    #[command(flatten)]
    machine: MachineArgs,
}

/// What the command came to.
#[derive(Serialize)]
struct Designed {
    design: Design,
    merging: Merging,
    /// Of every level of the merging, in its order.
    re_evaluated: Vec<Vec<PointQuality>>,
    /// Of the vehicle's own schedule with fewer switchings.
    shipped_reduced: Vec<PointQuality>,
    /// Why no schedule with fewer switchings is accepted; none where one is.
    none_accepted: Option<String>,
}

impl Designed {
    fn levels(&self) -> Vec<Level<'_>> {
        let trials = self.merging.levels.iter();
        trials.zip(self.re_evaluated.iter().map(Vec::as_slice)).collect()
    }

    /// A design that leads to no accepted schedule has failed its check.
    fn verdict(&self) -> Result<(), Failure> {
        match &self.none_accepted {
            None => Ok(()),
            Some(refused) => Err(Failure::failed(refused, &[])
                .and("allow more evaluations of each interval: --evaluations N")),
        }
    }
}

impl DesignGains {
    pub fn execute(self, context: &Context) -> Result<(), Failure> {
        if self.evaluations == 0 {
            return Err(Failure::input("--evaluations must be at least 1"));
        }
        let vehicle = self.study.vehicle()?;
        let (points, lacking) = evaluate::points(&vehicle).map_err(Failure::input)?;
        for reason in lacking {
            note!("not judged: {reason}");
        }
        let profile = desk::profile::load(&self.machine.profile)?;
        let mut run =
            StudyRun::begin("design-gains", &self.study, &self.machine, &profile, &vehicle)?;
        run.set("evaluations", self.evaluations as i64);
        let mut machine = self.machine.start(context)?;
        let mut console = Console::new(machine.port());

        let bench = PitchBench::load(&mut console, &profile)?;
        run.patch("pitch-loop.toml", console.patch_hash());
        let effort = Effort { evaluations: self.evaluations, ..EFFORT };
        let design = design(
            &mut console,
            &bench,
            &vehicle,
            &Criteria::DESIGN,
            effort,
            &mut |i, of, interval| {
                let [from, to] = interval.judged_s;
                note!(
                    "interval {i} of {of}, {from}–{to} s: cost {:.2} -> {:.2} in {} evaluations",
                    interval.first_cost,
                    interval.cost,
                    interval.evaluations
                );
            },
        )?;
        let plan = LongPeriodPlan::new(Vec::new(), profile.clone());
        let merging = merge(&mut console, &vehicle, &plan, &design.schedule, |level, flights| {
            note!(
                "{} switchings: {:.1} kPa deg after {flights} flights",
                level.schedule.switch_time_s.len() - 1,
                level.max_q_alpha_padeg / 1e3
            );
        })?;
        let bench = PitchBench::load(&mut console, &profile)?;
        let re_evaluated = merging
            .levels
            .iter()
            .map(|level| evaluate(&mut console, &bench, &vehicle, &points, &level.schedule))
            .collect::<Result<Vec<_>, _>>()?;
        let shipped_reduced =
            evaluate(&mut console, &bench, &vehicle, &points, &vehicle.data().gains_reduced)?;
        console.bye()?;
        drop(machine);
        let mut designed =
            Designed { design, merging, re_evaluated, shipped_reduced, none_accepted: None };
        let levels = designed.levels();
        if fewest_accepted(&levels).is_none() {
            designed.none_accepted = Some(none_accepted(&levels));
        }
        self.tell(&run, &vehicle, &designed)
    }

    fn tell(
        &self,
        run: &StudyRun,
        vehicle: &vehicle::Vehicle,
        all: &Designed,
    ) -> Result<(), Failure> {
        let levels = all.levels();
        let data = vehicle.data();
        let designed = designed_section(&levels);
        let reduced = reduced_sections(&levels);
        let text = format!("{designed}\n{reduced}");
        let file = run.file("gains.toml", &text)?;
        let shipped = data.gains.schedule();
        let sections = gain_design_sections(
            &all.design,
            &levels,
            (&shipped, &data.gains_reduced),
            &all.shipped_reduced,
            data.mass.burn_time_s,
            all.none_accepted.as_deref(),
        );
        let report = run.finish(
            all,
            "Design of the gain schedules",
            "Gains improved run by run on the patched pitch loop; then fewer switchings, accepted by flights and re-evaluated.",
            sections,
        )?;
        if self.machine.json {
            let json = serde_json::to_string_pretty(all).map_err(Failure::input)?;
            say!("{json}");
            return all.verdict();
        }
        say!("Criteria\n{}", criteria_table(&all.design.criteria).text());
        say!("Designed by {} runs\n{}", all.design.runs, design_table(&all.design).text());
        say!("{designed}");
        say!("{}", as_toml("gains", "shipped", &shipped));
        say!(
            "Fewer switchings by {} trial flights\n{}",
            all.merging.flights,
            merging_table(&levels).text()
        );
        say!("{reduced}");
        say!("{}", as_toml("gains_reduced", "shipped", &data.gains_reduced));
        say!(
            "The shipped reduced schedule seen by the short-period model\n{}",
            evaluation_table(&all.shipped_reduced).text()
        );
        if let Some(worst) = worst(&all.shipped_reduced).filter(|w| !w.accepted()) {
            say!(
                "It overshoots most at {} ({} s): {}.",
                worst.point,
                worst.time_s,
                worst
                    .quality
                    .overshoot
                    .map_or("it diverges".to_owned(), |v| format!("{:.0} %", 100.0 * v))
            );
        }
        say!("schedules: {}\nreport: {}", file.display(), report.display());
        all.verdict()
    }
}

impl From<DesignFault> for Failure {
    fn from(fault: DesignFault) -> Failure {
        match fault {
            DesignFault::Console(fault) => fault.into(),
            other => Failure::input(other),
        }
    }
}

impl From<MergeFault> for Failure {
    fn from(fault: MergeFault) -> Failure {
        match fault {
            MergeFault::Study(fault) => fault.into(),
            other => Failure::input(other),
        }
    }
}
