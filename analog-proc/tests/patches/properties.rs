//! No input makes the patch compiler panic or hang: random bytes, mutated patches, odd numbers.

use crate::{bundle, faults, sound};
use analog_proc::patch::{bundle_from_path, compile};
use interface::control::PatchBundle;
use proptest::prelude::*;
use std::ops::Range;

/// Compiles, and shows whatever faults there are in every form.
fn try_compile(text: &str) {
    match compile(&bundle(text), &[]) {
        Ok(ordered) => {
            assert_eq!(ordered.order.len(), ordered.netlist.blocks.len());
            // Every net is computed before it is read: stores, then topological order.
            let mut done = vec![false; ordered.netlist.blocks.len()];
            for id in &ordered.order {
                let block = &ordered.netlist.blocks[id.index()];
                if !block.kind.is_store() {
                    for input in &block.inputs {
                        let driver = ordered.netlist.nets[input.net.index()].driver;
                        assert!(done[driver.index()], "{} is read too early", block.name);
                    }
                }
                done[id.index()] = true;
            }
            assert!(analog_proc::draw::svg(&ordered).ends_with("</svg>"));
        }
        Err(faults) => {
            assert!(!faults.faults().is_empty());
            assert!(!faults.render().is_empty());
            assert!(faults.to_list().iter().all(|f| f.place > Some((0, 0))));
        }
    }
}

/// Every kind of block and every field once.
const RICH: &str = include_str!("rich.toml");

#[test]
fn the_rich_patch_is_free_of_faults() {
    let ordered = sound(compile(&bundle(RICH), &[]));
    assert!(ordered.netlist.blocks.len() > 50);
    try_compile(RICH);
}

/// Byte ranges of the numbers in a text.
fn numbers(text: &str) -> Vec<Range<usize>> {
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '.';
    let words = text.split(|c| !is_word(c)).filter(|w| w.starts_with(|c: char| c.is_ascii_digit()));
    let at = |word: &str| word.as_ptr() as usize - text.as_ptr() as usize;
    words.map(|word| at(word)..at(word) + word.len()).collect()
}

const ODD: [&str; 12] = [
    "nan",
    "inf",
    "-inf",
    "1e999",
    "-1e999",
    "1e308",
    "-0.0",
    "5e-324",
    "1e18",
    "99999999999999999999",
    "true",
    "\"nan\"",
];

#[test]
fn no_odd_number_in_any_field_panics() {
    for range in numbers(RICH) {
        for odd in ODD {
            let mut text = RICH.to_owned();
            text.replace_range(range.clone(), odd);
            try_compile(&text);
        }
    }
}

#[test]
fn deep_nesting_is_refused() {
    for (open, close) in [("[", "]"), ("{ a = ", " }")] {
        let deep = format!("{}1{}", open.repeat(100_000), close.repeat(100_000));
        assert_eq!(faults(&format!("params = {deep}")).faults()[0].code_name(), "toml-syntax");
    }
    let dotted = format!("{} = 1", ["a"; 50_000].join("."));
    faults(&dotted);
    let long =
        format!("[blocks]\nx = {{ kind = \"summer\", in = [\"{}x\"] }}", "2*".repeat(200_000));
    faults(&long);
}

#[test]
fn a_chain_of_sub_patches_is_refused_where_it_is_too_deep() {
    let files = (0..100)
        .map(|i| (format!("{i}.toml"), format!("[use]\nu = {{ patch = \"{}.toml\" }}\n", i + 1)))
        .collect();
    let deep = PatchBundle { root: "0.toml".into(), files };
    let faults = compile(&deep, &[]).unwrap_err();
    assert_eq!(faults.faults()[0].code_name(), "too-large");
}

#[test]
fn a_large_patch_compiles_and_a_large_faulty_one_ends() {
    let good: String = (0..20_000)
        .map(|i| format!("x{i} = {{ kind = \"integrator\", in = [\"x{}\"] }}\n", (i + 1) % 20_000))
        .collect();
    assert!(compile(&bundle(&format!("[blocks]\n{good}")), &[]).is_ok());
    let bad = good.replace("in = [\"x", "in = [\"y");
    let faults = faults(&format!("[blocks]\n{bad}"));
    assert!(faults.to_string().starts_with("20000 faults"), "{faults}");
}

#[test]
fn endless_files_and_folders_are_refused() {
    for path in ["/dev/zero", "/dev/null/x", "/", "", "no-such-file.toml"] {
        let faults = bundle_from_path(path.as_ref()).unwrap_err();
        assert_eq!(faults.faults()[0].code_name(), "missing-file", "{path}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p.toml");
        std::fs::write(&path, &bytes).unwrap();
        match bundle_from_path(&path) {
            Ok(bundle) => {
                prop_assert_eq!(bundle.hash().len(), 64);
                try_compile(&bundle.files[0].1);
            }
            Err(faults) => prop_assert_eq!(faults.faults()[0].code_name(), "not-utf8"),
        }
    }

    #[test]
    fn random_text_never_panics(text in "(\\[?(blocks|use|params|ports|expect)\\]?|[a-z.]{1,5}|[={}\\[\\]\",\n*-]|[0-9]{1,3}|kind|in|\\PC){0,60}") {
        try_compile(&text);
    }

    #[test]
    fn cut_and_spliced_patches_never_panic(
        cuts in proptest::collection::vec((0..RICH.len(), 0..40usize, 0..RICH.len(), 0..40usize), 1..6)
    ) {
        let mut bytes = RICH.as_bytes().to_vec();
        for (at, removed, from, inserted) in cuts {
            let at = at.min(bytes.len());
            let end = (at + removed).min(bytes.len());
            let source = &RICH.as_bytes()[from..(from + inserted).min(RICH.len())];
            bytes.splice(at..end, source.iter().copied());
        }
        try_compile(&String::from_utf8_lossy(&bytes));
    }

    #[test]
    fn swapped_lines_keep_the_patch_valid(from in 0usize..60, to in 0usize..60) {
        // The order of the lines is the user's; only the order of parameters matters.
        let (head, body) = RICH.split_once("[blocks]\n").unwrap();
        let (body, tail) = body.split_once("\n[").unwrap();
        let mut lines: Vec<&str> = body.lines().filter(|l| !l.is_empty()).collect();
        let (from, to) = (from % lines.len(), to % lines.len());
        lines.swap(from, to);
        let text = format!("{head}[blocks]\n{}\n\n[{tail}", lines.join("\n"));
        prop_assert!(compile(&bundle(&text), &[]).is_ok());
    }
}
