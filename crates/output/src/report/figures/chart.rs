//! `chart`: a chart that an analysis makes, on every tracker.

use super::drawer::{DrawError, Drawer, Drawing, Scope};
use super::lines::{NamedCurve, drawing, plain};
use crate::analysis::Chart;
use crate::engine::execute::analyse::Analysed;
use crate::figure::Curves;
use crate::results::Results;
use crate::results::manifest;
use crate::spec::table::FindingName;

/// The entry of this kind.
pub const DRAWER: Drawer = Drawer { word: "chart", shows_tracks: false, draw };

fn draw(scope: &Scope<'_>) -> Result<Drawing, DrawError> {
    let shows = scope.given("shows", scope.params().shows.as_ref())?;
    Ok(drawing(chart(scope.results, shows), format!("there is no analysis {}", shows.analysis)))
}

/// Draws a chart of an analysis, on every tracker.
fn chart(results: &Results, shows: &FindingName) -> Curves {
    let found: Vec<(&Analysed, &Chart)> = results
        .analyses
        .iter()
        .filter(|a| a.analysis == shows.analysis)
        .filter_map(|a| Some((a, a.findings.charts.iter().find(|c| c.name == shows.part)?)))
        .collect();
    let several = found.len() > 1;
    let named = |(analysed, chart): &(&Analysed, &Chart)| {
        let who = &analysed.tracker;
        let named = |(name, points): &NamedCurve| {
            let name = match name.as_str() {
                "" => who.clone(),
                value if value.starts_with('[') => format!("{who} {value}"),
                _ if several => format!("{who}, {name}"),
                _ => name.clone(),
            };
            (name, points.clone())
        };
        chart.curves.iter().map(named).collect::<Vec<_>>()
    };
    let of_first = |text: fn(&Chart) -> &str| found.first().map_or("", |(_, c)| text(c));
    let note = found.first().map(|(a, _)| format!("{}, {}", a.suites_note(), manifest::runs(a.runs)));
    let curves = found.iter().flat_map(named).collect();
    Curves {
        y_log: found.first().is_some_and(|(_, c)| c.y_log),
        ..plain(&note.unwrap_or_default(), of_first(|c| &c.x), of_first(|c| &c.y), curves)
    }
}
