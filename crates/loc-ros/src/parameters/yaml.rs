//! Which part of a parameter file is that of a node, and YAML values that remember their lines.

use super::NodeParameters;
use crate::{Error, Result};
use serde::de::{self, Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};
use serde_saphyr::Spanned;
use std::fmt;

/// The key under which a node's parameters stand.
const PARAMETERS: &str = "ros__parameters";

struct Node<'a> {
    name: String,
    parameters: &'a [(String, Value, u64)],
}

/// The parameters of a node: those of wildcards, and over them its own.
pub(super) fn parameters(file: &str, text: &str, node: &str) -> Result<NodeParameters> {
    let root: Value = serde_saphyr::from_str(text).map_err(|error| {
        let line = error.location().map_or(0, |location| location.line());
        let message = format!("line {line}: {}", error.without_snippet());
        Error::Parameters { file: file.to_owned(), message }
    })?;
    let mut nodes = Vec::new();
    find(&root, "", &mut nodes);
    let is_wildcard = |node: &&Node<'_>| node.name.ends_with('*');
    let is_named = |candidate: &&Node<'_>| last(&candidate.name) == node;
    let mut own: Vec<&Node<'_>> = nodes.iter().filter(is_named).collect();
    let others: Vec<&Node<'_>> = nodes.iter().filter(|n| !is_wildcard(n) && !is_named(n)).collect();
    if own.is_empty() && others.len() == 1 {
        // The only node of the file, whatever its name: there is no other that could be meant.
        own = others;
    }
    let chosen: Vec<_> = nodes.iter().filter(is_wildcard).chain(own).collect();
    if chosen.is_empty() {
        let names: Vec<&str> = nodes.iter().map(|node| node.name.as_str()).collect();
        let found = if names.is_empty() { "no node".into() } else { names.join(", ") };
        let message = format!("expected `{node}:` and below it `{PARAMETERS}:`, got {found}");
        return Err(Error::Parameters { file: file.to_owned(), message });
    }
    let mut given = NodeParameters::new(file, node);
    for chosen in chosen {
        flatten(chosen.parameters, "", &mut given);
    }
    Ok(given)
}

/// Every node below a value, with its name.
fn find<'a>(value: &'a Value, name: &str, nodes: &mut Vec<Node<'a>>) {
    let Value::Map(entries) = value else { return };
    for (key, value, _) in entries {
        match value {
            Value::Map(parameters) if key == PARAMETERS => {
                nodes.push(Node { name: name.to_owned(), parameters });
            }
            _ => find(value, &format!("{name}/{}", key.trim_start_matches('/')), nodes),
        }
    }
}

fn last(name: &str) -> &str {
    name.rsplit('/').next().unwrap_or(name)
}

/// `initial_pose:` with `x:` below it is `initial_pose.x`.
fn flatten(entries: &[(String, Value, u64)], prefix: &str, given: &mut NodeParameters) {
    for (key, value, line) in entries {
        let key = format!("{prefix}{key}");
        match value {
            Value::Map(inner) => flatten(inner, &format!("{key}."), given),
            value => given.insert(key, value.clone(), *line),
        }
    }
}

/// A value.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    Null,
    Bool(bool),
    Integer(i64),
    Number(f64),
    Text(String),
    List,
    Map(Vec<(String, Value, u64)>),
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Null => f.write_str("nothing"),
            Value::Bool(value) => write!(f, "`{value}`"),
            Value::Integer(value) => write!(f, "`{value}`"),
            Value::Number(value) => write!(f, "`{value}`"),
            Value::Text(value) => write!(f, "the text `{value}`"),
            Value::List => f.write_str("a list"),
            Value::Map(_) => f.write_str("keys of its own"),
        }
    }
}

impl<'de> Deserialize<'de> for Value {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(AnyValue)
    }
}

struct AnyValue;

impl<'de> Visitor<'de> for AnyValue {
    type Value = Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a value")
    }

    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_none<E>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_some<D: Deserializer<'de>>(self, deserializer: D) -> Result<Value, D::Error> {
        Value::deserialize(deserializer)
    }

    fn visit_bool<E>(self, value: bool) -> Result<Value, E> {
        Ok(Value::Bool(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Value, E> {
        Ok(Value::Integer(value))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Value, E> {
        Ok(i64::try_from(value).map_or(Value::Number(value as f64), Value::Integer))
    }

    fn visit_f64<E>(self, value: f64) -> Result<Value, E> {
        Ok(Value::Number(value))
    }

    fn visit_str<E: de::Error>(self, value: &str) -> Result<Value, E> {
        Ok(Value::Text(value.to_owned()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Value, A::Error> {
        while list.next_element::<Value>()?.is_some() {}
        Ok(Value::List)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Value, A::Error> {
        let mut entries = Vec::new();
        while let Some(key) = map.next_key::<String>()? {
            let value: Spanned<Value> = map.next_value()?;
            entries.push((key, value.value, value.referenced.line()));
        }
        Ok(Value::Map(entries))
    }
}
