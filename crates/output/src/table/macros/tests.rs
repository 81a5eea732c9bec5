use super::super::render::tests::{in_latex, of_word, sample};
use super::*;
use proptest::prelude::*;
use trackfail_testing::hostile;

#[test]
fn every_number_has_a_name() {
    let text = macros("khalid2016/table1", &[], &[sample()]);
    let expected = "\\tfset{khalid2016/table1/Struck/precision/DT(7c)EF}{.120}\n\
                    \\tfset{khalid2016/table1/Struck/precision/DT(7c)EF/published}{.110}\n\
                    \\tfset{khalid2016/table1/Struck/precision/DT(7c)EF/difference}{+.010}\n";
    assert!(text.contains(expected), "{text}");
    assert_eq!(text.matches("\n\\tfset{").count(), 6);
    // A table that is not called like its experiment is named.
    let quick = macros("quickstart", &[], &[sample()]);
    assert!(quick.contains("{quickstart/table1/Struck/precision/ARTE*}{.100}"));
    assert_eq!(number("-0.17±0.18"), "\\ensuremath{-}0.17\\ensuremath{\\pm}0.18");
    // Two tables of one name, which only analyses can have rows like, are told apart.
    let twice = macros("a", &[], &[sample(), sample()]);
    let names: Vec<&str> = twice.split("\n\\tfset{").skip(1).filter_map(|t| t.split('}').next()).collect();
    let different: std::collections::BTreeSet<&&str> = names.iter().collect();
    assert_eq!((names.len(), different.len()), (12, 12));
}

#[test]
fn numbers_of_the_text_have_names_too() {
    let fact = Fact { parts: vec!["targets".into(), "present".into()], shown: "12".into() };
    let text = macros("a", &[fact], &[]);
    assert!(text.ends_with("\\tfset{a/about/targets/present}{12}\n"), "{text}");
}

#[test]
fn any_word_is_the_text_of_its_numbers_and_a_plain_part_of_their_names() {
    for word in hostile::words() {
        let text = macros("a", &[], &[of_word(&word)]);
        let numbers: Vec<(&str, &str)> = text
            .lines()
            .skip(3)
            .map(|line| line.strip_prefix("\\tfset{").unwrap().split_once("}{").unwrap())
            .collect();
        assert_eq!(numbers.len(), 6);
        for (k, (name, number)) in numbers.into_iter().enumerate() {
            assert!(read(name).unwrap().contains(&word), "{name}");
            let number = hostile::latex(number.strip_suffix('}').unwrap());
            assert!(k > 2 || number == in_latex(&word), "{number}");
        }
    }
}

/// Reads a list of names back from what [`name`] made; `None` for other text.
fn read(name: &str) -> Option<Vec<String>> {
    let part = |text: &str| {
        let mut read = String::new();
        let mut rest = text;
        while let Some((before, coded)) = rest.split_once('(') {
            let (code, after) = coded.split_once(')')?;
            read.push_str(before);
            read.push(char::from_u32(u32::from_str_radix(code, 16).ok()?)?);
            rest = after;
        }
        Some(read + rest)
    };
    name.split('/').map(part).collect()
}

proptest! {
    // Names can be read back, so no two lists have the same one, and TeX reads them as they are.
    #[test]
    fn names_are_plain_and_never_confused(
        parts in prop::collection::vec("[a-zA-Z0-9_ ()/.=\\[\\];\u{5d0}\u{1f600}-]{0,12}|\\PC{0,5}", 1..6)
    ) {
        let list: Vec<&str> = parts.iter().map(String::as_str).collect();
        let name = name(&list);
        let special = ['%', '#', '\\', '{', '}', '~', '^', '$', '&', '"'];
        prop_assert!(name.is_ascii() && !name.contains(special));
        prop_assert_eq!(read(&name), Some(parts));
    }
}
