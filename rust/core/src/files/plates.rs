//! What printers need beside the drawing itself. In: a drawing, how it is written and where it lies on its page; out: its layers, with traps
//! and registration marks; and for every ink what writes its plate.

use crate::base::{Error, Ink, Palette, Result};
use crate::drawing::Drawing;
use crate::files::export::Export;
use crate::files::layers::{Layer, Layers, capitalized};
use crate::files::layout::Placement;
use crate::files::{Style, Writer, registration};

/// Points to the mm.
const MM: f64 = 72.0 / 25.4;

/// The separation that is all of them.
pub(super) const ALL: &str = "All";

/// Separations of inks that every press has: an ink of such a name is printed with that.
pub(super) const PROCESS: [&str; 4] = ["Cyan", "Magenta", "Yellow", "Black"];

/// The id of the layer of registration marks.
pub(super) const REGISTRATION: &str = "registration-marks";

impl Layer {
    /// Whether it holds registration marks: they are of all inks.
    pub(super) fn is_registration(&self) -> bool {
        self.id == REGISTRATION
    }

    /// The separation that it is printed on, as PDF and PostScript name it; none for black and white and for paper, which are no spot
    /// colours.
    pub(super) fn separation(&self, palette: &Palette) -> Option<&str> {
        if self.is_registration() {
            return Some(ALL);
        }
        let name = self.ink_name();
        let of_press = || PROCESS.into_iter().find(|process| process.eq_ignore_ascii_case(name)).unwrap_or(name);
        (!palette.is_black_and_white() && name != palette.paper_name()).then(of_press)
    }
}

impl Layers {
    /// The separations of its layers, each with the colour that stands for it where there is none, once, in their order.
    pub(super) fn separations(&self, palette: &Palette) -> Vec<(&str, [u8; 3])> {
        let mut all: Vec<(&str, [u8; 3])> = Vec::new();
        for layer in &self.layers {
            if let Some(name) = layer.separation(palette)
                && all.iter().all(|(other, _)| *other != name)
            {
                all.push((name, layer.rgb));
            }
        }
        all
    }
}

impl Export {
    /// What a vector file of a drawing holds where the drawing lies so on its page.
    ///
    /// # Errors
    /// As [`Drawing::layers`].
    pub(super) fn layers_of(&self, drawing: &Drawing, placement: &Placement) -> Result<Layers> {
        let mut layers = drawing.layers(self.style, &self.only, self.paper.as_ref())?;
        if let Some(trap) = self.trap {
            self.spread(&mut layers, drawing, trap.points() / placement.scale)?;
        }
        if self.registration_marks {
            let size = [drawing.width as f64, drawing.height as f64];
            let rgb = self.rgb_of_marks(&drawing.palette)?;
            let areas = registration::marks(size, MM / placement.scale);
            let (id, label) = (REGISTRATION.to_owned(), "Registration marks".to_owned());
            layers.layers.push(Layer { id, label, ink: Ink::BLACK, rgb, areas });
        }
        Ok(layers)
    }

    /// What registration marks are drawn with where a colour is one: that of the only ink of a plate, else black.
    pub(super) fn rgb_of_marks(&self, palette: &Palette) -> Result<[u8; 3]> {
        let rgb = match self.only.of(palette)?[..] {
            [ink] if ink < palette.inks().len() => palette.inks()[ink].rgb,
            _ => [0; 3],
        };
        // On a sheet of their own colour nobody would find them.
        let is_lost = self.paper.as_ref().is_some_and(|paper| paper.rgb() == rgb);
        Ok(if is_lost { rgb.map(|value| 255 - value) } else { rgb })
    }

    /// Adds what inks cover of darker ones, and puts the lightest layers lowest: then the picture is as it was.
    fn spread(&self, layers: &mut Layers, drawing: &Drawing, distance: f64) -> Result<()> {
        let order = drawing.palette.lightest_first();
        let mut trapped = Vec::new();
        for (place, ink) in order.iter().enumerate() {
            let (of_ink, others) = std::mem::take(&mut layers.layers).into_iter().partition(|layer| layer.ink.index() == *ink);
            layers.layers = others;
            let of_ink: Vec<Layer> = of_ink;
            if let Some(first) = of_ink.first() {
                let areas = drawing.trap(*ink, &order[place + 1..], distance)?;
                if !areas.is_empty() {
                    let name = first.ink_name();
                    let (id, label) = (format!("{name}-trap"), format!("{} trap", capitalized(name)));
                    trapped.push(Layer { id, label, ink: first.ink, rgb: first.rgb, areas });
                }
            }
            trapped.extend(of_ink);
        }
        // The paper's, if it is drawn as an ink, is neither lighter nor darker: nothing spreads onto it.
        layers.layers.splice(0..0, trapped);
        layers.overprint = true;
        Ok(())
    }
}

