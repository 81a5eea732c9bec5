//! The keys of an experiment file, as serde reads them and as the JSON Schema describes them.

use super::FoldsBy;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
use toml::Spanned;

/// An experiment file.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Experiment {
    /// Version of this format: 1.
    #[schemars(with = "u32")]
    pub schema: Spanned<u32>,
    /// Path-like name, e.g. `khalid2016/table1`: the folder of its results.
    #[schemars(with = "String")]
    pub name: Spanned<String>,
    /// Title for people.
    pub title: String,
    /// Key of the paper it replicates.
    pub paper: Option<String>,
    /// The paper's object, e.g. `Table 1`.
    pub object: Option<String>,
    /// Warning to the reader, without which the numbers would be misjudged.
    pub note: Option<String>,
    /// Whether its methods stand on the leaderboard, with all trackers pooled.
    #[serde(default)]
    pub leaderboard: bool,
    /// How labels are scored, e.g. `khalid2016/1`; may be left out where there is no method.
    #[schemars(with = "Option<String>")]
    pub protocol: Option<Spanned<String>>,
    /// Base of all seeds.
    #[serde(default)]
    pub seed: u64,
    /// What is left out together where a parameter or model is made on `others`.
    #[serde(default)]
    pub folds: FoldsBy,
    /// Role -> suite; `test` is required.
    #[schemars(with = "BTreeMap<String, String>")]
    pub suites: Spanned<BTreeMap<String, Spanned<String>>>,
    /// Trackers.
    #[schemars(with = "Vec<Tracker>")]
    pub tracker: Spanned<Vec<Tracker>>,
    /// Methods; may be left out where there is an analysis.
    #[serde(default = "none")]
    #[schemars(with = "Vec<Method>")]
    pub method: Spanned<Vec<Method>>,
    /// Analyses of signals.
    #[serde(default)]
    pub analysis: Vec<Analysis>,
    /// Tables.
    #[serde(default)]
    pub table: Vec<Table>,
    /// Figures.
    #[serde(default)]
    pub figure: Vec<Figure>,
    /// Numbers that the paper prints.
    #[serde(default)]
    pub published: Vec<Published>,
    /// Conclusions as predicates over our numbers.
    #[serde(default)]
    pub claim: Vec<Claim>,
}

/// One `[[tracker]]`; keys other than these are the tracker's parameters, checked by its plugin.
#[derive(Deserialize, JsonSchema)]
pub struct Tracker {
    /// Kind of tracker.
    #[schemars(with = "String")]
    pub name: Spanned<String>,
    /// Name in tables; the kind if left out.
    #[schemars(with = "Option<String>")]
    pub label: Option<Spanned<String>>,
    /// Family in which its measures are pooled beside those of all trackers, e.g. `deep`.
    #[schemars(with = "Option<String>")]
    pub family: Option<Spanned<String>>,
    /// Repetitions, at least 1.
    #[schemars(with = "Option<u32>")]
    pub runs: Option<Spanned<u32>>,
    /// Repetitions on suites that models are learned from; as many as `runs` if left out.
    #[schemars(with = "Option<u32>")]
    pub training_runs: Option<Spanned<u32>>,
    /// Label of another tracker of which this is a reading: the same one with other choices where its description leaves
    /// them open. That one's published numbers stand beside this one's too.
    #[schemars(with = "Option<String>")]
    pub like: Option<Spanned<String>>,
    /// Run protocol: `one-pass` (if left out), `vot-reset`, `otb-temporal` ...
    #[schemars(with = "Option<String>")]
    pub protocol: Option<Spanned<String>>,
    /// Sources of videos, e.g. `otb`, on which it runs; all if left out.
    #[schemars(with = "Option<Vec<String>>")]
    pub sources: Option<Vec<Spanned<String>>>,
    /// Tracks that are known not to be there, with the reason; of results that are replayed. Any other track that is not there
    /// is a failure.
    pub absent: Option<Vec<Absence>>,
}

/// A track that is known not to be there: `{ sequence = "Board", reason = "the file lacks a line" }`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Absence {
    /// Name of the sequence.
    #[schemars(with = "String")]
    pub sequence: Spanned<String>,
    /// Why there is no track.
    #[schemars(with = "String")]
    pub reason: Spanned<String>,
}

