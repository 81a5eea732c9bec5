//! Recipes of the results of each stage. The table at [`address`](crate::store::address) lists their
//! ingredients.

use super::Job;
use crate::error::CellError;
use crate::spec::method::{
    Candidates, DetectorChoice, FixedDetector, Method, SignalChoice, Training, Variant,
};
use crate::spec::{Absence, Experiment, Tracker};
use crate::store::address::{Address, Recipe, Stage};
use std::path::{Path, PathBuf};
use trackfail_core::image::DECODER;
use trackfail_core::num::seed;
use trackfail_dataset::{DatasetError, Frames, Sequence, file_digest};
use trackfail_methods::score::overlap::OVERLAP;
use trackfail_methods::score::{Protocol, Restarts};
use trackfail_methods::tracker::{RunContext, STATE_FORM};

/// Seed of a tracker's run on a sequence.
pub fn track_seed(experiment: &Experiment, sequence: &Sequence, tracker: &Tracker, run: u32) -> u64 {
    seed::seed(experiment.seed, &[&sequence.name, &tracker.label, &run.to_string()])
}

fn failed(e: DatasetError) -> CellError {
    CellError::Failed(e.to_string())
}

/// Common part of the recipes of all tracks of a sequence. `digest` is the files digest of the sequence.
///
/// # Errors
/// When a video cannot be decoded.
pub fn sequence(sequence: &Sequence, digest: &str) -> Result<Recipe, CellError> {
    let mut recipe =
        Recipe::new(Stage::Track).with("sequence", &sequence.name).with("frames and truth", digest);
    if !matches!(sequence.frames, Frames::Rendered(..)) {
        recipe = recipe.with("frame decoder", DECODER);
    }
    // Trackers may choose by the type of the target.
    for target in sequence.attributes.iter().filter(|a| a.starts_with("target-")) {
        recipe = recipe.with("type of target", target);
    }
    if let Some(decoded) = sequence.decoded_digest().map_err(failed)? {
        recipe = recipe.with("decoded frames", decoded);
    }
    Ok(recipe)
}

/// Recipe of a track; `common` is the part made by [`sequence`](fn@sequence).
///
/// # Errors
/// When a file that the tracker reads is absent or faulty, or the experiment declares the track absent.
pub fn track(
    experiment: &Experiment,
    sequence: &Sequence,
    common: &Recipe,
    job: Job,
    data_roots: &[PathBuf],
) -> Result<Recipe, CellError> {
    let (run, tracker) = (job.run, &experiment.trackers[job.tracker]);
    let seed = track_seed(experiment, sequence, tracker, run);
    let mut recipe =
        common.clone().with_plugin("tracker", tracker.kind, tracker.version, &tracker.setup.params());
    if tracker.setup.facts().uses_seed {
        recipe = recipe.with("seed", seed);
    }
    let context = RunContext { sequence, start_frame: 0, run, seed, data_roots };
    let inputs = tracker.setup.inputs(&context).map_err(CellError::from);
    let declared = tracker.absent.iter().find(|absence| absence.sequence == sequence.name);
    let inputs = match (inputs, declared) {
        (inputs, None) => inputs?,
        (Err(_), Some(Absence { sequence, reason })) => {
            return Err(CellError::Absent(format!("has no track on {sequence}, as declared: {reason}")));
        }
        (Ok(_), Some(Absence { sequence, .. })) => {
            return Err(CellError::Failed(format!(
                "{sequence}: a track of {} is declared `absent`, but can be read; take the declaration out",
                tracker.label
            )));
        }
    };
    if !inputs.is_empty() || tracker.setup.facts().uses_run {
        recipe = recipe.with("run", run);
    }
    recipe.ingredients.extend(files(inputs, data_roots)?);
    Ok(recipe.with("form of states", STATE_FORM))
}

/// An ingredient of a recipe: name and value.
pub type Ingredient = (String, String);

