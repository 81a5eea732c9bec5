use super::page::{Page, Shape, share_before};
use super::*;
use std::collections::BTreeSet;
use trackfail_core::image::Frame;
use trackfail_core::region::{Rect, Region};
use trackfail_testing::hostile::{elements, texts, words};

/// A wave in 0..1 that looks like a tracking error or a quality score.
fn wave(n: usize) -> Vec<f64> {
    (0..n).map(|t| 0.45 + 0.4 * (0.2 * t as f64).sin()).collect()
}

fn line(values: Vec<f64>, color: Color) -> Mark {
    let points = values.into_iter().enumerate().map(|(t, v)| (t as f64 + 1.0, v)).collect();
    Mark::line(points, Style::new(color, Dash::SOLID))
}

/// Error and score over the frames of a sequence, with a loss and alarms.
fn panels(n: usize) -> [Panel; 2] {
    let (from, to) = (n as f64 * 0.6, n as f64 * 0.7);
    let grey = Style::new(Color::GRAY, Dash::DASHED);
    let top = |x, marker| Mark::Top(x, marker, Color::BLUE);
    let error = vec![Mark::Shade(from..to), Mark::Upright(from, grey), line(wave(n), Color::BLACK)];
    let score = vec![
        Mark::Level(0.5, grey),
        line(wave(n), Color::BLUE),
        top(from, Marker::AlarmBegins),
        top(to, Marker::AlarmEnds),
    ];
    let legend = vec![Entry::new(Symbol::Line(grey, None), "τ₁ = 0.5")];
    let axes = [Axis::new("Oₜ", Range::Fixed(0.0, 1.0)), Axis::new("|zₜ|", Range::FromZero)];
    let [of_error, of_score] =
        axes.map(|y| Panel { title: "(a)".into(), x: Axis::frames(1, n), y, ..Panel::default() });
    [Panel { marks: error, ..of_error }, Panel { marks: score, legend, ..of_score }]
}

fn still(number: u32, caption: &str) -> Still {
    let pixels = Frame::from_fn(160, 120, |x, y| [(x + number as usize) as u8, (2 * y) as u8, 90]);
    let boxes = vec![
        (Region::Rect(Rect::new(20.0, 10.0, 200.0, 90.0)), BoxStyle::BACKGROUND),
        (Region::Rect(Rect::new(-1e7, -40.0, 1e9, 60.0)), BoxStyle::STATE),
        (Region::Polygon(vec![(70.0, 40.0), (100.0, 50.0), (90.0, 90.0)]), BoxStyle::TRUTH),
    ];
    Still { number, pixels, boxes, caption: caption.into() }
}

/// Five stills over a row of three panels.
fn strip() -> Figure {
    let [error, score] = panels(725);
    let stills: Vec<Still> = [100, 250, 452, 460, 700].into_iter().map(|n| still(n, "lost")).collect();
    Figure {
        title: "basketball, DSST".into(),
        note: "1 of 1 sequences".into(),
        legend: box_legend(&stills),
        stills,
        form: Form::Strip,
        rows: vec![vec![error, score.clone(), score]],
    }
}

/// Figure of `n` sequences side by side, with two panels each.
fn sequences(n: usize) -> Figure {
    let columns: Vec<[Panel; 2]> = (0..n).map(|k| panels(120 + 90 * k)).collect();
    let rows = (0..2).map(|r| columns.iter().map(|c| c[r].clone()).collect()).collect();
    Figure { stills: vec![], rows, ..strip() }
}

/// Sweep with a band, markers, names and an upright line.
fn sweep() -> Figure {
    let published = Style::new(Color::GRAY, Dash::DASHED);
    let mut marks = vec![Mark::Upright(0.004, published)];
    let mut legend = vec![Entry::new(Symbol::Upright(published), "published τ₁ = 0.004")];
    for i in 0..4 {
        let f = |k: i32| 0.3 - 0.004 * f64::from(k - 4 - i).powi(2);
        let points: Vec<(f64, f64)> = (3..=9).map(|k| (f64::from(k) * 0.001, f(k))).collect();
        let (style, marker) = (Style::nth(i as usize), Some(Marker::nth(i as usize)));
        marks.push(Mark::Band(points.iter().map(|p| (p.0, p.1 - 0.02, p.1 + 0.03)).collect(), style.color));
        marks.push(Mark::Line { points, style, marker });
        legend.push(Entry::new(Symbol::Line(style, marker), format!("horizon {i}")));
    }
    marks.push(Mark::Point((0.004, 0.3), Marker::Operating, Color::BLUE));
    marks.push(Mark::Point((0.005, 0.2), Marker::Published, Color::GRAY));
    marks.push(Mark::Name((0.006, 0.28), "best".into()));
    let (x, y) = (Axis::new("τ₁", Range::Auto), Axis::new("F-score", Range::Auto));
    let panel = Panel { title: "window 20".into(), x, y, marks, legend: vec![] };
    Figure { title: "F-score against the threshold".into(), rows: vec![vec![panel]], legend, ..noted() }
}

