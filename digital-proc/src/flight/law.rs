//! The digital side of a long-period flight, frame by frame.
//!
//! Two tasks. The slow one, once a trajectory step: V, γ, h, Γ, v, y by RK4 with
//! attitude and control forces sampled at its start, pitch programme, sequencer,
//! failures, wind, and the correction of the redundant α integrator. The fast one, in every frame:
//! the aerodynamic functions, at the trajectory interpolated between the two
//! ends of the step, as slopes for the DCUs. (The data set's functions are
//! linear in α and β, so a slope is the whole function and α multiplies it on
//! the analog side, without a sampling lag.)
//!
//! Redundant integrator (figure 1 of the paper, in the pitch plane): the analog
//! α̇ = θ̇ + d(Γ − γ_air)/dt + K e_k/T, where the digital side sends the drift
//! from its own step and e_k = α_d(t_k) − α_a(t_k), both of one instant.

use super::{
    AlphaPath, FlightFault,
    channels::{AttitudeSample, StageChannels},
    options::{OptionChannels, Options},
};
use crate::linkage::executive::Rate;
use interface::{
    Tick,
    frame::{RunState, Samples, Updates},
};
use vehicle::{
    Vehicle,
    airframe::AirframeCoefficients,
    flight_mode::{ControlSettings, control_settings},
    flight_summary::FlightSample,
    range_safety::impact_point,
    reference::FlightCase,
    table_edges::{EdgeRecord, TableName},
    trajectory::{self, Attitude, Flow, TrajectoryState},
};

/// Part of the α error that is taken out in one trajectory step. Half: a prompt
/// correction of 0 < K < 2 is stable, one a frame late of K < 1.
const CORRECTION_GAIN: f64 = 0.5;

/// What the digital side goes on from between two frames; the rest follows from the plan.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub struct LawState {
    start: Tick,
    state: TrajectoryState,
    next: TrajectoryState,
}

/// The digital side of one flight.
#[derive(Clone)]
pub struct FlightLaw<'v> {
    vehicle: &'v Vehicle,
    case: &'v FlightCase,
    channels: StageChannels,
    alpha: AlphaPath,
    options: Options,
    added: OptionChannels,
    slow: Rate,
    step: Tick,
    /// Start of the current trajectory step.
    start: Tick,
    state: TrajectoryState,
    next: TrajectoryState,
    settings: ControlSettings,
    edges: EdgeRecord,
}

/// What one frame came to.
pub struct FrameResult {
    /// The monitored variables.
    pub sample: FlightSample,
    /// What was sampled of the analog side.
    pub attitude: AttitudeSample,
    /// Slopes and mass properties in force.
    pub airframe: AirframeCoefficients,
    /// Gains in force.
    pub settings: ControlSettings,
    /// Table edges met.
    pub edges: EdgeRecord,
}

