//! The digital side's view of one session: patch, presets and runs by name.
//!
//! A console holds a port of either link. It resolves block names to channels
//! once, at load, so that a frame touches only indices. It knows nothing of
//! rockets and refuses a name that the patch does not have, with the nearest one.

use super::launch::{Fellow, Started};
use desk::faults::suggestion;
use interface::{
    Tick,
    control::{
        Channel, ChannelKind, Checkpoints, LinearModel, Overload, PatchBundle, Reply, Request,
        RunSpec, Sweep, SweepCase, SweptRun,
    },
    frame::{RunState, Samples, Updates},
    link::{DigitalPort, Law, LinkFault},
    profile::Profile,
};

/// Why a session could not go on.
#[derive(Debug, thiserror::Error)]
pub enum ConsoleFault {
    /// The partner or the link failed.
    #[error(transparent)]
    Link(#[from] LinkFault),
    /// The analog side refused a request; its own words.
    #[error("{0}")]
    Refused(String),
    /// The analog run stopped by itself.
    #[error("the analog run stopped at {time}: {fault}")]
    RunFault {
        /// Problem time of the last frame.
        time: Tick,
        /// The analog side's account.
        fault: String,
    },
    /// The patch has no such channel.
    #[error("the patch has no {kind} `{name}`; {remedy}")]
    NoChannel {
        /// Kind of channel.
        kind: &'static str,
        /// The name asked for.
        name: String,
        /// The nearest name of that kind, or all of them.
        remedy: String,
    },
    /// An answer that does not fit the request.
    #[error(
        "the analog side answered {request} with something else; both sides must be of one build"
    )]
    WrongReply {
        /// The request.
        request: &'static str,
    },
}

/// What a run left behind on the analog side.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnosis {
    /// Fault text, if the last run faulted.
    pub fault: Option<String>,
    /// Latched overloads in order of time.
    pub overloads: Vec<Overload>,
}

/// A run of a sweep, by names.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepRun<'n> {
    /// Initial conditions by integrator.
    pub ics: Vec<(&'n str, f64)>,
    /// DACs, DCUs and control lines (1 or 0).
    pub settings: Vec<(&'n str, f64)>,
    /// Problem time at which it ends.
    pub stop: Tick,
}

/// Samples asked for at a time: a megabyte, and no more than a moment between two signs of life.
const SAMPLES_A_REQUEST: usize = 1 << 17;
/// Runs asked for at a time: half a megabyte of settings.
const RUNS_A_REQUEST: usize = 256;

/// One session seen from the digital side.
pub struct Console<'p> {
    port: &'p mut dyn DigitalPort,
    fellow: Option<Fellow>,
    channels: Vec<Channel>,
    patch_hash: String,
}

