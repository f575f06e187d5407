//! JSON object of a light. Its kind may stand after other fields, so all fields are kept until it
//! is known.

use std::fmt;

use serde::de::{DeserializeOwned, Deserializer, Error, MapAccess, Visitor};
use serde_json::{Map, Value};
use serde_path_to_error::{Path, Segment};

/// Fields of a light, and its kind.
pub(super) struct LightObject {
    pub kind: String,
    fields: Map<String, Value>,
}

impl LightObject {
    /// Reads an object. Null stands for an omitted field; `is_field` decides whether any kind has a
    /// field of that name.
    pub fn read<'de, D: Deserializer<'de>>(
        deserializer: D,
        default_kind: &str,
        is_field: impl Fn(&str) -> bool,
    ) -> Result<Self, D::Error> {
        let mut fields = deserializer.deserialize_map(Fields)?;
        let kind = match fields.remove("kind") {
            None => default_kind.to_owned(),
            Some(Value::String(kind)) => kind,
            Some(_) => return Err(D::Error::custom("/kind: must be the name of a kind of light")),
        };
        fields.retain(|name, value| !value.is_null() || !is_field(name));
        Ok(Self { kind, fields })
    }

    /// Parses the fields as those of one kind. An error names the field by a JSON pointer.
    pub fn fields<T: DeserializeOwned>(self) -> Result<T, String> {
        let Self { kind, fields } = self;
        serde_path_to_error::deserialize(Value::Object(fields)).map_err(|error| {
            let pointer = pointer(error.path());
            let text = error.inner().to_string();
            let unknown =
                text.strip_prefix("unknown field `").and_then(|rest| rest.split_once('`'));
            match unknown {
                Some((name, _)) => {
                    let step = escaped(name);
                    format!("/{step}: a light of kind {kind} has no field `{name}`")
                }
                None if pointer.is_empty() => text,
                None => format!("{pointer}: {text}"),
            }
        })
    }

    pub fn unknown_kind(&self, known: &[&str]) -> String {
        let known = known.join("`, `");
        format!("/kind: unknown variant `{}`, expected one of `{known}`", self.kind)
    }
}

fn escaped(name: &str) -> String {
    name.replace('~', "~0").replace('/', "~1")
}

fn pointer(path: &Path) -> String {
    let step = |segment: &Segment| match segment {
        Segment::Seq { index } => format!("/{index}"),
        Segment::Map { key } => format!("/{}", escaped(key)),
        Segment::Enum { .. } | Segment::Unknown => String::new(),
    };
    path.iter().map(step).collect()
}

struct Fields;

impl<'de> Visitor<'de> for Fields {
    type Value = Map<String, Value>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a light object")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let mut fields = Map::new();
        while let Some((name, value)) = map.next_entry::<String, Value>()? {
            if fields.contains_key(&name) {
                return Err(A::Error::custom(format_args!("duplicate field `{name}`")));
            }
            fields.insert(name, value);
        }
        Ok(fields)
    }
}
