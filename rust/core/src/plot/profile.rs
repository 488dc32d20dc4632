//! Profiles of machines. In: TOML; out: a [`Machine`] whose every value keeps its rule, or one sentence that says what is wrong.
//!
//! Every key is declared once, in [`PROFILE_KEYS`], which the documentation shows as a table.

use toml::{Table, Value as Toml};

use crate::base::{Error, Result, in_one_line, or_nearest};
use crate::options::{Typed, Value};
use crate::plot::commands::{PLACEHOLDERS, placeholders};
use crate::plot::machine::{Corner, Cornering, Limit, Machine, MachineFormat, Upward};

/// A key of a profile as it is declared.
#[derive(Debug, Clone, Copy)]
pub struct ProfileKey {
    /// Its name, in snake case.
    pub name: &'static str,
    /// The formats whose machines have it.
    pub formats: &'static [MachineFormat],
    /// What is meant without it; empty for one that must be there.
    pub default: &'static str,
    /// Which values it takes, as the end of a sentence that begins with "it must be".
    pub allowed: &'static str,
    /// What it says, in one sentence without its full stop.
    pub sentence: &'static str,
    /// Sets what it says, if the value is allowed.
    set: fn(&mut Machine, &Toml) -> Option<()>,
}

const ALL: &[MachineFormat] = &[MachineFormat::Svg, MachineFormat::Gcode, MachineFormat::Hpgl];
const GCODE: &[MachineFormat] = &[MachineFormat::Gcode];
const HPGL: &[MachineFormat] = &[MachineFormat::Hpgl];
const WITH_COMMANDS: &[MachineFormat] = &[MachineFormat::Gcode, MachineFormat::Hpgl];

const SPEED: &str = "a number between 0.001 and 10000 (mm/s)";
const SPEEDS: &str = "one or two numbers between 0.001 and 10000 (mm/s)";
const ACCELERATIONS: &str = "one or two numbers between 0.001 and 1000000 (mm/s²)";
const SECONDS: &str = "a number between 0 and 60 (seconds)";
const COMMANDS: &str = "text of one or more lines";

