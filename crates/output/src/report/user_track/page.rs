//! A user's tracks as one HTML file that needs nothing beside it.

use super::{UserTrack, UserVideo, telling_frames};
use crate::report::html;
use crate::report::page::{Page, ReportError};
use crate::report::sequences::json::{NOWHERE, Said, embedded};
use crate::report::sequences::{Method, Sequence, Sequences, Track};
use crate::report::verdict::{of_target, table, verdict};
use crate::results::detections::{JudgedMethod, TargetState};
use crate::results::{MethodSeries, TrackSeries};
use ::image::codecs::jpeg::JpegEncoder;
use ::image::{ExtendedColorType, ImageEncoder};
use base64::prelude::{BASE64_STANDARD, Engine};
use rayon::prelude::*;
use std::collections::BTreeMap;
use trackfail_core::image::Frame;
use trackfail_core::image::patch::halved;
use trackfail_core::region::Region;
use trackfail_dataset::DatasetError;
use trackfail_methods::score::TrackScore;

/// Largest number of pictures in a page.
const MAX_PICTURES: usize = 120;
/// Most bytes of all pictures together, as the page has them.
const MAX_PICTURE_BYTES: usize = 1_900_000;
/// Largest width and height of a picture, in pixels.
const MAX_PICTURE_SIDE: usize = 400;
/// Quality of a picture, of 100.
const QUALITY: u8 = 70;
/// Most bytes of the series.
const MAX_SERIES: usize = 64 << 20;

/// A page that cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum UserPageError {
    /// A frame cannot be decoded.
    #[error(transparent)]
    Frame(#[from] DatasetError),
    /// A picture cannot be encoded.
    #[error("a thumbnail cannot be encoded: {0}")]
    Picture(#[from] ::image::ImageError),
    /// The tracks are longer than a page can show.
    #[error("the tracks are too long for a page; give a part of the video, or fewer methods")]
    TooLong,
    /// The page does not fit its template.
    #[error(transparent)]
    Page(#[from] ReportError),
}

impl UserVideo<'_> {
    /// The page.
    ///
    /// # Errors
    /// See [`UserPageError`].
    pub fn page(&self) -> Result<String, UserPageError> {
        let sequences = self.sequences()?;
        let series = embedded(&sequences, MAX_SERIES).ok_or(UserPageError::TooLong)?;
        let sentence = |track: &UserTrack| {
            let method = track.first_method()?;
            Some(of_target(&track.judged, &verdict(&track.judged, method)))
        };
        let page = Page {
            title: format!("Is the tracker on its target? {}", self.sequence.name),
            verdict: self.tracks.iter().filter_map(sentence).collect(),
            stretches: table(&self.tracks.iter().map(|track| &track.judged).collect::<Vec<_>>()),
            sequences: sequences.tallies(),
            series,
            provenance: self.facts.clone(),
            provenance_head: self.facts.len(),
            ..Page::default()
        };
        Ok(html::render(&page)?)
    }

    fn sequences(&self) -> Result<Sequences, UserPageError> {
        let methods = self.tracks.first().map_or(&[][..], |track| &track.judged.methods);
        let method = |method: &JudgedMethod| Method {
            name: method.name.clone(),
            thresholds: vec![threshold(method); self.tracks.len()],
            counted: String::new(),
        };
        let has_frames = self.sequence.has_frames();
        let sequence = Sequence {
            name: self.sequence.name.clone(),
            first: i64::from(self.sequence.number(0)),
            size: has_frames.then(|| self.sequence.size()).transpose()?,
            truth: vec![None; self.sequence.len()],
            pictures: if has_frames { self.pictures()? } else { BTreeMap::new() },
            ..Sequence::default()
        };
        Ok(Sequences {
            trackers: self.tracks.iter().map(UserTrack::name).collect(),
            methods: methods.iter().map(method).collect(),
            sequences: vec![sequence],
            tracks: self.tracks.iter().enumerate().map(|(k, track)| shown(k, track)).collect(),
            note: String::new(),
            unannotated: true,
        })
    }

    /// Small pictures of the frames that say most, as many as have room, by frame.
    fn pictures(&self) -> Result<BTreeMap<usize, String>, UserPageError> {
        let telling = telling_frames(&self.tracks, self.sequence.len(), MAX_PICTURES);
        let mut ranked: Vec<(usize, usize)> = telling.into_iter().enumerate().collect();
        // A video is decoded in the order of its frames.
        ranked.sort_unstable_by_key(|(_, t)| *t);
        let frames = ranked.into_iter().map(|(rank, t)| (rank, t, self.sequence.frame(t)));
        let picture = |(rank, t, frame): (usize, usize, Result<Frame, DatasetError>)| {
            Ok::<_, UserPageError>((rank, (t, thumbnail(frame?)?)))
        };
        let all: BTreeMap<usize, (usize, String)> =
            frames.par_bridge().map(picture).collect::<Result<_, _>>()?;
        let mut left = MAX_PICTURE_BYTES;
        let mut fits = |(_, text): &(usize, String)| {
            let rest = left.checked_sub(text.len());
            left = rest.unwrap_or(0);
            rest.is_some()
        };
        Ok(all.into_values().take_while(|picture| fits(picture)).collect())
    }
}

/// The frame, halved until it is small, as an address `data:...`.
fn thumbnail(mut frame: Frame) -> Result<String, ::image::ImageError> {
    while frame.width().max(frame.height()) > MAX_PICTURE_SIDE {
        frame = halved(&frame);
    }
    let mut bytes = Vec::new();
    let (width, height) = (frame.width() as u32, frame.height() as u32);
    let encoder = JpegEncoder::new_with_quality(&mut bytes, QUALITY);
    encoder.write_image(frame.bytes(), width, height, ExtendedColorType::Rgb8)?;
    Ok(format!("data:image/jpeg;base64,{}", BASE64_STANDARD.encode(bytes)))
}

fn threshold(method: &JudgedMethod) -> Option<f64> {
    method.threshold.filter(|v| v.is_finite())
}

/// A track as the page shows it.
fn shown(tracker: usize, track: &UserTrack) -> Track {
    let rect = |region: &Option<Region>| region.as_ref().map_or(NOWHERE, Region::rect);
    let series = TrackSeries {
        rects: track.regions.iter().map(rect).collect(),
        error: vec![f64::NAN; track.regions.len()],
        ..TrackSeries::default()
    };
    let said = track.judged.methods.iter().map(|method| said(&series, method)).enumerate().collect();
    Track::new([0, tracker], &series, &[], said)
}

/// What a method says; its changes are those of the state.
pub(super) fn said(track: &TrackSeries, method: &JudgedMethod) -> Said {
    let in_state = |wanted: TargetState| {
        let runs = method.stretches().filter(move |(state, _)| *state == wanted);
        runs.map(|(_, run)| run).collect::<Vec<_>>()
    };
    let lost = in_state(TargetState::Lost);
    let mut changes = vec![0; method.states.len()];
    for run in &lost {
        changes[run.start] = 1;
        if method.states.get(run.end) == Some(&TargetState::Tracking) {
            changes[run.end] = -1;
        }
    }
    let detections = (0..changes.len()).filter(|t| changes[*t] != 0).collect();
    let judged = TrackScore { detections, ..TrackScore::default() };
    let series = MethodSeries {
        score: method.score.iter().map(|score| score.unwrap_or(f64::NAN)).collect(),
        alarm: method.label.clone(),
        changes,
        ..MethodSeries::default()
    };
    Said::new(track, &series, &judged, threshold(method)).in_states(&lost, &in_state(TargetState::Absent))
}
