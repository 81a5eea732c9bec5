//! Operating point: the point of a method's grid that its paper uses. Figures mark it, and the method is
//! ranked by it.

use serde_json::Value;
use trackfail_engine::spec::Experiment;
use trackfail_engine::spec::builtin;
use trackfail_engine::spec::method::{Method, Variant};

/// Papers, by their names in experiments, with the methods that they propose.
const OWN: [(&str, &[&str]); 2] = [("khalid2016", &["DTEF"]), ("sanmiguel2015", &["AVU", "ARTE*"])];

/// Published values of the parameters in a method's grid, by axis; `None` if one of them is not published.
pub fn published(method: &Method) -> Option<Vec<(String, f64)>> {
    let name = method.like.as_deref().unwrap_or(&method.name);
    let known = builtin::published_method(name)?.ok()?;
    let known = known.variants.first()?;
    let mut params = vec![known.detector.example.detector.params()];
    params.extend(known.signals.iter().map(|s| s.signal.params()));
    let value = |axis: &String| {
        let value = params.iter().find_map(|p| p.get(axis).and_then(Value::as_f64))?;
        Some((axis.clone(), value))
    };
    method.variants.first()?.point.iter().map(|(axis, _)| value(axis)).collect()
}

/// Variant of a method with a grid at the published parameters.
pub fn variant(method: &Method) -> Option<&Variant> {
    nearest(method).filter(|(_, distance)| *distance == 0.0).map(|(variant, _)| variant)
}

/// Variant with which a method is ranked: the only one, or that with the published parameters. For a method
/// that the experiment's paper proposes, the nearest variant will do. (Choosing the best variant would bias
/// the ranking.)
pub fn ranked<'m>(experiment: &Experiment, method: &'m Method) -> Option<&'m Variant> {
    if let [only] = method.variants.as_slice() {
        return Some(only);
    }
    let own = OWN.iter().find(|(paper, _)| experiment.paper.as_deref() == Some(*paper));
    let is_own = own.is_some_and(|(_, methods)| methods.contains(&method.name.as_str()));
    nearest(method).filter(|(_, distance)| is_own || *distance == 0.0).map(|(variant, _)| variant)
}

/// Variant with the smallest sum of relative differences to the published values, and that sum.
fn nearest(method: &Method) -> Option<(&Variant, f64)> {
    let published = published(method)?;
    let distance = |v: &Variant| -> f64 {
        let pairs = v.point.iter().zip(&published);
        pairs.map(|((_, at), (_, printed))| (at - printed).abs() / printed.abs().max(f64::MIN_POSITIVE)).sum()
    };
    // The first of equally near ones.
    method.variants.iter().map(|v| (v, distance(v))).min_by(|a, b| a.1.total_cmp(&b.1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::experiment;

    fn ranked_params(paper: &str, methods: &[(&str, &str)]) -> Vec<Option<String>> {
        let experiment = experiment(paper, methods, "");
        experiment.methods.iter().map(|m| ranked(&experiment, m).map(Variant::params)).collect()
    }

    #[test]
    fn a_grid_is_ranked_at_its_published_point_alone() {
        let own = "signal = { kind = \"rgb-histogram\" }\ndetector = { kind = \"level\" }\ngrid = { below = [0.5, 0.88] }";
        let methods = [
            ("DTEF", "grid = { horizon = [5, 10], threshold = [0.003, 0.004] }"),
            ("CovF", "grid = { above = [2.0, 2.5] }"),
            ("RAW", ""),
            ("own", own),
        ];
        let expected = [Some("horizon=5;threshold=0.004"), None, Some(""), None];
        assert_eq!(ranked_params("", &methods), expected.map(|p| p.map(String::from)));
    }

    #[test]
    fn the_papers_own_method_is_always_ranked() {
        let methods = ["DTEF", "NAIVE"].map(|name| (name, "grid = { threshold = [0.002, 0.005, 0.008] }"));
        let expected = [Some("threshold=0.005".to_string()), None];
        assert_eq!(ranked_params("paper = \"khalid2016\"", &methods), expected);
        assert_eq!(ranked_params("", &methods), [None, None]);
    }

    #[test]
    fn own_methods_are_published_ones() {
        let known = trackfail_judge::method::names();
        assert!(OWN.iter().flat_map(|(_, methods)| *methods).all(|m| known.contains(m)));
    }
}
