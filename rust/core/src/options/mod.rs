//! The options of a drawing. In: what somebody asks for, as values by name; out: [`Options`], plain data with every value in its
//! range, and what is told of them. Source: parameters of the paper, and our own.
//!
//! [`declared`] is the one place that knows them all. The same names, defaults and ranges hold in Rust, Python, the command line and
//! the metadata of a drawing.

mod budget;
mod choices;
mod declaration;
mod declared;
mod inks;
mod numbers;
mod presets;
mod schema;
mod value;

use crate::base::{Checked, Error, Result, in_one_line, or_nearest};

pub use budget::{Budget, DEFAULT_MAX_NODES, DEFAULT_NODES_PER_PIXEL, LEAST_PIXELS, PIXELS_PER_NODE};
pub use choices::{Alpha, Backdrop, Crossings, Edge, ErrorWeighting, InkList, LatticeKind, Only, Order, Point};
pub use declaration::{Absent, Audience, DeclarationOf, Group, PUBLISHED, Stage};
pub use declared::{DECLARATIONS, Declaration, Options, Published};
pub(crate) use numbers::{bytes, in_hours};
pub use numbers::{seconds, whole};
pub use presets::{Preset, preset, presets};
pub use schema::schema;
pub use value::{Rule, Value};
pub(crate) use value::{Typed, words};

impl Options {
    /// The paper's settings: the published method as it is by [`Published::default`] (density 1 and no node budget, saliency alone,
    /// one Lloyd step), and none of what we add to it.
    pub fn paper() -> Self {
        Self {
            detail: 0.0,
            floor: 0.0,
            midtones: 0.0,
            sharpen: 0.0,
            local_contrast: 0.0,
            stippling: 0.0,
            refine: 0,
            tone_tolerance: None,
            split: 0,
            tolerance: 0.0,
            published: Published::default(),
            ..Self::default()
        }
    }

    /// The same options with one of them changed, by its name; a field of [`Published`] is `published.NAME`. Its type is checked here,
    /// its range by [`Options::check`].
    ///
    /// # Errors
    /// [`Error::Option`] if the value is of another type than the option, [`Error::Input`] if there is no such option.
    pub fn set(&mut self, name: &str, value: &Value) -> Result<()> {
        let declaration = Declaration::named(name)?;
        if (declaration.set)(self, value) { Ok(()) } else { Err(declaration.refuse(value)) }
    }

    /// Checks every value, and that they go together.
    ///
    /// # Errors
    /// [`Error::Option`] for the first that breaks its rule.
    pub fn check(self) -> Result<Checked<Self>> {
        for declaration in DECLARATIONS {
            let value = declaration.value(&self);
            let is_allowed = match declaration.absent {
                Some(_) if value == Value::Absent => true,
                _ => declaration.rule.takes(&value),
            };
            if !is_allowed {
                return Err(declaration.refuse(&value));
            }
        }
        if let (Some(_), Some(value)) = (self.nodes, self.nodes_per_pixel) {
            return Err(Error::option("nodes_per_pixel", value, "left out when nodes is given: the budget is one or the other"));
        }
        self.check_inks()?;
        if let Some(largest) = self.stipple_max.filter(|largest| *largest < self.stipple_min) {
            return Err(Error::option("stipple_max", largest, "at least stipple_min"));
        }
        if let (Some(Point::At(black)), Some(Point::At(white))) = (self.black_point, self.white_point)
            && white <= black
        {
            return Err(Error::option("white_point", white, format!("above black_point, which is {black}")));
        }
        Ok(Checked::of(self))
    }

    /// The options of a drawing's metadata, by name: all but `threads`, on which no drawing depends.
    pub fn to_json(&self) -> serde_json::Map<String, serde_json::Value> {
        let (method, plain): (Vec<&Declaration>, Vec<_>) =
            DECLARATIONS.iter().filter(|d| d.name != "threads").partition(|d| d.group == Group::Method);
        let of = |declarations: Vec<&Declaration>| {
            declarations.iter().map(|d| (d.name.to_owned(), (&d.value(self)).into())).collect::<serde_json::Map<_, _>>()
        };
        let mut json = of(plain);
        json.insert(PUBLISHED.to_owned(), of(method).into());
        json
    }

    /// Options from a drawing's metadata, the defaults where it says nothing.
    ///
    /// # Errors
    /// As [`Options::set`].
    pub fn from_json(json: &serde_json::Map<String, serde_json::Value>) -> Result<Self> {
        let mut options = Self::default();
        named(json).try_for_each(|(name, value)| options.set(&name, &value.into()))?;
        Ok(options)
    }

