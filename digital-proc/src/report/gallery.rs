//! A page of every component, made only by the tests; it is what is looked at when the
//! style sheet changes (`REPORT_GALLERY=DIR` keeps it).

use std::path::Path;

use interface::Tick;

use super::plot::*;
use super::*;
use crate::run_dir::{Column, PatchIdentity, RunRecord, Seed, Trace, TraceWriter};
use crate::study::claim::{Claim, Evidence, Verdict};

/// A smooth stand-in for a flight: shapes and magnitudes only.
fn sample_trace(rows: usize) -> Trace {
    let columns = FLIGHT_COLUMNS.map(|(name, unit)| Column::new(name, unit));
    let mut bytes = Vec::new();
    let mut writer = TraceWriter::new(&mut bytes, Path::new("sample"), &columns, 64).unwrap();
    for n in 0..rows {
        let t = 49.0 * n as f64 / (rows - 1) as f64;
        let q = 95_000.0 * (-((t - 32.0) / 11.0).powi(2)).exp();
        let alpha = 0.03 * (t * 0.9).sin() * (-t / 30.0).exp();
        let row = [
            21.5 * t,
            1.57 - 0.4 * (t / 49.0).powi(2),
            9.8 * t * t,
            2e-5 * t * t,
            alpha,
            0.07 * t,
            q,
            q * alpha,
            1.57 - 0.42 * (t / 49.0).powi(2) + 0.01 * (2.0 * t).sin(),
            0.002 * (0.7 * t).cos(),
            if t > 17.0 { 8_000.0 * (3.0 * t).sin() } else { 0.0 },
        ];
        writer.push(Tick((t * 1e9) as i64), &row).unwrap();
    }
    writer.finish().unwrap();
    Trace::from_bytes(&bytes, Path::new("sample")).unwrap()
}

fn sample_record() -> RunRecord {
    RunRecord {
        command: "fly normal".to_owned(),
        command_line: ["digital-proc", "fly", "--mode", "normal"].map(str::to_owned).to_vec(),
        started: "2026-03-01T12:34:56Z".to_owned(),
        profile: "ideal".to_owned(),
        link: "shm".to_owned(),
        versions: [("digital-proc".to_owned(), "0.1.0".to_owned())].into(),
        patch: Some(PatchIdentity {
            name: "stage.toml".to_owned(),
            sha256: "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08".to_owned(),
        }),
        seeds: [("gyro noise".to_owned(), Seed(7))].into(),
        parameters: toml::toml! { frame = "100ms" [wind] shear_per_s = 0.028 },
    }
}

fn sample_flight(rows: usize) -> String {
    let mut summary = Summary::new();
    summary.add("max_q_kpa", "Maximum dynamic pressure", 94.87, 4, "kPa", "at 32.1 s, Mach 2.21");
    summary.add("velocity_m_s", "Burn-out velocity", 1053.2, 5, "m/s", "");
    summary.add("altitude_km", "Burn-out altitude", 23.61, 4, "km", "");
    let context = FlightContext {
        title: "First-stage flight, normal mode".to_owned(),
        lead: "Two processes, 0.1 s frames, no wind.".to_owned(),
        q_alpha_limit_pa_rad: Some(2_000.0),
        marks: vec![Mark { x: 17.0, name: "FTC on".to_owned() }],
        further: Vec::new(),
    };
    flight_report(&context, &summary, &sample_trace(rows), &sample_record()).unwrap()
}

