//! Critical-difference diagrams (Demsar, Journal of Machine Learning Research 7, 2006, Fig. 1): mean ranks on a
//! line, the best at the left, and bars that join methods whose ranks are too close to tell them apart.

use super::draw::Plot;
use super::error::FigureError;
use super::font;
use super::heading::heading;
use super::scene::{Anchor, Item, Point, Scene, Stroke};
use super::style::{Color, Dash, INK, MARGIN, MEDIUM, SMALL, SOFT, WIDTH};

/// Methods ranked on the same blocks.
#[derive(Debug, Clone, PartialEq)]
pub struct Ranking {
    /// Heading: what they are ranked on; may be empty.
    pub label: String,
    /// Each method with its mean rank, between 1 and the number of methods.
    pub methods: Vec<(String, f64)>,
    /// Critical difference of mean ranks: methods at least this far apart differ.
    pub critical: f64,
}

/// Rankings below each other.
#[derive(Debug, Clone, PartialEq)]
pub struct Ranks {
    /// Title; may be empty.
    pub title: String,
    /// Note under the title; may be empty.
    pub note: String,
    /// The rankings.
    pub rankings: Vec<Ranking>,
}

/// Height of a line of names, in units.
const LINE: f64 = 17.0;
/// Distance between two bars, in units.
const BAR: f64 = 7.0;
/// Most room for names on either side, as a share of the width.
const NAMES: f64 = 0.39;
/// Room beside a name and its rank, in units.
const BESIDE: f64 = 36.0;
/// More rankings than these stand in two columns, those of few methods.
const MANY: usize = 2;
/// Most methods of a ranking beside another.
const MAX_NARROW: usize = 8;
/// Room between the columns, in units.
const GAP: f64 = 16.0;
const THIN: Stroke = Stroke { rgb: SOFT, width: 0.8, dash: Dash::Solid };
const AXIS: Stroke = Stroke { rgb: INK, width: 1.2, dash: Dash::Solid };

impl Plot for Ranks {
    fn scene(&self, width: f64) -> Result<Scene, FigureError> {
        let is_ranking = |r: &Ranking| {
            let last = r.methods.len() as f64;
            let in_order = r.methods.iter().all(|(_, rank)| (1.0..=last).contains(rank));
            r.methods.len() > 1 && in_order && r.critical > 0.0 && r.critical.is_finite()
        };
        if self.rankings.is_empty() || !self.rankings.iter().all(is_ranking) {
            return Err(FigureError::Empty("a ranking needs two methods with ranks from 1 to their number"));
        }
        let mut scene = Scene::new(&self.title, width);
        let mut y = heading(&mut scene, &self.title, &self.note);
        let several = self.rankings.len() > MANY && width >= WIDTH;
        let is_narrow = |r: &Ranking| several && r.methods.len() <= MAX_NARROW;
        // Two narrow ones in a row stand beside each other.
        for rankings in self.rankings.chunk_by(|a, b| is_narrow(a) && is_narrow(b)) {
            let columns = if is_narrow(&rankings[0]) { 2 } else { 1 };
            let w = (width - 2.0 * MARGIN - GAP * (columns - 1) as f64) / columns as f64;
            for row in rankings.chunks(columns) {
                let mut bottom = y;
                for (k, ranking) in row.iter().enumerate() {
                    let left = MARGIN + k as f64 * (w + GAP);
                    bottom = bottom.max(draw_one(&mut scene, ranking, (left, y), w));
                }
                y = bottom + 14.0;
            }
        }
        scene.height = y + MARGIN / 2.0;
        Ok(scene)
    }
}

