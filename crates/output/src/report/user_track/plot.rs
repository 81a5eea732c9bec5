//! A user's track as a figure: stills over a panel for each method.

use super::{UserTrack, UserVideo, telling_frames};
use crate::figure::{
    Axis, Color, Dash, Entry, Figure, Form, Mark, Panel, Range, Still, Style, Symbol, annotate, spans_where,
};
use crate::report::verdict::verdict;
use crate::results::detections::{JudgedMethod, TargetState};
use trackfail_dataset::DatasetError;

/// Stills of a figure.
const STILLS: usize = 5;

impl UserVideo<'_> {
    /// The figure: the score of each method with its threshold, shaded where the target is lost.
    ///
    /// # Errors
    /// When a frame cannot be decoded.
    pub fn plot(&self) -> Result<Figure, DatasetError> {
        let frames = self.sequence.len();
        let mut shown = telling_frames(&self.tracks, frames, STILLS);
        shown.sort_unstable();
        shown.retain(|_| self.sequence.has_frames());
        let still = |t: &usize| {
            let pixels = annotate(&self.sequence.frame(*t)?, &self.boxes(*t), "", Color::Black);
            let state = match self.tracks.as_slice() {
                [track] => track.state(*t).word(),
                _ => "",
            };
            Ok(Still { number: self.sequence.number(*t), pixels, boxes: Vec::new(), caption: state.into() })
        };
        let stills: Vec<Still> = shown.iter().map(still).collect::<Result<_, DatasetError>>()?;
        let panels = |track: &UserTrack| -> Vec<Vec<Panel>> {
            track.judged.methods.iter().map(|method| vec![self.panel(track, method)]).collect()
        };
        let note = match self.tracks.as_slice() {
            [track] => track.first_method().map(|method| verdict(&track.judged, method)),
            _ => None,
        };
        let rows: Vec<Vec<Panel>> = self.tracks.iter().flat_map(panels).collect();
        let mut marks = rows.iter().flatten().flat_map(|panel| &panel.marks);
        let has_loss = marks.any(|mark| matches!(mark, Mark::Shade(_)));
        let lost = has_loss.then(|| Entry::new(Symbol::Shade, "target lost"));
        Ok(Figure {
            title: self.sequence.name.clone(),
            note: note.unwrap_or_default(),
            stills,
            form: Form::Strip,
            rows,
            legend: lost.into_iter().collect(),
        })
    }

    fn panel(&self, track: &UserTrack, method: &JudgedMethod) -> Panel {
        let first = self.sequence.number(0);
        let at = |t: usize| f64::from(first) + t as f64;
        let several = self.tracks.len() > 1;
        let title = if several { format!("{}, {}", track.name(), method.name) } else { method.name.clone() };
        let lost: Vec<bool> = method.states.iter().map(|state| *state == TargetState::Lost).collect();
        let shade = |run: std::ops::Range<usize>| Mark::Shade(at(run.start) - 0.5..at(run.end) - 0.5);
        let score = method.score.iter().enumerate().map(|(t, score)| (at(t), score.unwrap_or(f64::NAN)));
        let style = Style::new(Color::Vermilion, Dash::Dashed);
        let level = method.threshold;
        let name = |value: f64| Entry::new(Symbol::Line(style, None), format!("threshold {value}"));
        let mut marks: Vec<Mark> = spans_where(&lost).into_iter().map(shade).collect();
        marks.extend(level.map(|value| Mark::Level(value, style)));
        marks.push(Mark::line(score.collect(), Style::new(Color::Blue, Dash::Solid)));
        Panel {
            title,
            x: Axis::frames(first, self.sequence.len()),
            y: Axis::new("score", Range::Auto),
            marks,
            legend: level.map(name).into_iter().collect(),
        }
    }
}
