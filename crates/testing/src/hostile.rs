//! Words of somebody who means harm, and readers of what is rendered that share nothing with what renders it.
//!
//! The law of every renderer: of a hostile word it gives what it gives of a harmless one, with that word in its place; see
//! [`assert_is_text`].

use quick_xml::Reader;
use quick_xml::escape::unescape;
use quick_xml::events::{BytesStart, Event};

/// A word that does no harm, and that no template has.
pub const PLAIN: &str = "xyzzy";

/// Markup of all kinds, formulas, terminal sequences and turned reading directions. None begins or ends with a blank.
const WORDS: [&str; 8] = [
    "</script><script>alert(\"x\")</script><img src=x onerror='a()'>",
    "</svg></title></style></h3><!-- <![CDATA[ &amp; &#60; ]]> {{ 7*7 }} {% raw %}",
    "a | `b` **c** __d__ [e](javascript:f()) ![g](http://example.org) # h ~~i~~ <br> j\\",
    "\\input{/etc/passwd} \\end{tabular} $x^2_3$ %c #1 & ~ { a--b -- -.5 ``q` [*] ^^41",
    "=1+1,\"a\"\"b\";\r\n@c,'d'\n+e\t-f",
    "1. one\n\n# head\n- list\n***\n> quote",
    "-\u{1b}[2J\u{1b}]0;x\u{7}\u{0}\u{9b}31m\u{7f}\u{fffe}.",
    "\u{202e}kcab\u{2066}\u{2028} \u{5e9}\u{5dc}\u{5d5}\u{5dd} \u{6f22}\u{5b57}\u{1f642}.",
];

/// The hostile words, of which the last one is very long.
pub fn words() -> Vec<String> {
    WORDS.into_iter().map(String::from).chain(["sequence-".repeat(60) + "end"]).collect()
}

/// True if a text shows itself and does nothing else: it has lines and tabs, and neither controls a terminal nor turns its direction.
pub fn shows_only_text(text: &str) -> bool {
    let turns = |c| matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    !text.contains(|c: char| (c.is_control() && !matches!(c, '\n' | '\t')) || turns(c))
}

/// Fails unless a word is rendered as text: what is read of its rendering is what is read of that of [`PLAIN`], with `shown`,
/// the word as people see it, in its place.
///
/// # Panics
/// If it is not.
#[track_caller]
pub fn assert_is_text(word: &str, shown: &str, rendered_and_read: impl Fn(&str) -> String) {
    let plain = rendered_and_read(PLAIN);
    assert!(plain.contains(PLAIN), "{plain}");
    assert_eq!(rendered_and_read(word), plain.replace(PLAIN, shown), "{word:?}");
}

/// Elements of HTML without an end.
const VOID: [&str; 6] = ["meta", "link", "br", "wbr", "img", "input"];

/// Reads HTML or SVG as a browser does. U+0001 begins an element or its end, U+0002 each attribute, and U+0003 ends them;
/// everything else is text. What is in scripts and styles is left out.
///
/// # Panics
/// If it is not well-formed, or has characters that are no text.
pub fn markup(page: &str) -> String {
    assert!(shows_only_text(page), "{page:?}");
    let page = without_code(page);
    let mut reader = Reader::from_str(&page);
    reader.config_mut().check_end_names = false;
    let (mut read, mut open) = (String::new(), Vec::<String>::new());
    loop {
        match reader.read_event().unwrap_or_else(|e| panic!("{e}: {page}")) {
            Event::Start(tag) => {
                push(&mut read, &tag);
                let name = tag.name().0.to_string();
                open.extend((!VOID.contains(&name.as_str())).then_some(name));
            }
            Event::Empty(tag) => push(&mut read, &tag),
            Event::End(tag) => {
                assert_eq!(open.pop().as_deref(), Some(tag.name().0), "{page}");
                read.push_str("\u{1}\u{3}");
            }
            Event::Text(text) => read.push_str(&text),
            Event::GeneralRef(name) => {
                read.push_str(&unescape(&format!("&{};", &*name)).expect("a reference"));
            }
            Event::DocType(_) => {}
            Event::Eof => break,
            other => panic!("{other:?} in {page}"),
        }
    }
    assert!(open.is_empty(), "{open:?} in {page}");
    read
}