/// Draws a ranking of a width from its upper left corner on; returns the first free line below it.
fn draw_one(scene: &mut Scene, ranking: &Ranking, (left, top): Point, width: f64) -> f64 {
    let label = font::fit(ranking.label.trim(), MEDIUM, width);
    scene.text(&label, (left, top + 9.0), MEDIUM, Anchor::Start, INK);
    let count = ranking.methods.len();
    let widths = ranking.methods.iter();
    let widths =
        widths.map(|(name, rank)| font::width(name, MEDIUM) + font::width(&format!("{rank:.2}"), SMALL));
    let side = (widths.fold(0.0, f64::max) + BESIDE).min(NAMES * width);
    let (from, to) = (left + side, left + width - side);
    let place = |rank: f64| from + (rank - 1.0) / (count - 1) as f64 * (to - from);

    // The critical difference as a length, cut off where it is longer than the axis.
    let y = top + 46.0;
    let end = (1.0 + ranking.critical).min(count as f64);
    scene.line(vec![(from, y), (place(end), y)], AXIS);
    for x in [from, place(end)].into_iter().take(if 1.0 + ranking.critical > end { 1 } else { 2 }) {
        scene.line(vec![(x, y - 4.0), (x, y + 4.0)], AXIS);
    }
    let text = format!("critical difference {:.2}", ranking.critical);
    scene.text(&text, (from, y - 12.0), SMALL, Anchor::Start, SOFT);

    let axis = y + 38.0;
    scene.line(vec![(from, axis), (to, axis)], AXIS);
    let every = count.div_ceil(((to - from) / 28.0) as usize).max(1);
    for rank in (1..=count).step_by(every) {
        let x = place(rank as f64);
        scene.line(vec![(x, axis - 5.0), (x, axis)], AXIS);
        scene.text(&rank.to_string(), (x, axis - 13.0), SMALL, Anchor::Middle, INK);
    }

    let mut order: Vec<&(String, f64)> = ranking.methods.iter().collect();
    // Stable, so that ties stay in the given order.
    order.sort_by(|a, b| a.1.total_cmp(&b.1));
    let ranks: Vec<f64> = order.iter().map(|m| m.1).collect();
    let bars = cliques(&ranks, ranking.critical);
    for (k, &(first, last)) in bars.iter().enumerate() {
        let y = axis + BAR * (k as f64 + 1.0);
        let stroke = Stroke { rgb: Color::Blue.rgb(), width: 3.2, dash: Dash::Solid };
        scene.line(vec![(place(ranks[first]) - 3.0, y), (place(ranks[last]) + 3.0, y)], stroke);
    }
    // The better half at the left from above, the others at the right from below, so that no lines cross.
    let names = axis + BAR * (bars.len() as f64 + 1.0) + 8.0;
    let half = count.div_ceil(2);
    for (k, (name, rank)) in order.iter().enumerate() {
        let is_left = k < half;
        let line = if is_left { k } else { count - 1 - k };
        let (x, y) = (place(*rank), names + LINE * line as f64);
        let (end, anchor) = if is_left { (from - 10.0, Anchor::End) } else { (to + 10.0, Anchor::Start) };
        scene.line(vec![(x, axis), (x, y), (end, y)], THIN);
        scene.items.push(Item::Circle { center: (x, axis), radius: 2.6, rgb: Color::Blue.rgb() });
        let rank = format!("{rank:.2}");
        let beside = font::width(&rank, SMALL) + 8.0;
        let name = font::fit(name, MEDIUM, side - 14.0 - beside);
        let towards = if is_left { -1.0 } else { 1.0 };
        scene.text(&name, (end + 4.0 * towards, y), MEDIUM, anchor, INK);
        let after = end + towards * (12.0 + font::width(&name, MEDIUM));
        scene.text(&rank, (after, y), SMALL, anchor, SOFT);
    }
    names + LINE * half as f64
}

