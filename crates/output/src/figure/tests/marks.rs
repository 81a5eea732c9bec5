//! Lines, gaps and the key of figures.

use super::*;

#[test]
fn lines_of_equal_f_begin_at_the_upper_edge() {
    let scene = panels_of_methods().scene(WIDTH).expect("a scene");
    let starts: Vec<f64> = scene
        .items
        .iter()
        .filter_map(|item| match item {
            scene::Item::Line { points, stroke } if stroke.rgb == [0xDC; 3] => points.first().map(|p| p.1),
            _ => None,
        })
        .collect();
    // F .2 to .8 in each of five panels, which stand in two rows.
    assert_eq!(starts.len(), 20);
    let mut edges = starts;
    edges.dedup_by(|a, b| (*a - *b).abs() < 0.5);
    assert_eq!(edges.len(), 2, "{edges:?}");
}

// Where the target is found again is no failure, and where an alarm ends no detection of one.
#[test]
fn the_key_of_a_strip_tells_the_two_ends_of_losses_and_alarms_apart() {
    let names = |strip: &Strip| parse(&strip.to_svg().expect("a figure")).1;
    let mut strip = three();
    let has = |texts: &[String], word: &str| texts.iter().any(|t| t == word);
    let both = names(&strip);
    assert!(has(&both, "loss") && has(&both, "recovery") && has(&both, "alarm begins"), "{both:?}");
    assert!(!has(&both, "alarm ends"));
    strip.rows[0][0].events.truncate(1);
    strip.rows[0][2].alarms.push((3, Edge::Ends));
    let other = names(&strip);
    assert!(has(&other, "loss") && !has(&other, "recovery") && has(&other, "alarm ends"), "{other:?}");
}

#[test]
fn values_that_are_not_finite_leave_gaps() {
    let mut strip = four();
    for panel in strip.rows.iter_mut().flatten() {
        panel.range = Range::Auto;
        for series in &mut panel.series {
            series.values[..8].copy_from_slice(&[
                f64::NAN,
                f64::INFINITY,
                1e308,
                -1e308,
                1e99,
                0.0,
                -0.0,
                1e-320,
            ]);
        }
        panel.thresholds.push(Threshold { name: "none".into(), value: f64::NAN, style: Style::nth(0) });
        panel.events.push((usize::MAX, Edge::Begins));
        panel.alarms.push((1_000_000, Edge::Ends));
        panel.spans.push(1_000_000..usize::MAX);
    }
    parse(&strip.to_svg().expect("a figure"));
    assert!(strip.to_png().is_ok());

    let mut empty = three();
    empty.rows[0][0].series[0].values.fill(f64::NAN);
    let (_, texts) = parse(&empty.to_svg().expect("a figure"));
    assert!(texts.iter().any(|t| t == "no values"));

    let one = FrameAxis { first: 7, count: 1 };
    let mut single = Panel::new("y", one);
    single.series.push(Series { name: String::new(), values: vec![0.5], style: Style::nth(0) });
    single.spans.push(0..1);
    let strip = Strip { stills: vec![], headings: vec![], rows: vec![vec![single]], ..three() };
    assert!(parse(&strip.to_svg().expect("a figure")).1.iter().any(|t| t == "7"));
}
