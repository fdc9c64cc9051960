//! `analog-proc linearise`: the linear model of a patch about a state of it, its roots and its Bode diagram.

use super::{
    PatchArgs, add_files, check::Compiled, expect_page, find_net, happenings, page_record,
    write_page,
};
use desk::{
    failure::Failure,
    outcome::{Figure, Outcome},
    report::{
        Cell, Column, Heading, Table,
        plot::{Axis, LineChart, Series, line_chart},
    },
};
use engine::{id::NetId, linear::Linear};
use interface::Tick;
use nalgebra::{Complex, DMatrix};
use std::path::PathBuf;

/// Make a patch linear about a state of it: roots, matrices, Bode diagram
///
/// Make a patch linear about a state of it, every operation differentiated exactly in its region.
///
///   analog-proc linearise patch-files/van-der-pol.toml
///   analog-proc linearise patch-files/rate-servo.toml --input gust --output felt --page bode.html
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Linearise {
    #[command(flatten)]
    patch: PatchArgs,
    /// Problem time to run to before; the initial condition without it
    #[arg(long, value_name = "TIME", default_value = "0s")]
    at: Tick,
    /// Net to be taken as an input in place of what drives it; may be repeated
    #[arg(long = "input", value_name = "NET")]
    inputs: Vec<String>,
    /// Net to be taken as an output; may be repeated
    #[arg(long = "output", value_name = "NET")]
    outputs: Vec<String>,
    /// Angular frequencies of the Bode diagram, rad/s [default: a decade beyond the roots]
    #[arg(long, value_name = "LOW:HIGH", value_parser = band)]
    bode: Option<(f64, f64)>,
    /// Page to write, with the Bode diagrams
    #[arg(long, value_name = "FILE.html")]
    page: Option<PathBuf>,
}

fn band(text: &str) -> Result<(f64, f64), String> {
    let ends = text.split_once(':').map(|(low, high)| (low.trim().parse(), high.trim().parse()));
    match ends {
        Some((Ok(low), Ok(high))) if 1e-12 <= low && low < high && high <= 1e12 => Ok((low, high)),
        _ => Err("write LOW:HIGH in rad/s, from 1e-12 to 1e12, for example 0.1:100".into()),
    }
}

/// A point of a Bode diagram.
struct Point {
    input: String,
    output: String,
    omega_radps: f64,
    gain_db: f64,
    phase_deg: f64,
}

impl Linearise {
    pub fn execute(self) -> Result<(), Failure> {
        if self.at < Tick::ZERO {
            return Err(Failure::input(format!("--at {} must not be negative", self.at)));
        }
        if let Some(page) = &self.page {
            expect_page(page, &self.patch.patch)?;
        }
        let Compiled { ordered, hash } = self.patch.compile()?;
        let find = |names: &[String]| -> Result<Vec<NetId>, Failure> {
            names.iter().map(|name| find_net(&ordered, name)).collect()
        };
        let (inputs, outputs) = (find(&self.inputs)?, find(&self.outputs)?);
        let mut simulation = ordered.simulation().map_err(Failure::input)?;
        let machine = simulation.machine();
        let states: Vec<String> =
            machine.block_of_state.iter().map(|b| machine.block_names[b.index()].clone()).collect();
        if let Some(name) = self.inputs.iter().find(|name| states.contains(name)) {
            return Err(Failure::input(format!(
                "`{name}` is a state, which nothing drives at one instant; name the net that goes into it"
            )));
        }
        let mut remarks = Vec::new();
        if self.at > Tick::ZERO {
            let advance = simulation.advance_to(self.at).map_err(Failure::input)?;
            remarks = happenings(&ordered, &simulation);
            if advance.stopped_by.is_some() {
                let at = advance.reached;
                remarks.push(format!("the run ended at {at} by the patch's overload policy"));
            }
        }
        let linear = simulation.linearise(&inputs, &outputs).map_err(Failure::input)?;
        let mut outcome = Outcome::new(
            format!("{}: linear about t = {}", ordered.netlist.title, simulation.now()),
            "ẋ = A x + B u, y = C x + D u about that state, regions as they are there.",
        );
        outcome.remarks = remarks;
        let roots = linear.roots();
        outcome.section("Roots").table("roots", "Roots, by frequency", roots_table(&roots));
        let points = self.points(&linear, &roots);
        if !points.is_empty() {
            outcome.section("Frequency response").long_table(
                "bode",
                "Frequency response",
                bode(&points),
            );
            for pair in points.chunk_by(|a, b| (&a.input, &a.output) == (&b.input, &b.output)) {
                let figures = diagram(pair);
                outcome.section("Frequency response").beside(figures);
            }
        }
        let matrices = [
            ("a", "A, per second", &linear.a, &states, &states),
            ("b", "B, per second", &linear.b, &states, &self.inputs),
            ("c", "C", &linear.c, &self.outputs, &states),
            ("d", "D", &linear.d, &self.outputs, &self.inputs),
        ];
        for (key, caption, matrix, rows, columns) in matrices {
            if !matrix.is_empty() {
                outcome.section("Matrices").long_table(key, caption, table(matrix, rows, columns));
            }
        }
        if let Some(page) = &self.page {
            write_page(&outcome, &page_record("linearise", &self.patch, hash), page)?;
            add_files(&mut outcome, [page.as_path()]);
        }
        outcome.tell("linearise", None, self.patch.json)
    }

