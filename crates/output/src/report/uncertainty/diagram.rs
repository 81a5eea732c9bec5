//! Diagrams of mean ranks with their critical difference.

use super::{Competitor, Field, Measured, Ranked};
use crate::figure::{Ranking, Ranks};

/// Most methods of a ranking, and most rankings, that a diagram can be read with.
const MAX: (usize, usize) = (12, 8);

/// The rankings of all fields as a diagram with its caption, or the reason why there is none; `None` without rankings.
pub(super) fn diagram(
    fields: &[Field],
    ranked: &[Option<Ranked>],
    measured: &Measured,
    suite: &str,
) -> Option<Result<(Ranks, String), String>> {
    let ranking = |(field, ranked): (&Field, &Option<Ranked>)| {
        let ranked = ranked.as_ref()?;
        let rank = |c: &Competitor| Some((c.name.clone(), *ranked.mean_ranks.get(&c.label)?));
        Some(Ranking {
            label: format!("{} ({} sequences)", field.label, ranked.blocks),
            methods: field.competitors.iter().filter_map(rank).collect(),
            critical: ranked.critical,
        })
    };
    let rankings: Vec<Ranking> = fields.iter().zip(ranked).filter_map(ranking).collect();
    let most = rankings.iter().map(|r| r.methods.len()).max()?;
    let too_many = match (most > MAX.0, rankings.len() > MAX.1) {
        (true, _) => Some(format!("{most} methods")),
        (false, true) => Some(format!("{} rankings", rankings.len())),
        (false, false) => None,
    };
    if let Some(many) = too_many {
        return Some(Err(format!(
            "Mean ranks by {} are in the table `uncertainty` alone: {many} are more than a diagram can show.",
            measured.title()
        )));
    }
    let caption = format!(
        "Mean ranks by {}, 1 the best; a bar joins methods that are less than the critical difference of Nemenyi's \
         test at 5 % apart, which these sequences cannot tell apart. {suite}",
        measured.title()
    );
    let competing = || fields.iter().flat_map(|f| &f.competitors).filter(|c| c.competes);
    let of_grid = if competing().any(|c| c.label != c.name) {
        "; a method with a grid is at its published parameters"
    } else {
        ""
    };
    let note = format!("Mean rank by {}, 1 the best{of_grid}", measured.title());
    Some(Ok((Ranks { title: String::new(), note, rankings }, caption)))
}
