//! The shape of a table: bounds of an interval in one column beside their value, and sheets of so many lines.

use super::{Block, Line, Part};

/// Headings of the columns of lower and upper bounds, and of both together.
const BOUNDS: [&str; 3] = ["95 % from", "95 % to", "95 %"];

/// Most lines of a float with its headings: a sheet of small letters, with room for a caption of five lines.
const MAX_LINES: usize = 50;

impl Part {
    /// The table with the two bounds of each interval in one column: `[low, high]`.
    pub(super) fn with_intervals(mut self) -> Self {
        let is = |column: Option<&String>, heading: &str| column.is_some_and(|c| c == heading);
        let mut k = 0;
        while k + 1 < self.columns.len() {
            if is(self.columns.get(k), BOUNDS[0]) && is(self.columns.get(k + 1), BOUNDS[1]) {
                self.columns[k] = BOUNDS[2].to_string();
                self.columns.remove(k + 1);
                for line in
                    self.blocks.iter_mut().flat_map(|b| &mut b.lines).filter(|l| k + 1 < l.cells.len())
                {
                    let (high, _) = line.cells.remove(k + 1);
                    let low = &mut line.cells[k].0;
                    if !(low.is_empty() && high.is_empty()) {
                        *low = format!("[{low}, {high}]");
                    }
                }
            }
            k += 1;
        }
        self
    }

    /// The columns that stay together, as the first one and their number: a value with its interval.
    pub(super) fn together(&self) -> Vec<(usize, usize)> {
        let mut together: Vec<(usize, usize)> = Vec::new();
        for (k, column) in self.columns.iter().enumerate() {
            match together.last_mut() {
                Some((_, count)) if column == BOUNDS[2] => *count += 1,
                _ => together.push((k, 1)),
            }
        }
        together
    }

    /// The table in parts that are no longer than a sheet, where each has so many tables below each other.
    pub(super) fn sheets(&self, below_each_other: usize) -> Vec<Self> {
        // Each of these has a line of headings and three rules.
        let most = (MAX_LINES / below_each_other.max(1)).saturating_sub(3).max(5);
        let mut sheets: Vec<Vec<Block>> = vec![Vec::new()];
        let mut used = 0;
        for block in &self.blocks {
            let head = usize::from(!block.heading.is_empty());
            let mut is_new = true;
            for line in &block.lines {
                let more = 1 + if is_new { head } else { 0 };
                if used + more > most {
                    sheets.push(Vec::new());
                    (used, is_new) = (0, true);
                }
                let Some(sheet) = sheets.last_mut() else { continue };
                if is_new {
                    sheet.push(Block { heading: block.heading.clone(), lines: Vec::new() });
                    used += head;
                }
                if let Some(last) = sheet.last_mut() {
                    last.lines.push(Line { heading: line.heading.clone(), cells: line.cells.clone() });
                }
                used += 1;
                is_new = false;
            }
        }
        let part = |blocks| Self { corner: self.corner.clone(), columns: self.columns.clone(), blocks };
        sheets.into_iter().map(part).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(columns: &[&str], rows: &[usize]) -> Part {
        let line = |k: usize| Line {
            heading: format!("row {k}"),
            cells: columns.iter().map(|c| (format!("{c} {k}"), false)).collect(),
        };
        let block = |n: &usize| Block { heading: "group".into(), lines: (0..*n).map(line).collect() };
        Part {
            corner: "method".into(),
            columns: columns.iter().map(|c| (*c).to_string()).collect(),
            blocks: rows.iter().map(block).collect(),
        }
    }

    #[test]
    fn bounds_are_one_column_that_stays_with_its_value() {
        let columns = ["reads", "AUROC", "95 % from", "95 % to", "found", "95 % from", "95 % to"];
        let part = part(&columns, &[1]).with_intervals();
        assert_eq!(part.columns, ["reads", "AUROC", "95 %", "found", "95 %"]);
        assert_eq!(part.blocks[0].lines[0].cells[2].0, "[95 % from 0, 95 % to 0]");
        assert_eq!(part.together(), [(0, 1), (1, 2), (3, 2)]);
    }

    // A sheet has 47 lines; a group that goes over its end has its heading again.
    #[test]
    fn a_long_table_is_several() {
        let lines = |part: &Part, below| -> Vec<Vec<usize>> {
            let sheets = part.sheets(below);
            sheets.iter().map(|s| s.blocks.iter().map(|b| b.lines.len()).collect()).collect()
        };
        let long = part(&["F"], &[30, 40, 5]);
        assert_eq!(lines(&long, 1), [vec![30, 15], vec![25, 5]]);
        assert_eq!(lines(&part(&["F"], &[30]), 2), [vec![21], vec![9]]);
        assert_eq!(lines(&part(&["F"], &[46]), 1), [vec![46]]);
    }
}