impl<'v> FlightLaw<'v> {
    /// At lift-off; `step` is the trajectory step, `slow` its rate in fast frames.
    pub fn new(
        vehicle: &'v Vehicle,
        case: &'v FlightCase,
        channels: StageChannels,
        (alpha, (options, added)): (AlphaPath, (Options, OptionChannels)),
        (slow, step): (Rate, Tick),
    ) -> FlightLaw<'v> {
        let state = TrajectoryState::at_lift_off(vehicle);
        FlightLaw {
            vehicle,
            case,
            channels,
            alpha,
            options,
            added,
            slow,
            step,
            start: Tick::ZERO,
            state,
            next: state,
            settings: control_settings(vehicle, &case.script, case.failure_start_s, 0.0),
            edges: EdgeRecord::NONE,
        }
    }

    pub fn kept(&self) -> LawState {
        LawState { start: self.start, state: self.state, next: self.next }
    }

    /// As it was between two frames of the same flight.
    pub fn resume(&mut self, kept: LawState) {
        let (case, time_s) = (self.case, kept.start.secs());
        (self.start, self.state, self.next) = (kept.start, kept.state, kept.next);
        self.settings = control_settings(self.vehicle, &case.script, case.failure_start_s, time_s);
    }

    /// The channels that it reads and sets.
    pub fn channels(&self) -> &StageChannels {
        &self.channels
    }

    /// α at lift-off, to which the redundant integrator is set.
    pub fn initial_incidence_rad(&self) -> f64 {
        let flow = trajectory::flow_at(&self.case.wind, &self.state);
        let pitch = self.vehicle.pitch_programme().at(0.0).pitch_rad;
        pitch + self.state.range_angle_rad - flow.air_path_angle_rad
    }

    /// α_y at lift-off, with ψ = 0.
    pub fn initial_yaw_incidence_rad(&self) -> f64 {
        trajectory::flow_at(&self.case.wind, &self.state).crosswind_angle_rad
    }

    /// Computes updates n from samples n.
    pub fn frame(
        &mut self,
        samples: &Samples,
        updates: &mut Updates,
    ) -> Result<FrameResult, FlightFault> {
        let attitude = self.channels.adc.read(samples);
        let time_s = samples.tick.secs();
        let slow_due = samples.run_state() != RunState::Ended && self.slow.due(samples.frame);
        if slow_due {
            self.begin_step(samples.tick, &attitude, updates)?;
        }
        let state = self.trajectory_at(samples.tick);
        let (flow, airframe) =
            trajectory::surroundings(self.vehicle, &self.case.wind, time_s, &state)?;
        self.set_slopes(&airframe, updates);
        if let Some(channels) = self.added.moments {
            let per_angle = airframe.moment_slope_nmprad / airframe.pitch_inertia_kgm2;
            let angles = [attitude.incidence_rad, attitude.yaw_incidence_rad];
            for (channel, angle) in channels.into_iter().zip(angles) {
                updates.set_dac(channel, per_angle * angle);
            }
        }
        self.edges.merge(airframe.edges);
        Ok(FrameResult {
            sample: self.sample(time_s, state, &attitude, &flow, &airframe),
            attitude,
            airframe,
            settings: self.settings,
            edges: std::mem::replace(&mut self.edges, EdgeRecord::NONE),
        })
    }

    /// The slow task: one trajectory step, and everything held over it.
    fn begin_step(
        &mut self,
        tick: Tick,
        attitude: &AttitudeSample,
        updates: &mut Updates,
    ) -> Result<(), FlightFault> {
        let time_s = tick.secs();
        self.start = tick;
        self.state = self.next;
        let sampled = Attitude {
            pitch_rad: attitude.angle_rad[0],
            yaw_rad: attitude.angle_rad[1],
            control_force_n: attitude.control_force_n,
        };
        let wind = &self.case.wind;
        let step_s = self.step.secs();
        let (frame, axes) = ((time_s, step_s), self.options.axes.into());
        let (next, edges) =
            trajectory::advance_in(axes, self.vehicle, wind, frame, &self.state, (&sampled, 0.0))?;
        self.next = next;
        self.edges.merge(edges);
        let command = self.vehicle.pitch_programme().at(time_s);
        self.edges.note(TableName::PitchProgramme, command.edge);
        self.settings =
            control_settings(self.vehicle, &self.case.script, self.case.failure_start_s, time_s);

        let (flow, airframe) = trajectory::surroundings(self.vehicle, wind, time_s, &self.state)?;
        let offset =
            |state: &TrajectoryState, flow: &Flow| state.range_angle_rad - flow.air_path_angle_rad;
        let offset_rad = offset(&self.state, &flow);
        let next_flow = trajectory::flow_at(wind, &self.next);
        let next_offset_rad = offset(&self.next, &next_flow);
        let alpha_error = attitude.angle_rad[0] + offset_rad - attitude.incidence_rad;
        let redundant = self.alpha == AlphaPath::Redundant;
        let mend = if redundant { CORRECTION_GAIN * alpha_error / step_s } else { 0.0 };

        if let Some([drift, mend]) = self.added.beta {
            let turned = next_flow.crosswind_angle_rad - flow.crosswind_angle_rad;
            let error =
                attitude.angle_rad[1] + flow.crosswind_angle_rad - attitude.yaw_incidence_rad;
            updates.set_dac(drift, turned / step_s);
            updates.set_dac(mend, CORRECTION_GAIN * error / step_s);
        }
        let dac = &self.channels.dac;
        let per_inertia = airframe.misalignment_moment_nm / airframe.pitch_inertia_kgm2;
        for (channel, value) in [
            (dac.theta_c, command.pitch_rad),
            (dac.gamma_air, flow.air_path_angle_rad),
            (dac.range_angle, self.state.range_angle_rad),
            (dac.wind_angle, flow.crosswind_angle_rad),
            (dac.alpha_drift, (next_offset_rad - offset_rad) / step_s),
            (dac.alpha_mend, mend),
            (dac.dead_zone, self.settings.gains.dead_zone_rad),
            (dac.a_misalign_p, self.case.pitch_misalignment * per_inertia),
            (dac.a_misalign_y, self.case.yaw_misalignment * per_inertia),
            (dac.a_cant, airframe.fin_cant_moment_nm / airframe.roll_inertia_kgm2),
            (dac.roll_reference, self.case.roll_drift.reference_rad(time_s)),
        ] {
            updates.set_dac(channel, value);
        }
        let (dcu, gains) = (&self.channels.dcu, &self.settings.gains);
        let [u_pitch, u_yaw] = self.settings.ftc_gain();
        let [demand_p, demand_y] = self.settings.tvc_gain_nprad();
        for (channel, value) in [
            (dcu.lead_f_p, gains.ftc_lead_s),
            (dcu.lead_f_y, gains.ftc_lead_s),
            (dcu.u_pitch, u_pitch),
            (dcu.u_yaw, u_yaw),
            (dcu.lead_phi, self.settings.roll_lead_s),
            (dcu.u_roll, self.settings.roll_gain),
            (dcu.dead_zone_yield, gains.dead_zone_yield),
            (dcu.lead_t_p, gains.tvc_lead_s),
            (dcu.lead_t_y, gains.tvc_lead_s),
            (dcu.demand_p, demand_p),
            (dcu.demand_y, demand_y),
        ] {
            updates.set_dcu(channel, value);
        }
        updates.set_control(self.channels.line.redundant, redundant);
        updates.set_control(self.channels.line.resolved, self.case.roll_drift.resolved);
        Ok(())
    }

    /// The fast task's outputs: aerodynamic slopes and control effectiveness.
    fn set_slopes(&self, k: &AirframeCoefficients, updates: &mut Updates) {
        let dcu = &self.channels.dcu;
        let s = &self.settings;
        let (i_yy, i_xx) = (k.pitch_inertia_kgm2, k.roll_inertia_kgm2);
        let pair_n = k.tip_pair_force_slope_nprad;
        let pair_accel = k.tip_arm_m * pair_n / i_yy;
        let half_roll = 0.5 * k.tip_pair_roll_slope_nmprad / i_xx;
        for (channel, value) in [
            (dcu.mu_alpha_p, k.moment_slope_nmprad / i_yy),
            (dcu.mu_alpha_y, k.moment_slope_nmprad / i_yy),
            (dcu.mu_rate_p, k.rate_damping_nms / i_yy),
            (dcu.mu_rate_y, k.rate_damping_nms / i_yy),
            (dcu.roll_damping, k.roll_damping_nms / i_xx),
            (dcu.accel_tip_p, s.pitch_tips_effectiveness * pair_accel),
            (dcu.accel_tip_2, 0.5 * s.tip_2_effectiveness * pair_accel),
            (dcu.accel_tip_4, 0.5 * s.tip_4_effectiveness * pair_accel),
            (dcu.accel_tvc_p, k.tvc_arm_m / i_yy),
            (dcu.accel_tvc_y, k.tvc_arm_m / i_yy),
            (dcu.roll_tip_2, s.tip_2_effectiveness * half_roll),
            (dcu.roll_tip_4, s.tip_4_effectiveness * half_roll),
            (dcu.side_tip_p, s.pitch_tips_effectiveness * pair_n),
            (dcu.side_tip_2, 0.5 * s.tip_2_effectiveness * pair_n),
            (dcu.side_tip_4, 0.5 * s.tip_4_effectiveness * pair_n),
        ] {
            updates.set_dcu(channel, value);
        }
    }

    /// The trajectory within the current step, linear between its ends.
    fn trajectory_at(&self, tick: Tick) -> TrajectoryState {
        let part = (tick - self.start).0 as f64 / self.step.0 as f64;
        let (a, b) = (self.state.to_array(), self.next.to_array());
        TrajectoryState::from_array(std::array::from_fn(|i| a[i] + part * (b[i] - a[i])))
    }

    fn sample(
        &self,
        time_s: f64,
        trajectory: TrajectoryState,
        attitude: &AttitudeSample,
        flow: &Flow,
        airframe: &AirframeCoefficients,
    ) -> FlightSample {
        FlightSample {
            time_s,
            trajectory,
            angle_rad: attitude.angle_rad,
            pitch_command_rad: self.vehicle.pitch_programme().at(time_s).pitch_rad,
            // The true incidence at this instant, whatever path the loop uses.
            incidence_rad: attitude.angle_rad[0] + trajectory.range_angle_rad
                - flow.air_path_angle_rad,
            yaw_incidence_rad: attitude.angle_rad[1] + flow.crosswind_angle_rad,
            mach: airframe.mach,
            dynamic_pressure_pa: airframe.dynamic_pressure_pa,
            tip_rad: attitude.tip_rad,
            tvc_n: attitude.tvc_n,
            impact: impact_point(&self.vehicle.data().site, &trajectory),
        }
    }
}
