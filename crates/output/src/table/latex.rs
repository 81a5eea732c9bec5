//! Tables as LaTeX: booktabs rules, siunitx columns, numbers as the paper rounds them.
//!
//! Columns whose numbers all have a digit before the point are aligned at it by siunitx (`S`). Where a paper
//! leaves the zero out (`.110`) they are flush right, because siunitx would put the zero back. Everything that is not
//! a number stands in braces, which siunitx leaves alone.

use super::layout::TableLayout;
use super::render::lines;
use crate::dataset::text::visible;

/// Comment that says what the preamble of a document with the table needs.
const NEEDS: &str = "% needs \\usepackage{booktabs,siunitx}\n";

/// Escapes text so that every LaTeX engine shows it as it is. Characters that pdfTeX does not know are kept for XeTeX and
/// LuaTeX; pdfTeX shows `?` for them.
pub fn latex_escape(text: &str) -> String {
    let mut out = String::new();
    // A run of characters that pdfTeX does not know.
    let mut foreign = String::new();
    for c in visible(text).chars() {
        if !is_common(c) {
            foreign.push(c);
            continue;
        }
        end_foreign(&mut out, &mut foreign);
        match c {
            '\\' => out.push_str("\\textbackslash{}"),
            '{' | '}' | '$' | '&' | '#' | '%' | '_' => {
                out.push('\\');
                out.push(c);
            }
            '~' => out.push_str("\\textasciitilde{}"),
            '^' => out.push_str("\\textasciicircum{}"),
            '<' => out.push_str("\\textless{}"),
            '>' => out.push_str("\\textgreater{}"),
            '±' => out.push_str("$\\pm$"),
            '×' => out.push_str("$\\times$"),
            '↑' => out.push_str("$\\uparrow$"),
            '↓' => out.push_str("$\\downarrow$"),
            '†' => out.push_str("\\textdagger{}"),
            '|' => out.push_str("\\textbar{}"),
            '"' => out.push_str("''"),
            // A `[` or `*` at the beginning of a row would be read as an argument of the line end before it, and
            // these quotes and dashes would form ligatures.
            '[' | ']' | '*' | '`' => {
                out.push('{');
                out.push(c);
                out.push('}');
            }
            '-' if out.ends_with('-') => out.push_str("{}-"),
            // The replacement character is in hardly any font.
            '\u{fffd}' => out.push('?'),
            c => out.push(c),
        }
    }
    end_foreign(&mut out, &mut foreign);
    out
}

/// Whether every engine knows a character: ASCII, accented letters of every font encoding, and what has a command.
fn is_common(c: char) -> bool {
    c.is_ascii() || (('À'..='ÿ').contains(&c) && !"ÐÞðþ÷".contains(c)) || "±↑↓†\u{fffd}".contains(c)
}

fn end_foreign(out: &mut String, foreign: &mut String) {
    if !foreign.is_empty() {
        let unknown = "?".repeat(foreign.chars().count());
        // Only XeTeX and LuaTeX, which read Unicode, have this command.
        out.push_str(&format!("{{\\ifdefined\\Umathcode {foreign}\\else {unknown}\\fi}}"));
        foreign.clear();
    }
}

/// A number as siunitx reads it: its digits before and after the point, and whether it has a sign.
fn digits(text: &str) -> Option<(usize, usize, bool)> {
    let unsigned = text.trim_start_matches(['+', '-']);
    let (whole, part) = unsigned.split_once('.').unwrap_or((unsigned, ""));
    let all_digits = |t: &str| t.bytes().all(|b| b.is_ascii_digit());
    let is_number =
        text.len() - unsigned.len() <= 1 && !whole.is_empty() && all_digits(whole) && all_digits(part);
    (is_number && !unsigned.ends_with('.')).then_some((whole.len(), part.len(), unsigned.len() < text.len()))
}

/// Whether a text is a number without a digit before the point.
fn is_bare(text: &str) -> bool {
    let unsigned = text.trim_start_matches(['+', '-']);
    unsigned.starts_with('.') && digits(&format!("0{unsigned}")).is_some()
}

/// Marks numbers that lack failed cells.
const FAILED: char = '†';

/// How each column is aligned: by a `table-format` of siunitx, or flush right (`None`).
fn formats(layout: &TableLayout) -> Vec<Option<String>> {
    let of_column = |k: usize| {
        let rows = layout.groups.iter().flat_map(|g| g.rows.iter().map(move |r| (g, r)));
        let cells = rows.flat_map(|(g, r)| lines(g, r)).filter_map(|(_, cells)| cells.into_iter().nth(k));
        let texts: Vec<String> = cells.map(|(text, _)| text.trim_end_matches(FAILED).to_string()).collect();
        if texts.iter().any(|t| is_bare(t)) {
            return None;
        }
        let found: Vec<(usize, usize, bool)> = texts.iter().filter_map(|t| digits(t)).collect();
        let whole = found.iter().map(|d| d.0).max()?;
        let part = found.iter().map(|d| d.1).max()?;
        let sign = if found.iter().any(|d| d.2) { "+" } else { "" };
        Some(if part == 0 { format!("{sign}{whole}") } else { format!("{sign}{whole}.{part}") })
    };
    (0..layout.columns.len()).map(of_column).collect()
}

