//! Color of a method, chosen by its name and equal on all pages.

use crate::figure::{Color, Dash, Marker, Style};
use crate::table::layout::is_anchor;
use trackfail_engine::spec::Experiment;
use trackfail_judge::method::names;

/// Number of colors. From this index on, [`Style::nth`] adds dashes.
const COLORS: usize = 7;

/// Index of a method's color: that of its name in the list of named methods. Other names get an index from a
/// hash (Fowler, Noll and Vo).
fn place(method: &str) -> usize {
    let hash = |sum: u64, byte: u8| (sum ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
    let known = names().iter().position(|name| *name == method);
    known.unwrap_or_else(|| (method.bytes().fold(0xcbf2_9ce4_8422_2325, hash) >> 32) as usize) % COLORS
}

/// Color of a method that is not an anchor.
pub fn of_name(method: &str) -> Color {
    Style::nth(place(method)).color
}

/// Color of a method; gray for an anchor.
pub fn color(experiment: &Experiment, method: &str) -> Color {
    if is_anchor(experiment, method) { Color::GRAY } else { of_name(method) }
}

/// Line and marker of a method. Methods of an experiment with the same color differ in them; the line of an
/// anchor is always dashed or dotted.
pub fn style(experiment: &Experiment, method: &str) -> (Style, Marker) {
    let own = color(experiment, method);
    let before = experiment.methods.iter().map(|m| m.name.as_str()).take_while(|name| *name != method);
    let twins = before.filter(|name| color(experiment, name) == own).count();
    let first = usize::from(own == Color::GRAY);
    (Style::new(own, Dash::nth(first + twins)), Marker::nth(place(method) + twins))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::experiment;

    const OWN: (&str, &str) =
        ("own", "signal = { kind = \"rgb-histogram\" }\ndetector = { kind = \"level\", below = 0.5 }");
    const NEVER: (&str, &str) = ("never", "detector = { kind = \"never\" }");

    // The list of named methods begins with DTEF, NAIVE, RAW, CovF: theirs are the first four colors, in any order and in any
    // company.
    #[test]
    fn a_method_has_one_color_in_all_experiments() {
        for methods in [&[("CovF", ""), ("DTEF", ""), NEVER][..], &[("DTEF", ""), OWN, ("CovF", ""), NEVER]] {
            let experiment = experiment("", methods, "");
            let colors = ["DTEF", "CovF", "never"].map(|m| color(&experiment, m));
            assert_eq!(colors, [Style::nth(0).color, Style::nth(3).color, Color::GRAY]);
            assert_eq!(color(&experiment, "DTEF"), of_name("DTEF"));
        }
    }

    #[test]
    fn methods_of_one_color_have_other_dashes() {
        // By its letters, `own` has the second color, which is that of NAIVE.
        let experiment = experiment("", &[("NAIVE", ""), OWN, NEVER], "");
        let styles = ["NAIVE", "own", "never"].map(|m| style(&experiment, m).0);
        assert_eq!(styles[0].color, styles[1].color);
        assert_eq!(styles.map(|s| s.dash), [Dash::SOLID, Dash::DASHED, Dash::DASHED]);
    }
}
