//! Tankage of the side-force fluid (objective v of the paper): what the worst conditions of
//! disturbances ask for, and the reserve.
//!
//! Every mode is flown in the synthetic wind from ahead and from behind, its share across blowing
//! to either side, under three-sigma thrust misalignments of either sign in both planes: the worst
//! of these is the worst flown case. Beside it each contributor acts alone, with the sign that
//! costs more; what it adds to the undisturbed flight of the mode is summed as independent, by the
//! root of the sum of squares. The tank must hold the larger of the two, over all modes, and the
//! reserve of the data set.

use super::{
    fault::StudyFault,
    long_period::run::{LongPeriodPlan, fly_all},
};
use crate::linkage::console::Console;
use desk::{
    outcome::Outcome,
    report::{Cell, Column, Table},
};
use vehicle::{
    Vehicle,
    flight_mode::FlightScript,
    flight_summary::FlightSummary,
    reference::{FlightCase, RollDrift},
    wind::Wind,
};

/// Signs of the wind along (−1 from ahead) and across (+1 to starboard), and of the misalignments
/// in pitch and yaw; 0 where it does not act.
type Signs = [f64; 4];
/// Number of contributors.
const CONTRIBUTORS: usize = 4;

/// Of every mode: undisturbed, each contributor alone with either sign, and all together.
fn all_signs() -> Vec<Signs> {
    let mut signs = vec![[0.0; CONTRIBUTORS]];
    for contributor in 0..CONTRIBUTORS {
        for sign in [-1.0, 1.0] {
            let mut alone = [0.0; CONTRIBUTORS];
            alone[contributor] = sign;
            signs.push(alone);
        }
    }
    let together = |n: usize| std::array::from_fn(|i| if n >> i & 1 == 0 { -1.0 } else { 1.0 });
    signs.extend((0..1 << CONTRIBUTORS).map(together));
    signs
}

/// What one mode asks for.
#[derive(Clone, Debug, PartialEq)]
pub struct ModeTankage {
    /// Its name.
    pub mode: String,
    /// Undisturbed, kg.
    pub undisturbed_kg: f64,
    /// What wind along, wind across and misalignments in pitch and yaw add, each alone and with
    /// the sign that costs more, kg.
    pub added_kg: [f64; CONTRIBUTORS],
    /// The worst of all flown together, with its signs.
    pub worst: (Signs, FlightSummary),
    /// Flights that were lost; what they would have used is not known.
    pub lost: usize,
}

impl ModeTankage {
    /// Undisturbed and the root of the sum of squares of what is added, kg.
    pub fn root_sum_square_kg(&self) -> f64 {
        self.undisturbed_kg + self.added_kg.iter().map(|kg| kg * kg).sum::<f64>().sqrt()
    }

    /// The larger of the two estimates, kg.
    fn asked_kg(&self) -> f64 {
        self.root_sum_square_kg().max(self.worst.1.injectant_kg)
    }
}

/// What all modes ask for.
#[derive(Clone, Debug, PartialEq)]
pub struct Tankage {
    /// Modes of which enough flights came to burn-out.
    pub modes: Vec<ModeTankage>,
    /// Modes of which nothing can be said.
    pub unknown: Vec<String>,
    /// Reserve, fraction.
    pub reserve: f64,
    /// What is carried, kg.
    pub carried_kg: f64,
}

/// Number of flights for so many modes.
pub fn flights(modes: usize) -> usize {
    modes * all_signs().len()
}

/// Flies every mode of the plan under all signs.
pub fn run(
    console: &mut Console<'_>,
    vehicle: &Vehicle,
    plan: &LongPeriodPlan,
    progress: impl FnMut(usize),
) -> Result<Tankage, StudyFault> {
    let signs = all_signs();
    let case = |script: &FlightScript, [along, cross, pitch, yaw]: &Signs| {
        Ok(FlightCase {
            script: script.clone(),
            failure_start_s: 0.0,
            wind: Wind::signed(vehicle, *along, *cross)?,
            pitch_misalignment: *pitch,
            yaw_misalignment: *yaw,
            roll_drift: RollDrift::NONE,
        })
    };
    let all = plan.modes.iter().flat_map(|mode| signs.iter().map(move |s| (mode, s)));
    let cases = all.map(|(mode, s)| case(mode, s)).collect::<Result<Vec<_>, StudyFault>>()?;
    let answers = fly_all(console, vehicle, plan, (&cases, false), progress)?;
    let ended: Vec<Option<FlightSummary>> = answers.into_iter().map(|a| a.ended.ok()).collect();
    let data = vehicle.data();
    let mut tankage = Tankage {
        modes: Vec::new(),
        unknown: Vec::new(),
        reserve: data.tvc.reserve_fraction,
        carried_kg: data.tvc.fluid_kg,
    };
    for (script, flown) in plan.modes.iter().zip(ended.chunks(signs.len())) {
        match of_mode(&script.name, &signs, flown) {
            Some(mode) => tankage.modes.push(mode),
            None => tankage.unknown.push(script.name.clone()),
        }
    }
    Ok(tankage)
}

