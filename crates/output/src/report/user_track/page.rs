//! A user's tracks as one self-contained HTML file.

use super::{UserTrack, UserVideo, telling_frames};
use crate::report::page::{Page, ReportError, render};
use crate::report::sequences::json::{NOWHERE, Said, embedded};
use crate::report::sequences::{Method, Sequence, Sequences, Track};
use crate::report::verdict::{of_target, table, verdict};
use crate::results::TrackSeries;
use crate::results::detections::JudgedMethod;
use ::image::codecs::jpeg::JpegEncoder;
use ::image::{ExtendedColorType, ImageEncoder};
use base64::prelude::{BASE64_STANDARD, Engine};
use rayon::prelude::*;
use std::collections::BTreeMap;
use trackfail_core::image::Frame;
use trackfail_core::image::patch::halved;
use trackfail_core::region::Region;
use trackfail_dataset::DatasetError;

/// Most pictures in a page.
const MAX_PICTURES: usize = 120;
/// Most bytes of all pictures together, as encoded in the page.
const MAX_PICTURE_BYTES: usize = 1_900_000;
/// Largest width and height of a picture, in pixels.
const MAX_PICTURE_SIDE: usize = 400;
/// JPEG quality of a picture, out of 100.
const QUALITY: u8 = 70;
/// Most bytes of the series.
const MAX_SERIES: usize = 64 << 20;

impl UserVideo<'_> {
    /// Renders the page as HTML.
    ///
    /// # Errors
    /// See [`ReportError`].
    pub fn page(&self) -> Result<String, ReportError> {
        let has_frames = self.sequence.has_frames();
        let sequence = Sequence {
            name: self.sequence.name.clone(),
            first: i64::from(self.sequence.number(0)),
            size: has_frames.then(|| self.sequence.size()).transpose()?,
            truth: vec![None; self.sequence.len()],
            pictures: if has_frames { self.pictures()? } else { BTreeMap::new() },
            ..Sequence::default()
        };
        let method = |method: &JudgedMethod| Method {
            name: method.name.clone(),
            thresholds: vec![method.threshold; self.tracks.len()],
            counted: String::new(),
        };
        let sequences = Sequences {
            trackers: self.tracks.iter().map(UserTrack::name).collect(),
            methods: self.tracks.iter().take(1).flat_map(|t| &t.judged.methods).map(method).collect(),
            sequences: vec![sequence],
            tracks: self.tracks.iter().enumerate().map(shown).collect(),
            note: String::new(),
            unannotated: true,
        };
        let too_long = "the tracks are too long for a page; give a part of the video, or fewer methods";
        let series = embedded(&sequences, MAX_SERIES).ok_or(ReportError::Unfit(too_long.into()))?;
        let sentence = |track: &UserTrack| {
            Some(of_target(&track.judged, &verdict(&track.judged, track.first_method()?)))
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
        render(&page)
    }

    /// Small pictures of the most telling frames, by frame, as many as fit.
    fn pictures(&self) -> Result<BTreeMap<usize, String>, ReportError> {
        let telling = telling_frames(&self.tracks, self.sequence.len(), MAX_PICTURES);
        let mut ranked: Vec<(usize, usize)> = telling.into_iter().enumerate().collect();
        // A video is decoded in the order of its frames.
        ranked.sort_unstable_by_key(|(_, t)| *t);
        let frames = ranked.into_iter().map(|(rank, t)| (rank, t, self.sequence.frame(t)));
        let picture = |(rank, t, frame): (usize, usize, Result<Frame, DatasetError>)| {
            Ok::<_, ReportError>((rank, (t, thumbnail(frame?)?)))
        };
        let all: BTreeMap<usize, (usize, String)> =
            frames.par_bridge().map(picture).collect::<Result<_, _>>()?;
        let mut bytes = 0;
        let fits = |(_, text): &(usize, String)| {
            bytes += text.len();
            bytes <= MAX_PICTURE_BYTES
        };
        Ok(all.into_values().take_while(fits).collect())
    }
}

/// The frame, halved until it is small, as a `data:...` URL.
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

/// A track in the form that the page shows.
fn shown((tracker, track): (usize, &UserTrack)) -> Track {
    let rect = |region: &Option<Region>| region.as_ref().map_or(NOWHERE, Region::rect);
    let series = TrackSeries {
        rects: track.regions.iter().map(rect).collect(),
        error: vec![f64::NAN; track.regions.len()],
        ..TrackSeries::default()
    };
    let said = track.judged.methods.iter().map(Said::of_states).enumerate().collect();
    Track::new([0, tracker], &series, &[], said)
}
