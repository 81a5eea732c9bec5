//! The color of a method: the same in all figures of an experiment, and for the methods of the papers in most others too.

use crate::figure::{Color, Style};
use crate::table::layout::is_anchor;
use trackfail_engine::spec::Experiment;
use trackfail_judge::method::names;

/// Number of colors, from which on [`Style::nth`] has dashes too.
const COLORS: usize = 7;

/// The place of a method, named without a grid point, among the colors. A method of the papers has that of its place in
/// their list, where no method before it has the same color; all others have the first that is free. Anchors have none.
pub fn place(experiment: &Experiment, method: &str) -> Option<usize> {
    let known = names();
    let own = experiment.methods.iter().map(|m| m.name.as_str());
    let own: Vec<&str> = own.filter(|name| !is_anchor(experiment, name)).collect();
    let mut places: Vec<Option<usize>> = vec![None; own.len()];
    for (k, name) in own.iter().enumerate() {
        let wanted = known.iter().position(|published| published == name).map(|at| at % COLORS);
        places[k] = wanted.filter(|at| !places.contains(&Some(*at)));
    }
    for k in 0..own.len() {
        if places[k].is_none() {
            places[k] = (0..).find(|at| !places.contains(&Some(*at)));
        }
    }
    places[own.iter().position(|name| *name == method)?]
}

/// The color of a method; gray for an anchor.
pub fn color(experiment: &Experiment, method: &str) -> Color {
    place(experiment, method).map_or(Color::Gray, |k| Style::nth(k).color)
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackfail_engine::spec::read::parse;

    fn places(methods: &[&str]) -> Vec<Option<usize>> {
        let mut text = "schema = 1\nname = \"a\"\ntitle = \"a\"\nprotocol = \"khalid2016/1\"\n[suites]\n\
                        test = \"synthetic-otb\"\ntrain = \"synthetic-vot\"\n[[tracker]]\nname = \"ncc\"\n"
            .to_string();
        for method in methods {
            text.push_str(&format!("[[method]]\nname = \"{method}\"\n"));
            if *method == "own" {
                text.push_str(
                    "signal = { kind = \"rgb-histogram\" }\ndetector = { kind = \"level\", below = 0.5 }\n",
                );
            }
        }
        text.push_str("[[method]]\nname = \"never\"\ndetector = { kind = \"never\" }\n");
        let experiment = parse("a.toml", &text).unwrap();
        methods.iter().chain(&["never"]).map(|m| place(&experiment, m)).collect()
    }

    // The list of published methods begins with DTEF, NAIVE, RAW, CovF: theirs are the first four colors, in any order and
    // in any company.
    #[test]
    fn a_published_method_has_one_color_in_all_experiments() {
        assert_eq!(places(&["CovF", "DTEF"]), [Some(3), Some(0), None]);
        assert_eq!(places(&["DTEF", "own", "RAW", "CovF"]), [Some(0), Some(1), Some(2), Some(3), None]);
    }
}
