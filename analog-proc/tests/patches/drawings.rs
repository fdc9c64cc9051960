//! The drawing of a patch shows every block, is well-formed, and is the same each time.

use crate::{bundle, shipped, sound};
use analog_proc::draw;
use analog_proc::order::Ordered;
use analog_proc::patch::{bundle_from_path, compile};

fn load(name: &str) -> Ordered {
    sound(compile(&bundle_from_path(&shipped(name)).unwrap(), &[]))
}

fn from_text(text: &str) -> Ordered {
    sound(compile(&bundle(text), &[]))
}

/// Texts of a drawing; panics where tags do not pair.
fn texts(drawing: &str) -> Vec<String> {
    let mut open = Vec::new();
    let mut found = Vec::new();
    for part in drawing.split('<').skip(1) {
        let (tag, text) = part.split_once('>').unwrap();
        match tag.strip_prefix('/') {
            Some(name) => assert_eq!(open.pop(), Some(name)),
            None => open.push(tag.split(' ').next().unwrap()),
        }
        found.push(text.trim().to_owned());
    }
    assert!(open.is_empty(), "not closed: {open:?}");
    found
}

#[test]
fn every_block_is_named_and_every_coefficient_shown() {
    for name in ["van-der-pol.toml", "heat-rod.toml", "rate-servo.toml"] {
        let ordered = load(name);
        let texts = texts(&draw::svg(&ordered));
        for block in &ordered.netlist.blocks {
            assert!(texts.contains(&block.name), "{name}: {}", block.name);
        }
        assert!(texts.contains(&ordered.netlist.title));
    }
    let lorenz = texts(&draw::svg(&load("lorenz.toml")));
    for shown in ["−10", "28", "−2.667", "IC 1"] {
        assert!(lorenz.iter().any(|t| t == shown), "{shown} is not shown");
    }
}

#[test]
fn a_drawing_is_the_same_each_time() {
    let ordered = load("rate-servo.toml");
    let first = draw::svg(&ordered);
    for _ in 0..5 {
        assert_eq!(first, draw::svg(&ordered));
    }
}

#[test]
fn titles_and_notes_are_escaped() {
    let ordered = from_text(
        "title = \"<a> & \\\"b\\\"\"\n[blocks]\nx = { kind = \"integrator\", in = [\"-1 * x\"], note = \"</svg><script>\" }\n",
    );
    let drawing = draw::svg(&ordered);
    texts(&drawing);
    assert!(!drawing.contains("<script>") && !drawing.contains("<a>"));
    assert!(drawing.contains("&lt;a&gt; &amp;"));
}

#[test]
fn each_wire_ends_at_an_arrow() {
    // Each input has one arrowhead: 1 for x, 2 for v, 1 for square, 2 for damping, 2 for drive.
    let drawing = draw::svg(&load("van-der-pol.toml"));
    assert_eq!(drawing.matches("class=\"tip\"").count(), 8);
}

#[test]
fn a_thousand_blocks_are_drawn() {
    let lines: String = (0..1000)
        .map(|i| {
            format!(
                "x{i} = {{ kind = \"integrator\", in = [\"x{}\", \"-1 * x{}\"] }}\n",
                (i * 7 + 1) % 1000,
                (i * 13 + 5) % 1000
            )
        })
        .collect();
    let drawing = draw::svg(&from_text(&format!("[blocks]\n{lines}")));
    assert_eq!(drawing.matches("class=\"name\"").count(), 1000);
}
