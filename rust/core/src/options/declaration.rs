//! What a declaration says of an option, and the macro that makes the structs and the table of them.

use super::value::{Rule, Value};

/// The heading under which an option stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Group {
    /// How many nodes there are, and where.
    Nodes,
    /// Labels and contours.
    Shapes,
    /// Dots.
    Stipples,
    /// The photo's tone before anything is done with it.
    Tones,
    /// Inks and paper.
    Inks,
    /// How the work is done.
    Work,
    /// The fields of [`super::Published`].
    Method,
}

impl Group {
    /// All groups, in the order in which they are shown.
    pub const ALL: [Self; 7] = [Self::Nodes, Self::Shapes, Self::Stipples, Self::Tones, Self::Inks, Self::Work, Self::Method];

    /// The heading.
    pub fn title(self) -> &'static str {
        match self {
            Self::Nodes => "Nodes",
            Self::Shapes => "Shapes",
            Self::Stipples => "Stipples",
            Self::Tones => "Tone",
            Self::Inks => "Inks",
            Self::Work => "Work",
            Self::Method => "Published method",
        }
    }
}

/// Who turns an option.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Audience {
    /// Whoever draws.
    Everyday,
    /// Whoever wants to know exactly.
    Further,
}

/// A step of a drawing whose result a session keeps, in the order of the data flow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// The tone of the photo.
    Tone,
    /// The tone with its details emphasized.
    Emphasis,
    /// The importance on the canvas.
    Importance,
    /// The lattice, and which of its nodes are kept.
    FirstGraph,
    /// The sites and their triangulation.
    SecondGraph,
    /// Areas and tones of the nodes' cells.
    Cells,
    /// Labels, and so components too.
    Labels,
    /// Contours and dots.
    Outlines,
}

impl Stage {
    /// All stages.
    pub const ALL: [Self; 8] = [
        Self::Tone,
        Self::Emphasis,
        Self::Importance,
        Self::FirstGraph,
        Self::SecondGraph,
        Self::Cells,
        Self::Labels,
        Self::Outlines,
    ];

    /// In plain words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tone => "tone",
            Self::Emphasis => "emphasis",
            Self::Importance => "importance",
            Self::FirstGraph => "first graph",
            Self::SecondGraph => "second graph",
            Self::Cells => "cells",
            Self::Labels => "labels",
            Self::Outlines => "outlines",
        }
    }
}

/// What stands for an option that is absent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Absent {
    /// On the command line.
    pub word: &'static str,
    /// What the program then does.
    pub meaning: &'static str,
}

/// An option as it is declared, a field of `O`.
#[derive(Debug)]
pub struct DeclarationOf<O> {
    /// Its name, in snake case.
    pub name: &'static str,
    /// Which values it takes.
    pub rule: Rule,
    /// What its numbers count, in the plural; empty for plain numbers.
    pub unit: &'static str,
    /// Under which heading it stands.
    pub group: Group,
    /// Who turns it.
    pub audience: Audience,
    /// What it means to leave it out, if it can be.
    pub absent: Option<Absent>,
    /// The stages that use it.
    pub stages: &'static [Stage],
    /// What it does, as it stands in the declaration.
    pub(super) lines: &'static str,
    pub(super) matters: fn(&O, Stage) -> bool,
    pub(super) get: fn(&O) -> Value,
    /// Sets the field if the value is of its type.
    pub(super) set: fn(&mut O, &Value) -> bool,
    pub(super) copy: fn(&mut O, &O),
}

impl<O> DeclarationOf<O> {
    /// What it does.
    pub fn description(&self) -> String {
        let words: Vec<&str> = self.lines.split_whitespace().collect();
        words.join(" ")
    }

    /// The first sentence of what it does, without its full stop.
    pub fn sentence(&self) -> String {
        let description = self.description();
        description.split_once(". ").map_or(description.trim_end_matches('.'), |(first, _)| first).to_owned()
    }

    /// As messages name it: a field of [`super::Published`] with the name of its group before it.
    pub fn full_name(&self) -> String {
        if self.group == Group::Method { format!("{PUBLISHED}.{}", self.name) } else { self.name.to_owned() }
    }

    /// Its value.
    pub fn value(&self, options: &O) -> Value {
        (self.get)(options)
    }

    /// What it takes, with its unit, as the end of a sentence that begins with "it must be".
    pub fn allowed(&self) -> String {
        let allowed = self.rule.allowed();
        if self.unit.is_empty() { allowed } else { format!("{allowed} {}", self.unit) }
    }