/// The plate of an ink, as a file of its own.
#[derive(Debug, Clone, PartialEq)]
pub struct Plate {
    /// What the ink is called, of a-z, 0-9 and -.
    pub name: String,
    ink: usize,
    writer: Writer,
}

impl Plate {
    /// The bytes of its file, of a drawing of the palette that it is for.
    ///
    /// # Errors
    /// As [`Writer::write`].
    pub fn write(&self, drawing: &Drawing) -> Result<Vec<u8>> {
        // A format that holds a whole drawing holds the plate as one.
        if self.writer.format.settings.contains(&"only") {
            self.writer.write(drawing)
        } else {
            self.writer.write(&drawing.plate(self.ink)?)
        }
    }
}

impl Writer {
    /// What writes the plates of a drawing of this palette: one of each ink that is drawn, and no paper.
    ///
    /// # Errors
    /// As [`Writer::check_palette`]; [`Error::Option`](crate::Error::Option) for a style that draws inks over each other.
    pub fn plates(&self, palette: &Palette) -> Result<Vec<Plate>> {
        self.check_plates()?;
        let names: Vec<&str> = palette.names().collect();
        let plate = |ink: usize| {
            let name = names[ink].to_owned();
            let writer = Self { format: self.format, export: self.export.of_plate(&name).check()? };
            writer.check_palette(palette)?;
            Ok(Plate { name, ink, writer })
        };
        self.export.only.of(palette)?.into_iter().map(plate).collect()
    }

