//! The limits of a process: what is the narrowest that it can make. In: values by name, or a process; out: [`Rules`] whose every limit
//! is in its range.
//!
//! Every rule is declared once, in [`RULES`]: the command line has a flag of each, and Python's `Rules` an argument. All lengths are
//! widths and diameters on paper, in mm.

use serde::Serialize;

use crate::base::{Checked, Error, Result, in_one_line, or_nearest};
use crate::files::{Length, length as read_length};
use crate::options::{Typed, Value, words};

words! {
    /// What is done about islands: white that black surrounds, which falls out when the black is cut away.
    Islands {
        /// They may be.
        Allow = "allow",
        /// They are reported and stay.
        Report = "report",
        /// Those smaller than the least area are filled, the others are joined to the frame.
        Bridge = "bridge",
    }
}

impl Serialize for Islands {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        match self.value() {
            Value::Word(word) => serializer.serialize_str(&word),
            _ => serializer.serialize_none(),
        }
    }
}

/// What a process can make. A limit that is `None` is no limit.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Rules {
    /// The narrowest black, in mm.
    pub min_feature: Option<f64>,
    /// The narrowest white, in mm.
    pub min_gap: Option<f64>,
    /// The least diameter of a dot of either ink, in mm. A dot is never allowed to be smaller than what is the narrowest of its ink.
    pub min_dot: Option<f64>,
    /// The smallest area of a region of either ink, in mm^2; dots in it count as its own. White that touches the frame is the sheet
    /// itself and of any size.
    pub min_area: Option<f64>,
    /// What is done about islands.
    pub islands: Islands,
}

/// Limits of length, in mm: a fiftieth of what lasers resolve, and more than any sheet's detail.
const LENGTHS: std::ops::RangeInclusive<f64> = 0.01..=1000.0;

/// Limits of area, in mm^2.
const AREAS: std::ops::RangeInclusive<f64> = 1e-4..=1e6;

/// What is read as a limit of length, and of area.
const LENGTH_ALLOWED: &str = "a length from 0.01mm to 1000mm with mm, cm, in, pt or px (px when there is no unit), such as 0.4mm";
const AREA_ALLOWED: &str =
    "an area from 0.0001mm2 to 1000000mm2 with mm2, cm2, in2, pt2 or px2 (px2 when there is no unit), such as 2mm2";

/// A rule as it is declared.
#[derive(Debug, Clone, Copy)]
pub struct ProcessRule {
    /// Its name, in snake case.
    pub name: &'static str,
    /// What its value is called in the help.
    pub value_name: &'static str,
    /// What it limits, in one sentence without its full stop.
    pub sentence: &'static str,
    /// Which values it takes, as the end of a sentence that begins with "it must be".
    pub allowed: &'static str,
    /// Sets the field if the value is of its type and in its range.
    set: fn(&mut Rules, &Value) -> Option<()>,
    /// As front ends see it: `None`, mm, mm^2, or a word.
    pub value: fn(&Rules) -> Value,
}

/// Every rule.
pub const RULES: &[ProcessRule] = &[
    ProcessRule {
        name: "min_feature",
        value_name: "LENGTH",
        sentence: "Narrowest black",
        allowed: LENGTH_ALLOWED,
        set: |rules, value| length(value).map(|mm| rules.min_feature = mm),
        value: |rules| number(rules.min_feature),
    },
    ProcessRule {
        name: "min_gap",
        value_name: "LENGTH",
        sentence: "Narrowest white between black",
        allowed: LENGTH_ALLOWED,
        set: |rules, value| length(value).map(|mm| rules.min_gap = mm),
        value: |rules| number(rules.min_gap),
    },
    ProcessRule {
        name: "min_dot",
        value_name: "LENGTH",
        sentence: "Least diameter of a dot",
        allowed: LENGTH_ALLOWED,
        set: |rules, value| length(value).map(|mm| rules.min_dot = mm),
        value: |rules| number(rules.min_dot),
    },
    ProcessRule {
        name: "min_area",
        value_name: "AREA",
        sentence: "Smallest area of a region, and of an island that gets a bridge",
        allowed: AREA_ALLOWED,
        set: |rules, value| area(value).map(|mm2| rules.min_area = mm2),
        value: |rules| number(rules.min_area),
    },
    ProcessRule {
        name: "islands",
        value_name: "ISLANDS",
        sentence: "White that black surrounds, which falls out of a stencil: allow, report or bridge it",
        allowed: "\"allow\", \"report\" or \"bridge\"",
        set: |rules, value| Islands::read(value).map(|islands| rules.islands = islands),
        value: |rules| rules.islands.value(),
    },
];

