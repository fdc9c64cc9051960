//! The record of a flight: its trace, the transfers of one on the wall clock, its checkpoints.

use super::{FlightState, FrameResult, Observer, TransferLog, pacing::Pacing};
use crate::linkage::saturation::Saturations;
use desk::{
    checkpoint,
    progress::Progress,
    run_dir::{Column, RunDirError, Trace, TraceState, TraceWriter},
};
use interface::{
    Tick,
    frame::{Samples, Transfer},
};
use serde::{Deserialize, Serialize};
use std::{
    fs::File,
    io::Write,
    path::{Path, PathBuf},
};

/// Rows in one batch of a trace: what a crash may cost.
pub const BATCH_ROWS: usize = 64;

/// One column: name, unit, and how it is read from a frame.
type Reader = (&'static str, &'static str, fn(&Samples, &FrameResult) -> f64);

const COLUMNS: [Reader; 41] = [
    ("velocity_m_s", "m/s", |_, r| r.sample.trajectory.speed_mps),
    ("flight_path_angle_rad", "rad", |_, r| r.sample.trajectory.path_angle_rad),
    ("altitude_m", "m", |_, r| r.sample.trajectory.altitude_m),
    ("range_angle_rad", "rad", |_, r| r.sample.trajectory.range_angle_rad),
    ("alpha_rad", "rad", |_, r| r.sample.incidence_rad),
    ("mach", "", |_, r| r.sample.mach),
    ("dynamic_pressure_pa", "Pa", |_, r| r.sample.dynamic_pressure_pa),
    ("q_alpha_pa_rad", "Pa rad", |_, r| r.sample.dynamic_pressure_pa * r.sample.incidence_rad),
    ("theta_rad", "rad", |_, r| r.sample.angle_rad[0]),
    ("psi_rad", "rad", |_, r| r.sample.angle_rad[1]),
    ("phi_rad", "rad", |_, r| r.sample.angle_rad[2]),
    ("theta_command_rad", "rad", |_, r| r.sample.pitch_command_rad),
    ("tvc_pitch_force_n", "N", |_, r| r.attitude.tvc_n[0]),
    ("tvc_yaw_force_n", "N", |_, r| r.attitude.tvc_n[1]),
    ("alpha_analog_rad", "rad", |_, r| r.attitude.incidence_rad),
    ("alpha_y_rad", "rad", |_, r| r.sample.yaw_incidence_rad),
    ("q_rad_s", "rad/s", |_, r| r.attitude.rate_radps[0]),
    ("r_rad_s", "rad/s", |_, r| r.attitude.rate_radps[1]),
    ("p_rad_s", "rad/s", |_, r| r.attitude.rate_radps[2]),
    ("pitch_tips_rad", "rad", |_, r| r.attitude.tip_rad[0]),
    ("tip_2_rad", "rad", |_, r| r.attitude.tip_rad[1]),
    ("tip_4_rad", "rad", |_, r| r.attitude.tip_rad[2]),
    ("control_force_n", "N", |_, r| r.attitude.control_force_n[0]),
    ("mass_kg", "kg", |_, r| r.airframe.mass_kg),
    ("thrust_n", "N", |_, r| r.airframe.thrust_n),
    ("moment_slope_n_m", "N m/rad", |_, r| r.airframe.moment_slope_nmprad),
    ("normal_force_slope_n", "N/rad", |_, r| r.airframe.normal_force_slope_nprad),
    ("ftc_gain", "", |_, r| r.settings.ftc_gain()[0]),
    ("ftc_lead_s", "s", |_, r| r.settings.gains.ftc_lead_s),
    ("tvc_gain_n", "N/rad", |_, r| r.settings.tvc_gain_nprad()[0]),
    ("tvc_lead_s", "s", |_, r| r.settings.gains.tvc_lead_s),
    ("dead_zone_rad", "rad", |_, r| r.settings.gains.dead_zone_rad),
    ("control_force_yaw_n", "N", |_, r| r.attitude.control_force_n[1]),
    ("q_alpha_total_pa_rad", "Pa rad", |_, r| r.sample.total_q_alpha_padeg().to_radians()),
    ("cross_speed_m_s", "m/s", |_, r| r.sample.trajectory.cross_speed_mps),
    ("cross_range_m", "m", |_, r| r.sample.trajectory.cross_m),
    ("azimuth_departure_rad", "rad", |_, r| {
        r.sample.trajectory.azimuth_departure_rad().unwrap_or(f64::NAN)
    }),
    ("impact_downrange_m", "m", |_, r| r.sample.impact.map_or(f64::NAN, |i| i.downrange_m)),
    ("impact_cross_m", "m", |_, r| r.sample.impact.map_or(f64::NAN, |i| i.cross_m)),
    ("adc_saturated", "", |s, _| f64::from(s.adc_saturated.count_ones())),
    ("overloads", "", |s, _| f64::from(s.overloads)),
];

/// The columns in order.
pub fn columns() -> Vec<Column> {
    COLUMNS.map(|(name, unit, _)| Column::new(name, unit)).into()
}

fn row(samples: &Samples, result: &FrameResult) -> [f64; COLUMNS.len()] {
    std::array::from_fn(|i| COLUMNS[i].2(samples, result))
}

/// The column of the transfers beside their ticks: the frame whose updates took effect.
/// A frame number is exact as a float up to 2⁵³.
pub fn transfer_columns() -> [Column; 1] {
    [Column::new("frame", "")]
}