    /// Whether there are plates when a drawing is written so: to be asked before its palette is known.
    ///
    /// # Errors
    /// [`Error::Option`](crate::Error::Option) for a style that draws inks over each other.
    pub fn check_plates(&self) -> Result<()> {
        if self.export.style == Style::Layered && self.format.settings.contains(&"style") {
            return Err(Error::option("style", "layered", "flat where each ink has a file of its own"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::NamedInk;
    use crate::drawing::Mark;
    use crate::drawing::samples::patches;
    use crate::files::Format;
    use crate::files::layers::Outline;
    use crate::options::Value;

    fn export(settings: &[(&str, &str)]) -> Export {
        let mut export = Export::default();
        for (name, value) in settings {
            let value = if *value == "True" { Value::Switch(true) } else { Value::Word((*value).to_owned()) };
            export.set(name, &value).unwrap();
        }
        export
    }

    fn layers(drawing: &Drawing, settings: &[(&str, &str)]) -> Layers {
        let export = export(settings).check().unwrap();
        let placement = export.layout.place(drawing.width, drawing.height).unwrap();
        export.layers_of(drawing, &placement).unwrap()
    }

    fn area(layers: &[&Layer]) -> f64 {
        layers.iter().flat_map(|layer| &layer.areas).map(crate::files::Area::area).sum()
    }

    #[test]
    fn lighter_inks_lie_lower_and_spread_into_darker_ones_alone() {
        for seed in 1..4 {
            let drawing = patches(4, 900, seed, false);
            let plain = layers(&drawing, &[]);
            let trapped = layers(&drawing, &[("trap", "0.5px")]);
            assert!(trapped.overprint && !trapped.multiply && !plain.overprint);
            let order = drawing.palette.lightest_first();
            let places: Vec<usize> =
                trapped.layers.iter().map(|layer| order.iter().position(|ink| *ink == layer.ink.index()).unwrap()).collect();
            assert!(places.is_sorted(), "{places:?}");
            // Every layer is there as it was, and traps beside them, none of the darkest ink.
            assert!(plain.layers.iter().all(|layer| trapped.layers.contains(layer)));
            let traps: Vec<&Layer> = trapped.layers.iter().filter(|layer| layer.id.ends_with("-trap")).collect();
            assert_eq!(trapped.layers.len(), plain.layers.len() + traps.len());
            assert!((1..4).contains(&traps.len()), "{}", traps.len());
            assert!(traps.iter().all(|layer| layer.ink.index() != order[3]));
            assert!(traps.iter().flat_map(|layer| &layer.areas).all(|area| area.mark.is_none() && area.area() > -1e-9));
            // A wider one covers more, and less than the darker inks with what it laps.
            let wide = layers(&drawing, &[("trap", "2px")]);
            for trap in &traps {
                let wide: Vec<&Layer> = wide.layers.iter().filter(|layer| layer.id == trap.id).collect();
                let darker = &order[order.iter().position(|ink| *ink == trap.ink.index()).unwrap()..];
                let all: Vec<&Layer> = plain.layers.iter().filter(|layer| darker.contains(&layer.ink.index())).collect();
                assert!(area(&[trap]) < area(&wide) && area(&wide) < area(&all), "{}", trap.id);
            }
        }
    }

    #[test]
    fn marks_stand_around_the_drawing_in_the_ink_of_its_plate() {
        let drawing = patches(3, 300, 1, false);
        let with_marks = layers(&drawing, &[("registration_marks", "True")]);
        let (marks, rest) = with_marks.layers.split_last().unwrap();
        assert!(marks.is_registration() && marks.rgb == [0; 3] && rest == layers(&drawing, &[]).layers);
        assert_eq!(marks.areas.len(), 8);
        // A px is 25.4/96 mm.
        let mm = 96.0 / 25.4;
        for area in &marks.areas {
            let bounds = match &area.exterior {
                Outline::Path(path) => kurbo::Shape::bounding_box(path),
                Outline::Circle { x, y, radius } => kurbo::Rect::new(x - radius, y - radius, x + radius, y + radius),
            };
            let around = kurbo::Rect::new(-9.0 * mm, -9.0 * mm, 60.0 + 9.0 * mm, 40.0 + 9.0 * mm);
            assert!(around.inflate(0.01, 0.01).contains_rect(bounds), "{bounds:?}");
            let drawn = kurbo::Rect::new(0.0, 0.0, 60.0, 40.0).inflate(0.9 * mm, 0.9 * mm);
            assert!(drawn.intersect(bounds).area() <= 0.0, "{bounds:?}");
            let line = area.area() / (mm * mm);
            assert!((line - if area.holes.is_empty() { 3.16 } else { std::f64::consts::PI }).abs() < 0.01, "{line}");
        }
        let name = drawing.palette.inks()[1].name.clone();
        let plate = layers(&drawing, &[("registration_marks", "True"), ("only", &name)]);
        assert_eq!(plate.layers.last().unwrap().rgb, drawing.palette.inks()[1].rgb);
        let margin = |settings: &[(&str, &str)]| export(settings).check().unwrap().layout.margin.to_string();
        assert_eq!(margin(&[("registration_marks", "True"), ("margin", "2cm")]), "2cm");
        assert_eq!(margin(&[("registration_marks", "True"), ("margin", "2mm")]), "10mm");
    }

    #[test]
    fn separations_are_named_by_inks_and_black_and_white_have_none() {
        let drawing = patches(3, 300, 1, false);
        let inks = drawing.palette.inks();
        let layers_with_marks = layers(&drawing, &[("registration_marks", "True"), ("trap", "1px")]);
        let mut found = layers_with_marks.separations(&drawing.palette);
        assert_eq!(found.pop(), Some((ALL, [0; 3])));
        found.sort_unstable();
        let mut expected: Vec<(&str, [u8; 3])> = inks.iter().map(|ink| (ink.name.as_str(), ink.rgb)).collect();
        expected.sort_unstable();
        assert_eq!(found, expected);
        let plain = drawing.plate(0).unwrap();
        let black = Drawing { palette: Palette::default(), ..plain };
        assert!(layers(&black, &[]).separations(&black.palette).is_empty());
        // Paper that is painted over ink is no plate.
        let layered = layers(&drawing, &[("style", "layered")]);
        assert!(layered.separations(&drawing.palette).iter().all(|(name, _)| *name != "paper"));
    }

    #[test]
    fn every_ink_that_is_drawn_has_a_plate() {
        let inks = ["black", "pink=#ff48b0"].map(|ink| NamedInk::parse(ink).unwrap());
        let palette = Palette::new(inks.to_vec(), [255; 3], false).unwrap();
        let names = |suffix: &str, settings: &[(&str, &str)]| -> Result<Vec<String>> {
            let writer = Format::of_suffix(suffix)?.writer(export(settings).check()?)?;
            Ok(writer.plates(&palette)?.into_iter().map(|plate| plate.name).collect())
        };
        assert_eq!(names("svg", &[]).unwrap(), ["black", "pink"]);
        assert_eq!(names("svg", &[("only", "paper,pink")]).unwrap(), ["pink", "paper"]);
        assert_eq!(names("png", &[("one_bit", "True")]).unwrap(), ["black", "pink"]);
        assert_eq!(names("json", &[("style", "layered")]).unwrap(), ["black", "pink"]);
        assert!(names("svg", &[("style", "layered")]).is_err());
        assert!(names("svg", &[("only", "green")]).is_err());
    }

    #[test]
    fn a_plate_holds_the_layers_of_its_ink() {
        let drawing = patches(3, 300, 2, false);
        let writer =
            Format::of_suffix("svg").unwrap().writer(export(&[("trap", "1px"), ("paper", "white")]).check().unwrap()).unwrap();
        let whole = String::from_utf8(writer.write(&drawing).unwrap()).unwrap();
        for plate in writer.plates(&drawing.palette).unwrap() {
            let text = String::from_utf8(plate.write(&drawing).unwrap()).unwrap();
            for group in text.split("<g ").skip(1).map(|group| group.trim_end().trim_end_matches("</svg>")) {
                assert!(group.starts_with(&format!("id=\"{}-", plate.name)) && whole.contains(group), "{}", plate.name);
            }
        }
        assert!(matches!(layers(&drawing, &[]).layers[0].areas[0].mark, Some(Mark::Region(_))));
    }
}
