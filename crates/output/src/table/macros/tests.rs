use super::super::render::tests::sample;
use super::*;
use proptest::prelude::*;

#[test]
fn every_number_has_a_command() {
    let text = macros("khalid2016/table1", &[], &[sample()]);
    let first = "tfkhalidZtwoZzeroZoneZsixZVtableZoneXtableZoneXStruckXprecisionXDTZOaaaahmEF";
    let expected = format!(
        "% table1, Struck, precision, DT|EF\n\\newcommand{{\\{first}}}{{.120}}\n\
         % table1, Struck, precision, DT|EF, published\n\\newcommand{{\\{first}Xpublished}}{{.110}}\n\
         % table1, Struck, precision, DT|EF, difference\n\\newcommand{{\\{first}Xdifference}}{{+.010}}\n"
    );
    assert!(text.contains(&expected), "{text}");
    assert_eq!(text.matches("\\newcommand").count(), 6);
    assert_eq!(number("-0.17±0.18"), "\\ensuremath{-}0.17\\ensuremath{\\pm}0.18");
    // Two tables of one name, which only analyses can have rows like, are told apart.
    let twice = macros("a", &[], &[sample(), sample()]);
    let names: Vec<&str> = twice.split("\\newcommand{").skip(1).filter_map(|t| t.split('}').next()).collect();
    let different: std::collections::BTreeSet<&&str> = names.iter().collect();
    assert_eq!((names.len(), different.len()), (12, 12));
}

#[test]
fn numbers_of_the_text_have_commands_too() {
    let fact = Fact { parts: vec!["targets".into(), "present".into()], shown: "12".into() };
    let text = macros("a", &[fact], &[]);
    assert!(text.ends_with("% targets, present\n\\newcommand{\\tfaXtargetsXpresent}{12}\n"), "{text}");
}

/// Reads a list of names back from what [`name`] made; `None` for other text.
fn read(name: &str) -> Option<Vec<String>> {
    let mut parts = vec![String::new()];
    let mut rest = name.strip_prefix("tf")?;
    while let Some(c) = rest.chars().next() {
        rest = &rest[1..];
        let last = parts.last_mut()?;
        match c {
            'X' => parts.push(String::new()),
            'Z' => {
                let single = [("ZU", '_'), ("ZH", '-'), ("ZS", ' '), ("ZP", '.'), ("ZV", '/'), ("ZE", '=')];
                let single = single.iter().chain(&[("ZX", 'X'), ("ZZ", 'Z')]);
                let digit = DIGITS.iter().position(|d| rest.starts_with(d));
                if let Some(d) = digit {
                    last.push_str(&d.to_string());
                    rest = &rest[DIGITS[d].len()..];
                } else if let Some((_, c)) = single.into_iter().find(|(code, _)| rest.starts_with(&code[1..]))
                {
                    last.push(*c);
                    rest = &rest[1..];
                } else {
                    let code = rest.strip_prefix('O')?.get(..6)?;
                    let number = code.bytes().fold(0, |n, b| n * 16 + u32::from(b - b'a'));
                    last.push(char::from_u32(number)?);
                    rest = &rest[7..];
                }
            }
            c => last.push(c),
        }
    }
    Some(parts)
}

proptest! {
    // Names can be read back, so no two lists have the same one.
    #[test]
    fn names_are_letters_and_never_confused(
        parts in prop::collection::vec("[a-zA-Z0-9_ XZO.=\\[\\];\u{5d0}\u{1f600}-]{0,12}|\\PC{0,5}", 1..6)
    ) {
        let list: Vec<&str> = parts.iter().map(String::as_str).collect();
        let name = name(&list);
        prop_assert!(name.bytes().all(|b| b.is_ascii_alphabetic()));
        prop_assert_eq!(read(&name), Some(parts));
    }
}
