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
        (!palette.is_black_and_white() && name != palette.paper_name()).then_some(name)
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
                let areas = drawing.trap(*ink, &order[place + 1..], distance, true)?;
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
        let plate = |ink: usize| {
            let name = palette.inks().get(ink).map_or(palette.paper_name(), |ink| &ink.name).to_owned();
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
