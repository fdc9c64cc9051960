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
    let (sound, faulty) = (&*patch("decay.toml"), &*patch("bad/several-faults.toml"));
    let study = &*patch("studies/servo-loop.toml");
    let at = |name: &str| bench.runs().join(name).display().to_string();
    let (runs, csv, svg, html) = (&*at(""), &*at("a.csv"), &*at("a.svg"), &*at("a.html"));
    // The command, its exit code, and what its JSON has, in pointers of RFC 6901.
    for (binary, args, code, has) in [
        (
            DIGITAL,
            &["fly", "--until", "1s", "--out", runs][..],
            0,
            &["/run", "/results/max_q_pa"][..],
        ),
        (
            DIGITAL,
            &["fly", "--until", "1s", "--clock", "wall", "--out", runs],
            0,
            &["/tables/overruns"],
        ),
        (DIGITAL, &["replay", "last", "--runs", runs], 0, &["/run", "/results/rows"]),
        (DIGITAL, &["list", "--runs", runs], 0, &["/tables/runs/1/state"]),
        (
            DIGITAL,
            &["export", "last", "--runs", runs, "--out", csv],
            0,
            &["/run", "/tables/files/0/file"],
        ),
        (
            DIGITAL,
            &["plot", "last", "--runs", runs, "--out", html],
            0,
            &["/run", "/tables/files/0/file"],
        ),
        (
            DIGITAL,
            &["short-period", "pitch", "--point", "max-q", "--out", runs],
            0,
            &["/run", "/tables/pitch/1/overshoot_percent", "/tables/linear_agreement/0/agrees"],
        ),
        (
            DIGITAL,
            &["short-period", "yaw-roll", "--point", "max-q", "--out", runs],
            0,
            &["/run", "/tables/yaw_roll/0/tvc_called_s"],
        ),
        (DIGITAL, &["failures"], 0, &["/tables/modes/0/mode"]),
        (
            ANALOG,
            &["check", sound],
            0,
            &["/results/blocks", "/tables/patch/0/sha_256", "/tables/static_check/0"],
        ),
        (
            ANALOG,
            &["run", sound, "--until", "1s", "--out", csv],
            0,
            &["/results/steps", "/tables/files/0/file"],
        ),
        (ANALOG, &["linearise", sound], 0, &["/tables/roots/0/real_part_1_s", "/tables/a/0/row"]),
        (ANALOG, &["linearise", sound, "--output", "nobody"], 2, &[]),
        (ANALOG, &["draw", sound, "--out", svg], 0, &["/results/blocks", "/tables/files/0/file"]),
        (DIGITAL, &["sampling", "circle", "--out", runs], 0, &["/run", "/claims/0/verdict"]),
        (DIGITAL, &["sampling", "noise", "--frames", "1001", "--out", runs], 0, &["/run"]),
        (DIGITAL, &["sampling", "loop", study, "--out", runs], 0, &["/run"]),
        (DIGITAL, &["sampling", "loop", faulty, "--out", runs], 2, &["/error/faults/0/line"]),
        // What fails: a check, the command line, files, surroundings, the flight itself, output.
        (ANALOG, &["check", sound, "--set", "pace=0.1"], 1, &["/tables/static_check/0"]),
        (ANALOG, &["check", faulty], 2, &["/error/faults/1/line", "/error/faults/1/code"]),
        (ANALOG, &["check", sound, "--profile", "ad5"], 2, &[]),
        (ANALOG, &["run", sound, "--until", "1s", "--record", "nobody", "--out", csv], 2, &[]),
        (ANALOG, &["run", sound, "--until", "1"], 2, &[]),
        (ANALOG, &["run", sound, "--until", "1s", "--record", "x,x"], 2, &[]),
        (ANALOG, &["cheque", sound], 2, &[]),
        (DIGITAL, &["fly", "--frmae", "1s"], 2, &[]),
        (DIGITAL, &["fly", "--mode", "rol-lost", "--out", runs], 2, &["/error/faults/0/remedy"]),
        (DIGITAL, &["fly", "--vehicle", sound, "--out", runs], 2, &["/error/faults/0/line"]),
        (DIGITAL, &["fly", "--attach", "nobody", "--out", runs], 2, &[]),
        (DIGITAL, &["fly", "--misalign-pitch", "300", "--out", runs], 2, &["/run"]),
        (DIGITAL, &["failures", sound], 2, &["/error/faults/0/line"]),
        (DIGITAL, &["replay", "nobody", "--runs", runs], 2, &[]),
        (DIGITAL, &["list", "--runs", sound], 2, &[]),
        (DIGITAL, &["plot", "last", "--runs", runs, "--out", "/dev/full"], 4, &[]),
        (DIGITAL, &["export", "last", "--runs", runs, "--out", "/dev/full"], 4, &[]),
        (ANALOG, &["draw", sound, "--out", "/no/folder/a.svg"], 2, &[]),
    ] {
        let what = format!("{args:?}");
        let output = expect(bench.command(binary, args).arg("--json"), code);
        let value = assert_output(&what, &output);
        for pointer in has {
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
    let output = expect(&mut bench.command(ANALOG, &["run", sound, "--until", "1s", "--json"]), 0);
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