/// One `[[method]]`: a signal and a detector under a name.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Method {
    /// Name in tables. A method of the papers needs nothing else.
    #[schemars(with = "String")]
    pub name: Spanned<String>,
    /// Name of another method of the file, or of a published one, of which this is a reading: signal, detector and grid are
    /// that one's, keys of `signal` and `detector` without a `kind` change single parameters, and its published numbers stand
    /// beside this one's too.
    #[schemars(with = "Option<String>")]
    pub like: Option<Spanned<String>>,
    /// `{ kind = "...", parameters }`, or a list of them for detectors that read several; left out for anchors.
    #[schemars(with = "Option<BTreeMap<String, serde_json::Value>>")]
    pub signal: Option<toml::Value>,
    /// `{ kind = "...", parameters }`; one parameter may be `{ train = ROLE, maximise = METRIC, grid = ... }`.
    #[schemars(with = "Option<BTreeMap<String, serde_json::Value>>")]
    pub detector: Option<toml::Table>,
    /// Parameter -> list of values; every combination is a method of its own.
    #[schemars(with = "Option<BTreeMap<String, serde_json::Value>>")]
    pub grid: Option<toml::Table>,
    /// Labels of the trackers it is run on; all if left out.
    #[schemars(with = "Option<Vec<String>>")]
    pub trackers: Option<Vec<Spanned<String>>>,
    /// How its labels are scored; as the experiment says if left out.
    #[schemars(with = "Option<String>")]
    pub protocol: Option<Spanned<String>>,
}

/// A parameter that is chosen on a suite: `{ train = "train", maximise = "f_score", grid = {...} }`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Train {
    /// Role of the suite it is chosen on, or `others`: for each sequence and tracker of the test suite on the other
    /// sequences and the other trackers.
    #[schemars(with = "String")]
    pub train: Spanned<String>,
    /// The pooled metric that is maximized; ties go to the first value.
    #[schemars(with = "String")]
    pub maximise: Spanned<String>,
    /// The values tried: `{ from = 0.0, to = 1.0, step = 0.1 }`, `{ values = [0.1, 1.0, 10.0] }` or
    /// `{ quantiles = 400 }`.
    #[schemars(with = "Grid")]
    pub grid: Spanned<Grid>,
}

/// Values to try: equally spaced, ends included, a list, or quantiles of the signal on the training suite.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Grid {
    /// First value.
    pub from: Option<f64>,
    /// Last value.
    pub to: Option<f64>,
    /// Distance, above 0.
    pub step: Option<f64>,
    /// Values, ascending.
    pub values: Option<Vec<f64>>,
    /// Number of quantiles of the signal's values on the training suite, the smallest and largest value included.
    pub quantiles: Option<usize>,
}

fn none() -> Spanned<Vec<Method>> {
    Spanned::new(0..0, Vec::new())
}

/// One `[[analysis]]`: what is computed from a signal on all tracks of one or more suites.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Analysis {
    /// Name in the experiment.
    #[schemars(with = "String")]
    pub name: Spanned<String>,
    /// `{ kind = "...", parameters }` of the signal; left out for an analysis of the trackers' regions.
    #[schemars(with = "Option<BTreeMap<String, serde_json::Value>>")]
    pub signal: Option<toml::Table>,
    /// `{ kind = "...", parameters }` of what is computed.
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub compute: toml::Table,
    /// Roles of the suites, in the order in which the analysis takes them.
    #[schemars(with = "Vec<String>")]
    pub suites: Spanned<Vec<String>>,
    /// Labels of the trackers whose tracks are analyzed; all if left out.
    #[schemars(with = "Option<Vec<String>>")]
    pub trackers: Option<Vec<Spanned<String>>>,
}

/// One `[[table]]`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// File name of the table.
    #[schemars(with = "String")]
    pub name: Spanned<String>,
    /// Text above the table.
    pub caption: Option<String>,
    /// Metrics, one grid axis, or `attribute`.
    #[schemars(with = "Option<Vec<String>>")]
    pub rows: Option<Spanned<Vec<Spanned<String>>>>,
    /// `method`, `tracker`, `attribute` or a grid axis.
    #[schemars(with = "Option<String>")]
    pub columns: Option<Spanned<String>>,
    /// Instead of rows and columns: a table that an analysis makes, as `ANALYSIS.TABLE`.
    #[schemars(with = "Option<String>")]
    pub shows: Option<Spanned<String>>,
    /// With `shows`: only this column of it, with a column for each tracker.
    #[schemars(with = "Option<String>")]
    pub column: Option<Spanned<String>>,
    /// Instead of rows and columns: the methods in order of this metric, with how sure their ranks are.
    #[schemars(with = "Option<String>")]
    pub rank: Option<Spanned<String>>,
    /// The metric shown when neither rows nor columns are metrics.
    #[schemars(with = "Option<String>")]
    pub metric: Option<Spanned<String>>,
    /// The methods shown; all if left out.
    #[schemars(with = "Option<Vec<String>>")]
    pub methods: Option<Vec<Spanned<String>>>,
    /// Another table, whose published numbers stand beside ours in this one too.
    #[schemars(with = "Option<String>")]
    pub published: Option<Spanned<String>>,
    /// The parts of the table that LaTeX shows.
    pub latex: Option<Latex>,
}

/// The parts of a table that LaTeX shows.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Latex {
    /// Names of the columns, in this order; all but anchors if left out.
    #[schemars(with = "Option<Vec<String>>")]
    pub columns: Option<Vec<Spanned<String>>>,
    /// `column` (3.3 in) or `text` (7 in); as the table needs it if left out.
    #[schemars(with = "Option<String>")]
    pub width: Option<Spanned<String>>,
}