/// One cell; `aligned` says whether siunitx aligns its column.
fn cell(text: &str, best: bool, aligned: bool) -> String {
    let number = text.trim_end_matches(FAILED);
    let bold = if best { "\\bfseries " } else { "" };
    if aligned && digits(number).is_some() {
        let failed = if number.len() < text.len() { "{\\textdagger}" } else { "" };
        return format!("{bold}{number}{failed}");
    }
    if text.is_empty() {
        return String::new();
    }
    format!("{{{bold}{}}}", latex_escape(text))
}

/// The `tabular` alone, for documents with their own caption and label.
pub fn body(layout: &TableLayout) -> String {
    let formats = formats(layout);
    let column = |format: &Option<String>| match format {
        Some(format) => format!("S[table-format={format}]"),
        None => "r".to_string(),
    };
    let columns: String = formats.iter().map(column).collect();
    let mut text = format!(
        "\\begingroup\n\\sisetup{{detect-weight, retain-explicit-plus}}\n\\begin{{tabular}}{{l{columns}}}\n\\toprule\n{}",
        latex_escape(&layout.corner)
    );
    for column in &layout.columns {
        text.push_str(&format!(" & {{{}}}", latex_escape(column)));
    }
    text.push_str(" \\\\\n");
    for group in &layout.groups {
        text.push_str("\\midrule\n");
        if !group.label.is_empty() {
            let (columns, label) = (layout.columns.len() + 1, latex_escape(&group.label));
            text.push_str(&format!("\\multicolumn{{{columns}}}{{l}}{{\\textit{{{label}}}}} \\\\\n"));
        }
        for row in &group.rows {
            for (heading, cells) in lines(group, row) {
                text.push_str(&latex_escape(&heading));
                for ((shown, best), format) in cells.iter().zip(&formats) {
                    text.push_str(&format!(" & {}", cell(shown, *best, format.is_some())));
                }
                text.push_str(" \\\\\n");
            }
        }
    }
    text.push_str("\\bottomrule\n\\end{tabular}\n\\endgroup\n");
    text
}

/// The whole floating table, with caption and label.
pub fn latex(layout: &TableLayout) -> String {
    format!(
        "{NEEDS}\\begin{{table}}\n\\centering\n\\caption{{{}}}\n\\label{{tab:{}}}\n{}\\end{{table}}\n",
        latex_escape(&layout.caption),
        layout.name,
        body(layout),
    )
}

#[cfg(test)]
mod tests {
    use super::super::render::tests::sample;
    use super::*;

    #[test]
    fn escapes_everything_special() {
        let text = latex(&sample());
        assert!(text.contains("\\caption{A \\& B\\_1. 12 of 21 targets.}"));
        // The paper leaves zeros out, so the columns are flush right.
        assert!(text.contains("\\begin{tabular}{lrr}"), "{text}");
        assert!(
            text.contains("precision $\\uparrow$ & {\\bfseries .120\\textdagger{}} & {.100} \\\\"),
            "{text}"
        );
        assert_eq!(
            latex_escape("\\{$}^~"),
            "\\textbackslash{}\\{\\$\\}\\textasciicircum{}\\textasciitilde{}"
        );
        assert_eq!(latex_escape("a--b é"), "a-{}-b é");
        assert_eq!(
            latex_escape("a\u{5d0}\u{5d1}b"),
            "a{\\ifdefined\\Umathcode \u{5d0}\u{5d1}\\else ??\\fi}b"
        );
    }

    #[test]
    fn siunitx_aligns_numbers_with_a_digit_before_the_point() {
        let mut layout = sample();
        let cells = &mut layout.groups[0].rows[0].cells;
        cells[0].ours = Some("0.120".into());
        cells[0].published = Some("12".into());
        cells[0].difference = Some("-0.010".into());
        let text = latex(&layout);
        assert!(text.contains("\\begin{tabular}{lS[table-format=+2.3]r}"), "{text}");
        assert!(
            text.contains("& \\bfseries 0.120{\\textdagger} &") && text.contains("difference & -0.010 &")
        );
        assert_eq!(digits("-0.5"), Some((1, 1, true)));
        for none in ["", ".5", "5.", "0.1±0.2", "1e5", "--1", "nan", "1.2.3"] {
            assert_eq!(digits(none), None, "{none}");
        }
        assert!(is_bare("-.5") && !is_bare("0.5") && !is_bare(".") && !is_bare(".a"));
    }
}