impl ProcessRule {
    /// The unit of its numbers.
    pub fn unit(&self) -> &'static str {
        if self.value_name == "AREA" { "mm2" } else { "mm" }
    }
}

fn number(limit: Option<f64>) -> Value {
    limit.map_or(Value::Absent, Value::Number)
}

/// A limit of length in mm, or none.
fn length(value: &Value) -> Option<Option<f64>> {
    if *value == Value::Absent {
        return Some(None);
    }
    let mm = rounded(read_length(value)?.mm());
    LENGTHS.contains(&mm).then_some(Some(mm))
}

/// A limit of area in mm^2, or none: a number with the square of a unit.
fn area(value: &Value) -> Option<Option<f64>> {
    let text = match value {
        Value::Absent => return Some(None),
        Value::Word(text) => text.trim().to_ascii_lowercase(),
        Value::Whole(number) => format!("{number}px2"),
        Value::Number(number) => format!("{number}px2"),
        _ => return None,
    };
    let unit = ["^2", "\u{b2}", "2"].iter().find_map(|square| {
        let before = text.strip_suffix(square)?;
        // The last digit of a number alone is no square.
        before.ends_with(|c: char| c.is_ascii_alphabetic()).then_some(before)
    });
    // A length of as many of the unit, and of one, tell the rest.
    let written = unit.or_else(|| text.ends_with(|c: char| c.is_ascii_digit()).then_some(&*text))?;
    let length: Length = written.parse().ok()?;
    let mm = Length { value: 1.0, ..length }.mm();
    let mm2 = rounded(length.value * mm * mm);
    AREAS.contains(&mm2).then_some(Some(mm2))
}

/// Without what conversions between units leave in the last digits.
fn rounded(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}

/// A process with its rules.
#[derive(Debug, Clone, Copy)]
pub struct Process {
    /// One lower-case word.
    pub name: &'static str,
    /// What it asks for, in one sentence without its full stop.
    pub sentence: &'static str,
    /// Its rules.
    pub rules: Rules,
}

/// All processes. Their figures are what shops and makers of machines ask for; any of them can be changed.
pub const PROCESSES: &[Process] = &[
    // Spots of common CO2 and diode lasers are 0.1 to 0.2 mm wide; NBM (Graphics Pro, November 2020) engraves at 300 to 400 dpi and
    // warns of hairlines.
    Process {
        name: "laser",
        sentence: "Engraving by a laser: lines and gaps of a beam or more",
        rules: of([0.2, 0.2, 0.25, 0.05], Islands::Allow),
    },
    // Hexio and other sign makers: no piece below 2 x 2 mm, since it neither sticks nor can be weeded; lines from 1 mm.
    Process {
        name: "vinyl",
        sentence: "Cut from adhesive film: pieces that can be weeded and stick",
        rules: of([1.0, 0.8, 2.0, 4.0], Islands::Allow),
    },
    // Bridges of hand-cut and laser-cut stencils in film of 0.2 mm: from 1/32 inch; openings that paint gets through: half a mm.
    Process {
        name: "stencil",
        sentence: "Black is cut away and the sheet hangs together: islands get bridges",
        rules: of([0.5, 0.8, 1.0, 2.0], Islands::Bridge),
    },
    // FastEditor's collected minima: 1 pt for screens, more for reversed lines; Transfer Express: 0.012 inch for ink.
    Process {
        name: "screen-print",
        sentence: "Ink through a screen: lines of a point, and wider gaps, since ink spreads",
        rules: of([0.35, 0.5, 0.5, 0.2], Islands::Allow),
    },
    // The finest V gouges cut 0.5 to 1 mm; a ridge of lino narrower than half a mm crumbles.
    Process {
        name: "lino",
        sentence: "Cut by hand with gouges: ridges that hold, and gaps as wide as the smallest gouge",
        rules: of([0.5, 0.8, 1.0, 1.0], Islands::Allow),
    },
    // A pen of 0.3 mm.
    Process {
        name: "pen",
        sentence: "Drawn by a pen of 0.3 mm: no line, gap or dot narrower than it",
        rules: of([0.3, 0.3, 0.3, 0.1], Islands::Allow),
    },
];

