//! Keys of an experiment file, as serde reads them and as the JSON Schema describes them.

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

/// Metrics that training can maximize.
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
    /// Path-like name, e.g. `khalid2016/table1`, which is also the folder of the results.
    #[schemars(extend("pattern" = "^[a-z0-9_-]{1,64}(/[a-z0-9_-]{1,64})*$"))]
    pub name: String,
    /// Title for people.
    pub title: String,
    /// Key of the paper that the experiment replicates.
    pub paper: Option<String>,
    /// The paper's object, e.g. `Table 1`.
    pub object: Option<String>,
    /// Warning to readers about what they could misjudge.
    pub note: Option<String>,
    /// True if the methods stand on the leaderboard, with all trackers pooled.
    #[serde(default)]
    pub leaderboard: bool,
    /// Name of an experiment, e.g. `benchmark/otb`, whose results stand beside the own ones in tables and figures.
    #[schemars(extend("pattern" = "^[a-z0-9_-]{1,64}(/[a-z0-9_-]{1,64})*$"))]
    pub beside: Option<String>,
    /// How labels are scored, e.g. `khalid2016/1`; may be left out where there is no method.
    #[schemars(extend("enum" = words(PROTOCOLS, |protocol| protocol.name)))]
    pub protocol: Option<String>,
    /// Seed from which all other seeds are derived.
    #[serde(default)]
    pub seed: u64,
    /// Unit of sequences that are left out together when training on `others`.
    #[serde(default)]
    pub folds: FoldsBy,
    /// Suite by role; `test` is required.
    #[schemars(extend("maxProperties" = MAX_ROLES))]
    pub suites: BTreeMap<String, String>,
    /// Trackers.
    #[schemars(extend("maxItems" = MAX_ITEMS))]
    pub tracker: Vec<Tracker>,
    /// Methods; may be left out if there is an analysis.
    #[serde(default)]
    #[schemars(extend("maxItems" = MAX_ITEMS))]
    pub method: Vec<Method>,
    /// Analyses of signals or of the regions of trackers.
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
    /// Numbers printed in the paper.
    #[serde(default)]
    #[schemars(extend("maxItems" = 4096))]
    pub published: Vec<Published>,
    /// Claims of the paper, each checked against our results.
    #[serde(default)]
    #[schemars(extend("maxItems" = 1024))]
    pub claim: Vec<Claim>,
}

/// One `[[tracker]]`. Keys other than these are parameters of the tracker.
#[derive(Deserialize, JsonSchema)]
pub struct Tracker {
    /// Kind of tracker, e.g. `kcf`.
    #[schemars(extend("enum" = words(TRACKERS, |entry| entry.kind)))]
    pub name: String,
    /// Name in tables; by default the kind.
    pub label: Option<String>,
    /// Family of trackers over which measures are pooled, beside those of all trackers, e.g. `deep`.
    pub family: Option<String>,
    /// Repetitions, at least 1.
    #[schemars(extend("minimum" = 1, "maximum" = MAX_RUNS))]
    pub runs: Option<u32>,
    /// Repetitions on suites that models are learned from; by default as many as `runs`.
    #[schemars(extend("minimum" = 1, "maximum" = MAX_RUNS))]
    pub training_runs: Option<u32>,
    /// Label of another tracker, of which this is a second reading: the same tracker with other choices where
    /// its description is ambiguous. The published numbers of the other one stand beside those of this one,
    /// too.
    pub like: Option<String>,
    /// Run protocol: `one-pass` (the default), `vot-reset`, `otb-temporal` ...
    #[schemars(extend("enum" = words(&RunProtocol::ALL, |protocol| protocol.name())))]
    pub protocol: Option<String>,
    /// Sources of videos on which the tracker runs, e.g. `otb`; by default all.
    #[schemars(extend("minItems" = 1))]
    pub sources: Option<Vec<String>>,
    /// Tracks that are known to be absent, with the reason. Only for trackers that replay results. Any other
    /// absent track is a failure.
    pub absent: Option<Vec<Absence>>,
    /// Parameters of the kind of tracker.
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
    /// Name in tables. A published method needs no other key.
    pub name: String,
    /// Name of another method of the file, or of a published one, of which this is a second reading. Signal,
    /// detector and grid are taken from the other one; `signal` and `detector` without a `kind` change single
    /// parameters. The published numbers of the other one stand beside those of this one, too.
    pub like: Option<String>,
    /// `{ kind = "...", parameters }`, or a list of these for detectors that read several signals; left out
    /// for anchors.
    #[schemars(extend("anyOf" = [of("Signal"), signals()[1], of("Change")]))]
    pub signal: Option<Value>,
    /// `{ kind = "...", parameters }`; one parameter may be `{ train = ROLE, maximise = METRIC, grid = ... }`.
    #[schemars(extend("anyOf" = [of("Detector"), of("Change")]))]
    pub detector: Option<Value>,
    /// Lists of values by parameter; each combination is a method of its own.
    #[schemars(extend(
        "additionalProperties" = { "type": "array", "items": { "type": "number" }, "minItems": 1 },
    ))]
    pub grid: Option<BTreeMap<String, Vec<Number>>>,
    /// Labels of the trackers on which the method is run; by default all.
    #[schemars(extend("minItems" = 1))]
    pub trackers: Option<Vec<String>>,
    /// Protocol that scores the labels; by default that of the experiment.
    #[schemars(extend("enum" = words(PROTOCOLS, |protocol| protocol.name)))]
    pub protocol: Option<String>,
}