fn of_mode(name: &str, signs: &[Signs], flown: &[Option<FlightSummary>]) -> Option<ModeTankage> {
    let (undisturbed, rest) = flown.split_first()?;
    let (alone, together) = rest.split_at(2 * CONTRIBUTORS);
    let undisturbed_kg = undisturbed.as_ref()?.injectant_kg;
    let mut added_kg = [0.0; CONTRIBUTORS];
    for (added, pair) in added_kg.iter_mut().zip(alone.chunks(2)) {
        for flight in pair {
            *added = f64::max(*added, flight.as_ref()?.injectant_kg - undisturbed_kg);
        }
    }
    let known = signs[1 + alone.len()..].iter().zip(together);
    let known = known.filter_map(|(signs, flight)| flight.map(|flight| (*signs, flight)));
    let worst = known.max_by(|a, b| a.1.injectant_kg.total_cmp(&b.1.injectant_kg))?;
    let lost = flown.iter().filter(|flight| flight.is_none()).count();
    Some(ModeTankage { mode: name.to_owned(), undisturbed_kg, added_kg, worst, lost })
}

impl Tankage {
    /// What the tank must hold, kg, and the mode that asks for it.
    pub fn needed_kg(&self) -> Option<(f64, &ModeTankage)> {
        let worst = self.modes.iter().max_by(|a, b| a.asked_kg().total_cmp(&b.asked_kg()))?;
        Some(((1.0 + self.reserve) * worst.asked_kg(), worst))
    }

    /// Adds the table, the sentence and what could not be flown.
    pub fn fill(&self, out: &mut Outcome) {
        let columns: [Column<ModeTankage>; 14] = [
            Column::new("Mode", "", |m| m.mode.as_str().into()),
            Column::of("Undisturbed", "kg", 3, |m| m.undisturbed_kg.into()),
            Column::of("Wind along adds", "kg", 3, |m| m.added_kg[0].into()),
            Column::of("wind across", "kg", 3, |m| m.added_kg[1].into()),
            Column::of("misalignment in pitch", "kg", 3, |m| m.added_kg[2].into()),
            Column::of("in yaw", "kg", 3, |m| m.added_kg[3].into()),
            Column::of("Root sum square", "kg", 3, |m| m.root_sum_square_kg().into()),
            Column::of("Worst flown", "kg", 3, |m| m.worst.1.injectant_kg.into()),
            Column::new("wind from", "", |m| side(m.worst.0[0], "ahead", "behind")),
            Column::new("across to", "", |m| side(m.worst.0[1], "port", "starboard")),
            Column::new("pitch", "3σ", |m| side(m.worst.0[2], "−1", "+1")),
            Column::new("yaw", "3σ", |m| side(m.worst.0[3], "−1", "+1")),
            Column::of("Impulse in pitch", "kN·s", 3, |m| {
                (m.worst.1.tvc_pitch_impulse_ns / 1e3).into()
            }),
            Column::of("in yaw", "kN·s", 3, |m| (m.worst.1.tvc_yaw_impulse_ns / 1e3).into()),
        ];
        out.section("Tankage of the side-force fluid").table(
            "tankage",
            "What every mode asks for: what each contributor adds alone, with the sign that costs more (the wind of the envelope, three-sigma misalignments), their root sum square on the undisturbed flight, and the worst of all 16 combinations of signs as flown.",
            Table::of(&columns, &self.modes),
        );
        if let Some((needed_kg, worst)) = self.needed_kg() {
            let percent = 100.0 * self.reserve;
            let worst_kg = worst.worst.1.injectant_kg;
            let sum_kg = worst.root_sum_square_kg();
            let of = format!("{}; by root sum square {sum_kg:.0} kg", worst.mode);
            let carried =
                format!("with {percent:.0} % of reserve; {:.0} kg are carried", self.carried_kg);
            let results = &mut out.results;
            results.add("fluid_worst_kg", "Side-force fluid, worst flown", worst_kg, 3, "kg", of);
            results.add("tankage_kg", "Side-force fluid, tankage", needed_kg, 3, "kg", carried);
        }
        for mode in self.modes.iter().filter(|m| m.lost > 0) {
            out.remarks.push(format!(
                "tankage: {} flights of {} were lost; what they would have used is not known",
                mode.lost, mode.mode
            ));
        }
        if !self.unknown.is_empty() {
            out.remarks.push(format!(
                "tankage: nothing can be said of {}: undisturbed or under single disturbances they were lost",
                self.unknown.join(", ")
            ));
        }
    }
}

fn side(sign: f64, negative: &str, positive: &str) -> Cell {
    if sign < 0.0 { negative.into() } else { positive.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_contributor_alone_and_all_signs_together() {
        let signs = all_signs();
        assert_eq!(signs.len(), 1 + 2 * 4 + 16);
        for (i, one) in signs.iter().enumerate() {
            let acting = one.iter().filter(|s| **s != 0.0).count();
            assert_eq!(
                acting,
                if i == 0 {
                    0
                } else if i <= 8 {
                    1
                } else {
                    4
                }
            );
            assert!(!signs[..i].contains(one));
        }
    }
}
