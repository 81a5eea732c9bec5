//! Tables as LaTeX: booktabs rules, siunitx columns, numbers as the paper rounds them.
//!
//! Columns whose numbers all have a digit before the point are aligned at the point by siunitx (`S`). If a
//! paper omits the zero (`.110`), they are flush right, because siunitx would add it again. Other texts are
//! in braces, which siunitx leaves alone.
//!
//! Anchors are left out unless the experiment names them ([`Latex`]); counts are a table of their own. A
//! table is made for the width of a column or of the text, depending on its number of columns. One with more
//! columns is split into several below each other, one longer than a page into several floats. LaTeX scales
//! down tables that are wider than their line.
//!
//! [`Latex`]: trackfail_engine::spec::table::Latex

use super::layout::{LabelKind, TableLayout};
use super::render::lines;
use crate::results::in_parts;
use std::ops::Range;
use trackfail_dataset::text::visible;
use trackfail_engine::spec::width::Width;

/// Comment that names the packages a document with the table needs.
const NEEDS: &str = "% needs \\usepackage{booktabs,graphicx,siunitx}\n";

/// Escapes text so that all LaTeX engines show it unchanged. Characters that pdfTeX does not know are kept
/// for XeTeX and LuaTeX; pdfTeX shows `?` for them.
pub fn latex_escape(text: &str) -> String {
    let mut out = String::new();
    let chars: Vec<char> = visible(text).chars().collect();
    for run in chars.chunk_by(|a, b| is_common(*a) == is_common(*b)) {
        if is_common(run[0]) {
            run.iter().for_each(|c| push_escaped(&mut out, *c));
        } else {
            let (known, unknown) = (run.iter().collect::<String>(), "?".repeat(run.len()));
            // Only XeTeX and LuaTeX, which read Unicode, have this command.
            out.push_str(&format!("{{\\ifdefined\\Umathcode {known}\\else {unknown}\\fi}}"));
        }
    }
    out
}

fn push_escaped(out: &mut String, c: char) {
    match c {
        '\\' => out.push_str("\\textbackslash{}"),
        '{' | '}' | '$' | '&' | '#' | '%' | '_' => out.extend(['\\', c]),
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
        // A `[` or `*` at the beginning of a row would be read as an argument of the line end before it, and these quotes
        // and dashes would form ligatures.
        '[' | ']' | '*' | '`' => out.extend(['{', c, '}']),
        '-' if out.ends_with('-') => out.push_str("{}-"),
        // The replacement character is in hardly any font.
        '\u{fffd}' => out.push('?'),
        c => out.push(c),
    }
}

/// True if all engines know the character: ASCII, accented letters of common font encodings, and characters
/// with a command.
fn is_common(c: char) -> bool {
    c.is_ascii() || (('À'..='ÿ').contains(&c) && !"ÐÞðþ÷".contains(c)) || "±↑↓†\u{fffd}".contains(c)
}

/// Number of digits before the point (at least one, as siunitx requires) and after it, and true if there is a
/// sign; `None` if the text is not a number.
fn digits(text: &str) -> Option<(usize, usize, bool)> {
    let unsigned = text.trim_start_matches(['+', '-']);
    let (whole, part) = unsigned.split_once('.').unwrap_or((unsigned, ""));
    let all_digits = |t: &str| t.bytes().all(|b| b.is_ascii_digit());
    let is_number = unsigned.ends_with(|c: char| c.is_ascii_digit()) && all_digits(whole) && all_digits(part);
    let signs = text.len() - unsigned.len();
    (is_number && signs <= 1).then_some((whole.len(), part.len(), signs == 1))
}

/// Mark of numbers that lack failed cells.
const FAILED: char = '†';

/// One cell; `aligned` is true in a column that siunitx aligns.
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

/// Escapes a text and sets a minus for the sign of each number, since siunitx does not format it.
fn upright(text: &str) -> String {
    let begins = |rest: &str| rest.starts_with(|c: char| c.is_ascii_digit() || c == '.');
    let pieces: Vec<&str> = text.split('-').collect();
    let mut out = latex_escape(pieces[0]);
    for (k, pair) in pieces.windows(2).enumerate() {
        let is_behind_hyphen = k > 0 && pair[0].is_empty();
        let is_sign = begins(pair[1]) && !is_behind_hyphen && !pair[0].ends_with(char::is_alphanumeric);
        let hyphen = if out.ends_with('-') { "{}-" } else { "-" };
        out.push_str(if is_sign { "$-$" } else { hyphen });
        out.push_str(&latex_escape(pair[1]));
    }
    out
}

/// A line of a table: index of the group, heading, and for each column the text and true if it is the best.
struct Line {
    group: usize,
    heading: String,
    cells: Vec<(String, bool)>,
}

/// A part of a table: headings of columns and groups, and lines.
struct Part {
    corner: String,
    columns: Vec<String>,
    groups: Vec<String>,
    lines: Vec<Line>,
}

