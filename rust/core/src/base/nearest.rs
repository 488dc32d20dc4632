//! What somebody may have meant who gave a word that is none of those that are taken: in, the word and the others; out, the nearest of
//! them, if one is near.

/// Words shorter than this are near to too many others.
const SHORTEST: usize = 3;

/// The word that was probably meant: one that begins with what was given, or else the one that the fewest changes lead to (letters left
/// out, added, replaced, or two neighbours swapped), at most one for every three letters. The first of equals.
pub fn nearest<'a>(given: &str, words: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let given = given.to_lowercase();
    let length = given.chars().count();
    if length < SHORTEST {
        return None;
    }
    let distance = |word: &str| {
        let word = word.to_lowercase();
        if word.starts_with(&given) { 0 } else { strsim::osa_distance(&given, &word) }
    };
    let near = words.into_iter().map(|word| (distance(word), word)).filter(|(distance, _)| *distance <= length / 3);
    near.min_by_key(|(distance, _)| *distance).map(|(_, word)| word)
}

/// What is allowed, and after it the word that was probably meant, `shown` as messages show words.
pub(crate) fn or_nearest<'a>(
    allowed: &str,
    given: &str,
    words: impl IntoIterator<Item = &'a str>,
    shown: impl Fn(&str) -> String,
) -> String {
    let meant = nearest(given, words).map_or_else(String::new, |word| format!("; did you mean {}?", shown(word)));
    format!("{allowed}{meant}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_are_understood_and_other_words_are_not() {
        let presets = ["default", "paper", "stipple", "portrait", "linocut", "poster", "scratchboard"];
        for (given, meant) in [
            ("potrait", Some("portrait")),
            ("Portrait", Some("portrait")),
            ("prortait", Some("portrait")),
            ("lino", Some("linocut")),
            ("stiple", Some("stipple")),
            ("scratch board", Some("scratchboard")),
            ("po", None),
            ("", None),
            ("engraving", None),
            ("\u{1b}[0m", None),
        ] {
            assert_eq!(nearest(given, presets), meant, "{given}");
        }
        assert_eq!(nearest("sgv", ["svg", "pdf"]), Some("svg"));
        assert_eq!(nearest("gif", ["svg", "pdf"]), None);
    }

    #[test]
    fn what_was_meant_ends_the_sentence() {
        let quoted = |word: &str| format!("\"{word}\"");
        assert_eq!(or_nearest("a or b", "flatt", ["flat"], quoted), "a or b; did you mean \"flat\"?");
        assert_eq!(or_nearest("a or b", "x", ["flat"], quoted), "a or b");
    }
}