/// Every key.
pub const PROFILE_KEYS: &[ProfileKey] = &[
    ProfileKey {
        name: "name",
        formats: ALL,
        default: "",
        allowed: "text of one line",
        sentence: "What the machine is called in messages",
        set: |machine, value| {
            let name = text(value)?;
            (!name.trim().is_empty() && !name.contains(char::is_control)).then(|| machine.name = name)
        },
    },
    ProfileKey {
        name: "format",
        formats: ALL,
        default: "",
        allowed: "\"svg\", \"gcode\" or \"hpgl\"",
        sentence: "Which files it reads",
        set: |machine, value| word(value).map(|format| machine.format = format),
    },
    ProfileKey {
        name: "area",
        formats: ALL,
        default: "",
        allowed: "two numbers between 1 and 100000 (mm)",
        sentence: "Width and height that it reaches",
        set: |machine, value| pair(value, |v| (1.0..=1e5).contains(&v)).map(|area| machine.area = area),
    },
    ProfileKey {
        name: "origin",
        formats: ALL,
        default: "\"bottom-left\", of SVG \"top-left\"",
        allowed: "\"top-left\", \"top-right\", \"bottom-left\", \"bottom-right\" or \"center\"",
        sentence: "Where on the sheet its zero lies, and so from where it reaches into the sheet",
        set: |machine, value| word(value).map(|origin| machine.origin = origin),
    },
    ProfileKey {
        name: "offset",
        formats: ALL,
        default: "[0, 0]",
        allowed: "two numbers between -1000 and 1000 (mm)",
        sentence: "How far inside that corner of the sheet its zero lies; a drawing without a page lies at zero itself",
        set: |machine, value| pair(value, |v| (-1000.0..=1000.0).contains(&v)).map(|offset| machine.offset = offset),
    },
    ProfileKey {
        name: "y",
        formats: ALL,
        default: "\"up\", of SVG \"down\"",
        allowed: "\"up\" or \"down\"",
        sentence: "Where y grows to on the sheet; x grows to the right",
        set: |machine, value| word(value).map(|y| machine.y = y),
    },
    ProfileKey {
        name: "draw_speed",
        formats: ALL,
        default: "",
        allowed: SPEED,
        sentence: "How fast it draws, along the path; the F of G-code is 60 times that",
        set: |machine, value| speed(value).map(|speed| machine.draw_speed = speed),
    },
    ProfileKey {
        name: "travel_speed",
        formats: ALL,
        default: "",
        allowed: SPEEDS,
        sentence: "How fast it moves with the pen up: one number along the path, two of the x and the y axis, each by itself (GRBL's $110 and $111 / 60)",
        set: |machine, value| limit(value, is_speed).map(|limit| machine.travel_speed = limit),
    },
    ProfileKey {
        name: "acceleration",
        formats: ALL,
        default: "",
        allowed: ACCELERATIONS,
        sentence: "How fast speed grows and falls: one number along the path, two of the axes (GRBL's $120 and $121)",
        set: |machine, value| {
            let limit = limit(value, is_acceleration)?;
            (machine.acceleration, machine.travel_acceleration) = (limit, limit);
            Some(())
        },
    },
    ProfileKey {
        name: "travel_acceleration",
        formats: ALL,
        default: "that of acceleration",
        allowed: ACCELERATIONS,
        sentence: "The same with the pen up",
        set: |machine, value| limit(value, is_acceleration).map(|limit| machine.travel_acceleration = limit),
    },
    ProfileKey {
        name: "junction_deviation",
        formats: ALL,
        default: "0.01",
        allowed: "a number between 0 and 10 (mm)",
        sentence: "How far beside a corner it may pass, which says how fast it is there (GRBL's $11); with 0 it stops at every corner",
        set: |machine, value| number(value, |v| (0.0..=10.0).contains(&v)).map(|v| machine.junction_deviation = v),
    },
    ProfileKey {
        name: "cornering",
        formats: ALL,
        default: "\"cautious\"",
        allowed: "\"cautious\" or \"grbl\"",
        sentence: "By which rule: that of gcode-simulator (cautious), or of GRBL's planner itself, which takes curves faster (grbl)",
        set: |machine, value| word(value).map(|cornering| machine.cornering = cornering),
    },
    ProfileKey {
        name: "pen_down_seconds",
        formats: ALL,
        default: "0",
        allowed: SECONDS,
        sentence: "How long lowering the pen takes",
        set: |machine, value| seconds(value).map(|seconds| machine.pen_down_seconds = seconds),
    },
    ProfileKey {
        name: "pen_up_seconds",
        formats: ALL,
        default: "0",
        allowed: SECONDS,
        sentence: "How long lifting the pen takes",
        set: |machine, value| seconds(value).map(|seconds| machine.pen_up_seconds = seconds),
    },
    ProfileKey {
        name: "press_seconds",
        formats: ALL,
        default: "0",
        allowed: SECONDS,
        sentence: "How long the pen stays down for a press, or the laser on for a pulse",
        set: |machine, value| seconds(value).map(|seconds| machine.press_seconds = seconds),
    },
    ProfileKey {
        name: "header",
        formats: WITH_COMMANDS,
        default: "\"G21\\nG90\", of HP-GL \"IN;\"",
        allowed: COMMANDS,
        sentence: "Commands before everything else: mm, absolute coordinates, the pen up",
        set: |machine, value| text(value).map(|commands| machine.header = commands),
    },
    ProfileKey {
        name: "footer",
        formats: WITH_COMMANDS,
        default: "\"\"",
        allowed: COMMANDS,
        sentence: "Commands after everything else, when the pen is up and at zero again",
        set: |machine, value| text(value).map(|commands| machine.footer = commands),
    },
    ProfileKey {
        name: "pen_down",
        formats: GCODE,
        default: "",
        allowed: COMMANDS,
        sentence: "Commands that lower the pen or switch the laser on",
        set: |machine, value| text(value).map(|commands| machine.pen_down = commands),
    },
    ProfileKey {
        name: "pen_up",
        formats: GCODE,
        default: "",
        allowed: COMMANDS,
        sentence: "Commands that lift the pen or switch the laser off",
        set: |machine, value| text(value).map(|commands| machine.pen_up = commands),
    },
    ProfileKey {
        name: "press",
        formats: GCODE,
        default: "\"G4 P{seconds}\"",
        allowed: COMMANDS,
        sentence: "Commands between these two for a press, where press_seconds is above 0",
        set: |machine, value| text(value).map(|commands| machine.press = commands),
    },
    ProfileKey {
        name: "pause",
        formats: ALL,
        default: "\"M0\", of SVG and HP-GL \"\"",
        allowed: COMMANDS,
        sentence: "Commands that wait until somebody has changed or filled the pen; in SVG what the name of a layer begins with. Empty if it cannot wait",
        set: |machine, value| text(value).map(|commands| machine.pause = commands),
    },
    ProfileKey {
        name: "power",
        formats: GCODE,
        default: "0",
        allowed: "a number between 0 and 1000000",
        sentence: "What {power} stands for: the S of a laser",
        set: |machine, value| number(value, |v| (0.0..=1e6).contains(&v)).map(|power| machine.power = power),
    },
    ProfileKey {
        name: "decimals",
        formats: GCODE,
        default: "3",
        allowed: "a whole number between 0 and 6",
        sentence: "Decimals of a coordinate",
        set: |machine, value| whole(value, 0..=6).map(|decimals| machine.decimals = decimals),
    },
    ProfileKey {
        name: "units_per_mm",
        formats: HPGL,
        default: "40",
        allowed: "a number between 1 and 10000",
        sentence: "Plotter units to the mm",
        set: |machine, value| number(value, |v| (1.0..=1e4).contains(&v)).map(|units| machine.units_per_mm = units),
    },
    ProfileKey {
        name: "pens",
        formats: HPGL,
        default: "[1, 2]",
        allowed: "two whole numbers between 1 and 99",
        sentence: "Where the black and the white pen are in the carousel",
        set: |machine, value| {
            let [black, white] = value.as_array()?.as_slice() else { return None };
            machine.pens = [whole(black, 1..=99)?, whole(white, 1..=99)?];
            Some(())
        },
    },
];