fn noted() -> Figure {
    Figure { note: "Δt₂ = 20; 20 sequences, 42 failures".into(), ..Figure::default() }
}

/// Panels of precision over recall.
fn precision_recall(n: usize) -> Figure {
    let points: Vec<(f64, f64)> = (0..=200).map(|k| f64::from(k) / 200.0).map(|x| (x, 1.0 - x * x)).collect();
    let share = |label: &str| Axis::new(label, Range::Fixed(0.0, 1.0));
    let panel = Panel {
        title: "DTEF, AP .41".into(),
        x: share("recall"),
        y: share("precision"),
        marks: vec![Mark::IsoF, Mark::line(points, Style::nth(0))],
        legend: vec![],
    };
    Figure { form: Form::Square, rows: vec![vec![panel; n]], ..sweep() }
}

fn dots() -> Dots {
    let panel = |label: &str, mark| DotPanel {
        label: label.into(),
        mark,
        published: vec![None, Some(0.6)],
        values: vec![Some(Dot { value: 0.4, bounds: Some((0.2, 0.5)) }), None],
        ..DotPanel::default()
    };
    Dots {
        title: "Readings of CovF".into(),
        note: String::new(),
        rows: vec!["as printed".into(), "x<y".into()],
        panels: vec![panel("recall", Some(0.7)), panel("precision", None)],
        shared_axis: false,
        colors: vec![Color::GREEN, Color::GRAY],
        chance: Some(0.5),
    }
}

/// Two polygons over fifteen spokes, one of them with a gap.
fn radar() -> Figure {
    let spoke = |k: usize| [format!("illumination variation {k}"), "0.424–0.622".to_string()];
    let polygon = |i: usize| {
        let corner = |k: usize| (k != 4 * i).then_some(0.3 + 0.04 * (k + i) as f64);
        Polygon { corners: (0..15).map(corner).collect(), style: Style::nth(i), marker: Marker::nth(i) }
    };
    let radar = Radar { spokes: (0..15).map(spoke).collect(), polygons: vec![polygon(0), polygon(1)] };
    let legend = vec![Entry::new(Symbol::Line(Style::nth(0), Some(Marker::nth(0))), "SAMF [0.650]")];
    let panel = Panel { marks: vec![Mark::Radar(radar)], ..Panel::default() };
    Figure { form: Form::Radar, rows: vec![vec![panel]], legend, ..noted() }
}

fn all() -> Vec<Figure> {
    let mut logarithmic = sweep();
    logarithmic.rows[0][0].x.log = true;
    let node = |x: f64, name: &str| ((x, 0.5), name.to_string());
    let arrow = |a: f64, b: f64| Mark::Arrow {
        from: node(a, "state"),
        to: node(b, "state"),
        label: vec!["an event: an action".into()],
        is_pair: a != b,
    };
    let unit = || Axis::new("", Range::Fixed(0.0, 1.0));
    let marks =
        vec![Mark::Node((0.2, 0.5), "state".into()), arrow(0.2, 0.8), arrow(0.8, 0.2), arrow(0.2, 0.2)];
    let diagram = Figure {
        form: Form::Diagram,
        rows: vec![vec![Panel { x: unit(), y: unit(), marks, ..Panel::default() }]],
        ..noted()
    };
    let dots = dots().figure();
    let curves = [sweep(), precision_recall(1), precision_recall(5), logarithmic];
    [strip(), sequences(4), dots, diagram, radar()].into_iter().chain(curves).collect()
}

/// All points of lines and shapes, and the extents of all texts, must lie on the page.
fn assert_on_page(page: &Page) {
    let inside = |x: f64, y: f64| {
        (-1e-6..=page.width + 1e-6).contains(&x) && (-1e-6..=page.height + 1e-6).contains(&y)
    };
    for shape in &page.shapes {
        match shape {
            Shape::Line { points, .. } | Shape::Fill { corners: points, .. } => {
                assert!(points.iter().all(|p| inside(p.0, p.1)), "{points:?}");
            }
            Shape::Text { text, at, size, anchor, upwards, .. } => {
                let w = font::width(text, *size);
                let back = w * share_before(*anchor);
                let ends = if *upwards {
                    [(at.0, at.1 + back), (at.0, at.1 + back - w)]
                } else {
                    [(at.0 - back, at.1), (at.0 - back + w, at.1)]
                };
                assert!(ends.iter().all(|p| inside(p.0, p.1)), "`{text}` at {ends:?}");
            }
        }
    }
}