/// Names and digests of files.
fn files(paths: Vec<PathBuf>, data_roots: &[PathBuf]) -> Result<Vec<Ingredient>, CellError> {
    let ingredient = |path: PathBuf| {
        // A file outside the data roots enters by its name only, so that its folder changes nothing.
        let below = data_roots.iter().find_map(|root| path.strip_prefix(root).ok());
        let shown = below.or(path.file_name().map(Path::new)).unwrap_or(&path);
        let parts: Vec<_> = shown.iter().map(|part| part.to_string_lossy()).collect();
        Ok((format!("file {}", parts.join("/")), file_digest(&path).map_err(failed)?))
    };
    paths.into_iter().map(ingredient).collect()
}

/// Names and digests of the files that a signal reads on a sequence.
///
/// # Errors
/// When one of them is absent.
pub fn signal_files(
    sequence: &Sequence,
    choice: &SignalChoice,
    data_roots: &[PathBuf],
) -> Result<Vec<Ingredient>, CellError> {
    let context = RunContext { sequence, start_frame: 0, run: 0, seed: 0, data_roots };
    files(choice.signal.inputs(&context)?, data_roots)
}

/// Recipe of a signal on a track. `companions` are the tracks of other trackers that it reads, `files` are
/// the files that it reads.
pub fn signal(track: Address, choice: &SignalChoice, companions: &[Address], files: &[Ingredient]) -> Recipe {
    let recipe = Recipe::new(Stage::Signal).with("track", track);
    let recipe = companions.iter().fold(recipe, |recipe, address| recipe.with("companion", address));
    let recipe = recipe.with_plugin("signal", choice.kind, choice.version, &choice.signal.params());
    let mut recipe = with_restarts(recipe, choice.restarts);
    recipe.ingredients.extend_from_slice(files);
    recipe
}

/// Adds the treatment of restarts to a recipe, unless restarts are parts of the track (the default).
fn with_restarts(recipe: Recipe, restarts: Restarts) -> Recipe {
    if restarts == Restarts::NewTrack { recipe.with("restarts", "new track") } else { recipe }
}

/// Adds the treatment of restarts by a detector, see [`judge::detect`](crate::execute::judge::detect). Before
/// version 2 frames after the only piece of a track were judged with it.
fn with_pieces(recipe: Recipe, restarts: Restarts) -> Recipe {
    let recipe = with_restarts(recipe, restarts);
    if restarts == Restarts::NewTrack { recipe.with("pieces", 2) } else { recipe }
}

/// Version of training; part of the address of all models.
/// - 1: the candidate with the largest pooled measure, the first among equals, with seed 0.
/// - 2: candidates may be quantiles of the signal.
pub const TRAINING: u32 = 2;

/// Version of reverse runs; part of the address of detections that use them.
/// - 1: first version.
pub const REVERSAL: u32 = 1;

