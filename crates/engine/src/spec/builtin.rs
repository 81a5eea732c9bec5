//! The experiments and published methods that come with the program.

use super::SpecError;
use super::document::array_of_tables;
use super::error::Source;
use super::limits::MAX_DETECTORS;
use super::method::{self, Method};
use crate::detector::DETECTORS;
use crate::plugin;
use crate::score::PROTOCOLS;
use crate::signal::Reads;
use serde::{Deserialize, Serialize};
use std::sync::LazyLock;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Name and text of every built-in experiment.
pub static EXPERIMENTS: &[(&str, &str)] = &[
    ("quickstart", include_str!("../../../../experiments/quickstart.toml")),
    ("benchmark/synthetic", include_str!("../../../../experiments/benchmark/synthetic.toml")),
    ("benchmark/otb", include_str!("../../../../experiments/benchmark/otb.toml")),
    ("benchmark/vot2014", include_str!("../../../../experiments/benchmark/vot2014.toml")),
    ("benchmark/fused", include_str!("../../../../experiments/benchmark/fused.toml")),
    ("benchmark/fused-models", include_str!("../../../../experiments/benchmark/fused-models.toml")),
    ("benchmark/fused-ablation", include_str!("../../../../experiments/benchmark/fused-ablation.toml")),
    ("benchmark/longterm", include_str!("../../../../experiments/benchmark/longterm.toml")),
    ("benchmark/cost", include_str!("../../../../experiments/benchmark/cost.toml")),
    ("benchmark/otb-boxes", include_str!("../../../../experiments/benchmark/otb-boxes.toml")),
    ("khalid2016/table1", include_str!("../../../../experiments/khalid2016/table1.toml")),
    ("khalid2016/table2", include_str!("../../../../experiments/khalid2016/table2.toml")),
    ("khalid2016/training", include_str!("../../../../experiments/khalid2016/training.toml")),
    ("khalid2016/figures", include_str!("../../../../experiments/khalid2016/figures.toml")),
    ("khalid2016/readings", include_str!("../../../../experiments/khalid2016/readings.toml")),
    ("sanmiguel2015/model", include_str!("../../../../experiments/sanmiguel2015/model.toml")),
    ("sanmiguel2015/convolution", include_str!("../../../../experiments/sanmiguel2015/convolution.toml")),
    ("sanmiguel2015/fig3", include_str!("../../../../experiments/sanmiguel2015/fig3.toml")),
    ("sanmiguel2015/fig13-d1", include_str!("../../../../experiments/sanmiguel2015/fig13-d1.toml")),
    ("sanmiguel2015/fig13-d2", include_str!("../../../../experiments/sanmiguel2015/fig13-d2.toml")),
    ("sanmiguel2015/fig14", include_str!("../../../../experiments/sanmiguel2015/fig14.toml")),
    (
        "sanmiguel2015/fig13-d1-unsigned",
        include_str!("../../../../experiments/sanmiguel2015/fig13-d1-unsigned.toml"),
    ),
    ("sanmiguel2015/start-up", include_str!("../../../../experiments/sanmiguel2015/start-up.toml")),
    ("sanmiguel2015/model-real", include_str!("../../../../experiments/sanmiguel2015/model-real.toml")),
    ("sanmiguel2015/readings", include_str!("../../../../experiments/sanmiguel2015/readings.toml")),
    (
        "sanmiguel2015/convolution-real",
        include_str!("../../../../experiments/sanmiguel2015/convolution-real.toml"),
    ),
    ("sanmiguel2015/fig13-real", include_str!("../../../../experiments/sanmiguel2015/fig13-real.toml")),
    ("sanmiguel2015/fig14-real", include_str!("../../../../experiments/sanmiguel2015/fig14-real.toml")),
    ("sanmiguel2015/table6", include_str!("../../../../experiments/sanmiguel2015/table6.toml")),
    ("sanmiguel2015/table6-d2", include_str!("../../../../experiments/sanmiguel2015/table6-d2.toml")),
    ("sanmiguel2015/table4", include_str!("../../../../experiments/sanmiguel2015/table4.toml")),
    ("sanmiguel2015/table4-d2", include_str!("../../../../experiments/sanmiguel2015/table4-d2.toml")),
    ("sanmiguel2015/table5", include_str!("../../../../experiments/sanmiguel2015/table5.toml")),
    ("sanmiguel2015/table7", include_str!("../../../../experiments/sanmiguel2015/table7.toml")),
    ("sanmiguel2015/table7-d2", include_str!("../../../../experiments/sanmiguel2015/table7-d2.toml")),
    ("sanmiguel2015/fig15", include_str!("../../../../experiments/sanmiguel2015/fig15.toml")),
    (
        "sanmiguel2015/built-in-model",
        include_str!("../../../../experiments/sanmiguel2015/built-in-model.toml"),
    ),
    ("khalid2016/thresholds", include_str!("../../../../experiments/khalid2016/thresholds.toml")),
    ("khalid2016/thresholds-real", include_str!("../../../../experiments/khalid2016/thresholds-real.toml")),
    ("sanmiguel2015/thresholds", include_str!("../../../../experiments/sanmiguel2015/thresholds.toml")),
    ("compare/otb", include_str!("../../../../experiments/compare/otb.toml")),
    ("compare/vot2014", include_str!("../../../../experiments/compare/vot2014.toml")),
];

