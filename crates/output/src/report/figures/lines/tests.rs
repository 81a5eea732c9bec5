use super::*;
use trackfail_engine::spec::read::parse;

/// An experiment with these methods, the last of them an anchor.
fn experiment(methods: &[&str]) -> Experiment {
    let mut text = "schema = 1\nname = \"a\"\ntitle = \"a\"\nprotocol = \"khalid2016/1\"\n[suites]\n\
                    test = \"synthetic-otb\"\n[[tracker]]\nname = \"ncc\"\n"
        .to_string();
    for method in methods {
        text.push_str(&format!("[[method]]\nname = \"{method}\"\nsignal = {{ kind = \"rgb-histogram\" }}\n"));
        text.push_str("detector = { kind = \"level\", below = 0.5 }\n");
    }
    text.push_str("[[method]]\nname = \"periodic\"\ndetector = { kind = \"periodic\", period = 25 }\n");
    parse("a.toml", &text).unwrap()
}

fn line(method: &str, tracker: &str, others: &[(&str, f64)]) -> Line {
    let others = others.iter().map(|(axis, v)| (axis.to_string(), *v)).collect();
    let points = vec![(0.1, 0.5), (0.2, 0.4)];
    let band = vec![(0.4, 0.6), (0.3, 0.5)];
    Line { method: method.into(), tracker: tracker.into(), others, points, band, ..Line::default() }
}

fn arranged(methods: &[&str], lines: Vec<Line>) -> Curves {
    arrange(&experiment(methods), "", ("x", "y"), lines)
}

fn names(curves: &Curves) -> Vec<&str> {
    curves.legend.iter().map(|e| e.name.as_str()).collect()
}

#[test]
fn a_method_has_its_color_on_every_tracker_and_a_tracker_its_dash() {
    let lines = ["A", "B"].iter().flat_map(|m| ["NCC", "SP"].map(|t| line(m, t, &[]))).collect();
    let curves = arranged(&["A", "B"], lines);
    let [facet] = curves.facets.as_slice() else { panic!("one panel") };
    let styles: Vec<(Color, Dash)> = facet.series.iter().map(|c| (c.style.color, c.style.dash)).collect();
    let [blue, red] = [0, 1].map(|k| Style::nth(k).color);
    let (whole, dashed) = (Dash::Solid, Dash::Dashed);
    assert_eq!(styles, [(blue, whole), (blue, dashed), (red, whole), (red, dashed)]);
    assert_eq!(names(&curves), ["A", "B", "NCC", "SP", "95 % bootstrap interval"]);
    // The color is that of the method's place in the experiment, not in the figure.
    let one = arranged(&["A", "B"], vec![line("B", "NCC", &[])]);
    assert_eq!(one.facets[0].series[0].style.color, red);
}

#[test]
fn many_trackers_have_a_panel_each() {
    let trackers = ["T1", "T2", "T3"];
    let lines = ["A", "B", "C"].iter().flat_map(|m| trackers.map(|t| line(m, t, &[]))).collect();
    let curves = arranged(&["A", "B", "C"], lines);
    let labels: Vec<&str> = curves.facets.iter().map(|f| f.label.as_str()).collect();
    assert_eq!(labels, trackers);
    assert!(curves.facets.iter().all(|f| f.series.len() == 3));
    assert!(curves.facets.iter().flat_map(|f| &f.series).all(|c| c.style.dash == Dash::Solid));
    assert_eq!(names(&curves), ["A", "B", "C", "95 % bootstrap interval"]);
}

#[test]
fn more_than_four_methods_have_a_panel_each_before_the_others() {
    let methods = ["A", "B", "C", "D", "E", "F"];
    let mut lines: Vec<Line> = methods.iter().map(|m| line(m, "NCC", &[])).collect();
    lines[0].summary = "AP .41".into();
    lines[0].operating = Some((0.1, 0.5));
    lines.push(Line { points: vec![(0.3, 0.3)], band: vec![], ..line("periodic", "NCC", &[]) });
    let curves = arranged(&methods, lines);
    assert_eq!(curves.facets.len(), 6);
    assert_eq!((curves.facets[0].label.as_str(), curves.facets[1].label.as_str()), ("A, AP .41", "B"));
    for facet in &curves.facets {
        // The method's own curve with its band, the anchor's point, and the five others behind.
        let bands: Vec<usize> = facet.series.iter().map(|c| c.band.len()).collect();
        assert_eq!((bands, facet.behind.len()), (vec![2, 0], 5));
    }
    assert_eq!(
        names(&curves),
        ["periodic", "the other methods", "operating point", "95 % bootstrap interval"]
    );
}

#[test]
fn values_of_a_parameter_have_colors_in_their_order() {
    let lines = [5.0, 10.0, 25.0, 50.0]
        .iter()
        .flat_map(|h| [10.0, 20.0].map(|w| line("A", "NCC", &[("horizon", *h), ("window", w)])));
    let curves = arranged(&["A"], lines.collect());
    let labels: Vec<&str> = curves.facets.iter().map(|f| f.label.as_str()).collect();
    assert_eq!(labels, ["window 10", "window 20"]);
    let colors: Vec<Color> = curves.facets[0].series.iter().map(|c| c.style.color).collect();
    assert_eq!(colors, [0, 1, 2, 3].map(|k| Color::ordered(k, 4)));
    assert_eq!(names(&curves), ["horizon 5", "horizon 10", "horizon 25", "horizon 50"]);
    // Only the published point's curve has a band.
    assert!(curves.facets.iter().flat_map(|f| &f.series).all(|c| c.band.is_empty()));
}

#[test]
fn published_points_have_a_sign() {
    let published = Line { published: vec![(0.1, 0.4), (0.2, 0.4)], ..line("A", "NCC", &[]) };
    let curves = arranged(&["A"], vec![published]);
    let signs: Vec<Sign> = curves.facets[0].signs.iter().map(|s| s.0).collect();
    assert_eq!(signs, [Sign::Published; 2]);
    assert_eq!(names(&curves), ["A", "published", "95 % bootstrap interval"]);
}

#[test]
fn headings_begin_with_a_capital() {
    for (text, expected) in [("recall", "Recall"), ("cₜ", "cₜ"), ("F1 score", "F1 score"), ("", "")] {
        assert_eq!(capitalized(text), expected);
    }
}