/// A profile that comes with the program.
#[derive(Debug, Clone, Copy)]
pub struct ShippedProfile {
    /// What it is asked for by.
    pub name: &'static str,
    /// What machine that is, in a few words.
    pub description: &'static str,
    /// The profile as TOML, to be changed for a machine of one's own.
    pub toml: &'static str,
}

impl Machine {
    /// The profiles that come with the program.
    pub const SHIPPED: &'static [ShippedProfile] = &[
        ShippedProfile {
            name: "axidraw",
            description: "AxiDraw V3 or SE/A4, which plots SVG by its own software",
            toml: include_str!("profiles/axidraw.toml"),
        },
        ShippedProfile {
            name: "grbl",
            description: "pen plotter of A4 with GRBL, whose servo lifts the pen",
            toml: include_str!("profiles/grbl.toml"),
        },
        ShippedProfile {
            name: "grbl-laser",
            description: "diode laser of 400 x 400 mm with GRBL in its laser mode",
            toml: include_str!("profiles/grbl-laser.toml"),
        },
        ShippedProfile { name: "hp7475a", description: "HP 7475A with A4 paper", toml: include_str!("profiles/hp7475a.toml") },
        ShippedProfile {
            name: "hp7475a-a3",
            description: "HP 7475A with A3 paper",
            toml: include_str!("profiles/hp7475a-a3.toml"),
        },
    ];

    /// The machine of a profile that comes with the program.
    ///
    /// # Errors
    /// [`Error::Option`] that lists the names.
    pub fn shipped(name: &str) -> Result<Self> {
        let Some(profile) = Self::SHIPPED.iter().find(|profile| profile.name == name) else {
            let names: Vec<&str> = Self::SHIPPED.iter().map(|profile| profile.name).collect();
            let (last, rest) = names.split_last().expect("there are profiles");
            let allowed = format!("{} or {last}", rest.join(", "));
            return Err(Error::option("machine", name, or_nearest(&allowed, name, names, str::to_owned)));
        };
        Self::parse(profile.toml)
    }

    /// Reads a profile.
    ///
    /// # Errors
    /// [`Error::Option`] for a value that is not allowed; [`Error::Input`] for what is no TOML, and for keys that are missing, unknown
    /// or of other machines.
    pub fn parse(profile: &str) -> Result<Self> {
        let table: Table = profile.parse().map_err(|error| not_toml(profile, &error))?;
        if let Some(name) = table.keys().find(|name| key(name).is_none()) {
            let sentence = format!("there is no key {} in the profile of a machine", in_one_line(name));
            return Err(Error::Input(or_nearest(&sentence, name, PROFILE_KEYS.iter().map(|key| key.name), str::to_owned)));
        }
        // What else must be there, and what is meant without it, is for the format to say.
        let mut machine = Self::of_format(MachineFormat::default());
        let format = match (key("format"), table.get("format")) {
            (Some(key), Some(value)) => key.give(&mut machine, value).map(|()| Some(machine.format))?,
            _ => None,
        };
        machine = Self::of_format(machine.format);
        let is_of_format = |key: &ProfileKey| match format {
            Some(format) => key.formats.contains(&format),
            None => key.formats.len() == ALL.len(),
        };
        let is_missing = |key: &&ProfileKey| key.default.is_empty() && is_of_format(key) && !table.contains_key(key.name);
        let missing: Vec<&str> = PROFILE_KEYS.iter().filter(is_missing).map(|key| key.name).collect();
        if let Some((last, rest)) = missing.split_last() {
            let list = if rest.is_empty() { (*last).to_owned() } else { format!("{} and {last}", rest.join(", ")) };
            return Err(Error::Input(format!("the profile of the machine lacks {list}")));
        }
        // In the order of the declarations: a key may set what one after it changes.
        for key in PROFILE_KEYS {
            let Some(value) = table.get(key.name) else { continue };
            if !is_of_format(key) {
                let formats: Vec<&str> = key.formats.iter().map(|format| format.name()).collect();
                let (formats, own) = (formats.join(" and "), machine.format.name());
                return Err(Error::Input(format!("{} is a key of machines for {formats}, but this one is for {own}", key.name)));
            }
            key.give(&mut machine, value)?;
        }
        machine.check_commands()?;
        Ok(machine)
    }

    /// What is meant by a profile that says no more than its format; speeds and the area are for the profile to say.
    fn of_format(format: MachineFormat) -> Self {
        let of = |svg: &str, gcode: &str, hpgl: &str| match format {
            MachineFormat::Svg => svg.to_owned(),
            MachineFormat::Gcode => gcode.to_owned(),
            MachineFormat::Hpgl => hpgl.to_owned(),
        };
        let is_svg = format == MachineFormat::Svg;
        Self {
            name: String::new(),
            format,
            area: [1.0; 2],
            origin: if is_svg { Corner::TopLeft } else { Corner::BottomLeft },
            offset: [0.0; 2],
            y: if is_svg { Upward::Down } else { Upward::Up },
            draw_speed: 1.0,
            travel_speed: Limit::Path(1.0),
            acceleration: Limit::Path(1.0),
            travel_acceleration: Limit::Path(1.0),
            junction_deviation: 0.01,
            cornering: Cornering::Cautious,
            pen_down_seconds: 0.0,
            pen_up_seconds: 0.0,
            press_seconds: 0.0,
            header: of("", "G21\nG90", "IN;"),
            footer: String::new(),
            pen_down: String::new(),
            pen_up: String::new(),
            press: of("", "G4 P{seconds}", ""),
            pause: of("", "M0", ""),
            power: 0.0,
            decimals: 3,
            units_per_mm: 40.0,
            pens: [1, 2],
        }
    }

    /// That commands are what machines read, and have no placeholder that stands for nothing.
    fn check_commands(&self) -> Result<()> {
        let commands = [
            ("header", &self.header),
            ("footer", &self.footer),
            ("pen_down", &self.pen_down),
            ("pen_up", &self.pen_up),
            ("press", &self.press),
            ("pause", &self.pause),
        ];
        for (name, text) in commands {
            let is_read = |c: char| c.is_ascii() && (!c.is_control() || matches!(c, '\n' | '\r' | '\t'));
            if let Some(other) = text.chars().find(|c| !is_read(*c)) {
                return Err(Error::Input(format!(
                    "{name} has the character {}, but commands are plain ASCII",
                    other.escape_default()
                )));
            }
            if let Some(unknown) = placeholders(text).find(|word| !PLACEHOLDERS.contains(word)) {
                let sentence = format!("{name} has {{{}}}, which stands for nothing", in_one_line(unknown));
                return Err(Error::Input(or_nearest(&sentence, unknown, PLACEHOLDERS.iter().copied(), |word| {
                    format!("{{{word}}}")
                })));
            }
        }
        Ok(())
    }
}

