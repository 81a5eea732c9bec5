//! A user's track as a figure, and frames of the video with the boxes, the state and the score drawn on them.

use super::{UserTrack, UserVideo, telling_frames};
use crate::figure::{
    AnnotatedBox, Axis, Color, Dash, Entry, Figure, Form, Mark, Panel, Range, Still, Style, Symbol, annotate,
};
use crate::report::verdict::{comparison, verdict};
use crate::results::detections::{JudgedMethod, TargetState};
use trackfail_core::image::Frame;
use trackfail_dataset::DatasetError;

/// Number of stills in the figure.
const STILLS: usize = 5;

/// Color of a state: green for tracking, vermilion for lost, gray for absent.
fn color(state: TargetState) -> Color {
    match state {
        TargetState::Tracking => Color::GREEN,
        TargetState::Lost => Color::VERMILION,
        TargetState::Absent => Color::GRAY,
    }
}

impl UserVideo<'_> {
    /// Frame `t` (0-based) with its boxes, drawn on the pixels `frame`. Each box has the color of its state
    /// and is dashed where it repeats an earlier one. Above are the number of the frame and, for a single
    /// target, the state and the score.
    pub fn drawn(&self, t: usize, frame: &Frame) -> Frame {
        let number = self.sequence.number(t);
        let (text, ground) = match self.lone() {
            Some(track) => {
                let state = track.state(t);
                let score = track.first_method().and_then(|method| comparison(method, t));
                (format!("{number}  {}  {}", state.word(), score.unwrap_or_default()), color(state))
            }
            None => (number.to_string(), Color::BLACK),
        };
        annotate(frame, &self.boxes(t), text.trim_end(), ground)
    }

    /// Boxes of frame `t`, in the colors of their states.
    fn boxes(&self, t: usize) -> Vec<AnnotatedBox> {
        let several = self.tracks.len() > 1;
        let annotated = |track: &UserTrack| {
            let (region, state) = (track.regions.get(t)?.clone()?, track.state(t));
            let target = track.judged.target.filter(|_| several);
            let label = target.map_or(String::new(), |id| format!("{id} {}", state.word()));
            let dash = if state == TargetState::Absent { Dash::DASHED } else { Dash::SOLID };
            Some(AnnotatedBox { region, color: color(state), dash, label })
        };
        self.tracks.iter().filter_map(annotated).collect()
    }

    /// Figure with the score of each method and its threshold. Frames with a lost target are shaded.
    ///
    /// # Errors
    /// When a frame cannot be decoded.
    pub fn plot(&self) -> Result<Figure, DatasetError> {
        let mut shown = telling_frames(&self.tracks, self.sequence.len(), STILLS);
        shown.sort_unstable();
        shown.retain(|_| self.sequence.has_frames());
        let still = |t: usize| {
            let pixels = annotate(&self.sequence.frame(t)?, &self.boxes(t), "", Color::BLACK);
            let caption = self.lone().map_or("", |track| track.state(t).word()).into();
            Ok(Still { number: self.sequence.number(t), pixels, boxes: Vec::new(), caption })
        };
        let of_methods = |track: &UserTrack| -> Vec<Vec<Panel>> {
            track.judged.methods.iter().map(|method| vec![self.panel(track, method)]).collect()
        };
        let sentence = |track: &UserTrack| Some(verdict(&track.judged, track.first_method()?));
        let has_loss = self.tracks.iter().flat_map(|t| &t.judged.methods).any(|m| !m.losses().is_empty());
        let lost = has_loss.then(|| Entry::new(Symbol::Shade, "target lost"));
        Ok(Figure {
            title: self.sequence.name.clone(),
            note: self.lone().and_then(sentence).unwrap_or_default(),
            stills: shown.into_iter().map(still).collect::<Result<_, DatasetError>>()?,
            form: Form::Strip,
            rows: self.tracks.iter().flat_map(of_methods).collect(),
            legend: lost.into_iter().collect(),
        })
    }

    fn panel(&self, track: &UserTrack, method: &JudgedMethod) -> Panel {
        let first = self.sequence.number(0);
        let at = |t: usize| f64::from(first) + t as f64;
        let several = self.tracks.len() > 1;
        let shade = |run: std::ops::Range<usize>| Mark::Shade(at(run.start) - 0.5..at(run.end) - 0.5);
        let score = method.score.iter().enumerate().map(|(t, score)| (at(t), score.unwrap_or(f64::NAN)));
        let style = Style::new(Color::VERMILION, Dash::DASHED);
        let name = |value: f64| Entry::new(Symbol::Line(style, None), format!("threshold {value}"));
        let mut marks: Vec<Mark> = method.losses().into_iter().map(shade).collect();
        marks.extend(method.threshold.map(|value| Mark::Level(value, style)));
        marks.push(Mark::line(score.collect(), Style::new(Color::BLUE, Dash::SOLID)));
        Panel {
            title: if several { format!("{}, {}", track.name(), method.name) } else { method.name.clone() },
            x: Axis::frames(first, self.sequence.len()),
            y: Axis::new("score", Range::Auto),
            marks,
            legend: method.threshold.map(name).into_iter().collect(),
        }
    }
}
