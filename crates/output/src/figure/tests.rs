mod marks;

use super::*;
use rand::RngExt;
use trackfail_core::image::Frame;
use trackfail_core::num::seed;
use trackfail_core::region::{Rect, Region};

const HOSTILE: &str = "</svg><script>alert(\"x\")</script> & 'q' \u{202e}abc \u{0}\u{7}\n שלום עולם";

/// Smooth noise in 0..1 that looks like a tracking error or a quality score.
fn wander(name: &str, n: usize) -> Vec<f64> {
    let mut rng = seed::rng(seed::seed(1, &[name]));
    let mut v = 0.3_f64;
    (0..n)
        .map(|_| {
            v = (v + 0.12 * (rng.random::<f64>() - 0.5)).clamp(0.0, 0.9);
            v
        })
        .collect()
}

fn panels(name: &str, first: u32, n: usize) -> [Panel; 3] {
    let frames = FrameAxis { first, count: n };
    let lost = n * 3 / 5..n * 7 / 10;
    let mut error = wander(name, n);
    error[lost.clone()].fill(1.0);
    let quality: Vec<f64> =
        error.iter().zip(wander("noise", n)).map(|(e, w)| 0.06 - 0.03 * e + 0.01 * w).collect();
    let mut forecast = vec![f64::NAN; n];
    for t in 20..n {
        forecast[t] = quality[t - 5..t].iter().sum::<f64>() / 5.0;
    }
    let residual: Vec<f64> = quality.iter().zip(&forecast).map(|(y, f)| (y - f).abs()).collect();
    let line = |name: &str, values: Vec<f64>, style| Series { name: name.into(), values, style };
    let blue = Style::new(Color::Blue, Dash::Solid);
    let red = Style { width: 1.2, ..Style::new(Color::Vermilion, Dash::Dashed) };
    let black = Style { width: 1.2, ..Style::new(Color::Black, Dash::Dashed) };

    let mut o = Panel::new("Oₜ", frames);
    o.range = Range::Fixed(0.0, 1.0);
    o.spans = vec![lost.clone()];
    o.events = vec![(lost.start, Edge::Begins), (lost.end, Edge::Ends)];
    o.series = vec![line("Oₜ", error, blue)];
    let mut y = Panel::new("yₜ", frames);
    y.spans = vec![lost.clone()];
    y.series = vec![line("yₜ", quality, blue), line("forecast", forecast, red)];
    let mut z = Panel::new("|zₜ|", frames);
    z.range = Range::FromZero;
    z.spans = vec![lost];
    z.alarms = (0..n).filter(|t| residual[*t] >= 0.004).map(|t| (t, Edge::Begins)).collect();
    z.thresholds = vec![Threshold { name: "τ₁ = 0.004".into(), value: 0.004, style: black }];
    z.series = vec![line("|zₜ|", residual, blue)];
    [o, y, z]
}

fn still(number: u32, caption: &str) -> Still {
    let pixels = Frame::from_fn(160, 120, |x, y| [(x + number as usize) as u8, (2 * y) as u8, (x ^ y) as u8]);
    let turned = Region::Polygon(vec![(70.0, 40.0), (100.0, 50.0), (90.0, 90.0), (60.0, 80.0)]);
    let boxes = vec![
        (Region::Rect(Rect::new(20.0, 10.0, 200.0, 90.0)), BoxStyle::Background),
        (Region::Rect(Rect::new(50.0, 30.0, 40.0, 50.0)), BoxStyle::State),
        (turned, BoxStyle::Truth),
    ];
    Still { number, pixels, boxes, caption: caption.into() }
}

/// As Fig. 3 of the paper.
fn three() -> Strip {
    let mut row = panels("basketball", 1, 725);
    for (panel, letter) in row.iter_mut().zip(["(a)", "(b)", "(c)"]) {
        panel.caption = letter.into();
    }
    Strip {
        shaded: LOST,
        title: "basketball, DSST".into(),
        note: "Fig. 3: 1 of 1 sequences".into(),
        stills: [100, 250, 452, 460, 700].into_iter().map(|n| still(n, "")).collect(),
        headings: vec![],
        rows: vec![row.into()],
    }
}

/// As Fig. 4.
fn four() -> Strip {
    let names = ["CarDark", "CarScale", "Crossing", "Doll"];
    let columns: Vec<[Panel; 3]> =
        names.iter().zip([393, 252, 120, 500]).map(|(name, n)| panels(name, 1, n)).collect();
    let rows = (0..3).map(|r| columns.iter().map(|c| c[r].clone()).collect()).collect();
    let headings = names.iter().map(|s| (*s).into()).collect();
    Strip {
        shaded: LOST,
        title: "Track quality scores".into(),
        note: "3 of 4 targets; missing: CarDark".into(),
        stills: vec![],
        headings,
        rows,
    }
}

