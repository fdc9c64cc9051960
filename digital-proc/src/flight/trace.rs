//! Columns of a flight's trace, and of the transfers of one on the wall clock.

use super::{FrameResult, TransferLog};
use desk::run_dir::{Column, Trace};
use interface::{
    Tick,
    frame::{Samples, Transfer},
};
use std::path::{Path, PathBuf};

/// One column: name, unit, and how it is read from a frame.
type Reader = (&'static str, &'static str, fn(&Samples, &FrameResult) -> f64);

const COLUMNS: [Reader; 34] = [
    ("velocity_m_s", "m/s", |_, r| r.sample.trajectory.speed_mps),
    ("flight_path_angle_rad", "rad", |_, r| r.sample.trajectory.path_angle_rad),
    ("altitude_m", "m", |_, r| r.sample.trajectory.altitude_m),
    ("range_angle_rad", "rad", |_, r| r.sample.trajectory.range_angle_rad),
    ("alpha_rad", "rad", |_, r| r.sample.incidence_rad),
    ("mach", "", |_, r| r.sample.mach),
    ("dynamic_pressure_pa", "Pa", |_, r| r.sample.dynamic_pressure_pa),
    ("q_alpha_pa_rad", "Pa rad", |_, r| r.sample.dynamic_pressure_pa * r.sample.incidence_rad),
    ("theta_rad", "rad", |_, r| r.sample.pitch_rad),
    ("psi_rad", "rad", |_, r| r.sample.yaw_rad),
    ("phi_rad", "rad", |_, r| r.sample.roll_rad),
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
    ("control_force_n", "N", |_, r| r.attitude.control_force_n),
    ("mass_kg", "kg", |_, r| r.airframe.mass_kg),
    ("thrust_n", "N", |_, r| r.airframe.thrust_n),
    ("moment_slope_n_m", "N m/rad", |_, r| r.airframe.moment_slope_nmprad),
    ("normal_force_slope_n", "N/rad", |_, r| r.airframe.normal_force_slope_nprad),
    ("ftc_gain", "", |_, r| r.settings.ftc_gain()[0]),
    ("ftc_lead_s", "s", |_, r| r.settings.gains.ftc_lead_s),
    ("tvc_gain_n", "N/rad", |_, r| r.settings.tvc_gain_nprad()[0]),
    ("tvc_lead_s", "s", |_, r| r.settings.gains.tvc_lead_s),
    ("dead_zone_rad", "rad", |_, r| r.settings.gains.dead_zone_rad),
    ("adc_saturated", "", |s, _| f64::from(s.adc_saturated.count_ones())),
    ("overloads", "", |s, _| f64::from(s.overloads)),
];

/// The columns in order.
pub fn columns() -> Vec<Column> {
    COLUMNS.iter().map(|(name, unit, _)| Column::new(*name, *unit)).collect()
}

/// One row.
pub fn row(samples: &Samples, result: &FrameResult) -> [f64; COLUMNS.len()] {
    std::array::from_fn(|i| COLUMNS[i].2(samples, result))
}

/// The column of the transfers beside their ticks: the frame whose updates took effect.
/// A frame number is exact as a float up to 2⁵³.
pub fn transfer_columns() -> [Column; 1] {
    [Column::new("frame", "")]
}

/// One transfer.
pub fn transfer_row(transfer: &Transfer) -> [f64; 1] {
    [transfer.frame as f64]
}

/// Why a stream is not that of a run's transfers.
#[derive(Debug, thiserror::Error)]
#[error("`{}` is not a record of transfers: {reason}; fly the run again", path.display())]
pub struct TransfersFault {
    path: PathBuf,
    reason: String,
}

/// Reads the transfers back; `path` serves messages only.
///
/// # Errors
/// [`TransfersFault`] when a row is no transfer, or not in order.
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
