//! `function`, `function-2d`, `digital-function`: function generators, by tables.

use super::*;
use engine::element::curve::{self, Curve, band, pieces_of_table};
use engine::element::piecewise::Piecewise;
use engine::element::surface::{Cell, Table};

kind! {
    Function(function) { x: Vec<f64>, y: Vec<f64> }
    "function", "straight lines through the points (x, y); end values hold beyond",
    "`x` increasing, `y`", r#"in = ["a"], x = [-1, 0, 1], y = [0, 2, 1]"#,
    class: Some(BlockClass::FunctionGenerator),
}

fn function(f: &mut Fields<'_, '_>) -> Option<Function> {
    let x = f.breakpoints("x");
    let y = f.numbers("y");
    let (x, y) = (x?, y?);
    if x.len() != y.len() {
        f.table_size("y", y.len(), format!("{} (one for each x)", x.len()));
        return None;
    }
    Some(Function { x, y })
}

impl Component for Function {
    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        table(to, block, o, &self.x, &self.y);
    }

    fn symbol(&self, pen: &mut Pen) {
        pen.frame();
        pen.curve("plot", &fitted(&self.x, &self.y));
    }
}

kind! {
    /// `z[i·y.len() + j] = f(x[i], y[j])`.
    Function2d(function2d) { x: Vec<f64>, y: Vec<f64>, z: Vec<f64> }
    "function-2d", "bilinear in (in0, in1)", "`x`, `y` increasing; `z`, one row an x",
    r#"in = ["a", "b"], x = [0, 1], y = [0, 1], z = [[0, 1], [2, 3]]"#,
    inputs: Inputs::named(&[("x", "x"), ("y", "y")]), class: Some(BlockClass::FunctionGenerator),
    symbol: |pen| pen.boxed("f(x,y)"),
}

fn function2d(f: &mut Fields<'_, '_>) -> Option<Function2d> {
    let x = f.breakpoints("x");
    let y = f.breakpoints("y");
    let size = x.as_ref().zip(y.as_ref()).map(|(x, y)| (x.len(), y.len()));
    let z = f.grid("z", size);
    Some(Function2d { x: x?, y: y?, z: z? })
}

impl Component for Function2d {
    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        let Function2d { x, y, z } = self.clone();
        let [u, v] = to.exactly(&block.inputs);
        let table = to.m.tables.len() as u32;
        let bands = [band(&x), band(&y)];
        to.m.tables.push(Table { x, y, z, bands });
        let slots = [u.slot, v.slot];
        let e = to.element(Piecewise::Cell(Cell { table, x: u, y: v }), &slots);
        let varying = to.vary(&slots);
        to.push(Op::Surface { o, e, table, x: u, y: v }, &[o], varying);
    }
}

kind! {
    /// Rubin's function generator.
    DigitalFunction(digital_function) { x: Vec<f64>, first_channel: u32, initial: Vec<f64> }
    "digital-function", "as `function`, ordinates set by the digital side",
    "`x`; `first-channel`: DCU of the first ordinate, the others follow; `initial` (zeros)",
    r#"in = ["a"], x = [-1, 0, 1], first-channel = 8"#,
    class: Some(BlockClass::FunctionGenerator),
}

fn digital_function(f: &mut Fields<'_, '_>) -> Option<DigitalFunction> {
    let x = f.breakpoints("x");
    let needed = x.as_ref().map_or(1, Vec::len);
    let first_channel = f.channel("first-channel", ChannelKind::Dcu, needed);
    let has_initial = f.place("initial").is_some();
    let initial = f.maybe("initial", |f| f.numbers("initial"));
    if has_initial && initial.is_none() {
        return None;
    }
    let x = x?;
    let initial = initial.unwrap_or_else(|| vec![0.0; x.len()]);
    if initial.len() != x.len() {
        f.table_size("initial", initial.len(), format!("{} (one for each x)", x.len()));
        return None;
    }
    Some(DigitalFunction { x, first_channel: first_channel?, initial })
}

impl Component for DigitalFunction {
    fn claim(&self) -> Option<Claim> {
        let (first, initial) = (self.first_channel, self.initial.clone());
        Some(Claim { kind: ChannelKind::Dcu, first, initial, range: None })
    }

    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        let curve = table(to, block, o, &self.x, &self.initial);
        // The ordinates lie side by side, so they have coefficients of their own.
        let first = to.m.dcu_channels.len() as u32;
        to.m.dcu_channels.extend((self.first_channel..).zip(self.initial.iter().copied()));
        to.m.digital_functions.push(curve::DigitalFunction { curve, first });
    }

    fn caption(&self) -> Option<String> {
        let first = self.first_channel;
        Some(format!("DCU {first}–{}", first as usize + self.x.len() - 1))
    }

    fn symbol(&self, pen: &mut Pen) {
        pen.frame();
        pen.curve("plot", &fitted(&self.x, &self.initial));
        pen.outline("axis", &[(-1.0, 0.8), (1.0, 0.8)], false);
    }
}

fn table(to: &mut Lowering, block: &Block, o: Slot, x: &[f64], y: &[f64]) -> Curve {
    let u = to.sum(&block.inputs);
    to.curve_into(o, u, x, &pieces_of_table(x, y))
}

/// A table as a curve within the symbol.
fn fitted(x: &[f64], y: &[f64]) -> Vec<(f64, f64)> {
    let bounds = |v: &[f64]| {
        let low = v.iter().copied().fold(f64::INFINITY, f64::min);
        let high = v.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        (low, (high - low).max(f64::MIN_POSITIVE))
    };
    let ((x0, width), (y0, height)) = (bounds(x), bounds(y));
    x.iter()
        .zip(y)
        .map(|(x, y)| (2.0 * (x - x0) / width - 1.0, 1.6 * (y - y0) / height - 0.8))
        .collect()
}
