//! `trackfail explain TABLE ROW COLUMN`: traces a number to sequences, events and frames.

use super::Failure;
use super::output::{self, Format};
use crate::report::explain::explain;
use crate::report::explain::listing::{self, Listing, NAMED};
use crate::report::explain::select;
use crate::report::trace::frame_range;
use std::path::PathBuf;

/// Arguments of `explain`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A table of an experiment that has results: `quickstart/table1`, or its name alone where only one has it
    #[arg(value_name = "TABLE")]
    table: String,
    /// A row of it
    #[arg(value_name = "ROW", allow_negative_numbers = true)]
    row: String,
    /// A column of it
    #[arg(value_name = "COLUMN", allow_negative_numbers = true)]
    column: String,
    /// Only this tracker, where the table has several
    #[arg(long, value_name = "LABEL")]
    tracker: Option<String>,
    /// Only this method (`DTEF`, `AVU[length=20]`), where neither rows nor columns are methods
    #[arg(long, value_name = "NAME")]
    method: Option<String>,
    /// Go down to the events and detections of this sequence
    #[arg(long, value_name = "NAME")]
    sequence: Option<String>,
    /// Go down to these frames of the sequence: `40-60`
    #[arg(long, value_name = "FROM-TO", requires = "sequence", value_parser = frame_range)]
    frames: Option<(i64, i64)>,
    /// Folder that results are read from
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
    /// How to print it
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Runs the verb.
///
/// # Errors
/// See [`Failure`].
pub fn run(args: &Args) -> Result<(), Failure> {
    let (results, table) = select::find_table(&args.results, &args.table)?;
    let table = &results.experiment.tables[table];
    let io = |e: &dyn std::fmt::Display| Failure::io(format!("{}: {e}", results.experiment.name));
    let scores = results.scores().map_err(|e| io(&e))?;
    let [row, column] = [&args.row, &args.column].map(|name| Some(name.as_str()));
    let wanted = [row, column, args.tracker.as_deref(), args.method.as_deref()];
    let digits = (args.format == Format::Table).then_some(4);
    // Blocks for people, one table for programs.
    let (mut blocks, mut whole) = (Vec::new(), Listing::default());
    let mut add = |headline: String, listing: Listing| -> Result<(), Failure> {
        if args.format == Format::Table {
            // The headline names the number, so the rows need not.
            let rows: Vec<Vec<String>> = listing.rows.iter().map(|row| row[NAMED..].to_vec()).collect();
            let table = output::text(args.format, &listing.headings[NAMED..], &rows)?;
            blocks.push(format!("{headline}\n{table}"));
        } else {
            whole.headings = listing.headings;
            whole.rows.extend(listing.rows);
        }
        Ok(())
    };
    for cell in &select::find_cells(&results, &scores, table, wanted)? {
        let explained = explain(&results, &scores, cell).map_err(|e| io(&e))?;
        let Some(sequence) = &args.sequence else {
            add(listing::about(&results, table, &explained), listing::sequences(&explained, digits))?;
            continue;
        };
        let traces = select::traces(&results, &explained, sequence)?;
        if let Some((from, to)) = args.frames {
            let numbers = || traces.iter().flat_map(|trace| &trace.track.numbers);
            if let (Some(first), Some(last)) = (numbers().min(), numbers().max())
                && (to < *first || from > *last)
            {
                let message = format!("--frames {from}-{to}: {sequence} has the frames {first} to {last}");
                return Err(Failure::usage(message));
            }
        }
        let headline = listing::about_sequence(&results, &explained, sequence);
        let listing = match (args.frames, explained.protocol.and_then(|p| p.frame)) {
            (Some(range), _) => listing::frames(&explained, &traces, range, digits),
            (None, Some(frame)) => listing::stretches(&explained, &traces, frame),
            (None, None) => listing::moments(&results, &explained, &traces, digits),
        };
        add(headline, listing)?;
    }
    match args.format {
        Format::Table => output::write(&blocks.join("\n")),
        format => output::print(format, &whole.headings, &whole.rows),
    }
}