    /// All pairs of input and output at a hundred frequencies a decade.
    fn points(&self, linear: &Linear, roots: &[Complex<f64>]) -> Vec<Point> {
        const A_DECADE: f64 = 100.0;
        let sizes = || roots.iter().map(|z| size(*z)).filter(|size| *size > 0.0);
        let slowest = sizes().fold(f64::INFINITY, f64::min);
        let fastest = sizes().fold(0.0, f64::max);
        let default = if fastest > 0.0 { (slowest / 10.0, fastest * 10.0) } else { (0.01, 100.0) };
        let (low, high) = self.bode.unwrap_or(default);
        let steps = (A_DECADE * libm::log10(high / low)).ceil().clamp(1.0, 2_000.0);
        let mut points = Vec::new();
        for (k, input) in self.inputs.iter().enumerate() {
            for (i, output) in self.outputs.iter().enumerate() {
                let mut turned = 0.0;
                for step in 0..=steps as usize {
                    let omega_radps = low * libm::pow(high / low, step as f64 / steps);
                    let response = linear.response(i, k, omega_radps);
                    // Without jumps from one point to the next.
                    let principal = libm::atan2(response.im, response.re).to_degrees();
                    let phase_deg = principal + 360.0 * ((turned - principal) / 360.0).round();
                    if phase_deg.is_finite() {
                        turned = phase_deg;
                    }
                    points.push(Point {
                        input: input.clone(),
                        output: output.clone(),
                        omega_radps,
                        gain_db: 20.0 * libm::log10(size(response)),
                        phase_deg,
                    });
                }
            }
        }
        points
    }
}

fn size(z: Complex<f64>) -> f64 {
    libm::hypot(z.re, z.im)
}

fn roots_table(roots: &[Complex<f64>]) -> Table {
    let columns: [Column<Complex<f64>>; 5] = [
        Column::of("Real part", "1/s", 6, |z| z.re.into()),
        Column::of("Imaginary part", "rad/s", 6, |z| z.im.into()),
        Column::of("Frequency", "rad/s", 6, |z| size(*z).into()),
        Column::of("Damping ratio", "", 4, |z| match size(*z) {
            0.0 => None::<f64>.into(),
            size => (-z.re / size).into(),
        }),
        Column::of("Time constant", "s", 4, |z| match z.re {
            0.0 => None::<f64>.into(),
            re => (-1.0 / re).into(),
        }),
    ];
    Table::of(&columns, roots)
}

fn bode(points: &[Point]) -> Table {
    let columns: [Column<Point>; 5] = [
        Column::new("Input", "", |p| p.input.as_str().into()),
        Column::new("Output", "", |p| p.output.as_str().into()),
        Column::of("Angular frequency", "rad/s", 17, |p| p.omega_radps.into()),
        Column::of("Gain", "dB", 17, |p| p.gain_db.into()),
        Column::of("Phase", "deg", 17, |p| p.phase_deg.into()),
    ];
    Table::of(&columns, points)
}

fn diagram(pair: &[Point]) -> Vec<Figure> {
    let (input, output) = (&pair[0].input, &pair[0].output);
    let of = |name: &str, unit: &str, value: fn(&Point) -> f64| {
        let points = pair.iter().map(|p| (p.omega_radps, value(p)));
        let chart = LineChart::new(
            format!("{name} from {input} to {output}"),
            Axis::new("Angular frequency", "rad/s").log(),
            Axis::new(name, unit),
            vec![Series::of(name, points)],
        );
        let id = format!("{}-{input}-{output}", name.to_lowercase());
        Figure::new(id, format!("{name} of the linear model."), line_chart(&chart))
    };
    vec![of("Gain", "dB", |p| p.gain_db), of("Phase", "°", |p| p.phase_deg)]
}

fn table(matrix: &DMatrix<f64>, rows: &[String], columns: &[String]) -> Table {
    let headings = columns.iter().map(|name| Heading::new(name.as_str(), "").digits(6));
    let mut table = Table::new([Heading::new("Row", "")].into_iter().chain(headings).collect());
    for (name, row) in rows.iter().zip(matrix.row_iter()) {
        let values = row.iter().map(|value| Cell::from(*value));
        table.row([Cell::from(name.as_str())].into_iter().chain(values));
    }
    table
}