fn push(read: &mut String, tag: &BytesStart<'_>) {
    read.push('\u{1}');
    read.push_str(tag.name().0);
    for attribute in tag.html_attributes() {
        let attribute = attribute.expect("an attribute");
        let value = unescape(&attribute.value).expect("a value");
        read.push_str(&format!("\u{2}{}={value}", attribute.key.0));
    }
    read.push('\u{3}');
}

/// A page without what is in its scripts and styles, which end where a browser ends them.
fn without_code(page: &str) -> String {
    let (mut kept, mut rest) = (String::new(), page);
    let next = |rest: &str| {
        let places = ["script", "style"].map(|name| rest.find(&format!("<{name}")).map(|at| (at, name)));
        places.into_iter().flatten().min()
    };
    while let Some((at, name)) = next(rest) {
        let begin = at + rest[at..].find('>').expect("an end of the tag") + 1;
        kept.push_str(&rest[..begin]);
        let code = &rest[begin..];
        rest = &code[code.find(&format!("</{name}")).expect("an end of the element")..];
    }
    kept + rest
}

/// The texts of HTML or SVG, without blanks around them; see [`markup`].
pub fn texts(page: &str) -> Vec<String> {
    let read = markup(page);
    let texts = read.split('\u{3}').filter_map(|part| part.split('\u{1}').next()).map(str::trim);
    texts.filter(|text| !text.is_empty()).map(String::from).collect()
}

/// The names of the elements of HTML or SVG, in their order.
pub fn elements(page: &str) -> Vec<String> {
    let read = markup(page);
    let names = read.split('\u{1}').skip(1).filter_map(|part| part.split(['\u{2}', '\u{3}']).next());
    names.filter(|name| !name.is_empty()).map(String::from).collect()
}

/// Reads Markdown as GitHub does: U+0001 stands before each character that is markup, everything else is text.
///
/// # Panics
/// If it has characters that are no text.
pub fn markdown(text: &str) -> String {
    assert!(shows_only_text(text), "{text:?}");
    let mut read = String::new();
    for line in text.lines() {
        let item = line.trim_start_matches(|c: char| c.is_ascii_digit());
        let is_item = if item.len() < line.len() {
            item.starts_with(['.', ')'])
        } else {
            item.starts_with(['-', '+', '='])
        };
        read.extend(is_item.then_some('\u{1}'));
        let mut rest = line.chars().peekable();
        while let Some(c) = rest.next() {
            match c {
                '\\' => read.push(rest.next_if(char::is_ascii_punctuation).unwrap_or(c)),
                '&' => {
                    let mut name = String::from(c);
                    while !name.ends_with(';') {
                        name.push(rest.next().expect("an end of the reference"));
                    }
                    read.push_str(&unescape(&name).expect("a reference"));
                }
                '`' | '*' | '_' | '[' | ']' | '<' | '>' | '#' | '~' | '$' | '!' | '|' => {
                    read.extend(['\u{1}', c])
                }
                _ => read.push(c),
            }
        }
        read.push('\n');
    }
    read
}

