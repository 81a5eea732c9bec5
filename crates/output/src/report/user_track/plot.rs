//! A user's track as a figure: stills over a panel for each method.

use super::{UserTrack, UserVideo, telling_frames};
use crate::figure::{
    Color, Dash, FrameAxis, Panel, Series, Still, Strip, Style, Threshold, annotate, spans_where,
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
    pub fn plot(&self) -> Result<Strip, DatasetError> {
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
        let axis = FrameAxis { first: self.sequence.number(0), count: frames };
        let panels = |track: &UserTrack| -> Vec<Vec<Panel>> {
            let of = |method: &JudgedMethod| vec![panel(track, method, axis, self.tracks.len() > 1)];
            track.judged.methods.iter().map(of).collect()
        };
        let note = match self.tracks.as_slice() {
            [track] => track.first_method().map(|method| verdict(&track.judged, method)),
            _ => None,
        };
        Ok(Strip {
            title: self.sequence.name.clone(),
            note: note.unwrap_or_default(),
            stills,
            headings: Vec::new(),
            rows: self.tracks.iter().flat_map(panels).collect(),
            shaded: "target lost",
        })
    }
}

fn panel(track: &UserTrack, method: &JudgedMethod, axis: FrameAxis, several: bool) -> Panel {
    let name = if several { format!("{}, {}", track.name(), method.name) } else { method.name.clone() };
    let mut panel = Panel::new("score", axis);
    panel.caption = name;
    let values = method.score.iter().map(|score| score.unwrap_or(f64::NAN)).collect();
    panel.series.push(Series { name: String::new(), values, style: Style::new(Color::Blue, Dash::Solid) });
    let style = Style::new(Color::Vermilion, Dash::Dashed);
    let level = method.threshold.map(|value| Threshold { name: format!("threshold {value}"), value, style });
    panel.thresholds.extend(level);
    let lost: Vec<bool> = method.states.iter().map(|state| *state == TargetState::Lost).collect();
    panel.spans = spans_where(&lost);
    panel
}
