//! Experiments and published methods that come with the program.

use super::error::{At, Errors, Source, SourceFile};
use super::limits::MAX_DETECTORS;
use super::method::{self, Method};
use super::{SpecError, wire};
use std::sync::LazyLock;
use toml::Spanned;
use toml::de::{DeTable, DeValue};
use trackfail_judge::method::METHODS;
use trackfail_methods::score::PROTOCOLS;

/// Makes pairs of name and text of experiments from their names.
macro_rules! experiments {
    ($($name:literal)*) => {
        &[$(($name, include_str!(concat!("../../../../experiments/", $name, ".toml")))),*]
    };
}

/// Name and text of every built-in experiment.
pub static EXPERIMENTS: &[(&str, &str)] = experiments! {
    "quickstart" "benchmark/synthetic" "benchmark/otb" "benchmark/vot2014" "benchmark/uav123" "benchmark/fused"
    "benchmark/deep" "benchmark/deep-models" "benchmark/longterm" "benchmark/cost" "benchmark/otb-boxes"
    "khalid2016/table1" "khalid2016/table2" "khalid2016/training" "khalid2016/figures"
    "khalid2016/readings" "sanmiguel2015/model" "sanmiguel2015/convolution" "sanmiguel2015/fig3"
    "sanmiguel2015/fig13-d1" "sanmiguel2015/fig13-d2" "sanmiguel2015/fig14"
    "sanmiguel2015/fig13-d1-unsigned" "sanmiguel2015/start-up" "sanmiguel2015/model-real"
    "sanmiguel2015/readings" "sanmiguel2015/convolution-real" "sanmiguel2015/fig13-real"
    "sanmiguel2015/fig14-real" "sanmiguel2015/table6" "sanmiguel2015/table6-d2" "sanmiguel2015/table4"
    "sanmiguel2015/table4-d2" "sanmiguel2015/table5" "sanmiguel2015/table7" "sanmiguel2015/table7-d2"
    "sanmiguel2015/fig15" "sanmiguel2015/built-in-model" "khalid2016/thresholds"
    "khalid2016/thresholds-real" "sanmiguel2015/thresholds" "compare/otb" "compare/vot2014"
};

/// The experiment that `trackfail run` runs when none is named.
pub const QUICKSTART: &str = "quickstart";

/// Name and table of every published method, parsed from the built-in file.
pub(super) static METHOD_TABLES: LazyLock<Vec<(String, Spanned<DeTable<'static>>)>> = LazyLock::new(|| {
    let methods: Vec<toml::Table> = serde_json::from_str(METHODS).unwrap_or_default();
    let table = |mut method: toml::Table| {
        method.remove("about");
        let name = method.get("name").and_then(toml::Value::as_str).unwrap_or_default().to_string();
        // Once a process: the tables live as long as it.
        let text: &'static str = method.to_string().leak();
        Some((name, DeTable::parse(text).ok()?))
    };
    methods.into_iter().filter_map(table).collect()
});

/// A published method by name, with its published threshold.
///
/// # Errors
/// When the built-in file of published methods is wrong, which tests exclude.
pub fn published_method(name: &str) -> Option<Result<Method, SpecError>> {
    let (_, table) = METHOD_TABLES.iter().find(|(known, _)| known == name)?;
    let table = Spanned::new(table.span(), DeValue::Table(table.get_ref().clone()));
    let (files, errors) = ([SourceFile::new("methods.json", METHODS)], Errors::default());
    let at = At::new(Source(&files), &table, &errors);
    let wire = at.read::<wire::Method>();
    let method = wire.and_then(|wire| method::read(at, None, &wire, &PROTOCOLS[0], MAX_DETECTORS));
    Some(errors.or(method))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::table::{Side, Table};
    use std::collections::BTreeSet;
    use trackfail_judge::method::names;
    use trackfail_methods::score::Metric;

    #[test]
    fn every_published_method_builds() {
        assert_eq!(METHOD_TABLES.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), names());
        for name in names() {
            let method = published_method(name).unwrap().unwrap();
            assert_eq!(method.variants.len(), 1, "{name}");
        }
    }

    #[test]
    fn every_table_of_detectors_has_all_anchors_and_a_score_that_chance_is_taken_from() {
        for (name, text) in EXPERIMENTS {
            let experiment = super::super::parse(name, text).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(experiment.name, *name);
            let kinds = |methods: &[String]| -> BTreeSet<String> {
                let methods = experiment.methods.iter().filter(|m| methods.contains(&m.name));
                methods.flat_map(|m| &m.variants).map(|v| v.detector.example.kind.to_string()).collect()
            };
            let has = |table: &Table, metric: Metric| match &table.rows {
                Side::Metrics(metrics) => metrics.contains(&metric),
                _ => table.metric == Some(metric),
            };
            for table in experiment.tables.iter().filter(|t| t.shows.is_none()) {
                let is_by_method =
                    table.ranked.is_some() || [&table.rows, &table.columns].contains(&&Side::Method);
                let anchors = ["never", "always", "periodic", "random", "oracle"];
                let has_all = anchors.iter().all(|anchor| kinds(&table.methods).contains(*anchor));
                assert!(has_all || !is_by_method, "{name}, {}", table.name);
                let beside = experiment.tables.iter().any(|t| has(t, Metric::F_OVER_CHANCE));
                assert!(!has(table, Metric::F_SCORE) || beside, "{name}, {}", table.name);
            }
        }
    }
}