/// The experiment that `trackfail run` runs when none is named.
pub const QUICKSTART: &str = "quickstart";

/// Name of the parameter of detectors that take a budget of false alarms.
const BUDGET: &str = "budget";

/// The papers' methods with their published thresholds, as an experiment file would write them.
const METHODS: &str = include_str!("methods.toml");

static METHOD_TABLES: LazyLock<Vec<(String, Spanned<DeTable<'static>>)>> = LazyLock::new(|| {
    let source = Source::new("methods.toml", METHODS);
    let document = DeTable::parse(METHODS).map_err(|e| source.toml(&e, 0..0));
    let tables = document.and_then(|d| array_of_tables(source, &d, "method")).unwrap_or_default();
    let name = |t: &Spanned<DeTable<'_>>| {
        t.get_ref().get("name").and_then(|n| n.get_ref().as_str()).unwrap_or_default().to_string()
    };
    tables.into_iter().map(|t| (name(&t), t)).collect()
});

/// Name and table of every published method.
pub(super) fn method_tables() -> &'static [(String, Spanned<DeTable<'static>>)] {
    &METHOD_TABLES
}

/// Names of the published methods.
pub fn method_names() -> Vec<&'static str> {
    METHOD_TABLES.iter().map(|(name, _)| name.as_str()).collect()
}

/// A published method by name, with its published threshold.
///
/// # Errors
/// When the file of published methods is wrong, which the tests exclude.
pub fn published_method(name: &str) -> Option<Result<Method, SpecError>> {
    let source = Source::new("methods.toml", METHODS);
    let (_, table) = METHOD_TABLES.iter().find(|(known, _)| known == name)?;
    Some(method::read(source, None, name, table, &PROTOCOLS[0], MAX_DETECTORS))
}

/// Whether the detector of a published method takes a budget of false alarms.
pub fn takes_budget(name: &str) -> bool {
    let table = METHOD_TABLES.iter().find(|(known, _)| known == name);
    let detector = table.and_then(|(_, table)| table.get_ref().get("detector")?.get_ref().as_table());
    let kind = detector.and_then(|detector| detector.get("kind")?.get_ref().as_str());
    let schema = kind.and_then(|kind| plugin::find(DETECTORS, kind)).map(|entry| (entry.schema)());
    schema.is_some_and(|schema| schema.get("properties").and_then(|p| p.get(BUDGET)).is_some())
}

/// Names of the published methods that take a budget of false alarms.
pub fn methods_with_budget() -> Vec<&'static str> {
    method_names().into_iter().filter(|name| takes_budget(name)).collect()
}

/// A published method by name, with a budget: the largest number of false alarms per 1000 frames.
///
/// # Errors
/// When the detector takes no budget, or refuses this one.
pub fn published_method_with_budget(name: &str, budget: f64) -> Option<Result<Method, SpecError>> {
    let text = format!("{BUDGET} = {budget:?}");
    // The published method is right, so what is wrong is the budget.
    let source = Source::new("--budget", &text);
    let (_, table) = METHOD_TABLES.iter().find(|(known, _)| known == name)?;
    let mut table: Spanned<DeTable<'_>> = table.clone();
    let set = match DeTable::parse(&text) {
        Ok(set) => set.into_inner(),
        Err(e) => return Some(Err(source.toml(&e, 0..0))),
    };
    if let Some(DeValue::Table(detector)) = table.get_mut().get_mut("detector").map(Spanned::get_mut) {
        for (key, value) in set {
            detector.remove(&**key.get_ref());
            detector.insert(key, value);
        }
    }
    Some(method::read(source, None, name, &table, &PROTOCOLS[0], MAX_DETECTORS))
}

/// Inputs that there are of a track beside its boxes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Inputs {
    /// The frames.
    pub frames: bool,
    /// Boxes of other trackers on the same frames.
    pub companions: bool,
    /// The tracker's own confidence.
    pub confidence: bool,
}

impl Inputs {
    /// Whether a signal that reads this can be computed.
    pub fn has(self, reads: Reads) -> bool {
        match reads {
            Reads::Boxes => true,
            Reads::Pixels => self.frames,
            Reads::Companions => self.companions,
            Reads::Confidence => self.confidence,
            Reads::Posterior | Reads::Response => false,
        }
    }
}

