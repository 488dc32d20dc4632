//! Every option, declared once. What an option is called, takes, is by default and is for stands here and nowhere else: parsing,
//! validation and its messages, command-line flags and their help, Python's `Options`, the page of options in the documentation, the
//! JSON schema, and what a session does again all come from these declarations.
//!
//! A declaration reads:
//!
//! ```text
//! /// What it does, in one sentence for the help. More of it, for Python and the documentation.
//! name: Type = default (in `Published` also the paper's), what it takes, "unit", Group, audience, [stages that use it];
//!     absent "its word on the command line", "what it means to leave it out";
//!     when |options, stage| whether it matters to the stage;
//! ```
//!
//! The last two lines are only for options that can be absent, and for those that matter only where others say so.

use super::choices::{Alpha, Backdrop, Crossings, Edge, ErrorWeighting, InkList, LatticeKind, Order, Point};
use super::declaration::Audience::{Everyday, Further};
use super::declaration::Group::{Inks, Method, Nodes, Shapes, Stipples, Tones, Work};
use super::declaration::Stage::{self, Emphasis, FirstGraph, Importance, Labels, Outlines, SecondGraph, Tone};
use super::declaration::{DeclarationOf, declare};
use super::value::Rule::{self, Switch, UpTo, Whole, Within, Words, WordsOrWithin};
use crate::base::Color;

/// The most nodes that a budget may ask for.
const MOST_NODES: u64 = 1_000_000_000;

/// The largest seed, 2^53: every program that reads JSON holds it exactly.
const MAX_SEED: u64 = 1 << 53;

