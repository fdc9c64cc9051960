//! The exact poles of a study's loop: the machine's own linear model of the patch at IC, closed
//! through the law as it is sampled, held and late. They are those of the measured loop as long as
//! it stays within the regions of that instant, whatever its converters round.

use super::{
    super::{
        bench::Bench,
        plan::LabError,
        theory::{
            C64, equivalent_root, nearest_root,
            period_map::ORIGIN,
            sampled_loop::{LinearLaw, Plant, period_map},
        },
    },
    LoopCase, LoopStudy,
    row::oscillates,
};
use crate::linkage::console::ConsoleFault;
use interface::{Tick, control::LinearModel, profile::Profile};
use nalgebra::{ComplexField, DMatrix, linalg::balancing::balance_parlett_reinsch};

/// Words of a law's memory beyond which its poles are not sought: a second's work.
const MOST_MEMORY: usize = 300;

/// The poles of one case.
#[derive(Clone, Debug)]
pub struct Poles {
    /// z of one frame.
    discrete: Vec<C64>,
    frame_s: f64,
}

impl Poles {
    /// Of the loop of `study` whose patch is loaded under `profile`; a reason where there are none.
    ///
    /// # Errors
    /// A lost partner.
    pub fn of(
        study: &LoopStudy,
        bench: &mut Bench<'_, '_>,
        profile: &Profile,
        case: &LoopCase,
    ) -> Result<Result<Poles, String>, LabError> {
        if profile.aperture() > Tick::ZERO || profile.settling() > Tick::ZERO {
            return Ok(Err("the profile's aperture and settling are not in them".to_owned()));
        }
        let (adcs, dacs) = (names(study, |law| &law.inputs), names(study, |law| &law.outputs));
        let law = match joined(study, &adcs, &dacs) {
            Ok(law) => law,
            Err(reason) => return Ok(Err(reason)),
        };
        let model = match bench.linearise(&dacs, &adcs) {
            Ok(model) => model,
            Err(ConsoleFault::Refused(reason)) => return Ok(Err(reason)),
            Err(fault) => return Err(fault.into()),
        };
        let LinearModel { states, a, b, c, d } = model;
        let (n, m, p) = (states.len(), dacs.len(), adcs.len());
        let mut plant = Plant {
            a: DMatrix::from_row_slice(n, n, &a),
            b: DMatrix::from_row_slice(n, m, &b),
            c: DMatrix::from_row_slice(p, n, &c),
            d: DMatrix::from_row_slice(p, m, &d),
        };
        // x = S z: states in units in which they are alike.
        if n > 0 && a.iter().all(|v| v.abs() < 1e150) {
            let scales = balance_parlett_reinsch(&mut plant.a);
            for (i, scale) in scales.iter().enumerate() {
                plant.b.row_mut(i).scale_mut(1.0 / scale);
                plant.c.column_mut(i).scale_mut(*scale);
            }
        }
        let (frame_s, latency_s) = (case.frame.secs(), case.latency.secs());
        let map = period_map(&plant, &law, profile.hold().into(), frame_s, latency_s)?;
        Ok(match map.balanced().discrete_roots() {
            Ok(discrete) => Ok(Poles { discrete, frame_s }),
            Err(fault) => Err(fault.to_string()),
        })
    }

    /// Greatest |z|: below 1 the loop is stable.
    pub fn spectral_radius(&self) -> f64 {
        self.discrete.iter().map(|z| z.modulus()).fold(0.0, f64::max)
    }

    /// The oscillatory root nearest to a measured one, or else the least damped, rad/s.
    pub fn oscillation(&self, measured: Option<C64>) -> Option<C64> {
        let modes = self.discrete.iter().filter(|z| z.modulus() > ORIGIN);
        let roots = modes.map(|z| equivalent_root(*z, self.frame_s));
        let all: Vec<C64> = roots.filter(|s| oscillates(*s, self.frame_s)).collect();
        match measured {
            Some(measured) => nearest_root(&all, measured),
            None => all.into_iter().max_by(|a, b| a.re.total_cmp(&b.re)),
        }
    }
}

/// Channels of all laws, each once.
fn names(study: &LoopStudy, of: fn(&super::LawSpec) -> &Vec<super::Named>) -> Vec<&str> {
    let mut all: Vec<&str> = Vec::new();
    for named in study.laws.iter().flat_map(of) {
        if !all.contains(&named.name.as_str()) {
            all.push(&named.name);
        }
    }
    all
}

/// All laws as one from `adcs` to `dacs`; why there is none.
fn joined(study: &LoopStudy, adcs: &[&str], dacs: &[&str]) -> Result<LinearLaw, String> {
    let laws = study.laws.iter().map(|law| law.element.linear());
    let laws: Option<Vec<LinearLaw>> = laws.collect();
    let laws = laws.ok_or("the law has a table")?;
    let memory: usize = laws.iter().map(|law| law.f.nrows()).sum();
    if memory > MOST_MEMORY {
        return Err(format!("the law remembers {memory} values, more than {MOST_MEMORY}"));
    }
    let mut all = LinearLaw {
        f: DMatrix::zeros(memory, memory),
        g: DMatrix::zeros(memory, adcs.len()),
        h: DMatrix::zeros(dacs.len(), memory),
        j: DMatrix::zeros(dacs.len(), adcs.len()),
    };
    let mut start = 0;
    for (spec, law) in study.laws.iter().zip(&laws) {
        let words = law.f.nrows();
        let place = |of: &[&str], name: &str| of.iter().position(|n| *n == name).unwrap_or(0);
        all.f.view_mut((start, start), (words, words)).copy_from(&law.f);
        for (k, input) in spec.inputs.iter().enumerate() {
            let adc = place(adcs, &input.name);
            for i in 0..words {
                all.g[(start + i, adc)] += law.g[(i, k)];
            }
            for (i, output) in spec.outputs.iter().enumerate() {
                all.j[(place(dacs, &output.name), adc)] += law.j[(i, k)];
            }
        }
        for (i, output) in spec.outputs.iter().enumerate() {
            let dac = place(dacs, &output.name);
            all.h.view_mut((dac, start), (1, words)).copy_from(&law.h.row(i));
        }
        start += words;
    }
    Ok(all)
}