/// As Fig. 5.
fn five() -> Strip {
    let [o, y, z] = panels("CarDark", 1, 393);
    let mut both = y.clone();
    both.label = "similarity".into();
    both.series[0].name = "RgbHist".into();
    both.series[1].name = "RLHist".into();
    let mut covariance = z.clone();
    covariance.label = "CovF".into();
    Strip {
        shaded: LOST,
        title: "CarDark".into(),
        note: String::new(),
        stills: [1, 200, 275].into_iter().map(|n| still(n, "target lost")).collect(),
        headings: vec![],
        rows: vec![vec![o, z], vec![covariance, both]],
    }
}

fn sweep() -> Curves {
    let curve = |(i, l): (usize, i32)| {
        let f = |k: i32| 0.3 - 0.004 * (f64::from(k) - 4.0 - i as f64).powi(2);
        let points: Vec<(f64, f64)> = (3..=9).map(|k| (f64::from(k) * 0.001, f(k))).collect();
        let band = points.iter().map(|p| (p.1 - 0.02, p.1 + 0.03)).collect();
        let curve = Curve { band, ..Curve::new(points, Style::nth(i), Marker::nth(i)) };
        (Entry::new(Symbol::Line(curve.style, curve.marker), format!("l = {l}")), curve)
    };
    let (mut legend, series): (Vec<Entry>, Vec<Curve>) =
        [5, 10, 25, 50].into_iter().enumerate().map(curve).unzip();
    let published = Style::new(Color::Gray, Dash::Dashed);
    legend.push(Entry::new(Symbol::Upright(published), "published τ₁ = 0.004"));
    let facet = Facet {
        label: "window 20".into(),
        signs: vec![
            (Sign::Operating, (0.004, 0.3), Color::Blue),
            (Sign::Published, (0.005, 0.2), Color::Gray),
        ],
        names: vec![("best".into(), (0.006, 0.28))],
        uprights: vec![(0.004, published)],
        series,
        ..Facet::default()
    };
    Curves {
        title: "F-score on D1 against the threshold".into(),
        note: "Δt₂ = 20; 20 sequences, 42 failures".into(),
        x: CurveAxis::new("τ₁"),
        y: CurveAxis::new("F-score"),
        square: false,
        iso_f: false,
        facets: vec![facet],
        legend,
    }
}

fn receiver() -> Curves {
    let curve = |(i, power): (usize, f64)| {
        let points = (0..=200).map(|k| f64::from(k) / 200.0).map(|x| (x, x.powf(power))).collect();
        Curve::new(points, Style::nth(i), Marker::nth(i))
    };
    let series = [0.2, 0.3, 0.5, 1.0].into_iter().enumerate().map(curve).collect();
    let share = |label: &str| CurveAxis { range: Range::Fixed(0.0, 1.0), ..CurveAxis::new(label) };
    Curves {
        title: "Receiver operating curves".into(),
        x: share("false positive rate"),
        y: share("recall"),
        square: true,
        facets: vec![Facet { series, ..Facet::default() }],
        ..sweep()
    }
}

/// Five panels of precision over recall.
fn panels_of_methods() -> Curves {
    let [facet] = receiver().facets.try_into().expect("one panel");
    let behind = facet.series.iter().map(|c| c.points.clone()).collect();
    let facet = Facet { label: "DTEF, AP .41".into(), behind, ..facet };
    Curves { iso_f: true, facets: vec![facet; 5], ..receiver() }
}

/// Every figure in both widths.
fn all() -> Vec<(&'static str, Files)> {
    let points = (-4..=2).map(|k| (10.0_f64.powi(k), f64::from(k * k))).collect();
    let series = vec![Curve::new(points, Style::nth(0), Marker::Circle)];
    let logarithmic = Curves {
        x: CurveAxis { log: true, ..CurveAxis::new("τ₁") },
        facets: vec![Facet { series, ..Facet::default() }],
        ..sweep()
    };
    let plots: [(&str, &dyn Plot); 7] = [
        ("three", &three()),
        ("four", &four()),
        ("five", &five()),
        ("sweep", &sweep()),
        ("receiver", &receiver()),
        ("panels", &panels_of_methods()),
        ("logarithmic", &logarithmic),
    ];
    let draw = |(name, plot): (&'static str, &dyn Plot)| {
        [WIDTH, COLUMN].map(|width| (name, plot.draw(width).expect("a figure")))
    };
    plots.into_iter().flat_map(draw).collect()
}

