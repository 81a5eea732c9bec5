//! A user's tracks as one HTML file that needs nothing beside it.

use super::{UserTrack, UserVideo, telling_frames};
use crate::report::html;
use crate::report::page::{Page, ReportError};
use crate::report::sequences::json::embedded;
use crate::report::sequences::{JudgedSeries, Method, Sequence, Sequences, Track};
use crate::report::verdict::{of_target, table, verdict};
use crate::results::detections::{JudgedMethod, TargetState};
use ::image::codecs::jpeg::JpegEncoder;
use ::image::{ExtendedColorType, ImageEncoder};
use base64::prelude::{BASE64_STANDARD, Engine};
use rayon::prelude::*;
use std::collections::BTreeMap;
use trackfail_core::image::Frame;
use trackfail_core::image::patch::halved;
use trackfail_core::region::{Rect, Region};
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
        let packed = self.sequences()?.packed();
        let series = embedded(&packed, MAX_SERIES).ok_or(UserPageError::TooLong)?;
        let sentence = |track: &UserTrack| {
            let method = track.first_method()?;
            Some(of_target(&track.judged, &verdict(&track.judged, method)))
        };
        let page = Page {
            title: format!("Is the tracker on its target? {}", self.sequence.name),
            verdict: self.tracks.iter().filter_map(sentence).collect(),
            stretches: table(&self.tracks.iter().map(|track| &track.judged).collect::<Vec<_>>()),
            sequences: packed.tallies(),
            series,
            provenance: self.facts.clone(),
            provenance_head: self.facts.len(),
            ..Page::default()
        };
        Ok(html::render(&page)?)
    }

    fn sequences(&self) -> Result<Sequences, UserPageError> {
        let first = self.tracks.first();
        let methods = first.map_or(&[][..], |track| &track.judged.methods);
        let method = |method: &JudgedMethod| Method {
            name: method.name.clone(),
            thresholds: vec![method.threshold.filter(|v| v.is_finite()); self.tracks.len()],
            counted: String::new(),
        };
        let frames = self.sequence.len();
        let has_frames = self.sequence.has_frames();
        let size = if has_frames { Some(self.sequence.size()?) } else { None };
        let sequence = Sequence {
            name: self.sequence.name.clone(),
            first: i64::from(self.sequence.number(0)),
            size,
            truth: vec![None; frames],
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
            let jpeg = jpeg(&small(frame?))?;
            let text = format!("data:image/jpeg;base64,{}", BASE64_STANDARD.encode(jpeg));
            Ok::<_, UserPageError>((rank, (t, text)))
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

/// The frame, halved until it is small.
fn small(mut frame: Frame) -> Frame {
    while frame.width().max(frame.height()) > MAX_PICTURE_SIDE {
        frame = halved(&frame);
    }
    frame
}

fn jpeg(frame: &Frame) -> Result<Vec<u8>, ::image::ImageError> {
    let mut bytes = Vec::new();
    let (width, height) = (frame.width() as u32, frame.height() as u32);
    let encoder = JpegEncoder::new_with_quality(&mut bytes, QUALITY);
    encoder.write_image(frame.bytes(), width, height, ExtendedColorType::Rgb8)?;
    Ok(bytes)
}

/// A track as the page shows it.
fn shown(tracker: usize, track: &UserTrack) -> Track {
    const NOWHERE: Rect = Rect { x: f64::NAN, y: f64::NAN, w: f64::NAN, h: f64::NAN };
    let rect = |region: &Option<Region>| region.as_ref().map_or(NOWHERE, Region::rect);
    Track {
        sequence: 0,
        tracker,
        rects: track.regions.iter().map(rect).collect(),
        background: Vec::new(),
        error: vec![f64::NAN; track.regions.len()],
        methods: track.judged.methods.iter().map(series).enumerate().collect(),
    }
}

/// The series of a method; its changes are those of the state.
pub(super) fn series(method: &JudgedMethod) -> JudgedSeries {
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
    JudgedSeries {
        score: method.score.iter().map(|score| score.unwrap_or(f64::NAN)).collect(),
        alarm: method.label.clone(),
        changes,
        judged: TrackScore { detections, ..TrackScore::default() },
        lost,
        absent: in_state(TargetState::Absent),
    }
}
