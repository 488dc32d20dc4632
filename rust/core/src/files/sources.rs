//! Where curves and dots stand in the file that they are from, for messages.

/// Where every curve and dot stands.
#[derive(Debug, Default)]
pub(super) struct Sources {
    /// Layers and elements, in words.
    holders: Vec<String>,
    /// The outlines, in the order of the file.
    outlines: Vec<Source>,
}

/// An outline of a file.
#[derive(Debug)]
struct Source {
    /// The first of the curves and dots that are from it, or from a later one.
    curve: usize,
    stipple: usize,
    holder: usize,
    /// Its number in its holder, from 1.
    number: usize,
}

impl Sources {
    /// Outlines that follow are in this layer or element.
    pub(super) fn enter(&mut self, holder: String) {
        self.holders.push(holder);
    }

    /// The next curves and dots, by their numbers, are from another outline.
    pub(super) fn begin(&mut self, curve: usize, stipple: usize) {
        let holder = self.holders.len().saturating_sub(1);
        let number = self.outlines.last().filter(|last| last.holder == holder).map_or(1, |last| last.number + 1);
        self.outlines.push(Source { curve, stipple, holder, number });
    }

    /// The next curves and dots, by their numbers, are from this outline after all.
    pub(super) fn place(&mut self, outline: usize, curve: usize, stipple: usize) {
        if let Some(source) = self.outlines.get_mut(outline) {
            (source.curve, source.stipple) = (curve, stipple);
        }
    }

    /// An outline in words.
    pub(super) fn outline(&self, number: usize) -> String {
        self.words(number + 1).unwrap_or_default()
    }

    /// A curve in words: `outline 12 of the layer black-regions`; in a file without layers `curve 12`.
    pub(super) fn curve(&self, number: usize) -> String {
        let after = self.outlines.partition_point(|source| source.curve <= number);
        self.words(after).unwrap_or_else(|| format!("curve {number}"))
    }

    /// A dot in words, likewise.
    pub(super) fn stipple(&self, number: usize) -> String {
        let after = self.outlines.partition_point(|source| source.stipple <= number);
        self.words(after).unwrap_or_else(|| format!("stipple {number}"))
    }

    /// The outline before this place.
    fn words(&self, after: usize) -> Option<String> {
        let source = self.outlines.get(after.checked_sub(1)?)?;
        Some(format!("outline {} of {}", source.number, self.holders.get(source.holder)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_and_dots_have_the_names_of_their_outlines() {
        let mut sources = Sources::default();
        assert_eq!((sources.curve(3), sources.stipple(4)), ("curve 3".to_owned(), "stipple 4".to_owned()));
        sources.enter("the layer black-regions".to_owned());
        // Two curves between runs along the frame, a dot that is a hole, a curve.
        sources.begin(0, 0);
        sources.begin(2, 0);
        sources.begin(2, 1);
        sources.enter("the element black-stipple-7".to_owned());
        sources.begin(3, 1);
        let curves: Vec<String> = (0..3).map(|number| sources.curve(number)).collect();
        let of = |number: usize| format!("outline {number} of the layer black-regions");
        assert_eq!(curves, [of(1), of(1), of(3)]);
        assert_eq!(sources.stipple(0), of(2));
        assert_eq!(sources.stipple(1), "outline 1 of the element black-stipple-7");
    }
}
