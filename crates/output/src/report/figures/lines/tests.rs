use super::*;
use crate::testing;

/// Experiment with these methods; the last one is an anchor.
fn experiment(methods: &[&str]) -> Experiment {
    let level = "signal = { kind = \"rgb-histogram\" }\ndetector = { kind = \"level\", below = 0.5 }";
    let mut all: Vec<(&str, &str)> = methods.iter().map(|method| (*method, level)).collect();
    all.push(("periodic", "detector = { kind = \"periodic\", period = 25 }"));
    testing::experiment("", &all, "")
}

fn line(method: &str, tracker: &str, others: &[(&str, f64)]) -> Line {
    let others = others.iter().map(|(axis, v)| (axis.to_string(), *v)).collect();
    let points = vec![(0.1, 0.5), (0.2, 0.4)];
    let band = vec![(0.4, 0.6), (0.3, 0.5)];
    Line { method: method.into(), tracker: tracker.into(), others, points, band, ..Line::default() }
}

fn arranged(methods: &[&str], lines: Vec<Line>) -> Figure {
    arrange(&experiment(methods), "", Default::default(), &lines)
}

fn names(figure: &Figure) -> Vec<&str> {
    figure.legend.iter().map(|e| e.name.as_str()).collect()
}

fn titles(figure: &Figure) -> Vec<&str> {
    figure.rows[0].iter().map(|panel| panel.title.as_str()).collect()
}

/// Styles of the lines of a panel, without those behind.
fn styles(panel: &Panel) -> Vec<Style> {
    let style = |mark: &Mark| if let Mark::Line { style, .. } = mark { Some(*style) } else { None };
    panel.marks.iter().filter_map(style).filter(|style| *style != BEHIND).collect()
}

fn count(panel: &Panel, is_it: fn(&Mark) -> bool) -> usize {
    panel.marks.iter().filter(|mark| is_it(mark)).count()
}

fn is_band(mark: &Mark) -> bool {
    matches!(mark, Mark::Band(..))
}

#[test]
fn a_method_has_its_color_on_every_tracker_and_a_tracker_its_dash_or_panel() {
    let of = |methods: &[&str], trackers: &[&str]| {
        let lines = methods.iter().flat_map(|m| trackers.iter().map(move |t| line(m, t, &[]))).collect();
        let figure = arranged(methods, lines);
        let styles = figure.rows[0].iter().flat_map(styles).map(|s| (s.color, s.dash));
        (styles.collect::<Vec<_>>(), names(&figure).join(", "), titles(&figure).join(", "))
    };
    let [(a, b), (c, d)] = [("A", "B"), ("C", "D")].map(|(k, l)| (colors::of_name(k), colors::of_name(l)));
    let (whole, dashed) = (Dash::SOLID, Dash::DASHED);
    let few = of(&["A", "B"], &["NCC", "SP"]);
    assert_eq!(few.0, [(a, whole), (a, dashed), (b, whole), (b, dashed)]);
    assert_eq!((few.1.as_str(), few.2.as_str()), ("A, B, NCC, SP, 95 % bootstrap interval", ""));
    let many = of(&["A", "C", "D"], &["T1", "T2", "T3"]);
    assert_eq!(many.0, [(a, whole), (c, whole), (d, whole)].repeat(3));
    assert_eq!((many.1.as_str(), many.2.as_str()), ("A, C, D, 95 % bootstrap interval", "T1, T2, T3"));
}

#[test]
fn more_than_four_methods_have_a_panel_each_before_the_others() {
    let methods = ["A", "B", "C", "D", "E", "F"];
    let mut lines: Vec<Line> = methods.iter().map(|m| line(m, "NCC", &[])).collect();
    lines[0].summary = "AP .41".into();
    lines[0].operating = Some((0.1, 0.5));
    lines.push(Line { points: vec![(0.3, 0.3)], band: vec![], ..line("periodic", "NCC", &[]) });
    let figure = arranged(&methods, lines);
    assert_eq!(titles(&figure), ["A, AP .41", "B", "C", "D", "E", "F"]);
    for panel in &figure.rows[0] {
        // The method's own curve with its band, the anchor's point, and the five others behind.
        let behind = count(panel, |mark| matches!(mark, Mark::Line { style, .. } if *style == BEHIND));
        assert_eq!((styles(panel).len(), count(panel, is_band), behind), (2, 1, 5));
    }
    let signs = ["periodic", "the other methods", "operating point", "95 % bootstrap interval"];
    assert_eq!(names(&figure), signs);
}

#[test]
fn values_of_a_parameter_have_colors_in_their_order() {
    let lines = [5.0, 10.0, 25.0, 50.0]
        .iter()
        .flat_map(|h| [10.0, 20.0].map(|w| line("A", "NCC", &[("horizon", *h), ("window", w)])));
    let figure = arranged(&["A"], lines.collect());
    assert_eq!(titles(&figure), ["window 10", "window 20"]);
    let colors: Vec<Color> = styles(&figure.rows[0][0]).iter().map(|s| s.color).collect();
    assert_eq!(colors, [0, 1, 2, 3].map(|k| Color::ordered(k, 4)));
    assert_eq!(names(&figure), ["horizon 5", "horizon 10", "horizon 25", "horizon 50"]);
    // Only the published point's curve has a band.
    assert!(figure.rows[0].iter().all(|panel| count(panel, is_band) == 0));
}

#[test]
fn published_points_have_a_sign() {
    let published = Line { published: vec![(0.1, 0.4), (0.2, 0.4)], ..line("A", "NCC", &[]) };
    let figure = arranged(&["A"], vec![published]);
    assert_eq!(count(&figure.rows[0][0], |mark| matches!(mark, Mark::Point(_, Marker::Published, _))), 2);
    assert_eq!(names(&figure), ["A", "published", "95 % bootstrap interval"]);
}

#[test]
fn headings_begin_with_a_capital() {
    for (text, expected) in [("recall", "Recall"), ("cₜ", "cₜ"), ("F1 score", "F1 score"), ("", "")] {
        assert_eq!(capitalized(text), expected);
    }
}
