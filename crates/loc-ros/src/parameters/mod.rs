//! Parameter files of ROS 2 nodes, such as `amcl.yaml` of nav2.
//!
//! A file has `amcl:`, below it `ros__parameters:`, below it one key a line. It may hold the
//! parameters of a whole robot, node by node. Names may have a prefix (`/robot1/amcl`), stand
//! inside each other (`robot1:`, below it `amcl:`), or be a wildcard (`/**`), which is meant for
//! every node.
//!
//! ```
//! use loc_ros::NodeParameters;
//! let text = "amcl:\n  ros__parameters:\n    max_particles: 800\n    map_topic: map\n";
//! let mut parameters = NodeParameters::parse("amcl.yaml", text, "amcl")?;
//! let found = parameters.integer("max_particles", 1)?;
//! assert_eq!(found.map(|found| (found.value, found.line)), Some((800, 3)));
//! let unknown = "amcl.yaml:4: map_topic: not a parameter of amcl that is known here";
//! assert_eq!(parameters.into_warnings(), [unknown]);
//! # Ok::<(), loc_ros::Error>(())
//! ```

mod yaml;

use crate::{Error, Result};
use std::collections::BTreeMap;
use std::path::Path;
use yaml::Value;

/// The parameters of one node, by name.
///
/// Each is taken out once; what is left at the end is unknown and named by
/// [`NodeParameters::into_warnings`], so that nothing in a file is ignored in silence.
#[derive(Debug)]
pub struct NodeParameters {
    file: String,
    node: String,
    parameters: BTreeMap<String, (Value, u64)>,
    /// By line, so that they come out in the order of the file.
    warnings: Vec<(u64, String)>,
}

impl NodeParameters {
    /// Reads a parameter file; `node` is the name of the node without its namespace.
    ///
    /// # Errors
    /// [`loc_core::Error::Io`], else as [`NodeParameters::parse`].
    pub fn read(file: &Path, node: &str) -> Result<Self> {
        let text = std::fs::read_to_string(file).map_err(loc_core::Error::io(file))?;
        NodeParameters::parse(&file.display().to_string(), &text, node)
    }

    /// The same from a text; `file` is only named in errors and warnings.
    ///
    /// # Errors
    /// [`Error::Parameters`] with the line for what is no YAML, or has no parameters of the node.
    pub fn parse(file: &str, text: &str, node: &str) -> Result<Self> {
        yaml::parameters(file, text, node)
    }

    fn new(file: &str, node: &str) -> Self {
        NodeParameters {
            file: file.to_owned(),
            node: node.to_owned(),
            parameters: BTreeMap::new(),
            warnings: Vec::new(),
        }
    }

    /// Adds a parameter, over one of the same name.
    fn insert(&mut self, key: String, value: Value, line: u64) {
        self.parameters.insert(key, (value, line));
    }

    /// A finite number that `allowed` says is one; `expected` in words.
    ///
    /// # Errors
    /// [`Error::Parameters`] with the line for a value of another type or out of range.
    pub fn number(
        &mut self,
        key: &str,
        expected: &str,
        allowed: impl Fn(f64) -> bool,
    ) -> Result<Option<Found<f64>>> {
        self.take(key, expected, |value| match value {
            Value::Integer(value) => Some(*value as f64).filter(|v| allowed(*v)),
            Value::Number(value) => Some(*value).filter(|v| v.is_finite() && allowed(*v)),
            _ => None,
        })
    }

    /// A whole number from `min` on.
    ///
    /// # Errors
    /// [`Error::Parameters`] with the line for a value of another type or out of range.
    pub fn integer(&mut self, key: &str, min: i64) -> Result<Option<Found<i64>>> {
        self.take(key, &format!("a whole number >= {min}"), |value| match value {
            Value::Integer(value) => Some(*value).filter(|v| *v >= min),
            _ => None,
        })
    }

    /// True or false.
    ///
    /// # Errors
    /// [`Error::Parameters`] with the line for a value of another type or out of range.
    pub fn flag(&mut self, key: &str) -> Result<Option<Found<bool>>> {
        self.take(key, "true or false", |value| match value {
            Value::Bool(value) => Some(*value),
            _ => None,
        })
    }

    /// A name that is not empty.
    ///
    /// # Errors
    /// [`Error::Parameters`] with the line for a value of another type or out of range.
    pub fn name(&mut self, key: &str) -> Result<Option<Found<String>>> {
        self.take(key, "a name", |value| match value {
            Value::Text(text) => Some(text.clone()).filter(|text| !text.trim().is_empty()),
            _ => None,
        })
    }

    /// What stands for one of the `choices`.
    ///
    /// # Errors
    /// [`Error::Parameters`] with the line for a value of another type or out of range.
    pub fn choice<T: Copy>(
        &mut self,
        key: &str,
        choices: &[(&str, T)],
    ) -> Result<Option<Found<T>>> {
        let names: Vec<&str> = choices.iter().map(|(name, _)| *name).collect();
        self.take(key, &format!("one of {}", names.join(", ")), |value| match value {
            Value::Text(text) => choices.iter().find(|(name, _)| name == text).map(|(_, of)| *of),
            _ => None,
        })
    }

    /// Names those of some parameters that are given, whatever their values, as changing nothing;
    /// in one warning, at the line of the first.
    pub fn ignore(&mut self, keys: &[impl AsRef<str>], reason: &str) {
        let mut found = Vec::new();
        for key in keys.iter().map(AsRef::as_ref) {
            found.extend(self.parameters.remove(key).map(|(_, line)| (line, key)));
        }
        found.sort_unstable();
        if let Some((line, _)) = found.first() {
            let keys: Vec<&str> = found.iter().map(|(_, key)| *key).collect();
            self.warn(*line, &keys.join(", "), reason);
        }
    }

    /// Adds a warning about a parameter.
    pub fn warn(&mut self, line: u64, key: &str, reason: &str) {
        self.warnings.push((line, self.warning(line, key, reason)));
    }

    /// A warning as a line for the user.
    pub fn warning(&self, line: u64, key: &str, reason: &str) -> String {
        format!("{}:{line}: {key}: {reason}", self.file)
    }

    /// All warnings in order of their lines, with one for each parameter that was not taken.
    pub fn into_warnings(mut self) -> Vec<String> {
        for (key, (_, line)) in std::mem::take(&mut self.parameters) {
            self.warn(line, &key, &format!("not a parameter of {} that is known here", self.node));
        }
        self.warnings.sort();
        self.warnings.into_iter().map(|(_, warning)| warning).collect()
    }

    /// An error about the settings as a whole.
    pub fn error(&self, error: &impl ToString) -> Error {
        Error::Parameters { file: self.file.clone(), message: error.to_string() }
    }

    fn take<T>(
        &mut self,
        key: &str,
        expected: &str,
        read: impl Fn(&Value) -> Option<T>,
    ) -> Result<Option<Found<T>>> {
        let Some((value, line)) = self.parameters.remove(key) else { return Ok(None) };
        match read(&value) {
            Some(value) => Ok(Some(Found { value, line })),
            None => {
                let message = format!("line {line}: {key}: expected {expected}, got {value}");
                Err(Error::Parameters { file: self.file.clone(), message })
            }
        }
    }
}

/// A value with its line.
#[derive(Debug, Clone, Copy)]
pub struct Found<T> {
    /// The value.
    pub value: T,
    /// Its line in the file.
    pub line: u64,
}
