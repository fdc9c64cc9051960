//! A digital law of a loop study as it stands in the text.

use super::{
    super::{loop_law::Element, theory::Refusal},
    LawSpec,
};
use desk::reader::{Named, SheetFields};
use vehicle::table::Table;

#[derive(Clone, Copy)]
enum Kind {
    GainMatrix,
    Difference,
    Delay,
    Table,
}

/// The law, or faults.
pub(super) fn law(f: &mut SheetFields<'_, '_>) -> Option<LawSpec> {
    let kinds = [
        ("gain-matrix", Kind::GainMatrix),
        ("difference-equation", Kind::Difference),
        ("delay", Kind::Delay),
        ("table", Kind::Table),
    ];
    let Some(kind) = f.word("kind", None, &kinds) else {
        // Which fields there are to be cannot be said.
        f.all();
        return None;
    };
    if let Kind::GainMatrix = kind {
        let (inputs, outputs) = (f.names("inputs"), f.names("outputs"));
        let rows = f.each("gain", "[[1.0]]", |f, key, row| f.row(key, row));
        let (inputs, outputs, rows) = (inputs?, outputs?, rows?);
        let fits = rows.len() == outputs.len() && rows.iter().all(|r| r.len() == inputs.len());
        let fault = format!("`gain` must be {} rows of {} numbers", outputs.len(), inputs.len());
        f.require(fits, "gain", fault, "one row an output, one column an input");
        return Some(LawSpec { inputs, outputs, element: Element::Gain(rows) });
    }
    let one = |named: Option<Named>| named.map(|named| vec![named]);
    let (inputs, outputs) = (one(f.named("input")), one(f.named("output")));
    let element = match kind {
        Kind::Delay => {
            let frames = f.whole_in("frames", None, 0..=u32::MAX);
            let gain = f.number("gain", Some(1.0));
            let delay = Element::delay(frames?, gain?);
            accepted(f, "frames", delay)?
        }
        Kind::Table => {
            let (x, y) = (f.numbers("x"), f.numbers("y"));
            let table = Table::new(x?, y?).map_err(Refusal::Table);
            Element::Table(accepted(f, "x", table)?)
        }
        _ => {
            let (b, a) = (f.numbers("numerator"), f.numbers("denominator"));
            let equation = Element::difference(b?, a?);
            accepted(f, "denominator", equation)?
        }
    };
    Some(LawSpec { inputs: inputs?, outputs: outputs?, element })
}

/// What was made of the values of a field, or a fault there.
fn accepted<T>(f: &mut SheetFields<'_, '_>, key: &str, made: Result<T, Refusal>) -> Option<T> {
    let (fault, remedy) = match made {
        Ok(made) => return Some(made),
        Err(Refusal::Setting { what, value, range }) => {
            (format!("{what} is {value}"), format!("it must be {range}"))
        }
        Err(other) => (other.to_string(), "correct it here".to_owned()),
    };
    f.require(false, key, fault, remedy);
    None
}