/// Center and color of a disk; `None` for other shapes.
fn disc(shape: &Shape) -> Option<((f64, f64), Color)> {
    match shape {
        Shape::Line { points, style } if points.len() == 2 && points[0] == points[1] => {
            Some((points[0], style.color))
        }
        _ => None,
    }
}

/// Number of disks, and of other lines, of a color.
fn count(page: &Page, color: Color) -> (usize, usize) {
    let is_line = |s: &&Shape| matches!(s, Shape::Line { style, .. } if style.color == color);
    let (discs, lines): (Vec<&Shape>, Vec<&Shape>) =
        page.shapes.iter().filter(is_line).partition(|shape| disc(shape).is_some());
    (discs.len(), lines.len())
}

/// Areas of the panel frames, found by the lines that go down and to the right.
fn frames(figure: &Figure, width: f64) -> Vec<(f64, f64, f64, f64)> {
    let corner = |shape: &Shape| match shape {
        Shape::Line { points, .. } => match points[..] {
            [(l, t), (x, b), (r, y)] if l == x && b == y && t < b && l < r => Some((l, t, r, b)),
            _ => None,
        },
        _ => None,
    };
    figure.page(width).expect("a layout").shapes.iter().filter_map(corner).collect()
}

#[test]
fn lines_of_equal_f_begin_at_the_upper_edge() {
    let page = precision_recall(5).page(WIDTH).expect("a layout");
    let start = |shape: &Shape| match shape {
        Shape::Line { points, style } if style.color == Color([0xDC; 3]) => points.first().map(|p| p.1),
        _ => None,
    };
    let mut starts: Vec<f64> = page.shapes.iter().filter_map(start).collect();
    // F .2 to .8 in each of five panels, which stand in two rows.
    assert_eq!(starts.len(), 20);
    starts.dedup_by(|a, b| (*a - *b).abs() < 0.5);
    assert_eq!(starts.len(), 2, "{starts:?}");
}

#[test]
fn svg_is_well_formed_offline_and_without_ids() {
    for figure in all() {
        let svg = figure.to_svg().expect("a figure");
        assert!(texts(&svg).len() > 3, "{svg}");
        assert_eq!(svg.matches("http").count(), 1, "only the namespace");
        assert!(!svg.contains(" id="));
    }
    assert!(all().iter().zip(all()).all(|(a, b)| a.draw(WIDTH) == b.draw(WIDTH)));
}

#[test]
fn stills_are_embedded_under_their_boxes_and_shown_in_the_png() {
    let figure = strip();
    let svg = figure.to_svg().expect("a figure");
    assert_eq!(svg.matches("<image ").count(), 5);
    assert!(svg.rfind("<image ") < svg.find("<polyline "));
    let data = svg.split("base64,").nth(1).and_then(|s| s.split('"').next()).expect("data");
    let png = base64::Engine::decode(&base64::prelude::BASE64_STANDARD, data).expect("base64");
    let embedded = ::image::load_from_memory(&png).expect("a PNG").to_rgb8();
    assert_eq!(embedded.as_raw(), figure.stills[0].pixels.bytes());
    let page = figure.page(WIDTH).expect("a layout");
    let image = ::image::load_from_memory(&figure.to_png().expect("a figure")).expect("a PNG").to_rgb8();
    let size = (f64::from(image.width()), f64::from(image.height()));
    assert_eq!(size, (2.0 * page.width, 2.0 * page.height.ceil()));
    let area = page.frames[0].0;
    let at = |x: f64, y: f64| image.get_pixel((2.0 * x) as u32, (2.0 * y) as u32).0;
    let (shown, meant) =
        (at(area.x + area.w * 0.75, area.y + area.h * 0.9), figure.stills[0].pixels.pixel(120, 108));
    assert!(shown.iter().zip(meant).all(|(a, b)| a.abs_diff(b) <= 8), "{shown:?} {meant:?}");
    assert_eq!(at(1.0, 1.0), [255; 3]);
}

