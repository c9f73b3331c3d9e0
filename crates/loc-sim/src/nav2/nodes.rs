//! Which part of a parameter file is amcl's.
//!
//! A file may hold the parameters of a whole robot, node by node. Names may have a prefix
//! (`/robot1/amcl`), stand inside each other (`robot1:`, below it `amcl:`), or be a wildcard
//! (`/**`), which is meant for every node.

use super::given::Given;
use super::value::Value;
use crate::Result;
use crate::config;

/// The key under which a node's parameters stand.
const PARAMETERS: &str = "ros__parameters";

struct Node<'a> {
    name: String,
    parameters: &'a [(String, Value, u64)],
}

/// The parameters of amcl: those of wildcards, and over them its own.
pub(super) fn parameters(file: &str, text: &str) -> Result<Given> {
    let root: Value = serde_saphyr::from_str(text).map_err(|error| {
        let line = error.location().map_or(0, |location| location.line());
        config::error(file, &format!("line {line}: {}", error.without_snippet()))
    })?;
    let mut nodes = Vec::new();
    find(&root, "", &mut nodes);
    let is_wildcard = |node: &&Node<'_>| node.name.ends_with('*');
    let is_amcl = |node: &&Node<'_>| last(&node.name) == "amcl";
    let mut own: Vec<&Node<'_>> = nodes.iter().filter(is_amcl).collect();
    let others: Vec<&Node<'_>> = nodes.iter().filter(|n| !is_wildcard(n) && !is_amcl(n)).collect();
    if own.is_empty() && others.len() == 1 {
        // The only node of the file, whatever its name: there is no other that could be meant.
        own = others;
    }
    let chosen: Vec<_> = nodes.iter().filter(is_wildcard).chain(own).collect();
    if chosen.is_empty() {
        let names: Vec<&str> = nodes.iter().map(|node| node.name.as_str()).collect();
        let found = if names.is_empty() { "no node".into() } else { names.join(", ") };
        let message = format!("expected `amcl:` and below it `{PARAMETERS}:`, got {found}");
        return Err(config::error(file, &message));
    }
    let mut given = Given::new(file);
    for node in chosen {
        flatten(node.parameters, "", &mut given);
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
fn flatten(entries: &[(String, Value, u64)], prefix: &str, given: &mut Given) {
    for (key, value, line) in entries {
        let key = format!("{prefix}{key}");
        match value {
            Value::Map(inner) => flatten(inner, &format!("{key}."), given),
            value => given.insert(key, value.clone(), *line),
        }
    }
}
