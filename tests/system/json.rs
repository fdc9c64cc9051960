//! With `--json` every command writes one object of one form (`tests/outcome.schema.json`),
//! whatever becomes of it.

use crate::bench_top::{ANALOG, BenchTop, DIGITAL, expect, partner_of, signal, until, wait_within};
use rustix::process::Signal;
use serde_json::Value;
use std::{process::Output, time::Duration};

/// Why `value` is not as `schema` says; of JSON Schema, what ours uses.
fn fault(schema: &Value, value: &Value, at: &str) -> Option<String> {
    let known = ["$schema", "title", "description"];
    schema.as_object().unwrap().iter().find_map(|(rule, says)| {
        let wrong = |why: String| Some(format!("{at}: {why}: {value}"));
        let names = || value.as_object().into_iter().flatten();
        match rule.as_str() {
            rule if known.contains(&rule) => None,
            "type" => {
                let is = |kind: &Value| match kind.as_str().unwrap() {
                    "object" => value.is_object(),
                    "array" => value.is_array(),
                    "string" => value.is_string(),
                    "number" => value.is_number(),
                    "null" => value.is_null(),
                    kind => panic!("{kind}"),
                };
                let fits = says.as_array().map_or_else(|| is(says), |any| any.iter().any(is));
                (!fits).then(|| wrong(format!("is not {says}")))?
            }
            "enum" => (!says.as_array().unwrap().contains(value))
                .then(|| wrong("is none of them".into()))?,
            "required" if value.is_null() => None,
            "required" => {
                let lacks = |name: &&Value| value.get(name.as_str().unwrap()).is_none();
                let lacking = says.as_array().unwrap().iter().find(lacks)?;
                wrong(format!("lacks {lacking}"))
            }
            "properties" => names()
                .find_map(|(name, inner)| fault(says.get(name)?, inner, &format!("{at}.{name}"))),
            "additionalProperties" => names()
                .filter(|(name, _)| schema["properties"].get(name).is_none())
                .find_map(|(name, inner)| match says {
                    Value::Bool(false) => wrong(format!("has an unknown {name}")),
                    says => fault(says, inner, &format!("{at}.{name}")),
                }),
            "propertyNames" => {
                let hyphens = says["pattern"].as_str().unwrap().contains("_-]");
                let fits = |c: char| {
                    c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_' || hyphens && c == '-'
                };
                names().find_map(|(name, _)| {
                    (name.is_empty() || !name.chars().all(fits))
                        .then(|| wrong(format!("`{name}` is no key")))?
                })
            }
            "items" => value
                .as_array()
                .into_iter()
                .flatten()
                .find_map(|v| fault(says, v, &format!("{at}[]"))),
            rule => panic!("the schema has a rule that is not checked: {rule}"),
        }
    })
}

/// One object on standard output, of the form, with an error just where the command failed.
pub fn assert_form(what: &str, text: &[u8], code: i32) -> Value {
    let schema = serde_json::from_str(include_str!("../outcome.schema.json")).unwrap();
    let text = String::from_utf8_lossy(text);
    let value: Value =
        serde_json::from_str(&text).unwrap_or_else(|e| panic!("{what}: {e}: {text}"));
    assert_eq!(fault(&schema, &value, what), None);
    match code {
        0 => assert_eq!(value["error"], Value::Null, "{what}"),
        code => assert_eq!(value["error"]["exit_code"], code, "{what}: {value}"),
    }
    value
}

fn assert_output(what: &str, output: &Output) -> Value {
    let code = output.status.code().unwrap();
    let value = assert_form(what, &output.stdout, code);
    if let Some(text) = value["error"]["text"].as_str() {
        // Both say the same, where standard error has not wrapped it or framed it.
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(told.contains(text.lines().next().unwrap()), "{what}: {told}\n{text}");
    }
    value
}