/// Everything that a flight goes on from, apart from what its `run.toml` tells.
#[derive(Serialize, Deserialize)]
pub struct Kept {
    /// SHA-256 of the `run.toml` that it belongs to, hexadecimal.
    pub record: String,
    /// Fast frames from one checkpoint to the next.
    pub every: u64,
    pub flight: FlightState,
    trace: TraceState,
    saturations: Saturations,
}

/// Where the checkpoints of a flight go.
struct Keeper<W: Write> {
    path: PathBuf,
    record: String,
    every: u64,
    state: fn(&TraceWriter<W>) -> Result<TraceState, RunDirError>,
}

/// Keeps a flight frame by frame.
pub struct Recorder<W: Write> {
    rows: TraceWriter<W>,
    keeper: Option<Keeper<W>>,
    /// On the wall clock: the frames whose updates took effect, with their instants.
    transfers: Option<TraceWriter<File>>,
    /// On the wall clock.
    pub pacing: Option<Pacing>,
    saturations: Saturations,
    progress: Progress,
}

impl<W: Write> Recorder<W> {
    /// Rows have the columns of [`columns`]; the flight ends at `stop`.
    pub fn new(rows: TraceWriter<W>, stop: Tick) -> Recorder<W> {
        Recorder {
            rows,
            keeper: None,
            transfers: None,
            pacing: None,
            saturations: Saturations::default(),
            progress: Progress::new(stop.secs() as u64, "s of flight"),
        }
    }

    /// Keeps the transfers too, of a flight on the wall clock in frames of `frame`.
    pub fn paced(mut self, transfers: TraceWriter<File>, frame: Tick) -> Recorder<W> {
        self.transfers = Some(transfers);
        self.pacing = Some(Pacing::new(frame));
        self
    }

    /// Ends the files; what was driven beyond its range.
    pub fn finish(self) -> Result<Saturations, RunDirError> {
        self.progress.done();
        self.rows.finish()?;
        self.transfers.map(TraceWriter::finish).transpose()?;
        Ok(self.saturations)
    }
}

impl Recorder<File> {
    /// Keeps checkpoints in the file `path`, `every` so many fast frames, of the flight whose
    /// `run.toml` has the SHA-256 `record`.
    pub fn keeping(mut self, path: PathBuf, every: u64, record: String) -> Recorder<File> {
        self.keeper = Some(Keeper { path, record, every, state: TraceWriter::state });
        self
    }

    /// Goes on with the record of a flight; gives the state that the flight goes on from.
    pub fn resume(
        trace: &Path,
        stop: Tick,
        path: PathBuf,
        kept: Kept,
    ) -> Result<(Recorder<File>, FlightState), RunDirError> {
        let Kept { record, every, flight, trace: state, saturations } = kept;
        let rows = TraceWriter::resume(trace, &columns(), BATCH_ROWS, state)?;
        let recorder = Recorder { saturations, ..Recorder::new(rows, stop) };
        Ok((recorder.keeping(path, every, record), flight))
    }
}

impl<W: Write> Observer for Recorder<W> {
    fn keep(&mut self, flight: FlightState) -> Result<(), RunDirError> {
        let Some(Keeper { path, record, every, state }) = &self.keeper else {
            return Ok(());
        };
        let (record, trace) = (record.clone(), state(&self.rows)?);
        let kept = Kept { record, every: *every, flight, trace, saturations: self.saturations };
        checkpoint::write(path, &kept)
    }

    fn told(&mut self, samples: &Samples) -> Result<(), RunDirError> {
        if let Some(pacing) = &mut self.pacing {
            pacing.observe(samples);
        }
        if let Some(transfers) = &mut self.transfers {
            for transfer in samples.transfers() {
                transfers.push(transfer.tick, &[transfer.frame as f64])?;
            }
        }
        Ok(())
    }

    fn flown(&mut self, samples: &Samples, result: &FrameResult) -> Result<(), RunDirError> {
        self.progress.at(result.sample.time_s as u64);
        self.saturations.note(samples);
        self.rows.push(samples.tick, &row(samples, result))
    }
}

/// Why a stream is not that of a run's transfers.
#[derive(Debug, thiserror::Error)]
#[error("`{}` is not a record of transfers: {reason}; fly the run again", path.display())]
pub struct TransfersFault {
    path: PathBuf,
    reason: String,
}

/// Reads the transfers back; `path` serves messages only.
pub fn read_transfers(path: &Path, trace: &Trace) -> Result<TransferLog, TransfersFault> {
    let fault = |reason: String| TransfersFault { path: path.to_owned(), reason };
    let frames = trace.column("frame").map_err(|e| fault(e.to_string()))?;
    let transfers = frames
        .iter()
        .zip(trace.ticks())
        .map(|(&frame, &tick)| {
            // 2⁵³: beyond it a float no longer counts.
            if (0.0..9_007_199_254_740_992.0).contains(&frame) && frame.fract() == 0.0 {
                let (frame, tick) = (frame as u64, Tick(tick));
                Ok(Transfer { frame, tick })
            } else {
                Err(fault(format!("{frame} is no frame number")))
            }
        })
        .collect::<Result<_, _>>()?;
    TransferLog::new(transfers).map_err(|e| fault(e.to_string()))
}