const fn of([feature, gap, dot, area]: [f64; 4], islands: Islands) -> Rules {
    Rules { min_feature: Some(feature), min_gap: Some(gap), min_dot: Some(dot), min_area: Some(area), islands }
}

impl Rules {
    /// The rules of a process, by its name.
    ///
    /// # Errors
    /// [`Error::Option`] with the names that there are.
    pub fn of_process(name: &str) -> Result<Self> {
        let found = PROCESSES.iter().find(|process| process.name == name).map(|process| process.rules);
        found.ok_or_else(|| {
            let names: Vec<&str> = PROCESSES.iter().map(|process| process.name).collect();
            let (last, rest) = names.split_last().expect("there are processes");
            let allowed = format!("{} or {last}", rest.join(", "));
            Error::option("process", name, or_nearest(&allowed, name, names.iter().copied(), str::to_owned))
        })
    }

    /// Gives a rule a value: a length with its unit, an area, a word, or none for no limit.
    ///
    /// # Errors
    /// [`Error::Option`] if the value is of another type or out of its range, [`Error::Input`] if there is no such rule.
    pub fn set(&mut self, name: &str, value: &Value) -> Result<()> {
        let rule = RULES.iter().find(|rule| rule.name == name);
        let rule = rule.ok_or_else(|| {
            let names = RULES.iter().map(|rule| rule.name);
            Error::Input(or_nearest(&format!("there is no rule {}", in_one_line(name)), name, names, str::to_owned))
        })?;
        (rule.set)(self, value).ok_or_else(|| {
            let words = rule.allowed.split('"').skip(1).step_by(2);
            Error::option(name, value, value.or_nearest(rule.allowed, words))
        })
    }

    /// Checks that there is a limit at all, and that every one is in its range.
    ///
    /// # Errors
    /// [`Error::Option`] for the first that is not, [`Error::Input`] if there is none.
    pub fn check(self) -> Result<Checked<Self>> {
        let lengths = [("min_feature", self.min_feature), ("min_gap", self.min_gap), ("min_dot", self.min_dot)];
        for (name, limit) in lengths {
            if let Some(limit) = limit.filter(|limit| !LENGTHS.contains(limit)) {
                return Err(Error::option(name, format!("{limit}mm"), LENGTH_ALLOWED));
            }
        }
        if let Some(limit) = self.min_area.filter(|limit| !AREAS.contains(limit)) {
            return Err(Error::option("min_area", format!("{limit}mm2"), AREA_ALLOWED));
        }
        if self == Self::default() {
            return Err(Error::Input(
                "the rules hold no limit: give a process, or one of min_feature, min_gap, min_dot, min_area and islands".into(),
            ));
        }
        Ok(Checked::of(self))
    }

    /// The finest limit of length, in mm; infinite without one.
    pub(super) fn finest(&self) -> f64 {
        [self.min_feature, self.min_gap, self.min_dot].into_iter().flatten().fold(f64::INFINITY, f64::min)
    }