/// A parameter that is chosen on a suite: `{ train = "train", maximise = "f_score", grid = {...} }`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Train {
    /// Role of the suite for training, or `others`: train for each sequence and tracker of the test suite on
    /// the other sequences and the other trackers.
    pub train: String,
    /// Pooled metric that is maximized; ties go to the first value.
    #[schemars(extend("enum" = best_metrics()))]
    pub maximise: String,
    /// Candidate values: `{ from = 0.0, to = 1.0, step = 0.1 }`, `{ values = [0.1, 1.0, 10.0] }` or `{
    /// quantiles = 400 }`.
    pub grid: Grid,
}

/// Candidate values: equally spaced with both ends, a list, or quantiles of the signal on the training suite.
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
    /// Distance between neighboring values, above 0.
    pub step: Option<f64>,
    /// Values, ascending.
    pub values: Option<Vec<f64>>,
    /// Number of quantiles of the signal on the training suite, from the smallest to the largest value.
    pub quantiles: Option<usize>,
}

/// One `[[analysis]]`: a computation on all tracks of one or more suites.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Analysis {
    /// Name in the experiment.
    pub name: String,
    /// `{ kind = "...", parameters }` of the signal; left out for an analysis of the trackers' regions.
    #[schemars(extend("$ref" = "#/$defs/Signal"))]
    pub signal: Option<Value>,
    /// `{ kind = "...", parameters }` of the computation.
    #[schemars(extend("$ref" = "#/$defs/Compute"))]
    pub compute: Value,
    /// Roles of the suites, in the order that the analysis expects.
    #[schemars(extend("maxItems" = MAX_ROLES))]
    pub suites: Vec<String>,
    /// Labels of the trackers whose tracks are analyzed; by default all.
    #[schemars(extend("minItems" = 1))]
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
    /// Rows: metrics, one grid axis, or `attribute`.
    #[schemars(extend("maxItems" = MAX_PARTS))]
    pub rows: Option<Vec<String>>,
    /// Columns: `method`, `tracker`, `attribute` or a grid axis.
    pub columns: Option<String>,
    /// Table of an analysis, as `ANALYSIS.TABLE`; replaces rows and columns.
    pub shows: Option<String>,
    /// With `shows`: the only column to show, with one column for each tracker.
    pub column: Option<String>,
    /// Metric by which methods are ranked, with the certainty of each rank; replaces rows and columns.
    #[schemars(extend("enum" = metrics()))]
    pub rank: Option<String>,
    /// Metric of all cells if neither rows nor columns are metrics.
    #[schemars(extend("enum" = metrics()))]
    pub metric: Option<String>,
    /// Methods to show; by default all.
    #[schemars(extend("maxItems" = MAX_ITEMS))]
    pub methods: Option<Vec<String>>,
    /// Name of another table whose published numbers stand beside ours in this one, too.
    pub published: Option<String>,
    /// Parts of the table that LaTeX shows.
    pub latex: Option<Latex>,
}

