//! OpenAPI schema of one kind of light.

use utoipa::PartialSchema;
use utoipa::openapi::schema::{AdditionalProperties, Object, SchemaType, Type};
use utoipa::openapi::{ObjectBuilder, RefOr, Schema};

/// Returns the schema of a kind as one closed object with a `kind`, which only the default kind may
/// omit. All fields that are not required may be null.
pub(super) fn light<T: PartialSchema>(kind: &str, default_kind: &str) -> Schema {
    let mut object = match T::schema() {
        RefOr::T(Schema::Object(object)) => object,
        // The derived schema of a flattened strength is apart from that of the other fields.
        RefOr::T(Schema::AllOf(all)) => {
            let mut joined = Object::new();
            joined.description = all.description;
            for item in all.items {
                if let RefOr::T(Schema::Object(part)) = item {
                    joined.properties.extend(part.properties);
                    joined.required.extend(part.required);
                }
            }
            joined
        }
        _ => unreachable!("a light is described by a struct"),
    };
    for (name, schema) in &mut object.properties {
        if !object.required.contains(name) {
            allow_null(schema);
        }
    }
    let kind_schema =
        ObjectBuilder::new().schema_type(SchemaType::new(Type::String)).enum_values(Some([kind]));
    object.properties.insert("kind".to_owned(), kind_schema.into());
    if kind != default_kind {
        object.required.insert(0, "kind".to_owned());
    }
    object.schema_type = SchemaType::new(Type::Object);
    object.additional_properties = Some(Box::new(AdditionalProperties::FreeForm(false)));
    Schema::Object(object)
}

fn allow_null(schema: &mut RefOr<Schema>) {
    let null = || ObjectBuilder::new().schema_type(SchemaType::new(Type::Null)).build();
    match schema {
        RefOr::T(Schema::Object(object)) => {
            if let SchemaType::Type(only) = &object.schema_type {
                object.schema_type = SchemaType::from_iter([only.clone(), Type::Null]);
            }
        }
        RefOr::T(Schema::OneOf(choices)) => choices.items.push(RefOr::T(Schema::Object(null()))),
        // An optional list is nullable already.
        _ => {}
    }
}