fn gallery() -> String {
    let mut number = Numbering::new();
    let t: Vec<f64> = (0..2_000).map(|n| f64::from(n) * 0.006).collect();
    let response = |w: f64, z: f64| -> Vec<f64> {
        t.iter().map(|t| 2.0 * (1.0 - (-z * w * t).exp() * (w * t).cos())).collect()
    };
    let names = [
        "normal",
        "FTC gain × 0.05",
        "TVC pole 1 rad/s",
        "gyro moved",
        "fast TVC",
        "control +20 %",
        "aero −20 %",
        "gain step late",
    ];
    let series = names
        .iter()
        .enumerate()
        .map(|(i, name)| {
            Series::line(*name, &t, &response(1.5 + 0.3 * i as f64, 0.5 / (i + 1) as f64))
        })
        .collect();
    let responses = LineChart::new(
        "Pitch response to a 2° step, 20 s",
        Axis::new("Time", "s"),
        Axis::new("Pitch attitude θ", "°"),
        series,
    )
    .limit(2.5, "overshoot 25 %")
    .mark(5.0, "residual from")
    .mark(10.0, "to");
    let per_cycle: Vec<f64> = (0..40).map(|n| 10f64.powf(1.0 + f64::from(n) / 25.0)).collect();
    let law = |k: f64| -> Vec<f64> { per_cycle.iter().map(|n| k / n.powf(1.2)).collect() };
    let thin = |v: &[f64]| -> Vec<f64> { v.iter().step_by(5).copied().collect() };
    let (few, a, b) = (thin(&per_cycle), law(20.0), law(1.5));
    let theory = measured_vs_theory(
        "Growth per cycle of the circle test",
        Axis::new("Samples per cycle", "").log(),
        Axis::new("Growth per cycle", "%").log(),
        &[
            Compared {
                name: "zero-order hold".to_owned(),
                measured: (few.clone(), thin(&a)),
                theory: (per_cycle.clone(), a),
            },
            Compared {
                name: "extrapolating".to_owned(),
                measured: (few, thin(&b)),
                theory: (per_cycle, b),
            },
        ],
    );
    let step_x: Vec<f64> = (0..30).map(f64::from).collect();
    let step_y: Vec<f64> =
        step_x.iter().map(|x| if *x == 12.0 { f64::NAN } else { (x * 0.4).sin() * 3e-7 }).collect();
    let held = LineChart::new(
        "Held DAC output with a missing frame",
        Axis::new("Time", "ms"),
        Axis::new("Voltage", "V"),
        vec![
            Series::step("DAC", &step_x, &step_y),
            Series::line("ideal", &step_x, &step_y).draw(Draw::LineAndMarkers),
        ],
    );
    let conditions = ["normal", "rate gyro forward", "FTC gain × 0.05", "TVC pole 10 → 1 rad/s"];
    let points = [
        "vertical rise 2 s",
        "pitch start 4 s",
        "7.5 s",
        "17 s",
        "transonic 18.3 s",
        "20 s",
        "25 s",
        "max Q 32.5 s",
        "34 s",
        "40 s",
        "45 s",
        "burn-out 47 s",
    ];
    let map = HeatMap {
        quantity: "Residual oscillation of θ, % of the step; criterion ≤ 5 %".to_owned(),
        corner: "Condition".to_owned(),
        rows: conditions.map(str::to_owned).to_vec(),
        columns: points.map(str::to_owned).to_vec(),
        cells: (0..4)
            .map(|r| {
                (0..12)
                    .map(|c| {
                        let value = 1.3 + f64::from(r * r * c) * 0.9;
                        HeatCell {
                            value,
                            violated: value > 5.0,
                            href: (value > 60.0).then(|| "#figure-4".to_owned()),
                        }
                    })
                    .collect()
            })
            .collect(),
        scale: None,
        digits: 2,
    };
    let bars = [
        ("Aerodynamic moment slope ±20 %", 18.0, 31.0),
        ("Bending frequency ±10 %", 23.1, 24.9),
        ("TVC time constant ±50 %", 26.0, 29.5),
        ("Gyro location ±1 m", 23.8, 24.1),
        ("FTC effectiveness ±10 %", 21.9, 26.4),
    ];
    let sensitivity = Tornado {
        title: "Sensitivity of the overshoot at maximum Q".to_owned(),
        x: Axis::new("Overshoot", "%"),
        nominal: 24.0,
        bars: bars
            .map(|(name, low, high)| TornadoBar { name: name.to_owned(), low, high })
            .to_vec(),
    };
    let waits = Histogram {
        title: "Transfer latency".to_owned(),
        x: Axis::new("Latency", "µs").log(),
        values: (1..5_000)
            .map(|n| 2.0 + 30.0 / f64::from(n).sqrt() + f64::from(n % 7) * 0.2)
            .collect(),
        bins: 40,
        log_counts: true,
        size: Size::HALF,
    };
    let claim =
        |id, sentence, criterion: &str, measured: &str, verdict, remark: Option<&str>| Claim {
            id,
            evidence: Evidence::FIGURE_4,
            sentence,
            criterion: criterion.to_owned(),
            measured: measured.to_owned(),
            verdict,
            remark: remark.map(str::to_owned),
        };
    let claims = [
        claim(
            "P1",
            "For a step command in pitch, the normal mode response of θ is found to be quite satisfactory.",
            "overshoot ≤ 25 %, residual ≤ 5 %, at every point",
            "21.4 %, 3.1 % (worst: 17 s)",
            Verdict::Holds,
            None,
        ),
        claim(
            "L2",
            "The load profiles single out a failure mode which violates the design structural load limit.",
            "exactly one mode exceeds the limit",
            "TVC dead zone stuck: 112 % of the limit",
            Verdict::NotJudged,
            Some("no flight with a tailwind was asked for"),
        ),
        claim(
            "Y2",
            "The fin tips saturate, calling in the TVC for the yaw axis.",
            "TVC above 20 % within 0.6 s",
            "14 % at 0.6 s",
            Verdict::Fails,
            None,
        ),
    ];
    let mut table = Table::new(vec![
        Heading::new("Dispersion", ""),
        Heading::new("Overshoot", "%"),
        Heading::new("Damping", "").digits(3),
        Heading::new("Shift", "rad/s"),
    ]);
    table.row(["Bending frequency".into(), 24.93.into(), 0.312_3.into(), (-1.2e-5).into()]);
    table.row(["TVC time constant".into(), 29.5.into(), (-0.05).into(), f64::NAN.into()]);
    let sections = vec![
        Section::new(
            "Partition",
            number.figure(
                "partition",
                "Who computes what.",
                block_diagram(&Partition::long_period()),
            ),
        ),
        Section::new(
            "Responses",
            number.figure(
                Evidence::FIGURE_4.anchor(),
                "Pitch responses for eight conditions; the limit is 25 % over the step.",
                line_chart(&responses),
            ),
        ),
        Section::new(
            "Condition matrix",
            number.table(
                "matrix",
                "Residual oscillation by condition and trajectory point.",
                heat_map(&map),
            ),
        ),
        Section::new(
            "Sensitivity",
            maud::html! {
                (number.figure("tornado", "Ranked by span.", tornado(&sensitivity)))
                (number.table("dispersions", "The same in numbers.", table.markup()))
            },
        ),
        Section::new(
            "Sampling",
            maud::html! {
                (number.figure("circle", "Lines are theory, markers are measured.", line_chart(&theory)))
                (side_by_side(&[
                    number.figure("held", "A gap stays a gap.", line_chart(&held.size(Size::HALF))),
                    number.figure("latency", "Counts on a logarithmic scale.", histogram(&waits)),
                ]))
            },
        ),
        Section::new("Claims", claims_table(&claims, &number)),
        Section::new("Provenance", provenance(&sample_record())),
    ];
    page(
        "First-stage control system: case study",
        "Every component of a report on one page, with made-up data.",
        &sections,
    )
}

