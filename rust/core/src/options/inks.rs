//! The palette that the options ask for.

use super::Options;
use crate::base::{Error, NamedInk, Palette, Result};

impl Options {
    /// Whether the drawing has other inks than black alone, for which the photo keeps its colour.
    pub fn wants_colour(&self) -> bool {
        self.inks.is_some() || self.levels.is_some() || self.extract_inks.is_some()
    }

    /// The inks and the paper of the drawing. `extract` is asked for inks of the photo, of so many colours, if the options ask for them.
    ///
    /// # Errors
    /// As [`Palette::new`].
    pub fn palette(&self, extract: impl FnOnce(usize) -> Vec<[u8; 3]>) -> Result<Palette> {
        let paper = self.paper.as_ref().map_or([255; 3], |paper| paper.rgb());
        let of_colours = |colours: Vec<[u8; 3]>| colours.into_iter().map(NamedInk::of_colour).collect();
        let inks = if let Some(inks) = &self.inks {
            inks.0.clone()
        } else if let Some(count) = self.extract_inks {
            let colours = extract(count as usize);
            of_colours(colours.into_iter().filter(|colour| *colour != paper).collect())
        } else if let Some(levels) = self.levels {
            (0..levels - 1).map(|level| NamedInk::of_grey(level, levels - 1)).collect()
        } else {
            return Ok(Palette::default());
        };
        Palette::new(inks, paper, self.overprint)
    }

    /// Checks that what is said of inks goes together.
    pub(super) fn check_inks(&self) -> Result<()> {
        let given =
            [("inks", self.inks.is_some()), ("levels", self.levels.is_some()), ("extract_inks", self.extract_inks.is_some())];
        let given: Vec<&str> = given.into_iter().filter(|(_, is_given)| *is_given).map(|(name, _)| name).collect();
        if let [first, second, ..] = given[..] {
            return Err(Error::option(second, "given", format!("left out when {first} is given: each says which inks there are")));
        }
        if self.overprint && (given.is_empty() || self.levels.is_some()) {
            return Err(Error::option("overprint", "True", "left out without inks or extract_inks: there is one ink alone"));
        }
        if self.overprint && self.extract_inks.is_some_and(|count| count as usize > crate::base::MOST_OVERPRINTED) {
            let most = crate::base::MOST_OVERPRINTED;
            return Err(Error::option(
                "extract_inks",
                self.extract_inks.unwrap_or_default(),
                format!("at most {most} with overprint"),
            ));
        }
        if self.inks.is_some() {
            self.palette(|_| Vec::new())?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::{InkList, Value};

    fn with(name: &str, value: Value) -> Options {
        let mut options = Options::default();
        options.set(name, &value).unwrap();
        options
    }

    #[test]
    fn levels_are_greys_evenly_apart() {
        let palette = with("levels", Value::Whole(4)).palette(|_| unreachable!()).unwrap();
        let greys: Vec<_> = palette.labels().map(|label| (palette.name(label), palette.rgb(label)[0])).collect();
        let expected =
            [("black", 0), ("grey-33", 85), ("grey-67", 170), ("paper", 255)].map(|(name, grey)| (name.to_owned(), grey));
        assert_eq!(greys, expected);
        assert!(with("levels", Value::Whole(2)).palette(|_| unreachable!()).unwrap().is_black_and_white());
    }

    #[test]
    fn inks_survive_json_and_what_does_not_go_together_is_refused() {
        let options = with("inks", Value::Word("#1d1d1b, pink=#ff48b0".into()));
        assert_eq!(options.to_json()["inks"], "#1d1d1b,pink=#ff48b0");
        assert_eq!(Options::from_json(&options.to_json()).unwrap(), options);
        let told = |change: fn(&mut Options)| {
            let mut options = Options::default();
            change(&mut options);
            options.check().unwrap_err().to_string()
        };
        assert_eq!(
            told(|o| (o.levels, o.extract_inks) = (Some(3), Some(3))),
            "extract_inks is given, but it must be left out when levels is given: each says which inks there are"
        );
        assert!(told(|o| o.overprint = true).starts_with("overprint is True, but it must be left out"));
        let twice = InkList(vec![NamedInk::of_colour([1, 2, 3]); 2]);
        let mut options = Options { inks: Some(twice), ..Options::default() };
        assert!(options.clone().check().unwrap_err().to_string().starts_with("inks is #010203,#010203, but it must be inks of"));
        options.set("inks", &Value::Word("mauve".into())).unwrap_err();
    }
}