    /// The least diameter of a dot of an ink, in mm; 0 without one.
    pub(super) fn least_dot(&self, ink: crate::base::Ink) -> f64 {
        let own = self.narrowest(ink);
        own.max(self.min_dot.unwrap_or(0.0))
    }

    /// The narrowest that an ink may be, in mm; 0 without a limit.
    pub(super) fn narrowest(&self, ink: crate::base::Ink) -> f64 {
        let limit = match ink {
            crate::base::Ink::BLACK => self.min_feature,
            _ => self.min_gap,
        };
        limit.unwrap_or(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn word(text: &str) -> Value {
        Value::Word(text.to_owned())
    }

    #[test]
    fn rules_are_set_by_name() {
        let mut rules = Rules::default();
        for (name, value) in [
            ("min_feature", word("0.4mm")),
            ("min_gap", word("1pt")),
            ("min_dot", word("0.05 cm")),
            ("min_area", word("2mm2")),
            ("islands", word("bridge")),
        ] {
            let before = rules;
            rules.set(name, &value).unwrap();
            assert_ne!(rules, before, "{name}");
        }
        let expected = Rules {
            min_feature: Some(0.4),
            min_gap: Some(0.352_777_778),
            min_dot: Some(0.5),
            min_area: Some(2.0),
            islands: Islands::Bridge,
        };
        assert_eq!(rules, expected);
        rules.set("min_gap", &Value::Absent).unwrap();
        assert_eq!(rules.min_gap, None);
    }

    #[test]
    fn areas_are_read_in_every_unit() {
        let read = |text: &str| area(&word(text)).flatten();
        for (text, mm2) in [
            ("2mm2", 2.0),
            ("2 mm^2", 2.0),
            ("0.02cm\u{b2}", 2.0),
            ("0.01in2", 6.4516),
            ("100", 7.000_434_028),
            ("100px2", 7.000_434_028),
        ] {
            assert_eq!(read(text), Some(mm2), "{text}");
        }
        for text in ["", "2mm", "mm2", "-2mm2", "nanmm2", "0mm2", "2", "2parsec2", "1e9mm2"] {
            // A number alone is px2: 2 of them are large enough.
            assert_eq!(read(text).is_some(), text == "2", "{text}");
        }
    }

    #[test]
    fn what_is_wrong_is_told_by_its_name() {
        let message = |name: &str, value: &Value| Rules::default().set(name, value).unwrap_err().to_string();
        for wrong in
            [word("0mm"), word("-1mm"), word("nan"), Value::Number(f64::NAN), Value::Number(-1.0), word("2km"), word("1100mm")]
        {
            assert_eq!(message("min_gap", &wrong), format!("min_gap is {wrong}, but it must be {LENGTH_ALLOWED}"));
        }
        assert!(message("min_area", &word("2mm")).starts_with("min_area is \"2mm\", but it must be an area"));
        assert_eq!(
            message("islands", &word("brigde")),
            "islands is \"brigde\", but it must be \"allow\", \"report\" or \"bridge\"; did you mean \"bridge\"?"
        );
        assert_eq!(message("min_gab", &Value::Absent), "there is no rule min_gab; did you mean min_gap?");
        assert!(Rules::default().check().unwrap_err().to_string().starts_with("the rules hold no limit"));
        let told = Rules { min_dot: Some(0.0), ..Rules::default() }.check().unwrap_err().to_string();
        assert!(told.starts_with("min_dot is 0mm, but it must be a length"), "{told}");
        let told = Rules::of_process("stensil").unwrap_err().to_string();
        assert_eq!(
            told,
            "process is stensil, but it must be laser, vinyl, stencil, screen-print, lino or pen; did you mean stencil?"
        );
    }

    #[test]
    fn processes_keep_their_own_rules() {
        for process in PROCESSES {
            let rules = Rules::of_process(process.name).unwrap().check().unwrap();
            assert_eq!(*rules, process.rules);
            assert!(rules.min_dot >= rules.min_feature, "{}", process.name);
        }
    }
}