/// The longest runs, first and last, of ascending ranks less than `critical` apart; runs of one are left out.
fn cliques(ranks: &[f64], critical: f64) -> Vec<(usize, usize)> {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for first in 0..ranks.len() {
        let last = ranks.partition_point(|r| r - ranks[first] < critical) - 1;
        if last > first && runs.last().is_none_or(|run| run.1 < last) {
            runs.push((first, last));
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn ranks(methods: &[(&str, f64)], critical: f64) -> Ranks {
        let methods = methods.iter().map(|(name, rank)| ((*name).to_string(), *rank)).collect();
        let ranking = Ranking { label: "NCC".into(), methods, critical };
        Ranks { title: "Mean ranks".into(), note: "20 sequences".into(), rankings: vec![ranking] }
    }

    // Demsar 2006, Fig. 1 (a): mean ranks 3.143, 2.000, 2.893, 1.964 and CD = 1.25. The best and the worst are
    // less than that apart, so one bar joins all; by Fig. 1's text at CD = 1.25 C4.5 differs from none.
    #[test]
    fn groups_by_hand() {
        assert_eq!(cliques(&[1.964, 2.0, 2.893, 3.143], 1.25), [(0, 3)]);
        assert_eq!(cliques(&[1.964, 2.0, 2.893, 3.143], 1.16), [(0, 2), (1, 3)]);
        assert_eq!(cliques(&[1.0, 2.0, 3.5, 4.0], 1.0), [(2, 3)]);
        assert_eq!(cliques(&[1.5, 1.5], 0.5), [(0, 1)]);
    }

    #[test]
    fn everything_is_shown_once_and_inside() {
        let long = "a".repeat(300);
        let names = [("DTEF", 1.2), ("RAW", 2.1), (long.as_str(), 3.0), ("x<y", 3.7)];
        let figure = ranks(&names, 9.0);
        let svg = figure.to_svg().unwrap();
        for word in ["DTEF", "RAW", "x&lt;y", "1.20", "3.70", "critical difference 9.00", "NCC"] {
            assert_eq!(svg.matches(&format!(">\n{word}\n<")).count(), 1, "{word}");
        }
        let scene = figure.scene(WIDTH).unwrap();
        for item in &scene.items {
            let inside = |x: f64, y: f64| (0.0..=WIDTH).contains(&x) && (0.0..=scene.height).contains(&y);
            match item {
                Item::Line { points, .. } => assert!(points.iter().all(|p| inside(p.0, p.1))),
                Item::Text { text, at, size, anchor, .. } => {
                    let width = font::width(text, *size);
                    let from = match anchor {
                        Anchor::Start => at.0,
                        Anchor::Middle => at.0 - width / 2.0,
                        Anchor::End => at.0 - width,
                    };
                    assert!(inside(from, at.1) && inside(from + width, at.1), "{text}");
                }
                _ => {}
            }
        }
        assert_eq!(svg, figure.to_svg().unwrap());
        assert!(!figure.to_png().unwrap().is_empty());
    }

    #[test]
    fn rankings_of_few_methods_stand_beside_each_other() {
        let of = |n: usize| {
            let methods = (0..n).map(|k| (format!("method {k}"), 1.0 + k as f64)).collect();
            Ranking { label: format!("on {n}"), methods, critical: 1.5 }
        };
        let figure = Ranks { rankings: vec![of(20), of(4), of(3), of(2)], ..ranks(&[], 1.0) };
        let place = |label: &str| {
            let is_it = |item: &&Item| matches!(item, Item::Text { text, .. } if text == label);
            let scene = figure.scene(WIDTH).unwrap();
            let Some(Item::Text { at, .. }) = scene.items.iter().find(is_it) else { panic!("{label}") };
            *at
        };
        let places = [20, 4, 3, 2].map(|n| place(&format!("on {n}")));
        assert!(places[0].1 < places[1].1 && places[1].1 == places[2].1 && places[2].1 < places[3].1);
        assert!(places[0].0 == places[1].0 && places[1].0 < places[2].0 && places[3].0 == places[0].0);
    }

    #[test]
    fn wrong_rankings_are_refused() {
        assert!(ranks(&[("a", 1.0)], 1.0).to_svg().is_err());
        assert!(ranks(&[("a", 1.0), ("b", 2.5)], 1.0).to_svg().is_err());
        assert!(ranks(&[("a", 1.0), ("b", f64::NAN)], 1.0).to_svg().is_err());
        assert!(ranks(&[("a", 1.0), ("b", 2.0)], f64::INFINITY).to_svg().is_err());
        assert!(Ranks { rankings: vec![], ..ranks(&[], 1.0) }.to_svg().is_err());
    }

    proptest! {
        #[test]
        fn bars_join_exactly_the_methods_that_do_not_differ(
            mut ranks in prop::collection::vec(1.0..9.0_f64, 2..9), critical in 0.1..4.0_f64,
        ) {
            ranks.sort_by(f64::total_cmp);
            let runs = cliques(&ranks, critical);
            for i in 0..ranks.len() {
                for j in i + 1..ranks.len() {
                    let joined = runs.iter().any(|(first, last)| *first <= i && j <= *last);
                    prop_assert_eq!(joined, ranks[j] - ranks[i] < critical);
                }
            }
        }
    }
}
