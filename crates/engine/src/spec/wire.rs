//! The keys of an experiment file, as serde reads them and as the JSON Schema describes them.

use super::figure::FIGURE_KINDS;
use super::limits::{MAX_DETECTORS, MAX_ITEMS, MAX_PARTS, MAX_ROLES};
use super::method::can_be_maximised;
use super::read::{MAX_RUNS, SCHEMA};
use super::schema::{of, signals, unread_keys};
use super::width::Width;
use super::{Absence, FoldsBy};
use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Map, Number, Value};
use std::collections::BTreeMap;
use trackfail_methods::score::{Metric, PROTOCOLS};
use trackfail_methods::tracker::TRACKERS;
use trackfail_methods::tracker::protocol::RunProtocol;

/// Words of a closed list.
fn words<T>(list: &'static [T], word: fn(&'static T) -> &'static str) -> Vec<&'static str> {
    list.iter().map(word).collect()
}

fn protocols() -> Vec<&'static str> {
    words(PROTOCOLS, |protocol| protocol.name)
}

/// Metrics that training can look for the largest value of.
fn best_metrics() -> Vec<&'static str> {
    Metric::names().filter(|n| Metric::from_name(n).as_ref().is_some_and(can_be_maximised)).collect()
}

fn kinds_of_figures() -> String {
    let kinds = FIGURE_KINDS.iter().map(|kind| format!("`{}` ({})", kind.word, kind.summary));
    kinds.collect::<Vec<_>>().join("; ") + "."
}

fn metrics() -> Vec<&'static str> {
    Metric::names().collect()
}

/// An experiment file.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Experiment {
    /// Version of this format.
    #[schemars(with = "Value", extend("const" = SCHEMA))]
    pub schema: u32,
    /// Path-like name, e.g. `khalid2016/table1`: the folder of its results.
    #[schemars(extend("pattern" = "^[a-z0-9_-]{1,64}(/[a-z0-9_-]{1,64})*$"))]
    pub name: String,
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
    #[schemars(extend("enum" = protocols()))]
    pub protocol: Option<String>,
    /// Base of all seeds.
    #[serde(default)]
    pub seed: u64,
    /// What is left out together where a parameter or model is made on `others`.
    #[serde(default)]
    pub folds: FoldsBy,
    /// Role -> suite; `test` is required.
    #[schemars(extend("maxProperties" = MAX_ROLES))]
    pub suites: BTreeMap<String, String>,
    /// Trackers.
    #[schemars(extend("maxItems" = MAX_ITEMS))]
    pub tracker: Vec<Tracker>,
    /// Methods; may be left out where there is an analysis.
    #[serde(default)]
    #[schemars(extend("maxItems" = MAX_ITEMS))]
    pub method: Vec<Method>,
    /// Analyses of signals.
    #[serde(default)]
    #[schemars(extend("maxItems" = MAX_ITEMS))]
    pub analysis: Vec<Analysis>,
    /// Tables.
    #[serde(default)]
    #[schemars(extend("maxItems" = MAX_ITEMS))]
    pub table: Vec<Table>,
    /// Figures.
    #[serde(default)]
    #[schemars(extend("maxItems" = MAX_ITEMS))]
    pub figure: Vec<Figure>,
    /// Numbers that the paper prints.
    #[serde(default)]
    #[schemars(extend("maxItems" = 4096))]
    pub published: Vec<Published>,
    /// Conclusions as predicates over our numbers.
    #[serde(default)]
    #[schemars(extend("maxItems" = 1024))]
    pub claim: Vec<Claim>,
}

/// One `[[tracker]]`; keys other than these are the tracker's parameters, checked by its plugin.
#[derive(Deserialize, JsonSchema)]
pub struct Tracker {
    /// Kind of tracker.
    #[schemars(extend("enum" = words(TRACKERS, |entry| entry.kind)))]
    pub name: String,
    /// Name in tables; the kind if left out.
    pub label: Option<String>,
    /// Family in which its measures are pooled beside those of all trackers, e.g. `deep`.
    pub family: Option<String>,
    /// Repetitions, at least 1.
    #[schemars(extend("minimum" = 1, "maximum" = MAX_RUNS))]
    pub runs: Option<u32>,
    /// Repetitions on suites that models are learned from; as many as `runs` if left out.
    #[schemars(extend("minimum" = 1, "maximum" = MAX_RUNS))]
    pub training_runs: Option<u32>,
    /// Label of another tracker of which this is a reading: the same one with other choices where its description leaves
    /// them open. That one's published numbers stand beside this one's too.
    pub like: Option<String>,
    /// Run protocol: `one-pass` (if left out), `vot-reset`, `otb-temporal` ...
    #[schemars(extend("enum" = words(&RunProtocol::ALL, |protocol| protocol.name())))]
    pub protocol: Option<String>,
    /// Sources of videos, e.g. `otb`, on which it runs; all if left out.
    pub sources: Option<Vec<String>>,
    /// Tracks that are known not to be there, with the reason; of results that are replayed. Any other track that is not there
    /// is a failure.
    pub absent: Option<Vec<Absence>>,
    /// The parameters of its kind.
    #[serde(flatten)]
    #[schemars(skip)]
    pub params: Map<String, Value>,
}

