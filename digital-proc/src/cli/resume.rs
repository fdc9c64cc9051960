//! `digital-proc resume`: a flight that was killed, from its last checkpoint.

use super::{
    Context, JoinArgs,
    fly::Flight,
    replay::{Recorded, expect_patch},
    runs::Which,
};
use crate::{
    flight::{
        Keeping, Stage, Timing,
        trace::{Kept, Recorder},
    },
    linkage::console::Console,
};
use desk::{
    checkpoint,
    failure::Failure,
    run_dir::{CHECKPOINT_FILE, RECORD_FILE, SUMMARY_FILE, TRACE_FILE},
};

/// Go on with a flight from its last checkpoint
///
/// Go on with a flight that was killed or interrupted, from the last checkpoint in its run
/// directory. Its trace and its report are those of a flight that was never stopped.
///
///     digital-proc fly --checkpoint 5s
///     digital-proc resume last
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Resume {
    #[command(flatten)]
    which: Which,
    #[command(flatten)]
    join: JoinArgs,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

impl Resume {
    pub fn execute(self, context: &Context) -> Result<(), Failure> {
        let Recorded { run, text, plan_record, vehicle, plan } = Recorded::open(&self.which)?;
        let directory = &run.directory;
        let path = directory.file(CHECKPOINT_FILE);
        if !path.exists() {
            let why = if directory.file(SUMMARY_FILE).exists() {
                "it has ended"
            } else {
                "it keeps no checkpoint (`fly --checkpoint 5s` does)"
            };
            let name = directory.name();
            return Err(Failure::input(format!("`{name}` cannot be gone on with: {why}")));
        }
        let kept: Kept = checkpoint::read(&path)?;
        if kept.record != text {
            return Err(Failure::input(format!(
                "{} is not as it was when the flight began; put it back, or fly anew",
                directory.file(RECORD_FILE).display()
            )));
        }
        let every = Some(kept.every);
        let mut machine = self.join.start(context)?;
        let mut console = Console::new(&mut machine);
        let mut stage =
            Stage::load_patch(&mut console, &vehicle, &plan.profile, plan.options.patch())?;
        expect_patch(&run.record, directory.name(), console.patch_hash())?;
        let (recorder, from) =
            Recorder::resume(&directory.file(TRACE_FILE), plan.stop, path, kept)?;
        let keeping = Keeping { every, from: Some(from) };
        let flight =
            Flight { run: &run, plan_record: &plan_record, plan: &plan, vehicle: &vehicle };
        let flown = flight.fly(console, &mut stage, (Timing::LockStep, keeping), recorder)?;
        drop(machine);
        flight.publish(flown, self.json)
    }
}