/// Lines of the rows that `keep` accepts, under the given columns. The two bounds of an interval become one
/// column: `[low, high]`.
fn part(layout: &TableLayout, columns: &[usize], keep: fn(LabelKind) -> bool) -> Part {
    let are_bounds = |a: &usize, b: &usize| [a, b].map(|k| layout.columns[*k].shown.as_str()) == BOUNDS[..2];
    let columns: Vec<&[usize]> = columns.chunk_by(are_bounds).collect();
    let column = |of: &&[usize]| match of {
        [k] => layout.columns[*k].shown.clone(),
        _ => BOUNDS[2].to_string(),
    };
    let mut lines_of_part = Vec::new();
    for (k, group) in layout.groups.iter().enumerate() {
        let rows = group.rows.iter().filter(|row| keep(row.label.kind));
        for (heading, cells) in rows.flat_map(|row| lines(group, row)) {
            let cell = |of: &&[usize]| {
                let (text, mark) = cells.get(of[0])?;
                let high = of.get(1).and_then(|k| cells.get(*k)).map(|(high, _)| high);
                let high = high.filter(|high| !(text.is_empty() && high.is_empty()));
                let text = high.map_or_else(|| text.clone(), |high| format!("[{text}, {high}]"));
                Some((text, !mark.is_empty()))
            };
            let cells = columns.iter().filter_map(cell).collect();
            lines_of_part.push(Line { group: k, heading, cells });
        }
    }
    // Long headings have notes for readers of the page.
    let is_short = |label: &str| label.chars().count() <= MAX_HEADING;
    let heading = layout.groups.iter().map(|g| if is_short(&g.label) { &g.label } else { &g.key });
    Part {
        corner: layout.corner.clone(),
        columns: columns.iter().map(column).collect(),
        groups: heading.cloned().collect(),
        lines: lines_of_part,
    }
}

/// Indices of the columns to show: those named by the experiment, or all but anchors.
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

/// Longest heading of a group, in characters. A longer one is replaced by its name.
const MAX_HEADING: usize = 48;

/// Most lines of a float with its headings: a page of small letters, with room for a caption of five lines.
const MAX_LINES: usize = 50;

/// Headings of lower bounds, upper bounds, and both in one column.
const BOUNDS: [&str; 3] = ["95 % from", "95 % to", "95 %"];

impl Part {
    /// Column ranges of the tables below each other. An interval stays with its value.
    fn side_by_side(&self, width: Width) -> Vec<Range<usize>> {
        // Most columns beside the row headings, at eight points.
        let most = match width {
            Width::Column => 5,
            Width::Text => 12,
        };
        let mut tables: Vec<Range<usize>> = vec![Range::default()];
        for (k, column) in self.columns.iter().enumerate() {
            match tables.last_mut() {
                Some(last) if last.len() < most || column == BOUNDS[2] => last.end = k + 1,
                _ => tables.push(k..k + 1),
            }
        }
        tables
    }

    /// Heading of the group of a line, if the group begins there, after the line `before`; empty for a group
    /// without a name.
    fn heading(&self, line: &Line, before: Option<&Line>) -> Option<&str> {
        let begins = before.is_none_or(|before| before.group != line.group);
        begins.then(|| self.groups[line.group].as_str())
    }

    /// Lines of each float, which has that many tables below each other.
    fn sheets(&self, below_each_other: usize) -> Vec<&[Line]> {
        // Each of these has a line of headings and three rules.
        let most = (MAX_LINES / below_each_other).saturating_sub(3).max(5);
        in_parts(&self.lines, most, |before, line| {
            1 + usize::from(self.heading(line, before.last()).is_some_and(|heading| !heading.is_empty()))
        })
    }

    fn tabular(&self, lines: &[Line], columns: Range<usize>) -> String {
        let formats: Vec<Option<String>> = columns.clone().map(|k| format_of(lines, k)).collect();
        let column = |format: &Option<String>| match format {
            Some(format) => format!("S[table-format={format}]"),
            None => "r".to_string(),
        };
        let aligned: String = formats.iter().map(column).collect();
        let mut text = format!("\\begin{{tabular}}{{l{aligned}}}\n\\toprule\n{}", latex_escape(&self.corner));
        for column in &self.columns[columns.clone()] {
            text.push_str(&format!(" & {{{}}}", latex_escape(column)));
        }
        text.push_str(" \\\\\n");
        for (k, line) in lines.iter().enumerate() {
            if let Some(heading) = self.heading(line, lines[..k].last()) {
                text.push_str("\\midrule\n");
                if !heading.is_empty() {
                    let (all, label) = (columns.len() + 1, latex_escape(heading));
                    text.push_str(&format!("\\multicolumn{{{all}}}{{l}}{{\\textit{{{label}}}}} \\\\\n"));
                }
            }
            text.push_str(&latex_escape(&line.heading));
            let cells = line.cells.iter().skip(columns.start).zip(&formats);
            for ((shown, best), format) in cells {
                text.push_str(&format!(" & {}", cell(shown, *best, format.is_some())));
            }
            text.push_str(" \\\\\n");
        }
        text.push_str("\\bottomrule\n\\end{tabular}");
        text
    }