/// Input of a detector as an ingredient: `signal`, or `track` for detectors without a signal, with the
/// address.
pub type Read = (&'static str, Address);

/// Recipe of a trained parameter, before its training data are added. `example` is one of the candidates.
fn parameter(protocol: &Protocol, training: &Training, example: &FixedDetector) -> Recipe {
    let mut recipe = Recipe::new(Stage::Model)
        .with("training", TRAINING)
        .with("protocol", protocol.name)
        .with("overlap", OVERLAP)
        .with("parameter", &training.key)
        .with("maximise", training.maximise.name())
        .with("candidates", training.candidates.count());
    recipe = with_reverse(recipe, example);
    let plugin = |fixed: &FixedDetector| {
        let recipe = Recipe::new(Stage::Model);
        let recipe = recipe.with_plugin("", fixed.kind, fixed.version, &fixed.detector.params());
        with_pieces(recipe, fixed.restarts).address()
    };
    match &training.candidates {
        Candidates::Listed(list) => {
            for (value, fixed) in list {
                recipe = recipe.with(format!("candidate {value}"), plugin(fixed));
            }
        }
        Candidates::Quantiles { .. } => recipe = recipe.with("candidate quantile", plugin(example)),
    }
    recipe
}

/// Recipe of a variant's trained parameter or learned model on the training data `tracks`; `None` for a
/// variant without either.
pub fn of_model(method: &Method, variant: &Variant, tracks: &[Read]) -> Option<Recipe> {
    let fixed = &variant.detector.example;
    let recipe = match &variant.detector.training {
        Some(training) => parameter(method.protocol, training, fixed),
        None => {
            let recipe = Recipe::new(Stage::Model).with("overlap", OVERLAP);
            recipe.with_plugin("learner", fixed.kind, fixed.version, &fixed.detector.learner()?.params())
        }
    };
    let with_tracks = |recipe: Recipe| tracks.iter().fold(recipe, |recipe, read| recipe.with(read.0, read.1));
    Some(if variant.detector.trains_on_others() {
        // They are many: one digest stands for them all.
        recipe.with("training data of others", with_tracks(Recipe::new(Stage::Model)).address())
    } else {
        with_tracks(recipe)
    })
}

/// Adds the version of reverse runs, if the detector uses them.
fn with_reverse(recipe: Recipe, fixed: &FixedDetector) -> Recipe {
    if fixed.detector.facts().needs_reverse { recipe.with("tracks backwards", REVERSAL) } else { recipe }
}

/// Ingredients that a detector adds to the recipes of its labels, equal for all of its cells.
pub struct DetectorKey {
    ingredients: Vec<Ingredient>,
    /// True if the seed of a cell is part of the recipe.
    pub uses_seed: bool,
}

impl DetectorKey {
    /// Key of a variant's detector, with the address of its model if it has one.
    pub fn new(detector: &DetectorChoice, model: Option<Address>) -> Self {
        let fixed = &detector.example;
        let mut recipe = Recipe::new(Stage::Labels);
        if detector.training.is_some() {
            // The chosen parameter stands for the detector.
            recipe =
                with_reverse(model.iter().fold(recipe, |recipe, model| recipe.with("model", model)), fixed);
        } else {
            recipe = recipe.with_plugin("detector", fixed.kind, fixed.version, &fixed.detector.params());
            recipe = with_pieces(with_reverse(recipe, fixed), fixed.restarts);
            recipe = model.iter().fold(recipe, |recipe, model| recipe.with("model", model));
        }
        Self { ingredients: recipe.ingredients, uses_seed: fixed.detector.facts().uses_seed }
    }

    /// Recipe of labels; `on` is its beginning, which depends on the input. The seed is included for detectors
    /// that use it.
    pub fn labels(&self, mut on: Recipe, seed: u64) -> Recipe {
        on.ingredients.extend_from_slice(&self.ingredients);
        if self.uses_seed { on.with("seed", seed) } else { on }
    }

    /// Address of the recipe that [`labels`](Self::labels) would make, without making it.
    pub fn address(&self, on: &Recipe, seed: u64) -> Address {
        let seed = self.uses_seed.then(|| ("seed".to_string(), seed.to_string()));
        on.address_with(self.ingredients.iter().chain(&seed))
    }
}

/// Version of the stored form of detector outputs.
/// - 2: with changes.
/// - 3: with the tracker's condition.
const OUTPUT_FORM: u32 = 3;

/// Beginning of a recipe, shared by all labels on one input.
pub fn labels_on(read: Read) -> Recipe {
    Recipe::new(Stage::Labels).with(read.0, read.1).with("overlap", OVERLAP).with("form", OUTPUT_FORM)
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackfail_methods::detector::DETECTORS;
    use trackfail_methods::score::Metric;

    fn fixed(kind: &str) -> FixedDetector {
        let entry = trackfail_core::plugin::find(DETECTORS, kind).unwrap();
        FixedDetector::new(entry, entry.build_from_text(entry.example).unwrap())
    }

    #[test]
    fn the_seed_is_part_of_the_address_for_detectors_that_use_it() {
        let read = ("track", Address([7; 32]));
        for (kind, counts) in [("random", true), ("level", false)] {
            let example = fixed(kind);
            let training = Training {
                key: "below".to_string(),
                role: "train".to_string(),
                maximise: Metric::F_SCORE,
                candidates: Candidates::Listed(Vec::new()),
            };
            let trained = DetectorChoice { example: example.clone(), training: Some(training) };
            let given = DetectorChoice { example, training: None };
            for key in [DetectorKey::new(&given, None), DetectorKey::new(&trained, Some(Address([9; 32])))] {
                let [one, two] = [1, 2].map(|seed| key.labels(labels_on(read), seed).address());
                assert_eq!(one != two, counts, "{kind}");
                assert_eq!(key.address(&labels_on(read), 1), one, "{kind}");
            }
        }
    }
}
