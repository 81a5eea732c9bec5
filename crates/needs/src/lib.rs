//! `#[needs(...)]` for tests of what is not on every machine: real sequences, or other programs.
//!
//! Where something is missing, the test is compiled with `#[ignore = "needs ..."]`, so that `cargo test` lists and
//! counts it as ignored; everywhere else it is an ordinary test.

mod conditions;

use conditions::NEEDS;
use proc_macro::{Delimiter, TokenStream, TokenTree};

/// Marks a test that needs something: `#[needs(real_data)]`, `#[needs(chromium)]`; it stands before `#[test]`.
#[proc_macro_attribute]
pub fn needs(names: TokenStream, test: TokenStream) -> TokenStream {
    match ignore(names, &test) {
        Ok(attribute) => {
            let mut tokens = tokens(&attribute);
            tokens.extend(test);
            tokens.extend(watch());
            tokens
        }
        Err(message) => tokens(&format!("compile_error!({message:?});")),
    }
}

/// The attribute that a test gets, empty where everything is there.
fn ignore(names: TokenStream, test: &TokenStream) -> Result<String, String> {
    // The attribute `#[test]` would otherwise already have decided whether the test is ignored.
    let is_test = |token: &TokenTree| match token {
        TokenTree::Group(g) => g.delimiter() == Delimiter::Bracket && g.stream().to_string() == "test",
        _ => false,
    };
    if !test.clone().into_iter().any(|token| is_test(&token)) {
        return Err("#[needs(...)] stands before #[test]".into());
    }
    let names = names.into_iter().filter_map(|token| match token {
        TokenTree::Ident(name) => Some(name.to_string()),
        _ => None,
    });
    let mut missing = Vec::new();
    for name in names {
        let known = || NEEDS.map(|need| need.name).join(", ");
        let need = NEEDS.iter().find(|need| need.name == name);
        let need = need.ok_or_else(|| format!("unknown need `{name}`; there are {}", known()))?;
        if !(need.is_met)() {
            missing.push(need.what);
        }
    }
    Ok(match missing.as_slice() {
        [] => String::new(),
        some => format!("#[ignore = {:?}]", format!("needs {}", some.join(" and "))),
    })
}

/// The names of the needs that were met when the tests were compiled, as an array of `&str`.
#[proc_macro]
pub fn met_when_compiled(_: TokenStream) -> TokenStream {
    let met: Vec<&str> = NEEDS.iter().filter(|need| (need.is_met)()).map(|need| need.name).collect();
    tokens(&format!("{{ {} let met: Vec<&str> = vec!{met:?}; met }}", watch()))
}

/// Lets cargo compile the tests again when the variables change that the conditions look at.
fn watch() -> TokenStream {
    tokens(
        "const _: (Option<&str>, Option<&str>) = (option_env!(\"TRACKFAIL_DATA\"), option_env!(\"PATH\"));",
    )
}

fn tokens(text: &str) -> TokenStream {
    text.parse().expect("the text is Rust")
}