    /// Whether a stage's own work depends on it, under these options.
    pub(crate) fn is_used(&self, stage: Stage, options: &O) -> bool {
        self.stages.contains(&stage) && (self.matters)(options, stage)
    }

    /// Takes it over from other options.
    pub(crate) fn copy(&self, to: &mut O, from: &O) {
        (self.copy)(to, from);
    }
}

/// The name of the field that holds [`super::Published`].
pub const PUBLISHED: &str = "published";

/// Makes the two structs and the table of declarations: see [`super::declared`] for how a declaration reads.
macro_rules! declare {
    (
        $(#[$about:meta])*
        $options:ident { $(
            $(#[doc = $line:literal])+
            $name:ident: $type:ty = $default:expr, $rule:expr, $unit:literal, $group:ident, $audience:ident, [$($stage:ident),*];
            $(absent $word:literal, $meaning:literal;)?
            $(when $matters:expr;)?
        )+ }
        $(#[$about_group:meta])*
        $published:ident { $(
            $(#[doc = $group_line:literal])+
            $group_name:ident: $group_type:ty = $ours:expr, $papers:expr, $group_rule:expr, $group_unit:literal, $group_group:ident,
                $group_audience:ident, [$($group_stage:ident),*];
            $(absent $group_word:literal, $group_meaning:literal;)?
            $(when $group_matters:expr;)?
        )+ }
    ) => {
        $(#[$about])*
        #[derive(Debug, Clone, PartialEq)]
        pub struct $options {
            $($(#[doc = $line])+ pub $name: $type,)+
            /// The parameters of the published method's graphs and diffusions.
            pub published: $published,
        }

        impl Default for $options {
            fn default() -> Self {
                Self { $($name: $default,)+ published: $published::ours() }
            }
        }

        $(#[$about_group])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct $published { $($(#[doc = $group_line])+ pub $group_name: $group_type,)+ }

        impl Default for $published {
            fn default() -> Self {
                Self { $($group_name: $papers,)+ }
            }
        }

        impl $published {
            /// What these parameters are in [`Options`] by default: ours.
            pub fn ours() -> Self {
                Self { $($group_name: $ours,)+ }
            }
        }

        /// Every option, in the order in which they are declared.
        pub const DECLARATIONS: &[$crate::options::declaration::DeclarationOf<$options>] = &[
            $($crate::options::declaration::entry!(
                [$name] $name, $rule, $unit, $group, $audience, [$($stage),*], [$($line),+], [$($word, $meaning)?], [$($matters)?]
            ),)+
            $($crate::options::declaration::entry!(
                [published.$group_name] $group_name, $group_rule, $group_unit, $group_group, $group_audience, [$($group_stage),*],
                [$($group_line),+], [$($group_word, $group_meaning)?], [$($group_matters)?]
            ),)+
        ];
    };
}

/// One line of the table: where the field is, its name, and what the declaration says of it.
macro_rules! entry {
    (
        [$($field:ident).+] $name:ident, $rule:expr, $unit:literal, $group:ident, $audience:ident, [$($stage:ident),*], [$($line:literal),+],
        [$($absent:tt)*], [$($matters:expr)?]
    ) => {
        $crate::options::declaration::DeclarationOf {
            name: stringify!($name),
            rule: $rule,
            unit: $unit,
            group: $group,
            audience: $audience,
            absent: $crate::options::declaration::absent!($($absent)*),
            stages: &[$($stage),*],
            lines: concat!($($line, "\n"),+),
            matters: $crate::options::declaration::matters!($($matters)?),
            get: |options| $crate::options::value::Typed::value(&options.$($field).+),
            set: |options, value| $crate::options::value::Typed::read(value).map(|value| options.$($field).+ = value).is_some(),
            copy: |to, from| to.$($field).+.clone_from(&from.$($field).+),
        }
    };
}

/// The line of a declaration that says what it means to leave the option out, if there is one.
macro_rules! absent {
    () => {
        None
    };
    ($word:literal, $meaning:literal) => {
        Some($crate::options::declaration::Absent { word: $word, meaning: $meaning })
    };
}

/// The line of a declaration that says where the option matters; without it, wherever it is used.
macro_rules! matters {
    () => {
        |_, _| true
    };
    ($matters:expr) => {
        $matters
    };
}

pub(super) use {absent, declare, entry, matters};