/// Counts elements and texts of a well-formed document; panics where it is not well-formed.
fn parse(xml: &str) -> (usize, Vec<String>) {
    let (mut open, mut elements, mut texts) = (Vec::new(), 0, Vec::new());
    let mut rest = xml;
    assert!(!xml.chars().any(|c| c != '\n' && c.is_control()), "control character");
    while let Some((text, after)) = rest.split_once('<') {
        assert!(!text.contains('>'), "{text}");
        for reference in text.split('&').skip(1) {
            let name = reference.split(';').next().unwrap_or("");
            assert!(["lt", "gt", "amp", "quot", "apos"].contains(&name), "&{reference}");
        }
        if !text.trim().is_empty() {
            assert!(!open.is_empty(), "text outside the root");
            texts.push(text.trim().to_owned());
        }
        let (tag, after) = after.split_once('>').expect("an end to each tag");
        assert!(!tag.contains('<'), "{tag}");
        rest = after;
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name));
            continue;
        }
        elements += 1;
        let body = tag.strip_suffix('/').unwrap_or(tag);
        let (name, attributes) = body.split_once(' ').unwrap_or((body, ""));
        assert!(name.chars().all(|c| c.is_ascii_alphabetic()), "{name}");
        let mut attributes = attributes.trim_start();
        while !attributes.is_empty() {
            let (key, value) = attributes.split_once("=\"").expect("a quoted value");
            assert!(key.chars().all(|c| c.is_ascii_alphanumeric() || c == '-'), "{key}");
            attributes = value.split_once('"').expect("a closing quote").1.trim_start();
        }
        if body == tag {
            open.push(name);
        }
    }
    assert!(open.is_empty() && rest.trim().is_empty());
    (elements, texts)
}

/// Places and extents of all texts must lie on the page.
fn assert_on_page(scene: &scene::Scene) {
    for item in &scene.items {
        let scene::Item::Text { text, at, size, anchor, upwards, .. } = item else { continue };
        let w = font::width(text, *size);
        let (a, b) = match anchor {
            scene::Anchor::Start => (0.0, w),
            scene::Anchor::Middle => (-w / 2.0, w / 2.0),
            scene::Anchor::End => (-w, 0.0),
        };
        let (from, to, end) =
            if *upwards { (at.1 - b, at.1 - a, scene.height) } else { (at.0 + a, at.0 + b, scene.width) };
        assert!(from >= -1e-6 && to <= end + 1e-6, "`{text}` reaches from {from} to {to} of {end}");
    }
}

#[test]
fn svg_is_well_formed_offline_and_without_ids() {
    for (name, Files { svg, .. }) in all() {
        let (elements, texts) = parse(&svg);
        assert!(elements > 20 && texts.len() > 5, "{name}");
        assert_eq!(svg.matches("http").count(), 1, "{name}: only the namespace");
        assert!(!svg.contains(" id="), "{name}");
    }
}

#[test]
fn stills_are_embedded_under_their_boxes() {
    let svg = three().to_svg().expect("a figure");
    assert_eq!(svg.matches("<image ").count(), 5);
    let (images, boxes) = (svg.rfind("<image "), svg.find("<polyline "));
    assert!(images < boxes);
    // The bytes between are the still itself.
    let data = svg.split("base64,").nth(1).and_then(|s| s.split('"').next()).expect("data");
    let png = base64::Engine::decode(&base64::prelude::BASE64_STANDARD, data).expect("base64");
    let image = ::image::load_from_memory(&png).expect("a PNG").to_rgb8();
    assert_eq!(image.as_raw(), three().stills[0].pixels.bytes());
}

#[test]
fn the_png_has_two_pixels_a_unit() {
    let figure = three();
    let scene = figure.scene(WIDTH).expect("a layout");
    let image = ::image::load_from_memory(&figure.to_png().expect("a figure")).expect("a PNG").to_rgb8();
    assert_eq!(f64::from(image.width()), 2.0 * scene.width);
    assert_eq!(f64::from(image.height()), 2.0 * scene.height.ceil());
    // The middle of the first still shows its pixel there.
    let area = scene.pictures[0].area;
    let at = |x: f64, y: f64| image.get_pixel((2.0 * x) as u32, (2.0 * y) as u32).0;
    let shown = at(area.x + area.w * 0.75, area.y + area.h * 0.9);
    let meant = figure.stills[0].pixels.pixel(120, 108);
    for (a, b) in shown.iter().zip(meant) {
        assert!(a.abs_diff(b) <= 8, "{shown:?} {meant:?}");
    }
    assert_eq!(at(1.0, 1.0), [255; 3]);
}