impl<'p> Console<'p> {
    /// At a machine whose two sides have greeted each other.
    pub fn new(machine: &'p mut Started) -> Console<'p> {
        let (port, fellow) = machine.parts();
        Console { port, fellow, channels: Vec::new(), patch_hash: String::new() }
    }

    /// Another machine like this one, where one can be started.
    pub fn fellow(&self) -> Option<Fellow> {
        self.fellow.clone()
    }

    /// Fails where the partner has gone or this side is interrupted, while nothing is asked of it.
    pub fn attend(&mut self) -> Result<(), ConsoleFault> {
        Ok(self.port.attend()?)
    }

    /// Uploads a patch; the machine goes to IC.
    ///
    /// # Errors
    /// [`ConsoleFault::Refused`] carries the rendered faults of the patch.
    pub fn load(
        &mut self,
        bundle: PatchBundle,
        params: Vec<(String, f64)>,
        profile: Profile,
    ) -> Result<(), ConsoleFault> {
        match request(self.port, &Request::Load { bundle, params, profile })? {
            Reply::Loaded { patch_hash, channels } => {
                self.patch_hash = patch_hash;
                self.channels = channels;
                Ok(())
            }
            _ => Err(ConsoleFault::WrongReply { request: "the patch" }),
        }
    }

    /// SHA-256 of the loaded patch, hexadecimal.
    pub fn patch_hash(&self) -> &str {
        &self.patch_hash
    }

    /// Every channel of the loaded patch.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// Number of the channel `name` of `kind`.
    pub fn channel(&self, kind: ChannelKind, name: &str) -> Result<usize, ConsoleFault> {
        let of_kind = || self.channels.iter().filter(move |c| c.kind == kind);
        of_kind().find(|c| c.name == name).map(|c| c.number as usize).ok_or_else(|| {
            let remedy = suggestion(name, of_kind().map(|c| c.name.as_str()));
            let kind = match kind {
                ChannelKind::Adc => "ADC",
                ChannelKind::Dac => "DAC",
                ChannelKind::Dcu => "DCU",
                ChannelKind::Sense => "sense line",
                ChannelKind::Control => "control line",
                ChannelKind::Interrupt => "interrupt line",
            };
            ConsoleFault::NoChannel { kind, name: name.to_owned(), remedy }
        })
    }

    /// Pot-set: values for `[params]` entries; the machine goes to IC.
    pub fn set_params(&mut self, params: Vec<(String, f64)>) -> Result<(), ConsoleFault> {
        self.done("pot-set", &Request::SetParams(params))
    }

    /// Initial conditions by integrator name; the machine goes to IC.
    pub fn set_ics(&mut self, ics: Vec<(String, f64)>) -> Result<(), ConsoleFault> {
        self.done("the initial conditions", &Request::SetIcs(ics))
    }

    /// DACs, DCUs and control lines by name (1 or 0), to be preset.
    pub fn settings(&self, values: &[(&str, f64)]) -> Result<Updates, ConsoleFault> {
        use ChannelKind::{Control, Dac, Dcu};
        let mut updates = Updates::new(0, Tick::ZERO);
        let is_settable = |c: &&Channel| matches!(c.kind, Dac | Dcu | Control);
        for &(name, value) in values {
            let all = || self.channels.iter().filter(is_settable);
            let channel = all().find(|c| c.name == name).ok_or_else(|| {
                let remedy = suggestion(name, all().map(|c| c.name.as_str()));
                let kind = "DAC, DCU or control line";
                ConsoleFault::NoChannel { kind, name: name.to_owned(), remedy }
            })?;
            let number = channel.number as usize;
            match channel.kind {
                Dac => updates.set_dac(number, value),
                Dcu => updates.set_dcu(number, value),
                _ => updates.set_control(number, value != 0.0),
            }
        }
        Ok(updates)
    }

    /// Lets updates take effect while the machine does not operate.
    pub fn preset(&mut self, updates: &Updates) -> Result<(), ConsoleFault> {
        self.done("the preset", &Request::Preset(*updates))
    }

    /// Net values now, in IC or HOLD.
    pub fn read(&mut self, nets: Vec<String>) -> Result<Vec<f64>, ConsoleFault> {
        match request(self.port, &Request::Read(nets))? {
            Reply::Values(values) => Ok(values),
            _ => Err(ConsoleFault::WrongReply { request: "a read-back" }),
        }
    }

    /// The linear model of the patch about its present state, from the nets `inputs`, in place of
    /// what drives them, to the nets `outputs`.
    ///
    /// # Errors
    /// [`ConsoleFault::Refused`]: an unknown net, a transport delay, a slope that does not exist.
    pub fn linearise(
        &mut self,
        inputs: &[&str],
        outputs: &[&str],
    ) -> Result<LinearModel, ConsoleFault> {
        let owned = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
        let (inputs, outputs) = (owned(inputs), owned(outputs));
        match request(self.port, &Request::Linearise { inputs, outputs })? {
            Reply::Linear(model) => Ok(model),
            _ => Err(ConsoleFault::WrongReply { request: "a linear model" }),
        }
    }

    /// What ended the last run, and latched overloads.
    pub fn diagnose(&mut self) -> Result<Diagnosis, ConsoleFault> {
        match request(self.port, &Request::Diagnose)? {
            Reply::Diagnosis { fault, overloads } => Ok(Diagnosis { fault, overloads }),
            _ => Err(ConsoleFault::WrongReply { request: "a diagnosis" }),
        }
    }

    /// Runs one OPERATE period by `law` and returns the samples at its end.
    ///
    /// # Errors
    /// [`ConsoleFault::RunFault`] when the analog run stops by itself, or the link's.
    pub fn run(&mut self, spec: &RunSpec, law: &mut impl Law) -> Result<Samples, ConsoleFault> {
        self.run_kept(spec, None, law)
    }

    /// As [`Console::run`], with checkpoints or from one, if there are to be any: `law` is given the
    /// analog side's state at each.
    pub fn run_kept(
        &mut self,
        spec: &RunSpec,
        checkpoints: Option<&Checkpoints>,
        law: &mut impl Law,
    ) -> Result<Samples, ConsoleFault> {
        let spec = spec.clone();
        let latency = spec.latency;
        let operate = match checkpoints {
            None => Request::Operate(spec),
            Some(checkpoints) => Request::OperateKept(spec, checkpoints.clone()),
        };
        self.done("OPERATE", &operate)?;
        let last = self.port.operate(latency, checkpoints, law)?;
        if last.run_state() == RunState::Faulted {
            let fault = self.diagnose()?.fault.unwrap_or_else(|| "no reason given".into());
            return Err(ConsoleFault::RunFault { time: last.tick, fault });
        }
        Ok(last)
    }

    /// Makes many runs that this side only reads, sampling the ADC channels `adc` once `every`;
    /// `each` is given them in order. They go side by side on the analog side's processors, and
    /// each has the bits of a run alone. Afterwards the machine stands as before.
    ///
    /// # Errors
    /// [`ConsoleFault`]: a refused setting or a lost partner, but not a run that faults.
    pub fn sweep<'n>(
        &mut self,
        every: Tick,
        adc: &[usize],
        runs: impl IntoIterator<Item = SweepRun<'n>>,
        mut each: impl FnMut(SweptRun),
    ) -> Result<(), ConsoleFault> {
        let mut runs = runs.into_iter().peekable();
        while runs.peek().is_some() {
            let adc = adc.iter().map(|channel| *channel as u32).collect();
            let mut sweep = Sweep { every, adc, cases: Vec::new() };
            let mut samples = 0;
            while samples < SAMPLES_A_REQUEST
                && sweep.cases.len() < RUNS_A_REQUEST
                && let Some(SweepRun { ics, settings, stop }) = runs.next()
            {
                samples += (stop.secs() / every.secs()) as usize * sweep.adc.len() + 1;
                let ics = ics.into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
                sweep.cases.push(SweepCase { ics, preset: self.settings(&settings)?, stop });
            }
            match request(self.port, &Request::Sweep(sweep))? {
                Reply::Swept(swept) => swept.into_iter().for_each(&mut each),
                _ => return Err(ConsoleFault::WrongReply { request: "a sweep" }),
            }
        }
        Ok(())
    }

    /// Ends the session.
    pub fn bye(self) -> Result<(), ConsoleFault> {
        match request(self.port, &Request::Bye)? {
            Reply::Done => Ok(()),
            _ => Err(ConsoleFault::WrongReply { request: "goodbye" }),
        }
    }

    fn done(&mut self, what: &'static str, message: &Request) -> Result<(), ConsoleFault> {
        match request(self.port, message)? {
            Reply::Done => Ok(()),
            _ => Err(ConsoleFault::WrongReply { request: what }),
        }
    }
}

fn request(port: &mut dyn DigitalPort, message: &Request) -> Result<Reply, ConsoleFault> {
    match port.request(message)? {
        Reply::Refused(reason) => Err(ConsoleFault::Refused(reason)),
        reply => Ok(reply),
    }
}