#[test]
fn any_word_is_whole_and_text_and_on_the_page() {
    const ELEMENTS: [&str; 10] =
        ["svg", "title", "rect", "g", "image", "text", "line", "polyline", "polygon", "circle"];
    let letters = |text: &str| text.chars().filter(|c| !c.is_whitespace()).collect::<String>();
    let short = |word: String| word.chars().take(108).collect::<String>();
    for name in words().into_iter().map(short).chain([String::new()]) {
        for mut figure in all() {
            figure.title.clone_from(&name);
            figure.note = name.repeat(3);
            figure.stills.iter_mut().for_each(|still| still.caption.clone_from(&name));
            figure.legend.iter_mut().for_each(|entry| entry.name.clone_from(&name));
            for panel in figure.rows.iter_mut().flatten() {
                panel.title.clone_from(&name);
                panel.legend.iter_mut().for_each(|entry| entry.name.clone_from(&name));
                for mark in &mut panel.marks {
                    match mark {
                        Mark::Name(_, text) => text.clone_from(&name),
                        Mark::Radar(radar) => {
                            radar.spokes.iter_mut().for_each(|spoke| spoke[0].clone_from(&name));
                        }
                        _ => {}
                    }
                }
            }
            for width in [WIDTH, COLUMN] {
                assert_on_page(&figure.page(width).expect("a layout"));
            }
            let svg = figure.to_svg().expect("a figure");
            assert!(elements(&svg).iter().all(|element| ELEMENTS.contains(&element.as_str())), "{svg}");
            assert!(!svg.contains('…'));
            // Once as the title of the document, then in lines.
            if !name.is_empty() {
                let (found, word) = (texts(&svg), font::clean(&name));
                assert_eq!(found[0], word.trim());
                assert!(letters(&found[1..].concat()).contains(&letters(&word)), "{svg}");
            }
        }
    }
}

#[test]
fn nothing_to_draw_is_an_error() {
    assert!(matches!(Figure::default().to_svg(), Err(FigureError::Empty(_))));
    let mut no_points = sweep();
    no_points.rows[0][0].marks.clear();
    assert!(matches!(no_points.to_png(), Err(FigureError::Empty(_))));
    assert!(matches!(Dots { rows: vec![], ..dots() }.figure().to_svg(), Err(FigureError::Empty(_))));
    let mut no_frames = strip();
    no_frames.rows[0][0].x = Axis::frames(1, 0);
    assert!(matches!(no_frames.to_svg(), Err(FigureError::Range(..))));
    let tall = Figure { rows: vec![strip().rows.remove(0); 60], ..strip() };
    assert!(matches!(tall.to_svg(), Err(FigureError::TooLarge { .. })));
}

#[test]
fn a_legend_does_not_move_or_shrink_panels() {
    for figure in [sweep(), precision_recall(1), precision_recall(5)] {
        let entry = |k| Entry::new(Symbol::Shade, format!("a long name of a curve, number {k}"));
        let with = Figure { legend: (0..20).map(entry).collect(), ..figure.clone() };
        let without = Figure { legend: vec![], ..figure };
        for width in [WIDTH, COLUMN] {
            assert_eq!(frames(&with, width), frames(&without, width));
            assert_eq!(frames(&with, width).len(), with.rows[0].len());
        }
    }
    // In strips a panel without a legend is as far from the next as one with.
    let row = || strip().rows.remove(0)[..2].to_vec();
    let mut figure = Figure { stills: vec![], rows: vec![row(), row(), row()], ..strip() };
    figure.rows[1].iter_mut().for_each(|panel| panel.legend.clear());
    let tops: Vec<f64> = frames(&figure, WIDTH).iter().map(|f| f.1).collect();
    assert!((tops[2] - tops[0] - (tops[4] - tops[2])).abs() < 1e-9, "{tops:?}");
}

#[test]
fn panels_are_alike_share_their_labels_and_stand_below_each_other() {
    for (width, columns) in [(WIDTH, 3), (COLUMN, 2)] {
        let figure = precision_recall(5);
        let frames = frames(&figure, width);
        let (w, h) = (frames[0].2 - frames[0].0, frames[0].3 - frames[0].1);
        for f in &frames {
            assert!((f.2 - f.0 - w).abs() < 1e-9 && (f.3 - f.1 - h).abs() < 1e-9 && f.2 < width);
        }
        assert_eq!(frames.iter().filter(|f| f.1 == frames[0].1).count(), columns);
        let page = figure.page(width).expect("a layout");
        let texts = |wanted: &str| {
            page.shapes.iter().filter(|s| matches!(s, Shape::Text { text, .. } if text == wanted)).count()
        };
        let all = self::frames(&sequences(8), width);
        let lefts: BTreeSet<i64> = all.iter().map(|f| f.0 as i64).collect();
        assert_eq!((all.len(), lefts.len()), (16, if width == WIDTH { 4 } else { 2 }));
        // A name for the common axis below, one for each row, and 0.0 at the left of each row and below each column.
        assert_eq!((texts("recall"), texts("precision")), (1, 5_usize.div_ceil(columns)));
        assert_eq!(texts("0.0"), 5_usize.div_ceil(columns) + columns);
    }
}