/// One `[[figure]]`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Figure {
    /// File name of the figure.
    #[schemars(with = "String")]
    pub name: Spanned<String>,
    /// One of the kinds of figures.
    #[schemars(with = "String")]
    pub kind: Spanned<String>,
    /// Text below the figure.
    pub caption: Option<String>,
    /// `text` (7 inches, as wide as a page of text; the default) or `column` (3.3 inches, one of two columns).
    #[schemars(with = "Option<String>")]
    pub width: Option<Spanned<String>>,
    /// strips: label of the tracker; the first one if left out.
    #[schemars(with = "Option<String>")]
    pub tracker: Option<Spanned<String>>,
    /// strips: sequences, side by side; if left out, the one with most events.
    #[serde(default)]
    #[schemars(with = "Vec<String>")]
    pub sequences: Vec<Spanned<String>>,
    /// strips: rows of panels: `error`, `signal:M`, `forecast:M`, `score:M`, `score:M+M2`, `labels:M+M2` or
    /// `condition:M+M2`.
    #[serde(default)]
    #[schemars(with = "Vec<Vec<String>>")]
    pub panels: Vec<Vec<Spanned<String>>>,
    /// strips: how many video frames to show above the panels, at most 12.
    #[schemars(with = "Option<usize>")]
    pub stills: Option<Spanned<usize>>,
    /// chart: what it shows, as `ANALYSIS.CHART`; radar: as `ANALYSIS.TABLE`.
    #[schemars(with = "Option<String>")]
    pub shows: Option<Spanned<String>>,
    /// radar: the column of that table.
    #[schemars(with = "Option<String>")]
    pub column: Option<Spanned<String>>,
    /// sweep, curve: metric on the y axis.
    #[schemars(with = "Option<String>")]
    pub metric: Option<Spanned<String>>,
    /// sweep: grid axis along x; curve: metric along x.
    #[schemars(with = "Option<String>")]
    pub x: Option<Spanned<String>>,
    /// sweep, curve, delay: the methods shown; all if left out.
    #[schemars(with = "Option<Vec<String>>")]
    pub methods: Option<Vec<Spanned<String>>>,
}

/// One `[[published]]`: printed values of one row of one table.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Published {
    /// Name of the table.
    #[schemars(with = "String")]
    pub table: Spanned<String>,
    /// The tracker the paper used.
    #[schemars(with = "String")]
    pub tracker: Spanned<String>,
    /// Row.
    #[schemars(with = "String")]
    pub row: Spanned<String>,
    /// Column -> text as printed.
    #[schemars(with = "BTreeMap<String, String>")]
    pub values: BTreeMap<String, Spanned<String>>,
}

/// One `[[claim]]`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    /// The conclusion in words.
    pub text: String,
    /// The predicate, e.g. `recall[DTEF] >= recall[RAW]`.
    #[schemars(with = "String")]
    pub holds: Spanned<String>,
    /// Whether a run must meet it (exit code 5 otherwise).
    #[serde(default)]
    pub required: bool,
}

/// Keys of an experiment file that it may have beside those of [`Experiment`], to say only what differs from another
/// one or to give several trackers or methods at once.
#[derive(JsonSchema)]
pub struct Shortcuts {
    /// The experiment that this one changes: a built-in name, or a file beside this one whose name ends in `.toml`.
    pub extends: Option<String>,
    /// Names of items of the base that this experiment does not have, by kind.
    pub without: Option<Without>,
    /// Trackers that share keys.
    #[schemars(rename = "tracker-group")]
    pub tracker_group: Option<Vec<TrackerGroup>>,
    /// Methods that share keys.
    #[schemars(rename = "method-group")]
    pub method_group: Option<Vec<MethodGroup>>,
}

/// Names of items of the base that an experiment does not have: `table = ["counts"]`.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Without {
    /// Labels of trackers, or names of groups.
    pub tracker: Option<Vec<String>>,
    /// Names of methods, or of groups.
    pub method: Option<Vec<String>>,
    /// Names of analyses.
    pub analysis: Option<Vec<String>>,
    /// Names of tables.
    pub table: Option<Vec<String>>,
    /// Names of figures.
    pub figure: Option<Vec<String>>,
    /// Names of tables whose published numbers are left out.
    pub published: Option<Vec<String>>,
    /// Texts of claims.
    pub claim: Option<Vec<String>>,
}

/// One `[[tracker-group]]`; all other keys are shared by the trackers.
#[derive(JsonSchema)]
pub struct TrackerGroup {
    /// Name that stands for all trackers of the group in lists of trackers.
    pub group: Option<String>,
    /// Kinds of trackers, or tables with the keys of a `[[tracker]]`.
    pub trackers: Vec<serde_json::Value>,
}

/// One `[[method-group]]`; all other keys are shared by the methods.
#[derive(JsonSchema)]
pub struct MethodGroup {
    /// Name that stands for all methods of the group in lists of methods.
    pub group: Option<String>,
    /// Names of methods, or tables with the keys of a `[[method]]`.
    pub methods: Vec<serde_json::Value>,
}
