//! The declarations as a JSON schema: what user interfaces, Python's `Options` and the page of options are made from.

use serde_json::{Map, Value, json};

use super::{DECLARATIONS, Declaration, Group, Options, PUBLISHED, Published, Rule};

/// The options as a JSON schema (2020-12) of what stands in a drawing's metadata.
///
/// Besides the schema's own words, a property has `x-group` (its heading), `x-everyday` (whether it is one of those that people turn),
/// `x-unit`, `x-stages` (what is done again when it changes, with all that follows), and, if it can be null, `x-absent` with its
/// `word` on the command line and what it means. A property of `published` also has `x-paper`, the paper's value.
pub fn schema() -> Value {
    let (ours, papers) = (Options::default(), Options { published: Published::default(), ..Options::default() });
    let (mut plain, mut method) = (Map::new(), Map::new());
    for declaration in DECLARATIONS {
        let mut property = property(declaration, &ours);
        if declaration.group == Group::Method {
            property.insert("x-paper".to_owned(), (&declaration.value(&papers)).into());
            method.insert(declaration.name.to_owned(), property.into());
        } else {
            plain.insert(declaration.name.to_owned(), property.into());
        }
    }
    let of_group = json!({
        "type": "object",
        "description": "Parameters of the published method's graphs and diffusions",
        "additionalProperties": false,
        "properties": method,
        "x-group": Group::Method.title(),
    });
    plain.insert(PUBLISHED.to_owned(), of_group);
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Options of a graphstipple drawing",
        "type": "object",
        "additionalProperties": false,
        "properties": plain,
    })
}

/// Inks as they are written.
const INKS: &str = "^([a-z0-9-]+=)?(white|black|#[0-9a-fA-F]{3}|#[0-9a-fA-F]{6})\
    ( *, *([a-z0-9-]+=)?(white|black|#[0-9a-fA-F]{3}|#[0-9a-fA-F]{6}))*$";

/// One option.
fn property(declaration: &Declaration, defaults: &Options) -> Map<String, Value> {
    let words = |words: &[&str]| json!({"type": "string", "enum": words});
    let within = |least: f64, most: f64| json!({"type": "number", "minimum": least, "maximum": most});
    let mut forms = match declaration.rule {
        Rule::Within(least, most) => vec![within(least, most)],
        Rule::UpTo(most) => vec![json!({"type": "number", "exclusiveMinimum": 0.0, "maximum": most})],
        Rule::Whole(least, most) => vec![json!({"type": "integer", "minimum": least, "maximum": most})],
        Rule::Switch => vec![json!({"type": "boolean"})],
        Rule::Words(all) => vec![words(all)],
        Rule::WordsOrWithin(all, least, most) => vec![words(all), within(least, most)],
        Rule::Inks => vec![json!({"type": "string", "pattern": INKS})],
        Rule::Color => vec![json!({"type": "string", "pattern": "^(white|black|#[0-9a-fA-F]{3}|#[0-9a-fA-F]{6})$"})],
    };
    if declaration.absent.is_some() {
        forms.push(json!({"type": "null"}));
    }
    let mut property = match (forms.pop(), forms.is_empty()) {
        (Some(Value::Object(only)), true) => only,
        (last, _) => Map::from_iter([("anyOf".to_owned(), forms.into_iter().chain(last).collect())]),
    };
    let mut say = |key: &str, value: Value| property.insert(key.to_owned(), value);
    say("description", declaration.description().into());
    say("default", (&declaration.value(defaults)).into());
    say("x-group", declaration.group.title().into());
    say("x-everyday", (declaration.audience == super::Audience::Everyday).into());
    say("x-unit", declaration.unit.into());
    say("x-stages", declaration.stages.iter().map(|stage| Value::from(stage.name())).collect());
    if declaration.rule == Rule::Inks {
        say("x-list", true.into());
    }
    if let Some(absent) = declaration.absent {
        say("x-absent", json!({"word": absent.word, "meaning": absent.meaning}));
    }
    property
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_schema_has_every_option_with_its_range_and_default() {
        let schema = schema();
        let (plain, method) = (&schema["properties"], &schema["properties"][PUBLISHED]["properties"]);
        assert_eq!(plain["gamma"]["minimum"], 0.1);
        assert_eq!(plain["gamma"]["default"], 1.0);
        assert_eq!(plain["nodes"]["anyOf"][0], json!({"type": "integer", "minimum": 3, "maximum": 1_000_000_000}));
        assert_eq!(plain["tone_tolerance"]["x-absent"]["word"], "off");
        assert_eq!(plain["seed"]["maximum"], json!(1u64 << 53));
        assert_eq!((&method["base"]["default"], &method["density"]["x-paper"]), (&json!(0.5), &json!(1.0)));
        assert_eq!(method["alpha"]["anyOf"][0]["enum"], json!(["tonal", "dynamic"]));
        let count = |properties: &Value| properties.as_object().map_or(0, Map::len);
        assert_eq!(count(plain) - 1 + count(method), DECLARATIONS.len());
    }
}