declare! {
    /// Everything that shapes a drawing besides the photo and the importance.
    Options {
        /// Nodes to keep, within 1 %: more make a finer drawing.
        nodes: Option<u64> = None, Whole(3, MOST_NODES), "nodes", Nodes, Everyday, [Emphasis, FirstGraph];
            absent "auto", "0.3 a pixel, 1,080 to 300,000";
        /// Factor on the default number of nodes: above 1 finer, below 1 bolder.
        fineness: f64 = 1.0, UpTo(16.0), "", Nodes, Everyday, [Emphasis, FirstGraph];
        /// Nodes to keep for every pixel: another way to say nodes.
        nodes_per_pixel: Option<f64> = None, UpTo(16.0), "nodes per pixel", Nodes, Further, [Emphasis, FirstGraph];
            absent "auto", "see nodes";
        /// Share of the photo's own detail in the importance. The rest is saliency, or 1 with a map of one's own.
        detail: f64 = 0.95, Within(0.0, 1.0), "", Nodes, Everyday, [Importance];
        /// The least importance: no part of the photo is left without nodes. It comes before midtones.
        floor: f64 = 0.15, Within(0.0, 1.0), "", Nodes, Further, [Importance];
        /// By how much less important black and white are than middle grey.
        midtones: f64 = 0.8, Within(0.0, 1.0), "", Nodes, Further, [Importance];
        /// Lloyd steps that even out the kept nodes.
        relax: u32 = 1, Whole(0, 100), "steps", Nodes, Further, [SecondGraph];

        /// How much of the photo is dots. Where it is smooth, single dots of changing size carry the tone on bare paper or solid ink,
        /// evenly spaced, and no shapes; 0 stipples nothing, 1 everything, and in between parts count as smooth that are rougher and rougher.
        stippling: f64 = 0.5, Within(0.0, 1.0), "", Shapes, Everyday, [Labels];
        /// Error passed on in middle tones: more makes dots, less makes shapes. The alpha that is called tonal: none at black and white.
        shading: f64 = 0.15, Within(0.0, 1.0), "", Shapes, Everyday, [FirstGraph, Labels];
            when |options, stage| options.published.alpha_of(stage) == Alpha::Tonal;
        /// Data weight: more makes crisper shapes. How much a node's own tone counts in the refinement of labels; less keeps the tone of
        /// small parts.
        crispness: f64 = 1.9, Within(0.0, 100.0), "", Shapes, Everyday, [Labels];
            when |options, _| options.refine > 0;
        /// Smoothness weight: more makes larger shapes. How much the neighbours' labels count in the refinement; more makes smoother
        /// contours too.
        cohesion: f64 = 0.2, Within(0.0, 100.0), "", Shapes, Everyday, [Labels];
            when |options, _| options.refine > 0;
        /// Emphasis of details as fine as the nodes.
        sharpen: f64 = 2.5, Within(0.0, 100.0), "", Shapes, Everyday, [Emphasis];
        /// Emphasis of details three times as coarse.
        local_contrast: f64 = 1.5, Within(0.0, 100.0), "", Shapes, Further, [Emphasis];
        /// How far the mean may be from the photo's. Beyond that the refinement moves all labels towards it.
        tone_tolerance: Option<f64> = Some(0.014), Within(0.0, 1.0), "", Shapes, Further, [Labels];
            absent "off", "the mean is left as it comes";
            when |options, _| options.refine > 0;
        /// How far a contour may be simplified: more means fewer points. It is the distance from the contour through all crossings, of
        /// which 0 keeps every one.
        tolerance: f64 = 0.5, Within(0.0, 2.0), "pixels", Shapes, Everyday, [Outlines];
        /// How far edges look drawn by hand. Contours waver, by up to a third of the gaps beside them, and dots are irregular.
        wobble: f64 = 0.0, Within(0.0, 1.0), "", Shapes, Everyday, [Outlines];
        /// How edges that wobble look. Smooth ones waver, inked ones swell and thin as under a pen too, torn ones are rough and have corners.
        edge: Edge = Edge::Smooth, Words(Edge::WORDS), "", Shapes, Everyday, [Outlines];
            when |options, _| options.wobble > 0.0;
        /// Sweeps of the refinement of labels at most. With 0 they stay as they were diffused, whatever their mean.
        refine: u32 = 12, Whole(0, 100), "sweeps", Shapes, Further, [Labels];
        /// Dots that fused by chance, up to so many, are taken apart where there is room. Below 2 none are.
        split: u32 = 4, Whole(0, 12), "nodes", Shapes, Further, [Labels];

        /// Area of a stipple relative to its node's cell.
        stipple_scale: f64 = 1.0, UpTo(4.0), "", Stipples, Further, [Outlines];
        /// Least radius of a stipple where there is room for it. The room is the triangles around its node.
        stipple_min: f64 = 0.0, Within(0.0, 1000.0), "pixels", Stipples, Further, [Outlines];
        /// Largest radius of a stipple. It may not be below stipple_min.
        stipple_max: Option<f64> = None, UpTo(1000.0), "pixels", Stipples, Further, [Outlines];
            absent "auto", "as its cell asks for";
        /// How far stipples are from round. They look made by hand; above 0 they are paths and count as regions.
        irregularity: f64 = 0.0, Within(0.0, 1.0), "", Stipples, Everyday, [Outlines];
        /// Which of the irregular shapes stipples and edges have.
        seed: u64 = 0, Whole(0, MAX_SEED), "", Stipples, Further, [Outlines];

        /// The photo's grey that becomes white. For scans and photos of paper; auto leaves half a percent of the pixels beyond it.
        white_point: Option<Point> = None, WordsOrWithin(Point::WORDS, 0.004, 1.0), "", Tones, Everyday, [Tone];
            absent "off", "1";
        /// The photo's grey that becomes black. It lies below the white point; auto as there.
        black_point: Option<Point> = None, WordsOrWithin(Point::WORDS, 0.0, 0.996), "", Tones, Everyday, [Tone];
            absent "off", "0";
        /// Takes the tone in linear light. White then reflects as much light as the photo's grey on a screen.
        linear: bool = false, Switch, "", Tones, Everyday, [Tone];
        /// Above 1 lighter, below darker. The tone is raised to the power 1 / gamma.
        gamma: f64 = 1.0, Within(0.1, 10.0), "", Tones, Everyday, [Tone];
        /// Contrast around middle grey. Distances from it are multiplied.
        contrast: f64 = 1.0, Within(0.0, 10.0), "", Tones, Everyday, [Tone];
        /// Swaps black and white in the photo.
        invert: bool = false, Switch, "", Tones, Everyday, [Tone];
        /// What becomes of all but the subject. Where a subject is given: keep leaves it as it is; soften has half the contrast and fewer
        /// nodes; fade has dots around the subject that grow smaller to nothing; paper is white, ink black.
        backdrop: Backdrop = Backdrop::Fade, Words(Backdrop::WORDS), "", Tones, Further, [Tone, Importance];
        /// What shows through transparent parts. Those of the photo, and of a map of one's own.
        background: Color = Color::white(), Rule::Color, "", Tones, Further, [];

        /// Inks, with commas between them. Up to 15, each a colour, with a name before it if it has one, as in
        /// "#1d1d1b,pink=#ff48b0".
        inks: Option<InkList> = None, Rule::Inks, "", Inks, Everyday, [Labels];
            absent "off", "black";
        /// Greys of even spacing. Black and white are among them. Another way to say inks.
        levels: Option<u32> = None, Whole(2, 16), "greys", Inks, Everyday, [Labels];
            absent "off", "see inks";
        /// Inks of the photo's own. So many are taken from its colours. Another way to say inks.
        extract_inks: Option<u32> = None, Whole(1, 15), "inks", Inks, Everyday, [Labels];
            absent "off", "see inks";
        /// Lays inks over each other, up to six. What the light of each is to that of the paper is multiplied; without it every place
        /// has one ink or none.
        overprint: bool = false, Switch, "", Inks, Everyday, [Labels];
            when |options, _| options.wants_colour();
        /// Colour of the whole page. Inks mix with it, and white marks that are paper have it too.
        paper: Option<Color> = None, Rule::Color, "", Inks, Everyday, [Labels];
            absent "none", "white";
            when |options, _| options.wants_colour();

        /// Worker threads; the drawing does not depend on them.
        threads: Option<usize> = None, Whole(1, 1024), "", Work, Further, [];
            absent "auto", "one a core";
    }

    /// The parameters of the published method's graphs and diffusions: by [`Default`] the paper's, in [`Options`] ours.
    Published {
        /// First graph: six or four neighbours a node.
        lattice: LatticeKind = LatticeKind::Hexagonal, LatticeKind::Hexagonal,
            Words(LatticeKind::WORDS), "", Method, Further, [FirstGraph];
        /// Lattice nodes per pixel. Given without a number of nodes, the importance decides how many are kept.
        density: Option<f64> = None, Some(1.0), UpTo(16.0), "nodes per pixel", Method, Further, [Emphasis, FirstGraph];
            absent "auto", "as fine as the number of nodes needs";
        /// How much errors avoid neighbours of another value. The weight of the difference of values between two nodes.
        k1: f64 = 1.0, 1.0, Within(0.0, 1000.0), "", Method, Further, [FirstGraph, Labels];
        /// How much errors avoid neighbours far away. The weight of the distance between two nodes.
        k2: f64 = 0.1, 0.1, Within(0.0, 1000.0), "per pixel", Method, Further, [FirstGraph, Labels];
        /// Dynamic alpha where there is no detail.
        base: f64 = 0.5, 0.5, Within(0.0, 1.0), "", Method, Further, [FirstGraph, Labels];
            when |options, stage| options.published.alpha_of(stage) == Alpha::Dynamic;
        /// How much dynamic alpha grows with detail: the paper's lambda.
        detail_gain: f64 = 6.0, 6.0, Within(0.0, 1000.0), "", Method, Further, [FirstGraph, Labels];
            when |options, stage| options.published.alpha_of(stage) == Alpha::Dynamic;
        /// Radius of the local mean that dynamic alpha measures detail against.
        hops: u32 = 1, 1, Whole(1, 16), "hops", Method, Further, [FirstGraph, Labels];
            when |options, stage| options.published.alpha_of(stage) == Alpha::Dynamic;
        /// Share of the error passed on while nodes are chosen. A number, tonal (see alpha) or dynamic (the paper's).
        importance_alpha: Alpha = Alpha::Constant(1.0), Alpha::Dynamic,
            WordsOrWithin(Alpha::WORDS, 0.0, 1.0), "", Method, Further, [FirstGraph];
        /// Share of the error passed on while nodes turn black or white. Tonal (see shading), dynamic (the paper's), or a number from 0
        /// (threshold) to 1 (halftone).
        alpha: Alpha = Alpha::Tonal, Alpha::Dynamic, WordsOrWithin(Alpha::WORDS, 0.0, 1.0), "", Method, Further, [Labels];
        /// Order in which nodes are chosen. Row by row, or one order by priority over all nodes (the paper's).
        importance_order: Order = Order::Rows, Order::Global, Words(Order::WORDS), "", Method, Further, [FirstGraph];
        /// Order in which nodes turn black or white. Without refinement, global (the paper's) keeps more of the photo's structure.
        order: Order = Order::Rows, Order::Global, Words(Order::WORDS), "", Method, Further, [Labels];
        /// How an error counts between cells of different areas. By area, or its bare value (the paper's).
        error_weighting: ErrorWeighting = ErrorWeighting::Area, ErrorWeighting::Value,
            Words(ErrorWeighting::WORDS), "", Method, Further, [Labels];
        /// Where contours cross edges between nodes. Where the tone passes middle grey, or at the midpoint (the paper's).
        crossings: Crossings = Crossings::Tone, Crossings::Midpoint, Words(Crossings::WORDS), "", Method, Further, [Outlines];
    }
}

/// An option as it is declared, a field of [`Options`] or of its [`Published`].
pub type Declaration = DeclarationOf<Options>;

impl Published {
    /// The alpha of the diffusion that a stage runs.
    fn alpha_of(&self, stage: Stage) -> Alpha {
        if stage == FirstGraph { self.importance_alpha } else { self.alpha }
    }
}
