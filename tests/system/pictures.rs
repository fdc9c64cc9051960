//! Pictures of a run by one command: the page, its figures and its extremes.

use crate::bench_top::{ANALOG, BenchTop, expect, stderr};
use serde_json::Value;

fn patch(name: &str) -> String {
    format!("{}/patch-files/{name}", env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn a_run_is_seen_with_one_command() {
    let top = BenchTop::new();
    std::fs::create_dir_all(top.runs()).unwrap();
    let page = top.runs().join("page.html").display().to_string();
    let lorenz = patch("lorenz.toml");
    let args = ["run", &lorenz, "--until", "40s", "--xy", "x:z", "--page", &page, "--json"];
    let told = expect(&mut top.command(ANALOG, &args), 0).stdout;
    let told: Value = serde_json::from_slice(&told).unwrap();
    assert_eq!(told["tables"]["files"][0]["file"], page.as_str());
    let of = |net: &str| {
        let rows = told["tables"]["extremes"].as_array().unwrap();
        rows.iter().find(|row| row["net"] == net).unwrap().clone()
    };
    // The attractor lies within |x| < 20, 0 < z < 50.
    let x = of("x");
    assert!(x["greatest"].as_f64().unwrap() < 20.0 && x["least"].as_f64().unwrap() > -20.0);
    assert!(of("z")["greatest"].as_f64().unwrap() > 40.0);
    let html = std::fs::read_to_string(&page).unwrap();
    assert!(html.contains("z over x") && !html.contains("Time histories"));

    // Without a place: the patch's name, here; and a net that is not recorded by default.
    let decay = patch("decay.toml");
    let mut command = top.command(ANALOG, &["run", &decay, "--until", "2s", "--plot", "x,clock"]);
    let output = expect(command.current_dir(top.runs()), 0);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("decay.html") && text.contains("Extremes"), "{text}");
    assert!(std::fs::read_to_string(top.runs().join("decay.html")).unwrap().contains("`clock`"));

    for (args, told) in [
        (["--xy", "x"], "write two nets"),
        (["--xy", "x:zz"], "`zz`"),
        (["--plot", "clok"], "`clock`"),
        (["--page", &decay], "ending in .html"),
        (["--page", "-"], ".html"),
    ] {
        let args = [&["run", &decay, "--until", "2s"], &args[..]].concat();
        let text = stderr(&expect(top.command(ANALOG, &args).current_dir(top.runs()), 2));
        assert!(text.contains(told), "{text}");
    }
}

/// What was drawn up to a fault is what one wants to see.
#[test]
fn a_run_that_faults_leaves_its_picture() {
    let top = BenchTop::new();
    std::fs::create_dir_all(top.runs()).unwrap();
    let pole = top.runs().join("pole.toml");
    let text = "[blocks]\nx = { kind = \"integrator\", in = [\"y\"], ic = 1.0 }\ny = { kind = \"multiplier\", in = [\"x\", \"x\"] }\n";
    std::fs::write(&pole, text).unwrap();
    let args = ["run", &pole.display().to_string(), "--until", "2s", "--page", "pole.html"];
    let output = expect(top.command(ANALOG, &args).current_dir(top.runs()), 2);
    assert!(stderr(&output).contains("pole.html"), "{}", stderr(&output));
    let page = std::fs::read_to_string(top.runs().join("pole.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("integrator"), "the fault is told on the page");
}