/// Reads LaTeX as an engine for Unicode shows it: U+0001 stands before each command and each character that is one, everything
/// else is text. Quotes are as they are typed.
///
/// # Panics
/// If braces or formulas have no end, or it has characters that are no text.
pub fn latex(text: &str) -> String {
    const SHOWN: [(&str, &str); 8] = [
        ("textbackslash", "\\"),
        ("textasciitilde", "~"),
        ("textasciicircum", "^"),
        ("textless", "<"),
        ("textgreater", ">"),
        ("textbar", "|"),
        ("textdagger", "\u{2020}"),
        ("pm", "\u{b1}"),
    ];
    assert!(shows_only_text(text), "{text:?}");
    let (mut read, mut depth, mut is_formula, mut before) = (String::new(), 0_usize, false, ' ');
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        match c {
            '\\' => {
                let mut name = String::new();
                while let Some(letter) = rest.next_if(char::is_ascii_alphabetic) {
                    name.push(letter);
                }
                if name.is_empty() {
                    let c = rest.next().expect("a command");
                    read.extend((!"{}$&#%_".contains(c)).then_some('\u{1}'));
                    read.push(c);
                } else {
                    rest.next_if_eq(&' ');
                    match SHOWN.iter().find(|known| known.0 == name) {
                        Some((_, shown)) => read.push_str(shown),
                        None if ["ensuremath", "ifdefined", "Umathcode", "fi"].contains(&&*name) => {}
                        // What stands to the next `\fi` is for other engines.
                        None if name == "else" => {
                            let mut other = String::new();
                            while !other.ends_with("\\fi") {
                                other.push(rest.next().expect("an end of the condition"));
                            }
                        }
                        None => read.push_str(&format!("\u{1}{name} ")),
                    }
                }
            }
            '{' => depth += 1,
            '}' => depth = depth.checked_sub(1).expect("a beginning of the group"),
            '$' => is_formula = !is_formula,
            '%' => while rest.next().is_some_and(|c| c != '\n') {},
            '#' | '_' | '^' | '~' | '&' => read.extend(['\u{1}', c]),
            // A ligature.
            '-' | '`' if c == before => read.extend(['\u{1}', c]),
            _ => read.push(c),
        }
        before = c;
    }
    assert!(depth == 0 && !is_formula, "{text}");
    read
}

/// The fields of CSV, by RFC 4180.
///
/// # Panics
/// If a quoted field has no end.
pub fn csv(text: &str) -> Vec<Vec<String>> {
    let (mut rows, mut row, mut field, mut is_quoted) = (Vec::new(), Vec::new(), String::new(), false);
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        match c {
            '"' if is_quoted && rest.next_if_eq(&'"').is_some() => field.push(c),
            '"' => is_quoted = !is_quoted,
            ',' if !is_quoted => row.push(std::mem::take(&mut field)),
            // The line end of RFC 4180.
            '\r' if !is_quoted && rest.peek() == Some(&'\n') => {}
            '\n' if !is_quoted => {
                row.push(std::mem::take(&mut field));
                rows.push(std::mem::take(&mut row));
            }
            _ => field.push(c),
        }
    }
    assert!(!is_quoted, "{text}");
    if !(row.is_empty() && field.is_empty()) {
        row.push(field);
        rows.push(row);
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readers_tell_markup_from_text() {
        let page = "<!DOCTYPE html><p id=\"a&#10;b\">c &lt;d&gt;<br><script>if (1 < 2) \"<b>\";</script></p>";
        assert_eq!(texts(page), ["c <d>"]);
        assert_eq!(elements(page), ["p", "br", "script"]);
        assert!(markup(page).starts_with("\u{1}p\u{2}id=a\nb\u{3}c <d>"));
        assert_eq!(markdown("- \\*a\\* *b* &#124;\n"), "\u{1}- *a* \u{1}*b\u{1}* |\n");
        let text = "\\_{\\ifdefined\\Umathcode \u{5d0}\\else ?\\fi} \\b{a}_--% c\n";
        assert_eq!(latex(text), "_\u{5d0} \u{1}b a\u{1}_-\u{1}-");
        assert_eq!(csv("a,\"b\"\",\n\"\r\n,c"), [vec!["a", "b\",\n"], vec!["", "c"]]);
        for bad in ["<p><b></p></b>", "<p>\u{202e}</p>", "<p>"] {
            assert!(std::panic::catch_unwind(|| markup(bad)).is_err(), "{bad}");
        }
    }
}
