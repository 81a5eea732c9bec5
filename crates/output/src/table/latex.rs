//! Tables as LaTeX: booktabs rules, siunitx columns, numbers as the paper rounds them.
//!
//! Columns whose numbers all have a digit before the point are aligned at it by siunitx (`S`). Where a paper
//! leaves the zero out (`.110`) they are flush right, because siunitx would put the zero back. Everything that is not
//! a number stands in braces, which siunitx leaves alone.
//!
//! A paper shows the methods: anchors are left out unless the experiment names them ([`Latex`]), counts are a table of
//! their own. A table is made for the width of a column (3.3 in) or of the text (7 in): in letters of ten, nine or eight
//! points by what they take on average, else as several tables below each other. One that is longer than a sheet is several floats. What is wider all the same is scaled
//! down to its line when LaTeX has measured it.
//!
//! [`Latex`]: trackfail_engine::spec::table::Latex

mod shape;

use super::layout::{Group, LabelKind, TableLayout};
use super::render::{Mark, lines};
use trackfail_dataset::text::visible;
use trackfail_engine::spec::width::Width;

/// Comment that says what the preamble of a document with the table needs.
const NEEDS: &str = "% needs \\usepackage{booktabs,graphicx,siunitx}\n";

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

/// One cell; `aligned` says whether siunitx aligns its column.
fn cell(text: &str, is_best: bool, aligned: bool) -> String {
    let number = text.trim_end_matches(FAILED);
    let bold = if is_best { "\\bfseries " } else { "" };
    if aligned && digits(number).is_some() {
        let failed = if number.len() < text.len() { "{\\textdagger}" } else { "" };
        return format!("{bold}{number}{failed}");
    }
    if text.is_empty() {
        return String::new();
    }
    format!("{{{bold}{}}}", upright(text))
}

/// A text whose numbers have a minus where they have a hyphen: siunitx is not asked for these.
fn upright(text: &str) -> String {
    let begins = |rest: &str| rest.starts_with(|c: char| c.is_ascii_digit() || c == '.');
    let mut out = String::new();
    let mut rest = text;
    while let Some(at) = rest.find('-') {
        let (before, after) = (&rest[..at], &rest[at + 1..]);
        let is_sign = begins(after) && !before.ends_with(|c: char| c.is_alphanumeric() || c == '-');
        out.push_str(&latex_escape(before));
        out.push_str(if is_sign { "$-$" } else { "-" });
        rest = after;
    }
    out + &latex_escape(rest)
}

/// A line of a table: its heading, and for each column its text and whether it is the best.
struct Line {
    heading: String,
    cells: Vec<(String, bool)>,
}

/// A group's heading with its lines.
struct Block {
    heading: String,
    lines: Vec<Line>,
}

/// The part of a table that is shown: headings and lines.
struct Part {
    corner: String,
    columns: Vec<String>,
    blocks: Vec<Block>,
}

/// The lines of some kinds of rows under the given columns.
fn part(layout: &TableLayout, columns: &[usize], keep: fn(LabelKind) -> bool) -> Part {
    let block = |group: &Group| {
        let rows = group.rows.iter().filter(|row| keep(row.label.kind));
        let line = |(heading, cells): (String, Vec<(String, Mark)>)| Line {
            heading,
            cells: columns
                .iter()
                .filter_map(|k| cells.get(*k))
                .map(|(t, m)| (t.clone(), *m != Mark::Plain))
                .collect(),
        };
        let lines: Vec<Line> = rows.flat_map(|row| lines(group, row)).map(line).collect();
        // Long headings have notes for readers of the page.
        let is_short = group.label.chars().count() <= MAX_HEADING;
        let heading = if is_short { &group.label } else { &group.key };
        (!lines.is_empty()).then(|| Block { heading: heading.clone(), lines })
    };
    let part = Part {
        corner: layout.corner.clone(),
        columns: columns.iter().filter_map(|k| layout.columns.get(*k)).map(|c| c.shown.clone()).collect(),
        blocks: layout.groups.iter().filter_map(block).collect(),
    };
    part.with_intervals()
}

/// The columns that are shown: those that the experiment names, or all but anchors.
fn columns(layout: &TableLayout) -> Vec<usize> {
    let all = || layout.columns.iter().enumerate();
    let place = |name: &String| all().find(|(_, c)| c.name == *name).map(|(k, _)| k);
    let chosen: Vec<usize> = layout.latex.columns.iter().filter_map(place).collect();
    if !chosen.is_empty() {
        return chosen;
    }
    let own: Vec<usize> = all().filter(|(_, c)| c.kind != LabelKind::Anchor).map(|(k, _)| k).collect();
    if own.is_empty() { all().map(|(k, _)| k).collect() } else { own }
}