impl ProfileKey {
    /// Gives a machine the value.
    ///
    /// # Errors
    /// [`Error::Option`] if it is not allowed.
    fn give(&self, machine: &mut Machine, value: &Toml) -> Result<()> {
        (self.set)(machine, value).ok_or_else(|| {
            let words = self.allowed.split('"').skip(1).step_by(2);
            let allowed = match value {
                Toml::String(given) => or_nearest(self.allowed, given, words, |word| format!("\"{word}\"")),
                _ => self.allowed.to_owned(),
            };
            Error::option(self.name, shown(value), allowed)
        })
    }
}

fn key(name: &str) -> Option<&'static ProfileKey> {
    PROFILE_KEYS.iter().find(|key| key.name == name)
}

/// What is no TOML, with its line.
fn not_toml(profile: &str, error: &toml::de::Error) -> Error {
    // Where the file ends too soon, the place is behind its end.
    let at = error.span().map_or(0, |span| span.start.min(profile.len()));
    let line = 1 + profile.as_bytes()[..at].iter().filter(|byte| **byte == b'\n').count();
    let message = error.message().lines().map(str::trim).collect::<Vec<_>>().join(", ");
    Error::Input(format!("line {line} of the machine's profile is no TOML: {}", in_one_line(&message)))
}

/// The most letters of a value that a message shows.
const MOST_SHOWN: usize = 60;