/// One `[[method]]`: a signal and a detector under a name.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
// Only what is like another method can leave `kind` to that one.
#[schemars(extend(
    "if" = { "not": { "required": ["like"] } },
    "then" = { "properties": { "signal": { "anyOf": signals() }, "detector": of("Detector") } },
))]
pub struct Method {
    /// Name in tables. A method of the papers needs nothing else.
    pub name: String,
    /// Name of another method of the file, or of a published one, of which this is a reading: signal, detector and grid are
    /// that one's, keys of `signal` and `detector` without a `kind` change single parameters, and its published numbers stand
    /// beside this one's too.
    pub like: Option<String>,
    /// `{ kind = "...", parameters }`, or a list of them for detectors that read several; left out for anchors.
    #[schemars(extend("anyOf" = [of("Signal"), signals()[1], of("Change")]))]
    pub signal: Option<Value>,
    /// `{ kind = "...", parameters }`; one parameter may be `{ train = ROLE, maximise = METRIC, grid = ... }`.
    #[schemars(extend("anyOf" = [of("Detector"), of("Change")]))]
    pub detector: Option<Value>,
    /// Parameter -> list of values; every combination is a method of its own.
    #[schemars(extend(
        "additionalProperties" = { "type": "array", "items": { "type": "number" }, "minItems": 1 },
    ))]
    pub grid: Option<BTreeMap<String, Vec<Number>>>,
    /// Labels of the trackers it is run on; all if left out.
    pub trackers: Option<Vec<String>>,
    /// How its labels are scored; as the experiment says if left out.
    #[schemars(extend("enum" = protocols()))]
    pub protocol: Option<String>,
}

/// A parameter that is chosen on a suite: `{ train = "train", maximise = "f_score", grid = {...} }`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Train {
    /// Role of the suite it is chosen on, or `others`: for each sequence and tracker of the test suite on the other
    /// sequences and the other trackers.
    pub train: String,
    /// The pooled metric that is maximized; ties go to the first value.
    #[schemars(extend("enum" = best_metrics()))]
    pub maximise: String,
    /// The values tried: `{ from = 0.0, to = 1.0, step = 0.1 }`, `{ values = [0.1, 1.0, 10.0] }` or
    /// `{ quantiles = 400 }`.
    pub grid: Grid,
}

/// Values to try: equally spaced, ends included, a list, or quantiles of the signal on the training suite.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [
    { "required": ["from", "to", "step"], "properties": { "values": false, "quantiles": false } },
    { "required": ["values"], "properties": { "from": false, "to": false, "step": false, "quantiles": false } },
    { "required": ["quantiles"], "properties": { "from": false, "to": false, "step": false, "values": false } },
]))]
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

/// One `[[analysis]]`: what is computed from a signal on all tracks of one or more suites.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Analysis {
    /// Name in the experiment.
    pub name: String,
    /// `{ kind = "...", parameters }` of the signal; left out for an analysis of the trackers' regions.
    #[schemars(extend("$ref" = "#/$defs/Signal"))]
    pub signal: Option<Value>,
    /// `{ kind = "...", parameters }` of what is computed.
    #[schemars(extend("$ref" = "#/$defs/Compute"))]
    pub compute: Value,
    /// Roles of the suites, in the order in which the analysis takes them.
    #[schemars(extend("maxItems" = MAX_ROLES))]
    pub suites: Vec<String>,
    /// Labels of the trackers whose tracks are analyzed; all if left out.
    pub trackers: Option<Vec<String>>,
}