    /// The names in a drawing's metadata that are no options.
    pub(crate) fn unknown(json: &serde_json::Map<String, serde_json::Value>) -> Vec<String> {
        named(json).map(|(name, _)| name).filter(|name| Declaration::named(name).is_err()).collect()
    }
}

/// The values of a drawing's metadata by their full names.
fn named(json: &serde_json::Map<String, serde_json::Value>) -> impl Iterator<Item = (String, &serde_json::Value)> {
    json.iter().flat_map(|(name, value)| match value {
        serde_json::Value::Object(group) if name == PUBLISHED => {
            group.iter().map(|(name, value)| (format!("{PUBLISHED}.{name}"), value)).collect()
        }
        // A parameter stands in its group, and nowhere else.
        _ if name.contains('.') => vec![(format!("\"{name}\""), value)],
        _ => vec![(name.clone(), value)],
    })
}

impl Declaration {
    /// The declaration of an option, a field of [`Published`] by `published.NAME`.
    ///
    /// # Errors
    /// [`Error::Input`] if there is none of this name.
    pub fn named(name: &str) -> Result<&'static Self> {
        let found = DECLARATIONS.iter().find(|declaration| declaration.full_name() == name);
        found.ok_or_else(|| {
            let sentence = format!("there is no option {}", in_one_line(name));
            let short = name.rsplit('.').next().unwrap_or(name);
            let full_name = |name: &str| DECLARATIONS.iter().find(|it| it.name == name).map_or_else(String::new, Self::full_name);
            Error::Input(or_nearest(&sentence, short, DECLARATIONS.iter().map(|it| it.name), full_name))
        })
    }

    /// A value as a command line has it, in words: what stands for nothing that the option takes remains a word.
    pub fn parse(&self, text: &str) -> Value {
        if self.absent.is_some_and(|absent| absent.word == text) { Value::Absent } else { self.rule.parse(text) }
    }

    /// The error that a value breaks the rule.
    fn refuse(&self, value: &Value) -> Error {
        let sort = self.rule.sort(value);
        let absent = if self.absent.is_some() && !sort.is_empty() { "None or " } else { "" };
        let allowed = format!("{absent}{sort}{}", self.allowed());
        Error::option(self.full_name(), value, value.or_nearest(&allowed, self.rule.words()))
    }
}