fn refers_outside(html: &str) -> bool {
    // Inside a page only `href="#…"` may lead anywhere.
    ["http:", "https:", "//", "src=", "@import", "url(", "<script", "<link"]
        .iter()
        .any(|outside| html.contains(outside))
        || html.matches("href=").count() != html.matches("href=\"#").count()
}

#[test]
fn pages_are_self_contained_and_links_have_targets() {
    for html in
        [gallery(), sample_flight(491), trace_report("t", &sample_trace(20), &sample_record())]
    {
        assert!(!refers_outside(&html));
        for link in html.split("href=\"#").skip(1) {
            let target = link.split('"').next().unwrap();
            assert!(html.contains(&format!("id=\"{target}\"")), "#{target} leads nowhere");
        }
        assert!(!html.contains("NaN"));
    }
}

#[test]
fn a_flights_report_is_small() {
    // Eleven curves of at most 800 points of at most 10 bytes, and 60 kB for the rest.
    let html = sample_flight(24_500);
    assert!(html.len() < 11 * 800 * 10 + 60_000, "{} bytes", html.len());
}

#[test]
fn a_missing_column_is_named() {
    let columns = [Column::new("velocity_m_s", "m/s")];
    let mut bytes = Vec::new();
    TraceWriter::new(&mut bytes, Path::new("t"), &columns, 8).unwrap().finish().unwrap();
    let trace = Trace::from_bytes(&bytes, Path::new("t")).unwrap();
    let error = flight_report(&FlightContext::default(), &Summary::new(), &trace, &sample_record());
    assert!(error.unwrap_err().to_string().contains("flight_path_angle_rad"));
}

#[test]
fn the_gallery_is_kept_when_asked_for() {
    let temporary = tempfile::tempdir().unwrap();
    let kept = std::env::var_os("REPORT_GALLERY").map(std::path::PathBuf::from);
    let folder = kept.as_deref().unwrap_or(temporary.path());
    for (name, html) in [("gallery.html", gallery()), ("flight.html", sample_flight(2_450))] {
        std::fs::write(folder.join(name), &html).unwrap();
        assert!(html.ends_with("</html>"));
    }
}