/// Characters of a group's heading; of a longer one the name alone is shown.
const MAX_HEADING: usize = 48;

/// Width of a character of ten points, in points.
const CHARACTER: f64 = 5.0;

/// Space on each side of a column, in points.
const SPACE: f64 = 3.0;

/// Sizes of letters, as parts of ten points, the largest first.
const SIZES: [(&str, f64); 3] = [("\\normalsize", 1.0), ("\\small", 0.9), ("\\footnotesize", 0.8)];

impl Part {
    /// The width of the row headings and of each column in points of letters of ten points, about.
    fn widths(&self) -> (f64, Vec<f64>) {
        let points = |text: &str| text.chars().count() as f64 * CHARACTER;
        let lines = || self.blocks.iter().flat_map(|b| &b.lines);
        let widest = |texts: &mut dyn Iterator<Item = &str>| texts.map(points).fold(0.0, f64::max);
        let first = widest(&mut lines().map(|l| l.heading.as_str()).chain([self.corner.as_str()]));
        let of = |(k, heading): (usize, &String)| {
            let cells = lines().filter_map(|l| l.cells.get(k)).map(|c| c.0.as_str());
            widest(&mut cells.chain([heading.as_str()]))
        };
        (first, self.columns.iter().enumerate().map(of).collect())
    }

    /// The largest letters that fit, and how many columns each of the tables below each other has.
    fn fit(&self, width: f64) -> (&'static str, Vec<usize>) {
        let (first, widths) = self.widths();
        let whole = |scale: f64| {
            scale * (first + widths.iter().sum::<f64>()) + 2.0 * SPACE * (widths.len() + 1) as f64
        };
        if let Some((size, _)) = SIZES.iter().find(|(_, scale)| whole(*scale) <= width) {
            return (size, vec![widths.len()]);
        }
        let (size, scale) = SIZES[SIZES.len() - 1];
        let mut parts = Vec::new();
        let mut left = 0.0;
        for (from, count) in self.together() {
            let columns = widths[from..from + count].iter();
            let more = columns.map(|column| scale * column + 2.0 * SPACE).sum::<f64>();
            match parts.last_mut() {
                Some(before) if left >= more => {
                    *before += count;
                    left -= more;
                }
                _ => {
                    parts.push(count);
                    left = width - scale * first - 2.0 * SPACE - more;
                }
            }
        }
        (size, parts)
    }

    /// The columns from one to another.
    fn slice(&self, from: usize, count: usize) -> Self {
        let line = |l: &Line| Line {
            heading: l.heading.clone(),
            cells: l.cells.iter().skip(from).take(count).cloned().collect(),
        };
        let block =
            |b: &Block| Block { heading: b.heading.clone(), lines: b.lines.iter().map(line).collect() };
        Self {
            corner: self.corner.clone(),
            columns: self.columns.iter().skip(from).take(count).cloned().collect(),
            blocks: self.blocks.iter().map(block).collect(),
        }
    }

    /// How each column is aligned: by a `table-format` of siunitx, or flush right (`None`).
    fn formats(&self) -> Vec<Option<String>> {
        let of_column = |k: usize| {
            let cells = self.blocks.iter().flat_map(|b| &b.lines).filter_map(|l| l.cells.get(k));
            let texts: Vec<&str> = cells.map(|(text, _)| text.trim_end_matches(FAILED)).collect();
            if texts.iter().any(|t| is_bare(t)) {
                return None;
            }
            let found: Vec<(usize, usize, bool)> = texts.iter().filter_map(|t| digits(t)).collect();
            let whole = found.iter().map(|d| d.0).max()?;
            let part = found.iter().map(|d| d.1).max()?;
            let sign = if found.iter().any(|d| d.2) { "+" } else { "" };
            Some(if part == 0 { format!("{sign}{whole}") } else { format!("{sign}{whole}.{part}") })
        };
        (0..self.columns.len()).map(of_column).collect()
    }

    fn tabular(&self) -> String {
        let formats = self.formats();
        let column = |format: &Option<String>| match format {
            Some(format) => format!("S[table-format={format}]"),
            None => "r".to_string(),
        };
        let columns: String = formats.iter().map(column).collect();
        let mut text = format!("\\begin{{tabular}}{{l{columns}}}\n\\toprule\n{}", latex_escape(&self.corner));
        for column in &self.columns {
            text.push_str(&format!(" & {{{}}}", latex_escape(column)));
        }
        text.push_str(" \\\\\n");
        for block in &self.blocks {
            text.push_str("\\midrule\n");
            if !block.heading.is_empty() {
                let (columns, label) = (self.columns.len() + 1, latex_escape(&block.heading));
                text.push_str(&format!("\\multicolumn{{{columns}}}{{l}}{{\\textit{{{label}}}}} \\\\\n"));
            }
            for line in &block.lines {
                text.push_str(&latex_escape(&line.heading));
                for ((shown, best), format) in line.cells.iter().zip(&formats) {
                    text.push_str(&format!(" & {}", cell(shown, *best, format.is_some())));
                }
                text.push_str(" \\\\\n");
            }
        }
        text.push_str("\\bottomrule\n\\end{tabular}");
        text
    }