#[test]
fn hostile_and_long_names_stay_text_and_on_the_page() {
    let long = "sequence-".repeat(34);
    for name in [HOSTILE, &long, "", "𝔘𝔫𝔦漢字🙂"] {
        let mut strip = three();
        strip.title = name.into();
        strip.note = name.repeat(4);
        strip.headings = vec![name.into(); 3];
        for still in &mut strip.stills {
            still.caption = name.into();
        }
        for panel in &mut strip.rows[0] {
            panel.caption = name.into();
            panel.label = name.into();
            panel.series.iter_mut().for_each(|s| s.name = name.into());
            panel.thresholds.iter_mut().for_each(|t| t.name = name.into());
        }
        assert_on_page(&strip.scene(WIDTH).expect("a layout"));
        let svg = strip.to_svg().expect("a figure");
        parse(&svg);
        assert!(!svg.contains("<script"));

        let mut curves = sweep();
        curves.title = name.into();
        curves.x.label = name.into();
        curves.y.label = name.into();
        curves.legend.iter_mut().for_each(|e| e.name = name.into());
        curves.facets[0].label = name.into();
        curves.facets[0].names[0].0 = name.into();
        assert_on_page(&curves.scene(WIDTH).expect("a layout"));
        assert_on_page(&curves.scene(COLUMN).expect("a layout"));
        parse(&curves.to_svg().expect("a figure"));
    }
    for figure in [three(), four(), five()] {
        assert_on_page(&figure.scene(WIDTH).expect("a layout"));
        assert_on_page(&figure.scene(COLUMN).expect("a layout"));
    }
    for figure in [sweep(), receiver(), panels_of_methods()] {
        assert_on_page(&figure.scene(COLUMN).expect("a layout"));
    }
}

#[test]
fn boxes_far_outside_do_not_leave_their_still() {
    let mut strip = three();
    for still in &mut strip.stills {
        still.boxes.push((Region::Rect(Rect::new(-1e7, -40.0, 1e9, 60.0)), BoxStyle::State));
    }
    let scene = strip.scene(WIDTH).expect("a layout");
    let first = scene.pictures[0].area;
    let top = scene.items.iter().filter_map(|item| match item {
        scene::Item::Line { points, .. } if points.iter().all(|p| p.1 <= first.bottom() + 1e-6) => {
            Some(points)
        }
        _ => None,
    });
    let mut lines = 0;
    for (x, y) in top.flatten() {
        lines += 1;
        let inside = |a: &scene::Area| {
            (a.x - 1e-6..=a.right() + 1e-6).contains(x) && (a.y - 1e-6..=a.bottom() + 1e-6).contains(y)
        };
        assert!(scene.pictures.iter().any(|p| inside(&p.area)), "{x} {y}");
    }
    assert!(lines > 20);
}

#[test]
fn nothing_to_draw_is_an_error() {
    let empty = Strip { stills: vec![], rows: vec![vec![]], ..three() };
    assert!(matches!(empty.to_svg(), Err(FigureError::Empty(_))));
    let no_points = Curves { facets: vec![], ..sweep() };
    assert!(matches!(no_points.to_png(), Err(FigureError::Empty(_))));
    let mut no_frames = three();
    no_frames.rows[0][0].frames.count = 0;
    assert!(matches!(no_frames.to_svg(), Err(FigureError::Empty(_))));
    let row = three().rows.remove(0);
    let tall = Strip { rows: vec![row; 60], ..three() };
    assert!(matches!(tall.to_svg(), Err(FigureError::TooLarge { .. })));
}

#[test]
fn the_same_data_gives_the_same_bytes() {
    assert_eq!(all(), all());
}

/// The frames of panels: the lines that go down and to the right around each.
fn frames(scene: &scene::Scene) -> Vec<(f64, f64, f64, f64)> {
    let corner = |item: &scene::Item| match item {
        scene::Item::Line { points, .. } => match points[..] {
            [(l, t), (x, b), (r, y)] if l == x && b == y && t < b && l < r => Some((l, t, r, b)),
            _ => None,
        },
        _ => None,
    };
    scene.items.iter().filter_map(corner).collect()
}

