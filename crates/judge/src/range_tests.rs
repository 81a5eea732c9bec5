//! The laws of every list of plugins: what an entry promises, and of ranges, that each end is accepted, and the next number
//! beyond it is refused.

use serde_json::{Value, json};
use std::ops::Bound;
use trackfail_core::plugin::{Entry, ParamError, Range, RawParams};

/// Checks that each kind is there once, that the parameters of its example are read back as they are shown, that an
/// unknown one is refused by its name, and the ranges.
pub fn check<T: ?Sized>(list: &[Entry<T>]) {
    for (n, entry) in list.iter().enumerate() {
        let kind = entry.kind;
        assert!(list[..n].iter().all(|other| other.kind != kind), "{kind} is there twice");
        assert!(entry.version >= 1 && !entry.summary.is_empty(), "{kind}");
        assert!((entry.schema)().as_value().is_object(), "{kind}");
        let shown = entry.build_from_text(entry.example).unwrap().params();
        let mut set = toml::Table::try_from(without_nulls(&shown)).unwrap();
        let build = |set: &toml::Table| entry.build_from_text(&toml::Value::Table(set.clone()).to_string());
        assert_eq!(build(&set).unwrap().params(), shown, "{kind}");
        set.insert("no-such-parameter".into(), 1.into());
        let refused = build(&set).err().unwrap_or_else(|| panic!("{kind}: a parameter that nobody knows"));
        assert!(refused.message.contains("no-such-parameter"), "{kind}: {refused}");
        entry.ranges.iter().for_each(|range| check_range(entry, range, &shown));
    }
}

/// TOML has no null: an option that is not set is left out.
fn without_nulls(value: &Value) -> Value {
    match value {
        Value::Object(members) => {
            let set = members.iter().filter(|(_, value)| !value.is_null());
            set.map(|(key, value)| (key.clone(), without_nulls(value))).collect()
        }
        other => other.clone(),
    }
}

/// Ranges of each entry in words, as pins.
pub fn pins<T: ?Sized>(list: &[Entry<T>]) -> Vec<String> {
    let ranges = |entry: &Entry<T>| {
        let ranges = entry.ranges.iter().map(|range| format!("{} {}", range.key, range.rule()));
        format!("{} {}", entry.kind, ranges.collect::<Vec<_>>().join("; "))
    };
    list.iter().filter(|entry| !entry.ranges.is_empty()).map(ranges).collect()
}

fn check_range<T: ?Sized>(entry: &Entry<T>, range: &Range, shown: &Value) {
    let build = |value: Value| -> Result<(), ParamError> {
        let mut params = shown.clone();
        set(&mut params, range.key, value);
        (entry.build)(RawParams::Json(&params)).map(|_| ())
    };
    let fraction = build(json!(1.5)).err().map(|e| e.message);
    let is_whole = fraction.is_some_and(|message| message.contains("floating point"));
    let number = |value: f64| if is_whole { json!(value as i64) } else { json!(value) };
    let next_down = |value: f64| if is_whole { value - 1.0 } else { value.next_down() };
    let next_up = |value: f64| if is_whole { value + 1.0 } else { value.next_up() };
    // The last number within and the first one beyond.
    let low = match range.low {
        Bound::Included(low) => Some((low, next_down(low))),
        Bound::Excluded(low) => Some((next_up(low), low)),
        Bound::Unbounded => None,
    };
    let high = match range.high {
        Bound::Included(high) => Some((high, next_up(high))),
        Bound::Excluded(high) => Some((next_down(high), high)),
        Bound::Unbounded => None,
    };
    for (within, beyond) in [low, high].into_iter().flatten() {
        let label = format!("{} {}: {within} {beyond}", entry.kind, range.key);
        // Another rule may refuse the number, such as one of two parameters together.
        let is_fault =
            |e: &ParamError| e.message.contains(&range.rule()) || e.message.contains("unknown field");
        let refused = build(number(within)).err().filter(is_fault);
        assert_eq!(refused, None, "{label}");
        let refused = build(number(beyond)).expect_err(&label);
        let is_no_such_number = refused.key.is_none();
        assert!(is_no_such_number || refused.message.contains(&range.rule()), "{label}: {refused}");
    }
}

/// Sets a parameter or, for a list, its first number.
fn set(params: &mut Value, key: &str, value: Value) {
    let (table, key) = match key.split_once('.') {
        Some((table, key)) => (&mut params[table], key),
        None => (params, key),
    };
    match table.get_mut(key) {
        Some(Value::Array(list)) if !list.is_empty() => list[0] = value,
        _ => table[key] = value,
    }
}