/// A value as a message shows it.
fn shown(value: &Toml) -> String {
    let text = match value {
        Toml::String(text) => format!("\"{text}\""),
        Toml::Integer(number) => number.to_string(),
        Toml::Float(number) => number.to_string(),
        Toml::Boolean(is_on) => is_on.to_string(),
        Toml::Datetime(time) => time.to_string(),
        Toml::Array(values) => format!("[{}]", values.iter().take(MOST_SHOWN).map(shown).collect::<Vec<_>>().join(", ")),
        Toml::Table(_) => "a table".to_owned(),
    };
    if text.chars().count() <= MOST_SHOWN { text } else { text.chars().take(MOST_SHOWN).chain("...".chars()).collect() }
}

fn text(value: &Toml) -> Option<String> {
    value.as_str().map(str::to_owned)
}

fn word<T: Typed>(value: &Toml) -> Option<T> {
    T::read(&Value::Word(text(value)?))
}

fn number(value: &Toml, is_allowed: impl Fn(f64) -> bool) -> Option<f64> {
    let number = match value {
        // A larger one than this holds is beyond every range.
        Toml::Integer(number) => *number as f64,
        Toml::Float(number) => *number,
        _ => return None,
    };
    is_allowed(number).then_some(number)
}

fn whole(value: &Toml, range: std::ops::RangeInclusive<u32>) -> Option<u32> {
    let number = u32::try_from(value.as_integer()?).ok()?;
    range.contains(&number).then_some(number)
}

fn pair(value: &Toml, is_allowed: impl Fn(f64) -> bool) -> Option<[f64; 2]> {
    let [first, second] = value.as_array()?.as_slice() else { return None };
    Some([number(first, &is_allowed)?, number(second, &is_allowed)?])
}

fn limit(value: &Toml, is_allowed: fn(f64) -> bool) -> Option<Limit> {
    number(value, is_allowed).map(Limit::Path).or_else(|| pair(value, is_allowed).map(Limit::Axes))
}

fn is_speed(value: f64) -> bool {
    (1e-3..=1e4).contains(&value)
}

fn is_acceleration(value: f64) -> bool {
    (1e-3..=1e6).contains(&value)
}

fn speed(value: &Toml) -> Option<f64> {
    number(value, is_speed)
}