/// Whether options are the same to the last bit: `==` takes -0 for 0, which are written differently.
pub(crate) fn identical(a: &Options, b: &Options) -> bool {
    format!("{a:?}") == format!("{b:?}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_survive_json() {
        let mut options = Options { gamma: 1.5, ..Options::default() };
        options.published = Published { alpha: Alpha::Constant(0.25), ..options.published };
        let json = options.to_json();
        assert_eq!(json[PUBLISHED]["alpha"], 0.25);
        assert!(json["nodes"].is_null() && !json.contains_key("threads"));
        assert_eq!(Options::from_json(&json).unwrap(), options);
        assert_eq!(Options::from_json(&serde_json::Map::new()).unwrap(), Options::default());
        let misspelt = serde_json::json!({"densty": 1});
        assert_eq!(
            Options::from_json(misspelt.as_object().unwrap()).unwrap_err().to_string(),
            "there is no option densty; did you mean published.density?"
        );
        let misspelt = serde_json::json!({"published": {"densty": 1}});
        assert_eq!(
            Options::from_json(misspelt.as_object().unwrap()).unwrap_err().to_string(),
            "there is no option published.densty; did you mean published.density?"
        );
    }

    #[test]
    fn messages_name_the_option_the_value_and_what_is_allowed() {
        let of_range = |change: fn(&mut Options)| {
            let mut options = Options::default();
            change(&mut options);
            options.check().unwrap_err().to_string()
        };
        assert_eq!(of_range(|o| o.gamma = f64::NAN), "gamma is NaN, but it must be between 0.1 and 10");
        assert_eq!(of_range(|o| o.fineness = 0.0), "fineness is 0, but it must be above 0 and at most 16");
        assert_eq!(of_range(|o| o.nodes = Some(2)), "nodes is 2, but it must be between 3 and 1000000000 nodes");
        assert_eq!(of_range(|o| o.published.hops = 0), "published.hops is 0, but it must be between 1 and 16 hops");
        assert_eq!(
            of_range(|o| o.published.alpha = Alpha::Constant(1.5)),
            "published.alpha is 1.5, but it must be \"tonal\", \"dynamic\" or a number between 0 and 1"
        );
        assert_eq!(
            of_range(|o| (o.nodes, o.nodes_per_pixel) = (Some(10), Some(0.1))),
            "nodes_per_pixel is 0.1, but it must be left out when nodes is given: the budget is one or the other"
        );
        let of_type = |name: &str, value: Value| Options::default().set(name, &value).unwrap_err().to_string();
        assert_eq!(of_type("gamma", Value::Word("2".into())), "gamma is \"2\", but it must be a number between 0.1 and 10");
        assert_eq!(of_type("relax", Value::Number(1.5)), "relax is 1.5, but it must be a whole number between 0 and 100 steps");
        assert_eq!(
            of_type("tone_tolerance", Value::Word("on".into())),
            "tone_tolerance is \"on\", but it must be None or a number between 0 and 1"
        );
        assert_eq!(
            of_type("background", Value::Word("red".into())),
            "background is \"red\", but it must be white, black, #rrggbb or #rgb"
        );
        assert_eq!(of_type("linear", Value::Whole(1)), "linear is 1, but it must be True or False");
        assert_eq!(
            of_type("published.order", Value::Word("random".into())),
            "published.order is \"random\", but it must be \"rows\" or \"global\""
        );
        assert_eq!(of_type("densty", Value::Whole(1)), "there is no option densty; did you mean published.density?");
    }

    #[test]
    fn what_is_quoted_stays_in_one_line() {
        let told = |name: &str, word: &str| Options::default().set(name, &Value::Word(word.into())).unwrap_err().to_string();
        assert_eq!(told("gamma", "2\n\u{1b}[0m"), "gamma is \"2\\n\\u{1b}[0m\", but it must be a number between 0.1 and 10");
        assert_eq!(told("gam\nma", "2"), "there is no option gam\\nma; did you mean gamma?");
        let json = serde_json::json!({"gamma": ["a\nb", {"c\n": "\u{7f}\u{85}"}]});
        assert!(!Options::from_json(json.as_object().unwrap()).unwrap_err().to_string().contains(char::is_control));
    }

    #[test]
    fn the_largest_stipple_is_not_below_the_least_and_a_seed_is_exact_in_json() {
        let radii =
            |stipple_min, stipple_max| Options { stipple_min, stipple_max: Some(stipple_max), ..Options::default() }.check();
        radii(2.0, 2.0).unwrap();
        assert_eq!(radii(2.0, 1.5).unwrap_err().to_string(), "stipple_max is 1.5, but it must be at least stipple_min");
        assert!(radii(0.0, 0.0).is_err());
        let seeded = |seed| Options { seed, ..Options::default() }.check();
        seeded(1 << 53).unwrap();
        assert_eq!(
            seeded((1 << 53) + 1).unwrap_err().to_string(),
            "seed is 9007199254740993, but it must be between 0 and 9007199254740992"
        );
    }

    #[test]
    fn the_white_point_lies_above_the_black_one() {
        let points = |black_point, white_point| Options { black_point, white_point, ..Options::default() }.check();
        points(Some(Point::At(0.2)), Some(Point::At(0.3))).unwrap();
        points(Some(Point::Auto), Some(Point::At(0.004))).unwrap();
        let told = points(Some(Point::At(0.3)), Some(Point::At(0.3))).unwrap_err().to_string();
        assert_eq!(told, "white_point is 0.3, but it must be above black_point, which is 0.3");
        assert!(points(Some(Point::At(1.0)), None).is_err() && points(None, Some(Point::At(0.0))).is_err());
    }

    /// Whoever adds an option has to say something of it, and nothing twice.
    #[test]
    fn every_declaration_is_whole() {
        for (number, declaration) in DECLARATIONS.iter().enumerate() {
            let sentence = declaration.sentence();
            assert!(sentence.len() > 20 && !sentence.ends_with('.'), "{}: {sentence}", declaration.name);
            assert!(DECLARATIONS[..number].iter().all(|other| other.name != declaration.name && other.sentence() != sentence));
            let value = declaration.value(&Options::default());
            assert!(declaration.absent.is_some() || value != Value::Absent, "{} is absent and does not say so", declaration.name);
            assert_eq!(Declaration::named(&declaration.full_name()).unwrap().name, declaration.name);
            let (mut copied, mut set) = (Options::paper(), Options::paper());
            declaration.copy(&mut copied, &Options::default());
            set.set(&declaration.full_name(), &value).unwrap();
            assert_eq!((declaration.value(&copied), &copied), (value, &set));
        }
    }
}