    /// LaTeX of the tables below each other. Those wider than the line are scaled down.
    fn body(&self, lines: &[Line], width: Width) -> String {
        let one = |columns: Range<usize>| {
            format!(
                "\\setbox0\\hbox{{%\n{}}}%\n\\ifdim\\wd0>\\linewidth\\resizebox{{\\linewidth}}{{!}}{{\\box0}}\\else\\leavevmode\\box0\\fi\n",
                self.tabular(lines, columns)
            )
        };
        let tables: Vec<String> = self.side_by_side(width).into_iter().map(one).collect();
        format!(
            "\\begingroup\\footnotesize\n\\setlength{{\\tabcolsep}}{{3pt}}\n\\sisetup{{detect-weight, retain-explicit-plus}}\n\
             {}\\endgroup\n",
            tables.join("\\par\\medskip\n")
        )
    }

    /// Width of a table: that of the experiment, or a column if the table fits.
    fn width(&self, layout: &TableLayout) -> Width {
        layout.latex.width.unwrap_or_else(|| match self.side_by_side(Width::Column).len() {
            1 => Width::Column,
            _ => Width::Text,
        })
    }

    /// Floats with caption and label, one per page.
    fn floating(&self, layout: &TableLayout, caption: &str, label: &str) -> String {
        let width = self.width(layout);
        // A table* goes over both columns of a paper that has two.
        let float = if width == Width::Column { "table" } else { "table*" };
        let sheets = self.sheets(self.side_by_side(width).len());
        let mut text = String::from(NEEDS);
        for (k, lines) in sheets.iter().enumerate() {
            // The parts of a table have one number, and the first one has its caption and label.
            let head = match k {
                0 => format!("\\caption{{{}}}\n\\label{{{label}}}", latex_escape(caption)),
                _ => {
                    format!("\\addtocounter{{table}}{{-1}}\n\\caption{{Part {} of {}.}}", k + 1, sheets.len())
                }
            };
            let body = self.body(lines, width);
            text.push_str(&format!("\\begin{{{float}}}\n\\centering\n{head}\n{body}\\end{{{float}}}\n"));
        }
        text
    }
}

/// Alignment of a column: a `table-format` of siunitx, or `None` for flush right.
fn format_of(lines: &[Line], column: usize) -> Option<String> {
    let cells = lines.iter().filter_map(|line| line.cells.get(column));
    let numbers = cells.filter_map(|(text, _)| digits(text.trim_end_matches(FAILED)));
    let found: Vec<(usize, usize, bool)> = numbers.collect();
    if found.iter().any(|d| d.0 == 0) {
        return None;
    }
    let whole = found.iter().map(|d| d.0).max()?;
    let part = found.iter().map(|d| d.1).max()?;
    let sign = if found.iter().any(|d| d.2) { "+" } else { "" };
    Some(if part == 0 { format!("{sign}{whole}") } else { format!("{sign}{whole}.{part}") })
}

/// Rows for a paper: results or, in a table of counts alone, the counts.
fn main_part(layout: &TableLayout) -> Part {
    let shown = part(layout, &columns(layout), |kind| kind == LabelKind::Result);
    if shown.lines.is_empty() { part(layout, &columns(layout), |_| true) } else { shown }
}

/// The `tabular` alone, for documents with their own caption and label.
pub fn body(layout: &TableLayout) -> String {
    let part = main_part(layout);
    part.body(&part.lines, part.width(layout))
}

/// The floating table with caption and label; several floats if it is longer than a page.
pub fn latex(experiment: &str, layout: &TableLayout) -> String {
    main_part(layout).floating(layout, &layout.caption, &label(experiment, &layout.name))
}

/// Label of a table, like `tab:khalid2016-table1-counts`, unique among all experiments. As in the names of
/// numbers, a table named like the last word of its experiment is not repeated.
fn label(experiment: &str, table: &str) -> String {
    let own =
        if experiment.split('/').next_back() == Some(table) { String::new() } else { format!("-{table}") };
    format!("tab:{}{own}", experiment.replace('/', "-"))
}

/// Counts behind the numbers of a table, as a floating table of their own; `None` without results or counts.
pub fn counts(experiment: &str, layout: &TableLayout) -> Option<String> {
    let has = |kind| layout.groups.iter().flat_map(|g| &g.rows).any(|row| row.label.kind == kind);
    if !has(LabelKind::Count) || !has(LabelKind::Result) {
        return None;
    }
    let part = part(layout, &columns(layout), |kind| kind == LabelKind::Count);
    let caption = format!("Counts behind {}. {}.", layout.name, layout.data);
    Some(part.floating(layout, &caption, &format!("{}-counts", label(experiment, &layout.name))))
}

#[cfg(test)]
mod tests;