#[test]
fn a_legend_does_not_move_or_shrink_panels() {
    for figure in [sweep(), receiver(), panels_of_methods()] {
        let entry = |k| Entry::new(Symbol::Patch([0; 3]), format!("a long name of a curve, number {k}"));
        let with = Curves { legend: (0..20).map(entry).collect(), ..figure.clone() };
        let without = Curves { legend: vec![], ..figure };
        for width in [WIDTH, COLUMN] {
            let of = |c: &Curves| frames(&c.scene(width).expect("a layout"));
            assert_eq!(of(&with), of(&without));
            assert_eq!(of(&with).len(), with.facets.len());
        }
    }
    // In strips a panel without a legend is as far from the next as one with.
    let mut strip = five();
    strip.rows = vec![strip.rows[0].clone(), strip.rows[1].clone(), strip.rows[0].clone()];
    let tops: Vec<f64> = frames(&strip.scene(WIDTH).expect("a layout")).iter().map(|f| f.1).collect();
    assert!((tops[0] - tops[2] - (tops[2] - tops[4])).abs() < 1e-9, "{tops:?}");
}

#[test]
fn panels_are_alike_and_share_their_labels() {
    for (width, columns) in [(WIDTH, 3), (COLUMN, 2)] {
        let scene = panels_of_methods().scene(width).expect("a layout");
        let frames = frames(&scene);
        let (w, h) = (frames[0].2 - frames[0].0, frames[0].3 - frames[0].1);
        for f in &frames {
            assert!((f.2 - f.0 - w).abs() < 1e-9 && (f.3 - f.1 - h).abs() < 1e-9 && f.2 < width);
        }
        assert_eq!(frames.iter().filter(|f| f.1 == frames[0].1).count(), columns);
        let texts = |wanted: &str| {
            let is_it =
                |item: &&scene::Item| matches!(item, scene::Item::Text { text, .. } if text == wanted);
            scene.items.iter().filter(is_it).count()
        };
        // A name for each axis, and 0.4 at the left of each row and below each column.
        assert_eq!((texts("recall"), texts("false positive rate")), (1, 1));
        assert!(texts("0.0") == 5_usize.div_ceil(columns) + columns, "{}", texts("0.0"));
    }
}

#[test]
fn figures_are_seven_or_three_point_three_inches_wide_with_letters_of_seven_points() {
    let plots: [&dyn Plot; 4] = [&three(), &four(), &sweep(), &panels_of_methods()];
    for plot in plots {
        for (width, inches) in [(WIDTH, "7in"), (COLUMN, "3.3in")] {
            let files = plot.draw(width).expect("a figure");
            assert!(files.svg.contains(&format!("width=\"{inches}\"")), "{}", &files.svg[..200]);
            // The box of a view has four units each of 0.7 points.
            let sizes =
                files.svg.split("font-size=\"").skip(1).filter_map(|s| s.split('"').next()?.parse().ok());
            let smallest = sizes.fold(f64::INFINITY, f64::min) / 4.0 * 0.7;
            assert!(smallest > 7.0, "{smallest} pt");
            let image = ::image::load_from_memory(&files.png).expect("a PNG");
            assert_eq!(f64::from(image.width()), 2.0 * width.ceil());
            // 8099 pixels a meter, 206 an inch.
            let density = files.png.windows(4).position(|w| w == b"pHYs").expect("a density") + 4;
            assert_eq!(files.png[density..density + 4], 8099_u32.to_be_bytes());
            assert!(files.pdf.starts_with(b"%PDF"));
        }
    }
}

#[test]
fn many_columns_stand_below_each_other() {
    let mut strip = four();
    for row in &mut strip.rows {
        row.extend(row.clone());
    }
    strip.headings = (0..8).map(|k| format!("sequence {k}")).collect();
    let (wide, narrow) = (strip.scene(WIDTH).expect("a layout"), strip.scene(COLUMN).expect("a layout"));
    assert_eq!((wide.width, narrow.width), (WIDTH, COLUMN));
    let lefts = |scene: &scene::Scene| {
        let mut lefts: Vec<i64> = frames(scene).iter().map(|f| f.0 as i64).collect();
        assert_eq!(lefts.len(), 24);
        lefts.sort_unstable();
        lefts.dedup();
        lefts.len()
    };
    assert_eq!((lefts(&wide), lefts(&narrow)), (4, 2));
}

#[test]
fn rows_have_names_in_place_of_numbers() {
    let mut strip = three();
    let panel = &mut strip.rows[0][0];
    panel.names = vec![(0.2, "EmpTh".into()), (0.8, "AVU".into())];
    let (_, texts) = parse(&strip.to_svg().expect("a figure"));
    for name in ["EmpTh", "AVU"] {
        assert_eq!(texts.iter().filter(|t| *t == name).count(), 1);
    }
    strip.rows[0].truncate(1);
    let (_, texts) = parse(&strip.to_svg().expect("a figure"));
    assert!(!texts.iter().any(|t| t == "0.5"), "{texts:?}");
}