/// Name of the method that the benchmark recommends for the inputs given, see `docs/which-detector.md`.
pub fn recommended(inputs: Inputs) -> &'static str {
    match inputs {
        Inputs { frames: true, companions: true, .. } => "Fused frames and companions",
        Inputs { companions: true, .. } => "Fused companions",
        Inputs { frames: true, .. } => "Fused frames",
        Inputs { confidence: true, .. } => "Confidence",
        Inputs { .. } => "Fused boxes",
    }
}

/// Name of the method that is recommended for the inputs among those that take a budget of false alarms.
pub fn recommended_with_budget(inputs: Inputs) -> &'static str {
    match recommended(inputs) {
        "Confidence" => "Fused confidence",
        name => name,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::Metric;
    use crate::spec::table::{Side, Table};
    use std::collections::BTreeSet;

    #[test]
    fn recommended_methods_are_published() {
        for bits in 0..8 {
            let [frames, companions, confidence] = [1, 2, 4].map(|bit| bits & bit > 0);
            let inputs = Inputs { frames, companions, confidence };
            assert!(method_names().contains(&recommended(inputs)));
            assert!(takes_budget(recommended_with_budget(inputs)), "{inputs:?}");
        }
    }

    #[test]
    fn a_published_method_takes_another_budget() {
        assert!(takes_budget("Fused boxes") && !takes_budget("CovF") && !takes_budget("none"));
        assert!(methods_with_budget().iter().all(|name| takes_budget(name)));
        let of_budget = |budget| {
            let method = published_method_with_budget("Fused boxes", budget).unwrap();
            method.map(|m| m.variants[0].detector.example().detector.params()["budget"].clone())
        };
        assert_eq!(of_budget(7.0).unwrap(), 7.0);
        assert!(of_budget(f64::NAN).is_err());
        for wrong in [0.0, 1e9] {
            let error = of_budget(wrong).unwrap_err().to_string();
            assert!(error.starts_with("--budget:1: `budget` must be from 0.000001 to 1000, not "), "{error}");
        }
        assert!(published_method_with_budget("CovF", 1.0).unwrap().is_err());
        assert!(published_method_with_budget("none", 1.0).is_none());
    }

    #[test]
    fn every_published_method_builds() {
        assert_eq!(
            method_names(),
            [
                "DTEF",
                "NAIVE",
                "RAW",
                "CovF",
                "RgbHist",
                "RLHist",
                "AVU",
                "Two-MChi",
                "M-model",
                "EmpTh",
                "ARTE",
                "ARTE*",
                "Companions",
                "Watchdog",
                "Displacement",
                "Scale",
                "Forward-backward",
                "First colors",
                "Object colors",
                "Template",
                "CUSUM",
                "Page-Hinkley",
                "Sequential test",
                "Conformal DTEF",
                "PSR",
                "APCE",
                "LMCF",
                "FuCoLoT",
                "Confidence",
                "Fused boxes",
                "Fused frames",
                "Fused watchdog",
                "Fused confidence",
                "Fused frames and confidence",
                "Fused companions",
                "Fused frames and companions",
            ]
        );
        for name in method_names() {
            let method = published_method(name).unwrap().unwrap();
            assert_eq!(method.variants.len(), 1, "{name}");
        }
    }

    #[test]
    fn every_experiment_is_valid_and_named_as_its_file() {
        for (name, text) in EXPERIMENTS {
            let experiment = super::super::parse(name, text).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(experiment.name, *name);
        }
    }

    #[test]
    fn every_table_of_detectors_has_all_anchors_and_a_score_that_chance_is_taken_from() {
        for (name, text) in EXPERIMENTS {
            let experiment = super::super::parse(name, text).unwrap();
            let kinds = |methods: &[String]| -> BTreeSet<String> {
                let methods = experiment.methods.iter().filter(|m| methods.contains(&m.name));
                methods.flat_map(|m| &m.variants).map(|v| v.detector.example().kind.to_string()).collect()
            };
            let has = |table: &Table, metric: Metric| match &table.rows {
                Side::Metrics(metrics) => metrics.contains(&metric),
                _ => table.metric == Some(metric),
            };
            for table in experiment.tables.iter().filter(|t| t.shows.is_none()) {
                let is_by_method =
                    table.ranked.is_some() || [&table.rows, &table.columns].contains(&&Side::Method);
                let kinds = kinds(&table.methods);
                for anchor in
                    ["never", "always", "periodic", "random", "oracle"].into_iter().filter(|_| is_by_method)
                {
                    assert!(kinds.contains(anchor), "{name}, {}: {anchor}", table.name);
                }
                let beside = experiment.tables.iter().any(|t| has(t, Metric::F_OVER_CHANCE));
                assert!(!has(table, Metric::F_SCORE) || beside, "{name}, {}", table.name);
            }
        }
    }
}
