//! Completes the OpenAPI document that is collected from the routes.
//!
//! Owns what operations have in common: error responses, the description of 304, and the schema of
//! bodies that are files, from which generators of clients choose bytes or text. Does not know any
//! route.

use brood_protocol::{Backend, BreedOptions, DeferredAnswer, LeaseId, Problem, SearchLine};
use utoipa::openapi::header::HeaderBuilder;
use utoipa::openapi::path::{Operation, ParameterBuilder, ParameterIn};
use utoipa::openapi::schema::{ArrayItems, KnownFormat, SchemaFormat, Type};
use utoipa::openapi::{
    Components, Content, ContentBuilder, ObjectBuilder, OpenApi, Ref, RefOr, Required, Response,
    ResponseBuilder, Schema,
};
use utoipa::{PartialSchema, ToSchema};

const UNCHANGED: &str = "unchanged since the ETag in `If-None-Match`";
const PREFER: &str = "`respond-async`, or with a time `respond-async, wait=5`: the response is 202 with a job \
                      if the answer is not ready within `wait` seconds (default 0.1, at most 20)";
const DEFERRED: &str =
    "job of the deferred answer: get it until `state` is not `running`, then get `answer`";
const REFUSED: &str = "The request is invalid or not allowed";
const FAILED: &str = "The server failed or is busy";

/// Adds what routes leave out, and the types that only parameters or lines of a stream have.
pub fn finish(mut openapi: OpenApi) -> OpenApi {
    let components = openapi.components.get_or_insert_default();
    add::<Problem>(components);
    add::<Backend>(components);
    add::<LeaseId>(components);
    add::<SearchLine>(components);
    components.schemas.values_mut().for_each(inline_options);
    components.schemas.remove(BreedOptions::name().as_ref());
    operations(&mut openapi).for_each(complete);
    openapi
}

/// Describes `Prefer: respond-async` and its answer.
pub fn describe_deferring(openapi: &mut OpenApi) {
    let prefer = ParameterBuilder::new()
        .name("Prefer")
        .parameter_in(ParameterIn::Header)
        .required(Required::False)
        .description(Some(PREFER))
        .schema(Some(ObjectBuilder::new().schema_type(Type::String)));
    let prefer = prefer.build();
    let schema = RefOr::Ref(Ref::from_schema_name(DeferredAnswer::name()));
    let content = ContentBuilder::new().schema(Some(schema)).build();
    let header = |words: &str| {
        let text = ObjectBuilder::new().schema_type(Type::String).build();
        HeaderBuilder::new().schema(Some(text)).description(Some(words)).build()
    };
    let deferred = ResponseBuilder::new()
        .description(DEFERRED)
        .content("application/json", content)
        .header("Location", header("address of the job"))
        .header("Preference-Applied", header("`respond-async`"))
        .build();
    for operation in operations(openapi) {
        operation.parameters.get_or_insert_default().push(RefOr::T(prefer.clone()));
        operation.responses.responses.insert("202".to_owned(), RefOr::T(deferred.clone()));
    }
}

fn operations(openapi: &mut OpenApi) -> impl Iterator<Item = &mut Operation> {
    openapi.paths.paths.values_mut().flat_map(|item| {
        let methods =
            [&mut item.get, &mut item.post, &mut item.patch, &mut item.delete, &mut item.put];
        methods.into_iter().flatten()
    })
}

/// Completes the bodies and responses of an operation, and adds its error responses.
fn complete(operation: &mut Operation) {
    if let Some(RefOr::T(body)) = &mut operation.request_body {
        for (media_type, content) in &mut body.content {
            complete_content(media_type, content);
        }
    }
    let responses = &mut operation.responses.responses;
    for (status, response) in responses.iter_mut() {
        if let RefOr::T(response) = response {
            complete_response(status, response);
        }
    }
    for (range, words) in [("4XX", REFUSED), ("5XX", FAILED)] {
        let mut response = ResponseBuilder::new().description(words).build();
        complete_response(range, &mut response);
        responses.insert(range.to_owned(), RefOr::T(response));
    }
}

fn complete_response(status: &str, response: &mut Response) {
    let is_error = status.starts_with(['4', '5']);
    if is_error && response.content.is_empty() {
        let schema = RefOr::Ref(Ref::from_schema_name(Problem::name()));
        let content = ContentBuilder::new().schema(Some(schema)).build();
        response.content.insert("application/problem+json".to_owned(), RefOr::T(content));
    }
    if status == "304" && response.description.is_empty() {
        UNCHANGED.clone_into(&mut response.description);
    }
    for (media_type, content) in &mut response.content {
        complete_content(media_type, content);
    }
}

/// Sets the schema of a file: text if its media type is text, else bytes. `Vec<u8>` of a route
/// means bytes; its own schema, an array of numbers, is only right in JSON.
fn complete_content(media_type: &str, content: &mut RefOr<Content>) {
    let RefOr::T(content) = content else { return };
    if media_type.ends_with("json") {
        return;
    }
    let is_text = match &content.schema {
        None => media_type.starts_with("text/"),
        Some(RefOr::T(Schema::Array(_))) => false,
        Some(_) => return,
    };
    let binary = SchemaFormat::KnownFormat(KnownFormat::Binary);
    let schema = ObjectBuilder::new().schema_type(Type::String);
    content.schema = Some(schema.format((!is_text).then_some(binary)).into());
}

/// Lists the fields of [`BreedOptions`], which [`Generation`](brood_protocol::Generation) flattens,
/// among the others of the schema, also where a page contains it.
fn inline_options(schema: &mut RefOr<Schema>) {
    match schema {
        RefOr::T(Schema::AllOf(parts)) => {
            let options = Ref::from_schema_name(BreedOptions::name()).ref_location;
            let has_options = |part: &RefOr<Schema>| matches!(part, RefOr::Ref(part) if part.ref_location == options);
            if !parts.items.iter().any(has_options) {
                return;
            }
            let Some(RefOr::T(Schema::Object(mut whole))) = parts.items.pop() else { return };
            let RefOr::T(Schema::Object(options)) = BreedOptions::schema() else { return };
            whole.description = parts.description.take();
            whole.properties.extend(options.properties);
            whole.required.extend(options.required);
            *schema = RefOr::T(Schema::Object(whole));
        }
        RefOr::T(Schema::Object(object)) => {
            object.properties.values_mut().for_each(inline_options);
        }
        RefOr::T(Schema::Array(array)) => {
            if let ArrayItems::RefOrSchema(items) = &mut array.items {
                inline_options(items);
            }
        }
        _ => {}
    }
}

fn add<T: ToSchema>(components: &mut Components) {
    components.schemas.insert(T::name().into_owned(), T::schema());
}