fn seconds(value: &Toml) -> Option<f64> {
    number(value, |v| (0.0..=60.0).contains(&v))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A profile that lacks nothing.
    const LEAST: &str =
        "name = \"Arm\"\nformat = \"svg\"\narea = [300, 200]\ndraw_speed = 50\ntravel_speed = 100\nacceleration = 500\n";

    fn message(profile: &str) -> String {
        let message = Machine::parse(profile).unwrap_err().to_string();
        assert!(!message.is_empty() && !message.contains('\n'), "{message}");
        message
    }

    fn with(line: &str) -> String {
        let name = line.split('=').next().unwrap_or("").trim();
        let kept = LEAST.lines().filter(|other| other.split('=').next().unwrap_or("").trim() != name);
        kept.chain([line]).collect::<Vec<_>>().join("\n")
    }

    #[test]
    fn shipped_profiles_are_sound_and_found_by_name() {
        for profile in Machine::SHIPPED {
            let machine = Machine::shipped(profile.name).unwrap();
            assert!(profile.toml.starts_with('#'), "{} says where its figures are from", profile.name);
            assert!(machine.area.iter().all(|side| *side >= 150.0) && machine.draw_speed <= 400.0);
            assert!(machine.draw_speed <= machine.travel_speed.least());
        }
        assert_eq!(Machine::shipped("grbl-laser").unwrap().power, 300.0);
        let error = |name: &str| Machine::shipped(name).unwrap_err().to_string();
        assert_eq!(
            error("axidrw"),
            "machine is axidrw, but it must be axidraw, grbl, grbl-laser, hp7475a or hp7475a-a3; did you mean axidraw?"
        );
        assert!(error("printer").ends_with("or hp7475a-a3"));
    }

    #[test]
    fn what_is_not_said_is_as_the_format_has_it() {
        let svg = Machine::parse(LEAST).unwrap();
        assert_eq!((svg.origin, svg.y, svg.pause.as_str()), (Corner::TopLeft, Upward::Down, ""));
        assert_eq!((svg.travel_acceleration, svg.cornering), (Limit::Path(500.0), Cornering::Cautious));
        let gcode = with("format = \"gcode\"") + "\npen_down = \"M3\"\npen_up = \"M5\"";
        let gcode = Machine::parse(&gcode).unwrap();
        assert_eq!((gcode.origin, gcode.y, gcode.pause.as_str(), gcode.decimals), (Corner::BottomLeft, Upward::Up, "M0", 3));
        let hpgl = Machine::parse(&with("format = \"hpgl\"")).unwrap();
        assert_eq!((hpgl.header.as_str(), hpgl.units_per_mm, hpgl.pens), ("IN;", 40.0, [1, 2]));
        // What is said of travel alone holds, in whatever order.
        let apart = Machine::parse(&format!("travel_acceleration = [1, 2]\n{LEAST}")).unwrap();
        assert_eq!((apart.acceleration, apart.travel_acceleration), (Limit::Path(500.0), Limit::Axes([1.0, 2.0])));
    }

    #[test]
    fn every_key_is_read_and_checked() {
        for key in PROFILE_KEYS {
            let format = key.formats.last().copied().unwrap_or_default();
            let mut machine = Machine::of_format(format);
            for bad in
                [Toml::Boolean(true), Toml::Array(vec![]), Toml::Table(Table::new()), Toml::Float(f64::NAN), Toml::Integer(-2000)]
            {
                assert!((key.set)(&mut machine, &bad).is_none(), "{} takes {}", key.name, shown(&bad));
                let message = key.give(&mut machine, &bad).unwrap_err().to_string();
                assert_eq!(message, format!("{} is {}, but it must be {}", key.name, shown(&bad), key.allowed));
            }
            assert_eq!(machine, Machine::of_format(format), "{} is set by what it does not take", key.name);
            let good = [
                Toml::String("M8".into()),
                Toml::String(key.allowed.split('"').nth(1).unwrap_or("").into()),
                Toml::Integer(2),
                Toml::Array(vec![Toml::Integer(2), Toml::Integer(3)]),
            ];
            let taken = good.iter().filter(|good| (key.set)(&mut machine, good).is_some()).count();
            assert!(taken >= 1, "{} takes nothing", key.name);
            assert!(key.default.is_empty() || key.default.contains(|c: char| c.is_alphanumeric() || c == '"'));
        }
    }

    #[test]
    fn the_documentation_has_every_key() {
        let row = |key: &ProfileKey| {
            let formats: Vec<&str> = key.formats.iter().map(|format| format.name()).collect();
            let formats = if formats.len() == ALL.len() { "all".to_owned() } else { formats.join(", ") };
            let default = if key.default.is_empty() { "it must be there" } else { key.default };
            format!("| `{}` | {formats} | {} | {default} | {} |\n", key.name, key.allowed, key.sentence)
        };
        let head = "| Key | Machines | Value | Without it | Meaning |\n|---|---|---|---|---|\n";
        let expected = format!("{head}{}", PROFILE_KEYS.iter().map(row).collect::<String>());
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/howto/plotter.md");
        let page = std::fs::read_to_string(path).unwrap();
        let (_, rest) = page.split_once("<!-- The keys begin").unwrap();
        let (_, rest) = rest.split_once("-->\n").unwrap();
        let (table, _) = rest.split_once("<!-- The keys end").unwrap();
        assert!(table.trim() == expected.trim(), "docs/howto/plotter.md should have this table:\n\n{expected}");
    }

    #[test]
    fn mistakes_are_told_in_one_sentence() {
        let lacking = "the profile of the machine lacks name, format, area, draw_speed, travel_speed and acceleration";
        assert_eq!([message(""), message("# nothing\n")], [lacking, lacking]);
        assert_eq!(
            message(
                "origin = \"center\"\nname = \"x\"\nformat = \"gcode\"\narea = [1, 1]\ndraw_speed = 1\ntravel_speed = 1\n\
                            acceleration = 1"
            ),
            "the profile of the machine lacks pen_down and pen_up"
        );
        for (line, expected) in [
            ("draw_sped = 50", "there is no key draw_sped in the profile of a machine; did you mean draw_speed?"),
            ("wings = 2", "there is no key wings in the profile of a machine"),
            ("\"a\\u0007b\" = 2", "there is no key a\\u{7}b in the profile of a machine"),
            ("draw_speed = -3", "draw_speed is -3, but it must be a number between 0.001 and 10000 (mm/s)"),
            ("draw_speed = 0", "draw_speed is 0, but it must be a number between 0.001 and 10000 (mm/s)"),
            ("draw_speed = inf", "draw_speed is inf, but it must be a number between 0.001 and 10000 (mm/s)"),
            ("draw_speed = \"fast\"", "draw_speed is \"fast\", but it must be a number between 0.001 and 10000 (mm/s)"),
            (
                "travel_speed = [1, 2, 3]",
                "travel_speed is [1, 2, 3], but it must be one or two numbers between 0.001 and 10000 (mm/s)",
            ),
            ("area = 300", "area is 300, but it must be two numbers between 1 and 100000 (mm)"),
            (
                "origin = \"top-lft\"",
                "origin is \"top-lft\", but it must be \"top-left\", \"top-right\", \"bottom-left\", \
              \"bottom-right\" or \"center\"; did you mean \"top-left\"?",
            ),
            ("name = \"two\\nlines\"", "name is \"two\\nlines\", but it must be text of one line"),
            ("units_per_mm = 40", "units_per_mm is a key of machines for hpgl, but this one is for svg"),
            ("header = \"IN;\"", "header is a key of machines for gcode and hpgl, but this one is for svg"),
            ("pause = \"größer\"", "pause has the character \\u{f6}, but commands are plain ASCII"),
            ("pause = \"{a\\nb}\"", "pause has {a\\nb}, which stands for nothing"),
            ("pause = \"{second}\"", "pause has {second}, which stands for nothing; did you mean {seconds}?"),
        ] {
            assert_eq!(message(&with(line)), expected, "{line}");
        }
        let long = message(&with(&format!("draw_speed = \"{}\"", "x".repeat(500))));
        assert!(long.len() < 160, "{long}");
    }

    proptest! {
        #[test]
        fn no_profile_panics(
            lines in prop::collection::vec((0..PROFILE_KEYS.len(), "[-+.\\[\\]{}\"0-9a-z,#=\\\\n \u{e9}]{0,12}"), 0..6),
            number in any::<f64>(),
            whole in any::<i64>(),
        ) {
            let given = lines.iter().map(|(key, value)| format!("{} = {value}", PROFILE_KEYS[*key].name));
            let numbers = PROFILE_KEYS.iter().flat_map(|key| [format!("{} = {number:?}", key.name), format!("{} = {whole}", key.name)]);
            for profile in given.clone().chain(numbers).map(|line| with(&line)).chain([given.collect::<Vec<_>>().join("\n")]) {
                if let Err(error) = Machine::parse(&profile) {
                    let message = error.to_string();
                    prop_assert!(!message.contains(char::is_control), "{message:?}");
                }
            }
        }
    }

    #[test]
    fn what_is_no_toml_is_told_with_its_line() {
        for (text, line) in [
            ("name = \"x\"\nformat", 2),
            ("G21\nG90\n", 1),
            ("\n\n<svg/>", 3),
            ("name = 1\nname = 2", 2),
            ("a = [1,\n2,\n", 2),
            ("\u{0}\u{1}PNG", 1),
            ("name = \"open", 1),
        ] {
            let message = message(text);
            assert!(message.starts_with(&format!("line {line} of the machine's profile is no TOML: ")), "{message}");
            assert!(message.is_ascii() || !message.contains(char::is_control));
        }
    }
}