#[test]
fn every_command_has_one_form() {
    let bench = BenchTop::new();
    let patch = |name: &str| format!("{}/patch-files/{name}", env!("CARGO_MANIFEST_DIR"));
    let at = |name: &str| bench.runs().join(name).display().to_string();
    let places = [
        ("SOUND", patch("decay.toml")),
        ("FAULTY", patch("bad/several-faults.toml")),
        ("STUDY", patch("studies/servo-loop.toml")),
        ("RUNS", at("")),
        ("CSV", at("a.csv")),
        ("SVG", at("a.svg")),
        ("HTML", at("a.html")),
    ];
    // The command, its exit code, and what its JSON has, in pointers of RFC 6901.
    for (command, code, has) in [
        ("digital fly --until 1s --out RUNS", 0, "/run /results/max_q_pa"),
        ("digital fly --until 1s --clock wall --out RUNS", 0, "/tables/overruns"),
        ("digital replay last --runs RUNS", 0, "/run /results/rows"),
        ("digital list --runs RUNS", 0, "/tables/runs/1/state"),
        ("digital export last --runs RUNS --out CSV", 0, "/run /tables/files/0/file"),
        ("digital plot last --runs RUNS --out HTML", 0, "/run /tables/files/0/file"),
        (
            "digital short-period pitch --point max-q --out RUNS",
            0,
            "/run /tables/pitch/1/overshoot_percent /tables/linear_agreement/0/agrees",
        ),
        (
            "digital short-period yaw-roll --point max-q --out RUNS",
            0,
            "/run /tables/yaw_roll/0/tvc_called_s",
        ),
        ("digital failures", 0, "/tables/modes/0/mode"),
        ("analog check SOUND", 0, "/results/blocks /tables/patch/0/sha_256 /tables/static_check/0"),
        ("analog run SOUND --until 1s --out CSV", 0, "/results/steps /tables/files/0/file"),
        ("analog linearise SOUND", 0, "/tables/roots/0/real_part_1_s /tables/a/0/row"),
        ("analog linearise SOUND --output nobody", 2, ""),
        ("analog draw SOUND --out SVG", 0, "/results/blocks /tables/files/0/file"),
        ("digital sampling circle --out RUNS", 0, "/run /claims/0/verdict"),
        ("digital sampling noise --frames 1001 --out RUNS", 0, "/run"),
        ("digital sampling loop STUDY --out RUNS", 0, "/run"),
        ("digital sampling loop FAULTY --out RUNS", 2, "/error/faults/0/line"),
        // What fails: a check, the command line, files, surroundings, the flight itself, output.
        ("analog check SOUND --set pace=0.1", 1, "/tables/static_check/0"),
        ("analog check FAULTY", 2, "/error/faults/1/line /error/faults/1/code"),
        ("analog check SOUND --profile ad5", 2, ""),
        ("analog run SOUND --until 1s --record nobody --out CSV", 2, ""),
        ("analog run SOUND --until 1", 2, ""),
        ("analog run SOUND --until 1s --record x,x", 2, ""),
        ("analog cheque SOUND", 2, ""),
        ("digital fly --frmae 1s", 2, ""),
        ("digital fly --mode rol-lost --out RUNS", 2, "/error/faults/0/remedy"),
        ("digital fly --vehicle SOUND --out RUNS", 2, "/error/faults/0/line"),
        ("digital fly --attach nobody --out RUNS", 2, ""),
        ("digital fly --misalign-pitch 300 --out RUNS", 2, "/run"),
        ("digital failures SOUND", 2, "/error/faults/0/line"),
        ("digital replay nobody --runs RUNS", 2, ""),
        ("digital list --runs SOUND", 2, ""),
        ("digital plot last --runs RUNS --out /dev/full", 4, ""),
        ("digital export last --runs RUNS --out /dev/full", 4, ""),
        ("analog draw SOUND --out /no/folder/a.svg", 2, ""),
    ] {
        let mut words = command.split(' ');
        let binary = if words.next() == Some("digital") { DIGITAL } else { ANALOG };
        let place = |word| places.iter().find(|p| p.0 == word).map_or(word, |p| &*p.1);
        let args: Vec<&str> = words.map(place).collect();
        let what = command;
        let output = expect(bench.command(binary, &args).arg("--json"), code);
        let value = assert_output(what, &output);
        for pointer in has.split_whitespace() {
            assert!(
                value.pointer(pointer).is_some_and(|v| !v.is_null()),
                "{what}: {pointer}: {value}"
            );
        }
        if !args[0].starts_with("cheque") {
            assert!(value["command"].as_str().unwrap().starts_with(args[0]), "{what}: {value}");
        }
    }
    // Where the record takes standard output, the rest is told beside it.
    let run = ["run", &places[0].1, "--until", "1s", "--json"];
    let output = expect(&mut bench.command(ANALOG, &run), 0);
    assert!(output.stdout.starts_with(b"time,"));
    assert_form("run", &output.stderr, 0);
    bench.assert_clean();
}

#[test]
fn a_lost_partner_and_an_interrupt_have_the_same_form() {
    for (dying, code) in [("partner", 3), ("this side", 130)] {
        let bench = BenchTop::new();
        let flight = bench.fly(&["--frame", "200us", "--fast", "1", "--json"]).spawn().unwrap();
        let partner = partner_of(&flight);
        until("the trace", Duration::from_secs(20), || {
            bench.run_directories().iter().any(|d| d.join("trace.arrow").is_file()).then_some(())
        });
        match code {
            3 => signal(partner, Signal::KILL),
            _ => signal(flight.id(), Signal::INT),
        }
        let (output, _) = wait_within(flight, Duration::from_secs(10));
        assert_eq!(output.status.code(), Some(code), "{dying}");
        let value = assert_output(dying, &output);
        assert!(value["run"].is_string(), "{value}");
    }
}