/// Parts of a table that LaTeX shows.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Latex {
    /// Names of the columns in this order; by default all but anchors.
    pub columns: Option<Vec<String>>,
    /// `column` (3.3 in) or `text` (7 in); by default the natural width of the table.
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
    /// Kind of figure.
    #[schemars(extend("enum" = words(FIGURE_KINDS, |kind| kind.word), "description" = kinds_of_figures()))]
    pub kind: String,
    /// Text below the figure.
    pub caption: Option<String>,
    /// `text` (7 inches, as wide as a page of text; the default) or `column` (3.3 inches, one of two columns).
    #[schemars(extend("enum" = Width::ALL.map(Width::word)))]
    pub width: Option<String>,
    /// strips: label of the tracker; by default the first one.
    pub tracker: Option<String>,
    /// strips: sequences, side by side; by default the one with most events.
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
    /// strips: number of video frames above the panels, at most 12.
    pub stills: Option<usize>,
    /// chart: the chart to show, as `ANALYSIS.CHART`; radar: the table, as `ANALYSIS.TABLE`.
    pub shows: Option<String>,
    /// radar: column of that table.
    pub column: Option<String>,
    /// sweep, curve: metric on the y axis.
    #[schemars(extend("enum" = metrics()))]
    pub metric: Option<String>,
    /// sweep: grid axis along x; curve: metric along x.
    pub x: Option<String>,
    /// sweep, curve, delay: methods to show; by default all.
    #[schemars(extend("maxItems" = MAX_ITEMS))]
    pub methods: Option<Vec<String>>,
}

/// One `[[published]]`: printed values of one row of one table.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Published {
    /// Name of the table.
    pub table: String,
    /// Tracker that the paper used.
    pub tracker: String,
    /// Name of the row.
    pub row: String,
    /// Printed texts by column.
    #[schemars(extend("maxProperties" = MAX_DETECTORS))]
    pub values: BTreeMap<String, String>,
}

/// One `[[claim]]`: a conclusion of the paper that is checked.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    /// The conclusion in words.
    pub text: String,
    /// The predicate, e.g. `recall[DTEF] >= recall[RAW]`.
    pub holds: String,
    /// True if a run must meet the claim (exit code 5 otherwise).
    #[serde(default)]
    pub required: bool,
}

/// Keys that shorten an experiment file: differences from another experiment, and groups of trackers or
/// methods.
#[derive(JsonSchema)]
pub struct Shortcuts {
    /// Experiment to extend: a built-in name, or a file beside this one whose name ends in `.toml`.
    pub extends: Option<String>,
    /// Items of the extended experiment that this one leaves out, by kind.
    pub without: Option<Without>,
    /// Groups of trackers that share keys.
    #[schemars(rename = "tracker-group")]
    pub tracker_group: Option<Vec<TrackerGroup>>,
    /// Groups of methods that share keys.
    #[schemars(rename = "method-group")]
    pub method_group: Option<Vec<MethodGroup>>,
}

/// Items of the extended experiment that are left out: `table = ["counts"]`.
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

/// One `[[tracker-group]]`. All other keys are shared by its trackers.
#[derive(JsonSchema)]
pub struct TrackerGroup {
    /// Name that stands for all trackers of the group in lists of trackers.
    pub group: Option<String>,
    /// Kinds of trackers, or tables with the keys of a `[[tracker]]`.
    #[schemars(extend("minItems" = 1, "items" = { "anyOf": [{ "type": "string" }, of("TrackerMember")] }))]
    pub trackers: Vec<Value>,
}

/// One `[[method-group]]`. All other keys are shared by its methods.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct MethodGroup {
    /// Name that stands for all methods of the group in lists of methods.
    pub group: Option<String>,
    /// Names of methods, or tables with the keys of a `[[method]]`.
    #[schemars(extend("minItems" = 1, "items" = { "anyOf": [{ "type": "string" }, of("Method")] }))]
    pub methods: Vec<Value>,
}