/// One `[[table]]`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// File name of the table.
    pub name: String,
    /// Text above the table.
    pub caption: Option<String>,
    /// Metrics, one grid axis, or `attribute`.
    #[schemars(extend("maxItems" = MAX_PARTS))]
    pub rows: Option<Vec<String>>,
    /// `method`, `tracker`, `attribute` or a grid axis.
    pub columns: Option<String>,
    /// Instead of rows and columns: a table that an analysis makes, as `ANALYSIS.TABLE`.
    pub shows: Option<String>,
    /// With `shows`: only this column of it, with a column for each tracker.
    pub column: Option<String>,
    /// Instead of rows and columns: the methods in order of this metric, with how sure their ranks are.
    #[schemars(extend("enum" = metrics()))]
    pub rank: Option<String>,
    /// The metric shown when neither rows nor columns are metrics.
    #[schemars(extend("enum" = metrics()))]
    pub metric: Option<String>,
    /// The methods shown; all if left out.
    #[schemars(extend("maxItems" = MAX_ITEMS))]
    pub methods: Option<Vec<String>>,
    /// Another table, whose published numbers stand beside ours in this one too.
    pub published: Option<String>,
    /// The parts of the table that LaTeX shows.
    pub latex: Option<Latex>,
}

/// The parts of a table that LaTeX shows.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Latex {
    /// Names of the columns, in this order; all but anchors if left out.
    pub columns: Option<Vec<String>>,
    /// `column` (3.3 in) or `text` (7 in); as the table needs it if left out.
    #[schemars(extend("enum" = Width::ALL.map(Width::word)))]
    pub width: Option<String>,
}

/// One `[[figure]]`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("allOf" = unread_keys()))]
pub struct Figure {
    /// File name of the figure.
    pub name: String,
    /// One of the kinds of figures.
    #[schemars(extend("enum" = words(FIGURE_KINDS, |kind| kind.word), "description" = kinds_of_figures()))]
    pub kind: String,
    /// Text below the figure.
    pub caption: Option<String>,
    /// `text` (7 inches, as wide as a page of text; the default) or `column` (3.3 inches, one of two columns).
    #[schemars(extend("enum" = Width::ALL.map(Width::word)))]
    pub width: Option<String>,
    /// strips: label of the tracker; the first one if left out.
    pub tracker: Option<String>,
    /// strips: sequences, side by side; if left out, the one with most events.
    #[serde(default)]
    #[schemars(extend("maxItems" = MAX_PARTS))]
    pub sequences: Vec<String>,
    /// strips: rows of panels: `error`, `signal:M`, `forecast:M`, `score:M`, `score:M+M2`, `labels:M+M2` or
    /// `condition:M+M2`.
    #[serde(default)]
    #[schemars(extend(
        "maxItems" = MAX_PARTS,
        "items" = { "type": "array", "items": { "type": "string" }, "maxItems": MAX_PARTS },
    ))]
    pub panels: Vec<Vec<String>>,
    /// strips: how many video frames to show above the panels, at most 12.
    pub stills: Option<usize>,
    /// chart: what it shows, as `ANALYSIS.CHART`; radar: as `ANALYSIS.TABLE`.
    pub shows: Option<String>,
    /// radar: the column of that table.
    pub column: Option<String>,
    /// sweep, curve: metric on the y axis.
    #[schemars(extend("enum" = metrics()))]
    pub metric: Option<String>,
    /// sweep: grid axis along x; curve: metric along x.
    pub x: Option<String>,
    /// sweep, curve, delay: the methods shown; all if left out.
    #[schemars(extend("maxItems" = MAX_ITEMS))]
    pub methods: Option<Vec<String>>,
}

/// One `[[published]]`: printed values of one row of one table.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Published {
    /// Name of the table.
    pub table: String,
    /// The tracker the paper used.
    pub tracker: String,
    /// Row.
    pub row: String,
    /// Column -> text as printed.
    #[schemars(extend("maxProperties" = MAX_DETECTORS))]
    pub values: BTreeMap<String, String>,
}

/// One `[[claim]]`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    /// The conclusion in words.
    pub text: String,
    /// The predicate, e.g. `recall[DTEF] >= recall[RAW]`.
    pub holds: String,
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
    #[schemars(extend("minItems" = 1, "items" = { "anyOf": [{ "type": "string" }, of("TrackerMember")] }))]
    pub trackers: Vec<Value>,
}

/// One `[[method-group]]`; all other keys are shared by the methods.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct MethodGroup {
    /// Name that stands for all methods of the group in lists of methods.
    pub group: Option<String>,
    /// Names of methods, or tables with the keys of a `[[method]]`.
    #[schemars(extend("minItems" = 1, "items" = { "anyOf": [{ "type": "string" }, of("Method")] }))]
    pub methods: Vec<Value>,
}