    /// The tables below each other, in letters that fit; what is wider than its line all the same is made smaller.
    fn body(&self, width: f64) -> String {
        let (size, counts) = self.fit(width);
        let mut text = format!(
            "\\begingroup{size}\n\\setlength{{\\tabcolsep}}{{{SPACE}pt}}\n\
             \\sisetup{{detect-weight, retain-explicit-plus}}\n"
        );
        let mut from = 0;
        for (k, count) in counts.into_iter().enumerate() {
            if k > 0 {
                text.push_str("\\par\\medskip\n");
            }
            text.push_str(&format!(
                "\\setbox0\\hbox{{%\n{}}}%\n\\ifdim\\wd0>\\linewidth\\resizebox{{\\linewidth}}{{!}}{{\\box0}}\\else\\leavevmode\\box0\\fi\n",
                self.slice(from, count).tabular()
            ));
            from += count;
        }
        text.push_str("\\endgroup\n");
        text
    }
}

/// The width that a table is made for: what the experiment says, or a column where it fits.
fn width(layout: &TableLayout, part: &Part) -> Width {
    layout.latex.width.unwrap_or_else(|| match part.fit(points(Width::Column)).1.as_slice() {
        [] | [_] => Width::Column,
        _ => Width::Text,
    })
}

/// A width in points of TeX.
fn points(width: Width) -> f64 {
    72.27 * width.inches()
}

/// The rows that a paper shows; where a table has nothing but counts, these.
fn main_part(layout: &TableLayout) -> Part {
    let shown = part(layout, &columns(layout), |kind| kind == LabelKind::Result);
    if shown.blocks.is_empty() { part(layout, &columns(layout), |_| true) } else { shown }
}

/// The `tabular` alone, for documents with their own caption and label.
pub fn body(layout: &TableLayout) -> String {
    let part = main_part(layout);
    part.body(points(width(layout, &part)))
}

/// The whole floating table, with caption and label; several where it is longer than a sheet.
pub fn latex(experiment: &str, layout: &TableLayout) -> String {
    let part = main_part(layout);
    floating(layout, &part, &layout.caption, &label(experiment, &layout.name))
}

/// The label of a table, `tab:khalid2016-table1-counts`: no two tables of all experiments have the same. As in the names of
/// numbers, a table that is called like the last word of its experiment is left out.
fn label(experiment: &str, table: &str) -> String {
    let own =
        if experiment.split('/').next_back() == Some(table) { String::new() } else { format!("-{table}") };
    format!("tab:{}{own}", experiment.replace('/', "-"))
}

/// The counts that the table's numbers are made from, as a floating table of their own; `None` without results or counts.
pub fn counts(experiment: &str, layout: &TableLayout) -> Option<String> {
    let has = |kind| layout.groups.iter().flat_map(|g| &g.rows).any(|row| row.label.kind == kind);
    if !has(LabelKind::Count) || !has(LabelKind::Result) {
        return None;
    }
    let part = part(layout, &columns(layout), |kind| kind == LabelKind::Count);
    let caption = format!("Counts behind {}. {}.", layout.name, layout.data);
    Some(floating(layout, &part, &caption, &format!("{}-counts", label(experiment, &layout.name))))
}

fn floating(layout: &TableLayout, part: &Part, caption: &str, label: &str) -> String {
    let width = width(layout, part);
    // A table* goes over both columns of a paper that has two.
    let float = if width == Width::Column { "table" } else { "table*" };
    let sheets = part.sheets(part.fit(points(width)).1.len());
    let mut text = String::from(NEEDS);
    for (k, sheet) in sheets.iter().enumerate() {
        // The parts of a table have one number, and the first one has its caption and label.
        let head = match k {
            0 => format!("\\caption{{{}}}\n\\label{{{label}}}", latex_escape(caption)),
            _ => format!("\\addtocounter{{table}}{{-1}}\n\\caption{{Part {} of {}.}}", k + 1, sheets.len()),
        };
        let body = sheet.body(points(width));
        text.push_str(&format!("\\begin{{{float}}}\n\\centering\n{head}\n{body}\\end{{{float}}}\n"));
    }
    text
}

#[cfg(test)]
mod tests;