#[test]
fn figures_are_seven_or_three_point_three_inches_wide_with_letters_of_seven_points() {
    for figure in [strip(), sweep(), precision_recall(5), dots().figure(), radar()] {
        for (width, inches) in [(WIDTH, "7in"), (COLUMN, "3.3in")] {
            let files = figure.draw(width).expect("a figure");
            assert!(files.svg.contains(&format!("width=\"{inches}\"")), "{}", &files.svg[..200]);
            // The box of a view has four units each of 0.7 points.
            let sizes =
                files.svg.split("font-size=\"").skip(1).filter_map(|s| s.split('"').next()?.parse().ok());
            let smallest = sizes.fold(f64::INFINITY, f64::min) / 4.0 * 0.7;
            assert!(smallest > 7.69, "{smallest} pt");
            let image = ::image::load_from_memory(&files.png).expect("a PNG");
            assert_eq!(f64::from(image.width()), 2.0 * width.ceil());
            // 8099 pixels a meter, 206 an inch.
            let density = files.png.windows(4).position(|w| w == b"pHYs").expect("a density") + 4;
            assert_eq!(files.png[density..density + 4], 8099_u32.to_be_bytes());
            assert!(files.pdf.starts_with(b"%PDF") && files.narrow_pdf.starts_with(b"%PDF"));
        }
    }
}

#[test]
fn values_that_are_not_finite_leave_gaps() {
    let mut figure = sequences(2);
    let odd = [0.5, f64::NAN, 0.2, 0.3, f64::INFINITY, 1e308, -1e308, 1e-320];
    for panel in figure.rows.iter_mut().flatten() {
        panel.y.range = Range::Auto;
        panel.marks = vec![line(odd.to_vec(), Color::BLUE), Mark::Level(f64::NAN, Style::nth(0))];
        panel.marks.extend([Mark::Upright(1e300, Style::nth(0)), Mark::Shade(1e9..f64::INFINITY)]);
    }
    assert!(!texts(&figure.to_svg().expect("a figure")).is_empty() && figure.to_png().is_ok());
    // One line of two points, and two dots.
    let mut one = Figure { stills: vec![], ..strip() };
    one.rows[0].truncate(1);
    one.rows[0][0].marks = vec![line(odd.to_vec(), Color::VERMILION)];
    let page = one.page(WIDTH).expect("a layout");
    assert_eq!(count(&page, Color::VERMILION), (2, 1));
    one.rows[0][0].marks = vec![line(vec![f64::NAN], Color::BLUE)];
    assert!(texts(&one.to_svg().expect("a figure")).iter().any(|t| t == "no values"));
    one.rows[0][0].x = Axis::frames(7, 1);
    assert!(texts(&one.to_svg().expect("a figure")).iter().any(|t| t == "7"));
}

#[test]
fn rows_have_names_in_place_of_numbers_and_dots_with_intervals() {
    let page = dots().figure().page(WIDTH).expect("a layout");
    // In each panel a dot, its interval in the color of its row and the line of chance; in one the published value.
    assert_eq!((count(&page, Color::GREEN), count(&page, Color::BLACK)), ((2, 2), (0, 1)));
    assert_eq!(count(&page, Color::GRAY), (0, 2));
    let found = texts(&dots().figure().to_svg().expect("a figure"));
    for name in ["as printed", "x<y", "recall", "precision"] {
        assert_eq!(found.iter().filter(|t| *t == name).count(), 1, "{name}");
    }
}

// Both panels have values of .4; with an axis of its own, the one without larger ones has it further to the right.
#[test]
fn equal_values_of_a_shared_axis_are_in_equal_places() {
    let dot = |value| Some(Dot { value, bounds: None });
    let panel = |high| DotPanel { values: vec![dot(0.0), dot(0.4), dot(high)], ..DotPanel::default() };
    let places = |shared_axis| {
        let (rows, panels) = (["a", "b", "c"].map(String::from).into(), vec![panel(0.4), panel(1.0)]);
        let figure = Dots { rows, panels, shared_axis, chance: None, ..dots() }.figure();
        let page = figure.page(WIDTH).expect("a layout");
        let x: Vec<f64> = page.shapes.iter().filter_map(disc).map(|(middle, _)| middle.0).collect();
        (x[1] - x[0], x[4] - x[3])
    };
    let (own, shared) = (places(false), places(true));
    assert!((shared.0 - shared.1).abs() < 1e-9 && own.0 > 2.0 * own.1, "{own:?} {shared:?}");
}
