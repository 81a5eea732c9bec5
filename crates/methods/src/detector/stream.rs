//! Detectors that judge a track while it goes on.

/// Judgement of one frame by a [`Stream`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Judgement {
    /// Probability that the target is lost in this frame, in `[0, 1]`; NaN from detectors that estimate none.
    pub probability: f64,
    /// Whether an alarm is on: from the frame in which it was raised until the recovery is confirmed.
    pub lost: bool,
    /// Whether this frame raises the alarm, and does not only hold one of the frames before.
    pub raised: bool,
    /// Features that speak for a loss, the loudest first; none that speaks against it.
    pub reasons: Vec<Reason>,
}

/// One of the features that speak for a loss.
#[derive(Debug, Clone, PartialEq)]
pub struct Reason {
    /// In words: `colors of the first frame: 0.21, usually 0.93`.
    pub text: String,
    /// Its share of the log odds of a loss, above 0.
    pub weight: f64,
}

/// A track being judged; `push` is called once a frame, in order, from the first frame on. Its memory does not grow.
pub trait Stream: Send {
    /// Judges the next frame by the values of the detector's signals, in their order; NaN for an input that is missing in
    /// this frame.
    fn push(&mut self, values: &[f64]) -> Judgement;

    /// Everything that it remembers, for [`Detector::resume`](super::Detector::resume).
    fn save(&self) -> Vec<u8>;
}
